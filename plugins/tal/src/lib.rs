//! The TAL planner of the Verti-Bench paper: MPPI with learned 6-DoF kinodynamics that attend to terrain patches along
//! the motion.
//!
//! The dynamics model is [`hybrid::Kinodynamics`] with [`hybrid::Attention`], trained by `tools/model-train` on
//! exploration of training worlds. The cost of a rollout is [`hybrid::Objective`]: distance from a point on the global
//! path, obstacles, roll, pitch and hazards. `docs/planners.md` compares the paper, the released code and this planner.

hybrid::export_hybrid! {
    planner: TalPlanner,
    name: "tal",
    about: "MPPI with learned 6-DoF kinodynamics with terrain attention, towards a point on the global path",
    aim: Path,
    learned: All,
    attention: true,
    params: {
        lookahead: 16.0 => "look-ahead distance of the local goal along the global path, m at full scale",
        steer_spread: 0.6 => "standard deviation of sampled steering, fraction of full lock",
        effective: 0.1 => "effective sample fraction that the temperature targets",
        goal: 1.0 => "weight of the distance from the local goal",
        tilt: 2.0 => "weight of roll and pitch above `roll` and `pitch`",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 8.0 => "weight of the probability of tipping over",
        risk: 0.0 => "CVaR level of the hazard costs `stuck` and `over`, 0 to 0.99; 0: expected cost",
    },
}
