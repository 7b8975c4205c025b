//! The TNT planner of the Verti-Bench paper: it estimates where the vehicle can go, and unfolds learned motion in six degrees of
//! freedom on the way that costs least.
//!
//! The motion is [`hybrid::Kinodynamics`], whose networks `tools/model-train` has learned from exploration of training worlds. What they
//! foresee at every place and heading makes the map of traversability ([`hybrid::costs`]), and from it comes the cost of the way to the
//! goal ([`hybrid::Values`]), which courses are drawn towards. `docs/planners.md` says what the paper says of it, what the released
//! code does, and what is different here.

hybrid::export_hybrid! {
    planner: TntPlanner,
    name: "tnt",
    about: "Samples steering and speed for learned motion in six degrees of freedom, over the ground that it foresees to be passable",
    aim: Traversability,
    learned: All,
    attention: false,
    params: {
        lookahead: 12.0 => "length of way that the cost of the way is measured in, m at full scale",
        steer_spread: 0.5 => "standard deviation of drawn steering, of full steering",
        effective: 0.03 => "share of the courses that the temperature gives a say",
        goal: 2.0 => "weight of the cost of the way to the goal",
        tilt: 6.0 => "weight of roll and pitch",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 30.0 => "weight of the probability of tipping over",
        risk: 0.0 => "level in [0, 0.99] of the conditional value at risk at which these two are priced; 0 prices what is to be expected",
        guided: 0.3 => "part of the courses that is drawn about a descent on the map of traversability, up to 0.9",
        price_stuck: 25.0 => "length of way, over its own, that a probability of one to get stuck is worth avoiding",
        price_over: 200.0 => "the same of a probability to tip over",
        price_slow: 1.0 => "the same of losing all speed within a second",
        price_obstacle: 30.0 => "the same of touching an obstacle",
    },
}
