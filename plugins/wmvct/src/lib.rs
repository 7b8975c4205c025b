//! The WM-VCT planner of the Verti-Bench paper: MPPI with a bicycle model for position and heading, the elevation map
//! for the height, and a network for roll and pitch.
//!
//! The network is that of [`hybrid::Kinodynamics`], of which this planner uses roll and pitch only. The cost of a
//! rollout is [`hybrid::Objective`]: distance from a point on the global path, obstacles, roll and pitch.
//! `docs/planners.md` compares the paper, the released code and this planner.

hybrid::export_hybrid! {
    planner: WmvctPlanner,
    name: "wmvct",
    about: "MPPI with a bicycle model and learned roll and pitch, towards a point on the global path",
    aim: Path,
    learned: Attitude,
    attention: false,
    params: {
        lookahead: 16.0 => "look-ahead distance of the local goal along the global path, m at full scale",
        steer_spread: 0.6 => "standard deviation of sampled steering, fraction of full lock",
        effective: 0.1 => "effective sample fraction that the temperature targets",
        goal: 1.0 => "weight of the distance from the local goal",
        tilt: 2.0 => "weight of roll and pitch above `roll` and `pitch`",
    },
}
