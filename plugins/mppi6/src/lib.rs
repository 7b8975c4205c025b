//! The MPPI-6 planner of the Verti-Bench paper: samples steering and speed, and rolls learned motion in six degrees of freedom out
//! over the terrain.
//!
//! The motion is [`hybrid::Kinodynamics`], whose networks `tools/model-train` has learned from exploration of training worlds. A
//! course costs what [`hybrid::Objective`] says: the way to a point on the global path, obstacles, roll and pitch.
//! `docs/planners.md` says what the paper says of it, what the released code does, and what is different here.

use hybrid::{
    CHANNELS, DT, HAZARDS, INPUTS, Kinodynamics, OUTPUTS, Objective, PATCH, State, Table, Terrain, Weights,
};
use vb_sdk::mppi::{Field, LANES, Mppi, Settings};
use vb_sdk::nn;
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Series, Task};

vb_sdk::export_planner! {
    planner: Mppi6Planner,
    name: "mppi6",
    about: "Samples steering and speed for learned motion in six degrees of freedom, towards a point on the global path",
    control_period: 0.1,
    params: {
        speed: 4.0 => "target speed, m/s at full scale",
        lookahead: 12.0 => "distance of the local goal along the global path, m at full scale",
        samples: 1000 => "courses drawn every control period",
        horizon: 20 => "steps of a course, of 0.2 s at full scale",
        spacing: 5 => "steps from one drawn command to the next; those between lie on a line",
        steer_spread: 0.4 => "standard deviation of drawn steering, of full steering",
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
        stuck: 3.0 => "weight of the probability of getting stuck",
        over: 3.0 => "weight of the probability of tipping over",
        learned: 1 => "whether the networks have a say; 0 for a bicycle on the plane through its wheels",
        explain: 0 => "number of courses (rounded up to a multiple of 8) to record with their costs beside the trajectory",
    }
}

/// The networks of the HMMWV.
static WEIGHTS: &[u8] = include_bytes!("hmmwv.vbnn");
/// The gains of the speed controller with which the model was learned: s/m, and 1/m.
const GAINS: (f64, f64) = (0.6, 0.15);

/// The planner.
pub struct Mppi6Planner {
    follower: Follower,
    lookahead: f64,
    model: Kinodynamics,
    objective: Objective,
    mppi: Mppi<2>,
    speed: SpeedController,
    root: f64,
    period: f64,
    explain: usize,
}

impl Planner for Mppi6Planner {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let vehicle = &task.vehicle;
        let scale = vehicle.scale;
        let root = scale.sqrt();
        let positive = |key| task.param_positive(key);
        let count = |key: &str| match task.param_as::<usize>(key)? {
            0 => Err(PlannerError::new(format!("parameter `{key}`: 0 is not above 0"))),
            n if n > 1_000_000 => Err(PlannerError::new(format!("parameter `{key}`: {n} is above 1000000"))),
            n => Ok(n),
        };
        let weight = |key: &str| match task.param_f64(key)? {
            value if value >= 0.0 => Ok(value as f32),
            value => Err(PlannerError::new(format!("parameter `{key}`: {value} is below 0"))),
        };
        let heights = task.elevation()?;
        let terrain = Terrain::new(heights, task.semantics.as_ref(), vehicle)
            .ok_or_else(|| PlannerError::new("the map of heights has fewer than 2 x 2 samples"))?;
        let (lookahead, target) = (positive("lookahead")? * scale, positive("speed")? * root);
        let (margin, radius) = (positive("margin")? * scale, 0.5 * vehicle.width);
        let clearance = Field::clearance(task, radius + margin)
            .ok_or_else(|| PlannerError::new("the occupancy map has fewer than 2 x 2 samples"))?;
        let settings = Settings {
            samples: count("samples")?,
            horizon: count("horizon")?,
            dt: DT * root as f32,
            spacing: count("spacing")?,
            spread: [positive("steer_spread")? as f32, (positive("speed_spread")? * root) as f32],
            low: [-1.0, 0.0],
            high: [1.0, vehicle.max_speed.min(2.0 * target) as f32],
            effective: positive("effective")?.min(0.999),
        };
        let objective = Objective {
            goal: [0.0; 2],
            per_lookahead: (1.0 / lookahead) as f32,
            target: target as f32,
            steps: settings.horizon as f32,
            weights: Weights {
                goal: weight("goal")?,
                obstacle: weight("obstacle")?,
                pace: weight("pace")?,
                effort: weight("effort")?,
                tilt: weight("tilt")?,
                stuck: weight("stuck")?,
                over: weight("over")?,
            },
            axle: (0.5 * vehicle.wheelbase) as f32,
            radius: radius as f32,
            margin: margin as f32,
            comfort: [positive("roll")?.to_radians() as f32, positive("pitch")?.to_radians() as f32],
            clearance,
        };
        let mut weights = nn::Weights::parse(WEIGHTS)?;
        if task.param_as::<u8>("learned")? == 0 {
            weights.layers.iter_mut().for_each(|l| {
                l.weights.fill(0.0);
                l.bias.fill(0.0);
            });
        }
        let ground = weights.network("ground", PATCH, CHANNELS)?;
        let motion = weights.network("motion", INPUTS, OUTPUTS)?;
        let hazards = weights.network("hazards", INPUTS, HAZARDS)?;
        let table = Table::new(heights.frame, &terrain, &ground);
        Ok(Self {
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            model: Kinodynamics::new(terrain, table, [motion, hazards], vehicle),
            objective,
            mppi: Mppi::new(settings, [0.0, target as f32], task.seed),
            speed: SpeedController::new(GAINS.0, GAINS.1),
            root,
            period: task.control_period,
            explain: task.param_as("explain")?,
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let start = State::of(o)?;
        let pose = o.pose()?;
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(self.lookahead);
        self.objective.goal = [goal.x as f32, goal.y as f32];
        let weighing = self.mppi.improve(&self.model, &self.objective, &start);
        let [steering, target] = self.mppi.command(0.0);
        let debug = if self.explain > 0 { self.explanation(&start, weighing.effective) } else { Vec::new() };
        self.mppi.advance(self.period);
        // The controller knows speeds at full scale.
        let speed = pose.linear_velocity.x / self.root;
        let (throttle, brake) = self.speed.update(target / self.root, speed, self.period);
        Ok(Command { steering: steering.clamp(-1.0, 1.0), throttle, brake, debug, ..Command::default() })
    }
}

impl Mppi6Planner {
    /// Courses as x, y, x, y, … one after the other, their costs, and how many had a say.
    fn explanation(&self, start: &State, effective: f64) -> Vec<Series> {
        let blocks = self.explain.div_ceil(LANES).min(self.mppi.costs().len() / LANES);
        let mut courses = Vec::new();
        for block in 0..blocks {
            let mut states = Vec::new();
            self.mppi.replay(block, &self.model, start, |s| states.push((s.x, s.y)));
            for lane in 0..LANES {
                courses.extend(states.iter().flat_map(|(x, y)| [x[lane], y[lane]]));
            }
        }
        let series = |name: &str, values: Vec<f32>| Series { name: name.into(), values };
        vec![
            series("trajectories", courses),
            series("trajectory_costs", self.mppi.costs()[..blocks * LANES].to_vec()),
            series("local_goal", self.objective.goal.to_vec()),
            series("effective_samples", vec![effective as f32]),
        ]
    }
}
