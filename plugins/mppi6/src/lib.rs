//! The MPPI-6 planner of the Verti-Bench paper: samples steering and speed, and rolls learned motion in six degrees of freedom out
//! over the terrain.
//!
//! The motion is [`hybrid::Kinodynamics`], whose networks `tools/model-train` has learned from exploration of training worlds. A
//! course costs what [`hybrid::Objective`] says: the way to a point on the global path, obstacles, roll and pitch.
//! `docs/planners.md` says what the paper says of it, what the released code does, and what is different here.

hybrid::export_hybrid! {
    planner: Mppi6Planner,
    name: "mppi6",
    about: "Samples steering and speed for learned motion in six degrees of freedom, towards a point on the global path",
    aim: Path,
    learned: All,
    attention: false,
    params: {
        lookahead: 16.0 => "distance of the local goal along the global path, m at full scale",
        steer_spread: 0.6 => "standard deviation of drawn steering, of full steering",
        effective: 0.1 => "share of the courses that the temperature gives a say",
        goal: 1.0 => "weight of the distance from the local goal",
        tilt: 2.0 => "weight of roll and pitch",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 8.0 => "weight of the probability of tipping over",
        risk: 0.0 => "level in [0, 0.99] of the conditional value at risk at which these two are priced; 0 prices what is to be expected",
    },
}
