//! The TNT planner of the Verti-Bench paper: estimates traversability, and samples rollouts of learned 6-DoF
//! kinodynamics along the path of minimum cost.
//!
//! The dynamics model is [`hybrid::Kinodynamics`], trained by `tools/model-train` on exploration of training worlds.
//! Its predictions at every position and heading form the traversability map ([`hybrid::costs`]). Sampling follows the
//! cost-to-go over this map ([`hybrid::Values`]). `docs/planners.md` compares the paper, the released code and this
//! planner.

hybrid::export_hybrid! {
    planner: TntPlanner,
    name: "tnt",
    about: "MPPI with learned 6-DoF kinodynamics over terrain predicted to be traversable",
    aim: Traversability,
    learned: All,
    attention: false,
    params: {
        lookahead: 12.0 => "normalisation length of the path cost, m at full scale",
        steer_spread: 0.5 => "standard deviation of sampled steering, fraction of full lock",
        effective: 0.03 => "effective sample fraction that the temperature targets",
        goal: 2.0 => "weight of the path cost to the goal",
        tilt: 6.0 => "weight of roll and pitch above `roll` and `pitch`",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 30.0 => "weight of the probability of tipping over",
        risk: 0.0 => "CVaR level of the hazard costs `stuck` and `over`, 0 to 0.99; 0: expected cost",
        guided: 0.3 => "fraction of rollouts sampled around a cost-to-go descent, up to 0.9",
        price_stuck: 25.0 => "added path cost per metre at a probability of 1 of getting stuck",
        price_over: 200.0 => "added path cost per metre at a probability of 1 of tipping over",
        price_slow: 1.0 => "added path cost per metre where the target speed is lost within 1 s",
        price_obstacle: 30.0 => "added path cost per metre in contact with an obstacle",
    },
}
