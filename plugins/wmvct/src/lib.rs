//! The WM-VCT planner of the Verti-Bench paper: a bicycle for place and heading, the map for the height, and a network for roll and
//! pitch, under MPPI.
//!
//! The network is that of [`hybrid::Kinodynamics`], of which this planner hears roll and pitch only. A course costs what
//! [`hybrid::Objective`] says: the way to a point on the global path, obstacles, roll and pitch. `docs/planners.md` says what the paper
//! says of it, what the released code does, and what is different here.

use hybrid::{Aim, Hybrid, Learned, Prediction};
use vb_sdk::{Command, Observation, Planner, PlannerError, Task};

vb_sdk::export_planner! {
    planner: WmvctPlanner,
    name: "wmvct",
    about: "Samples steering and speed for a bicycle whose roll and pitch are learned, towards a point on the global path",
    control_period: 0.1,
    params: {
        speed: 4.0 => "target speed, m/s at full scale",
        lookahead: 16.0 => "distance of the local goal along the global path, m at full scale",
        samples: 1000 => "courses drawn every control period",
        horizon: 20 => "steps of a course, of 0.2 s at full scale",
        spacing: 5 => "steps from one drawn command to the next; those between lie on a line",
        steer_spread: 0.6 => "standard deviation of drawn steering, of full steering",
        speed_spread: 1.0 => "standard deviation of drawn speed, m/s at full scale",
        effective: 0.1 => "share of the courses that the temperature gives a say",
        goal: 1.0 => "weight of the distance from the local goal",
        obstacle: 10.0 => "weight of obstacles and edges",
        margin: 1.0 => "distance between vehicle and obstacle that costs nothing, m at full scale",
        pace: 0.5 => "weight of the deviation from the target speed",
        effort: 0.2 => "weight of steering",
        tilt: 2.0 => "weight of roll and pitch",
        roll: 12.0 => "roll that costs nothing, degrees",
        pitch: 15.0 => "pitch that costs nothing, degrees",
        learned: 1 => "whether the networks have a say; 0 for a bicycle on the plane through its wheels",
        explain: 0 => "number of courses (rounded up to a multiple of 8) to record with their costs beside the trajectory",
    }
}

const PREDICTION: Prediction = Prediction { learned: Learned::Attitude, attention: false };

/// The planner.
pub struct WmvctPlanner(Hybrid);

impl Planner for WmvctPlanner {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        Hybrid::new(task, Aim::Path, PREDICTION).map(Self)
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        self.0.step(o)
    }
}
