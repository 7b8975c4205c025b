//! The MPPI planner of the Verti-Bench paper: samples steering and speed, rolls a bicycle out in the plane, and follows
//! the global path around obstacles. It does not look at the terrain.
//!
//! Every control period 1000 courses of 20 steps are drawn about the last plan and rolled out ([`vb_sdk::mppi`]). A
//! course costs, each as a mean over its steps,
//! - `goal` · (distance from the local goal / look-ahead)², and as much again for its end,
//! - `obstacle` · what it comes too near to obstacles and to the edge of the world, in shares of `margin`, squared, for two
//!   circles about the axles that cover the vehicle's width; ten times `obstacle` for each that touches,
//! - `pace` · (speed / target − 1)²,
//! - `effort` · steering².
//!
//! `docs/planners.md` says what the paper says of it, what the released code does, and what is different here.

mod cost;

use cost::Objective;
use vb_sdk::mppi::{Bicycle, BicycleState, Field, LANES, Mppi, Settings};
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, GridFrame, LabelMap, Observation, Planner, PlannerError, Series, Task};

vb_sdk::export_planner! {
    planner: MppiPlanner,
    name: "mppi",
    about: "Samples steering and speed for a bicycle in the plane, around obstacles towards a point on the global path",
    control_period: 0.1,
    params: {
        speed: 5.0 => "target speed, m/s at full scale",
        lookahead: 10.0 => "distance of the local goal along the global path, m at full scale",
        samples: 1000 => "courses drawn every control period",
        horizon: 20 => "steps of a course",
        dt: 0.15 => "time of a step, s at full scale",
        spacing: 5 => "steps from one drawn command to the next; those between lie on a line",
        steer_spread: 0.4 => "standard deviation of drawn steering, of full steering",
        speed_spread: 0.5 => "standard deviation of drawn speed, m/s at full scale",
        effective: 0.1 => "share of the courses that the temperature gives a say",
        goal: 1.0 => "weight of the distance from the local goal",
        obstacle: 10.0 => "weight of obstacles and edges",
        margin: 1.0 => "distance between vehicle and obstacle that costs nothing, m at full scale",
        pace: 3.0 => "weight of the deviation from the target speed",
        effort: 0.2 => "weight of steering",
        speed_kp: 1.0 => "proportional gain of the speed controller, s/m at full scale",
        explain: 0 => "number of courses (rounded up to a multiple of 8) to record with their costs beside the trajectory",
    },
    without_maps: { local_map }
}

pub struct MppiPlanner {
    follower: Follower,
    lookahead: f64,
    model: Bicycle,
    objective: Objective,
    mppi: Mppi<2>,
    speed: SpeedController,
    /// The least and the greatest coordinates of the world, where there is no map of its obstacles.
    edges: Option<((f64, f64), (f64, f64))>,
    period: f64,
    explain: usize,
}

/// The least coordinates of the world, m.
fn low(task: &Task) -> (f64, f64) {
    (-task.half_extent.x, -task.half_extent.y)
}

/// The greatest coordinates of the world, m.
fn high(task: &Task) -> (f64, f64) {
    (task.half_extent.x, task.half_extent.y)
}

/// A map of the whole world in which nothing is known.
fn unknown(task: &Task) -> LabelMap {
    let resolution = 0.5 * task.vehicle.scale;
    let count = |half: f64| (2.0 * half / resolution).clamp(1.0, 4096.0) as u32 + 1;
    let (rows, cols) = (count(task.half_extent.y), count(task.half_extent.x));
    let (origin_x, origin_y) = low(task);
    let frame = GridFrame { rows, cols, resolution, origin_x, origin_y };
    LabelMap { frame, data: vec![255; rows as usize * cols as usize] }
}

impl Planner for MppiPlanner {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let vehicle = &task.vehicle;
        let scale = vehicle.scale;
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
        let effective = positive("effective")?;
        if effective >= 1.0 {
            return Err(PlannerError::new(format!("parameter `effective`: {effective} is not below 1")));
        }
        // Speeds and times scale by the root of the lengths (Froude).
        let root = scale.sqrt();
        let (lookahead, target) = (positive("lookahead")? * scale, positive("speed")? * root);
        let margin = positive("margin")? * scale;
        let radius = 0.5 * vehicle.width;
        let clearance = match &task.occupancy {
            Some(_) => Field::clearance(task, radius + margin),
            // Until the first map of the surroundings comes, only the edge of the world is known.
            None => Field::around(&unknown(task), low(task), high(task), radius + margin),
        };
        let clearance =
            clearance.ok_or_else(|| PlannerError::new("the occupancy map has fewer than 2 x 2 samples"))?;
        let settings = Settings {
            samples: count("samples")?,
            horizon: count("horizon")?,
            dt: (positive("dt")? * root) as f32,
            spacing: count("spacing")?,
            spread: [positive("steer_spread")? as f32, (positive("speed_spread")? * root) as f32],
            low: [-1.0, 0.0],
            high: [1.0, vehicle.max_speed.min(2.0 * target) as f32],
            effective,
        };
        let objective = Objective {
            goal: [0.0; 2],
            per_lookahead: (1.0 / lookahead) as f32,
            target: target as f32,
            steps: settings.horizon as f32,
            weights: cost::Weights {
                goal: weight("goal")?,
                obstacle: weight("obstacle")?,
                pace: weight("pace")?,
                effort: weight("effort")?,
            },
            axle: (0.5 * vehicle.wheelbase) as f32,
            radius: radius as f32,
            margin: margin as f32,
            clearance,
        };
        Ok(Self {
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            model: Bicycle::of(vehicle),
            objective,
            mppi: Mppi::new(settings, [0.0, target as f32], task.seed),
            speed: SpeedController::new(task.param_f64("speed_kp")? / root, 0.0),
            edges: task.occupancy.is_none().then(|| (low(task), high(task))),
            period: task.control_period,
            explain: task.param_as("explain")?,
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        if let (Some((low, high)), Some(seen)) = (self.edges, &o.local_map) {
            let reach = f64::from(self.objective.radius + self.objective.margin);
            if let Some(clearance) = Field::around(&seen.occupancy, low, high, reach) {
                self.objective.clearance = clearance;
            }
        }
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(self.lookahead);
        // In single precision differences near the vehicle are finer than differences of positions in the world.
        self.objective.goal = [goal.x as f32, goal.y as f32];
        let start = BicycleState::of(pose, o.last_steering);
        let weighing = self.mppi.improve(&self.model, &self.objective, &start);
        let [steering, target] = self.mppi.command(0.0);
        let debug = if self.explain > 0 { self.explanation(&start, weighing.effective) } else { Vec::new() };
        self.mppi.advance(self.period);
        let (throttle, brake) = self.speed.update(target, pose.linear_velocity.x, self.period);
        Ok(Command { steering: steering.clamp(-1.0, 1.0), throttle, brake, debug, ..Command::default() })
    }
}

impl MppiPlanner {
    /// Courses as x, y, x, y, … one after the other, their costs, and how many had a say.
    fn explanation(&self, start: &BicycleState, effective: f64) -> Vec<Series> {
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
            series("clearance", vec![self.objective.clearance.at(&start.x, &start.y)[0]]),
        ]
    }
}

#[cfg(test)]
mod tests;
