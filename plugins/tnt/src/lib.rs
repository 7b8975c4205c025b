//! The TNT planner of the Verti-Bench paper: it estimates where the vehicle can go, and unfolds learned motion in six degrees of
//! freedom on the way that costs least.
//!
//! The motion is [`hybrid::Kinodynamics`], whose networks `tools/model-train` has learned from exploration of training worlds. What they
//! foresee at every place and heading makes the map of traversability ([`hybrid::costs`]), and from it comes the cost of the way to the
//! goal ([`hybrid::Values`]), which courses are drawn towards. `docs/planners.md` says what the paper says of it, what the released
//! code does, and what is different here.

use hybrid::{Aim, Hybrid, Learned, Prediction};
use vb_sdk::{Command, Observation, Planner, PlannerError, Task};

vb_sdk::export_planner! {
    planner: TntPlanner,
    name: "tnt",
    about: "Samples steering and speed for learned motion in six degrees of freedom, over the ground that it foresees to be passable",
    control_period: 0.1,
    params: {
        speed: 4.0 => "target speed, m/s at full scale",
        lookahead: 12.0 => "length of way that the cost of the way is measured in, m at full scale",
        samples: 1000 => "courses drawn every control period",
        horizon: 20 => "steps of a course, of 0.2 s at full scale",
        spacing: 5 => "steps from one drawn command to the next; those between lie on a line",
        steer_spread: 0.5 => "standard deviation of drawn steering, of full steering",
        speed_spread: 1.0 => "standard deviation of drawn speed, m/s at full scale",
        effective: 0.03 => "share of the courses that the temperature gives a say",
        goal: 2.0 => "weight of the cost of the way to the goal",
        obstacle: 10.0 => "weight of obstacles and edges",
        margin: 1.0 => "distance between vehicle and obstacle that costs nothing, m at full scale",
        pace: 0.5 => "weight of the deviation from the target speed",
        effort: 0.2 => "weight of steering",
        tilt: 6.0 => "weight of roll and pitch",
        roll: 12.0 => "roll that costs nothing, degrees",
        pitch: 15.0 => "pitch that costs nothing, degrees",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 30.0 => "weight of the probability of tipping over",
        guided: 0.3 => "part of the courses that is drawn about a descent on the map of traversability, up to 0.9",
        price_stuck: 25.0 => "length of way, over its own, that a probability of one to get stuck is worth avoiding",
        price_over: 200.0 => "the same of a probability to tip over",
        price_slow: 1.0 => "the same of losing all speed within a second",
        price_obstacle: 30.0 => "the same of touching an obstacle",
        learned: 1 => "whether the networks have a say; 0 for a bicycle on the plane through its wheels",
        explain: 0 => "number of courses (rounded up to a multiple of 8) to record with their costs beside the trajectory",
    }
}

const PREDICTION: Prediction = Prediction { learned: Learned::All, attention: false };

/// The planner.
pub struct TntPlanner(Hybrid);

impl Planner for TntPlanner {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        Hybrid::new(task, Aim::Traversability, PREDICTION).map(Self)
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        self.0.step(o)
    }
}
