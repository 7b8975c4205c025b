//! The WM-VCT planner of the Verti-Bench paper: a bicycle for place and heading, the map for the height, and a network for roll and
//! pitch, under MPPI.
//!
//! The network is that of [`hybrid::Kinodynamics`], of which this planner hears roll and pitch only. A course costs what
//! [`hybrid::Objective`] says: the way to a point on the global path, obstacles, roll and pitch. `docs/planners.md` says what the paper
//! says of it, what the released code does, and what is different here.

hybrid::export_hybrid! {
    planner: WmvctPlanner,
    name: "wmvct",
    about: "Samples steering and speed for a bicycle whose roll and pitch are learned, towards a point on the global path",
    aim: Path,
    learned: Attitude,
    attention: false,
    params: {
        lookahead: 16.0 => "distance of the local goal along the global path, m at full scale",
        steer_spread: 0.6 => "standard deviation of drawn steering, of full steering",
        effective: 0.1 => "share of the courses that the temperature gives a say",
        goal: 1.0 => "weight of the distance from the local goal",
        tilt: 2.0 => "weight of roll and pitch",
    },
}
