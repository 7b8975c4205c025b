//! The MPPI planner of the Verti-Bench paper: samples steering and speed, rolls out a planar bicycle model, and follows
//! the global path around obstacles. It does not use the terrain.
//!
//! Every control period it samples 1000 rollouts of 20 steps around the last plan ([`vb_sdk::mppi`]). The cost of a
//! rollout is the sum of, each as a mean over its steps,
//! - `goal` · (distance from the local goal / look-ahead distance)², plus the same term for the final state,
//! - `obstacle` · (penetration into `margin` around obstacles and the edge of the world, as a fraction of `margin`)²,
//!   for two circles around the axles that cover the vehicle's width; ten times `obstacle` for each circle in contact,
//! - `pace` · (speed / target − 1)²,
//! - `effort` · steering².
//!
//! `docs/planners.md` compares the paper, the released code and this planner.

mod cost;

use cost::Objective;
use vb_sdk::mppi::{Bicycle, BicycleState, Field, LANES, Mppi, Settings};
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, GridFrame, LabelMap, Observation, Planner, PlannerError, Series, Task};

vb_sdk::export_planner! {
    planner: MppiPlanner,
    name: "mppi",
    about: "MPPI with a planar bicycle model: follows the global path around obstacles",
    control_period: 0.1,
    params: {
        speed: 5.0 => "target speed, m/s at full scale",
        lookahead: 10.0 => "look-ahead distance of the local goal along the global path, m at full scale",
        samples: 1000 => "rollouts per control period",
        horizon: 20 => "steps per rollout",
        dt: 0.15 => "step length, s at full scale",
        spacing: 5 => "spacing of sampled commands, steps; linear in between",
        steer_spread: 0.4 => "standard deviation of sampled steering, fraction of full lock",
        speed_spread: 0.5 => "standard deviation of sampled speeds, m/s at full scale",
        effective: 0.1 => "effective sample fraction that the temperature targets",
        goal: 1.0 => "weight of the distance from the local goal",
        obstacle: 10.0 => "weight of obstacles and world edges",
        margin: 1.0 => "distance from obstacles above which they have no cost, m at full scale",
        pace: 3.0 => "weight of the deviation from the target speed",
        effort: 0.2 => "weight of steering",
        speed_kp: 1.0 => "proportional gain of the speed controller, s/m at full scale",
        explain: 0 => "number of rollouts (rounded up to a multiple of 8) to record with their costs in the debug file",
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
    /// Minimum and maximum coordinates of the world, for tasks without an occupancy map.
    edges: Option<((f64, f64), (f64, f64))>,
    period: f64,
    explain: usize,
}

/// Minimum coordinates of the world, m.
fn low(task: &Task) -> (f64, f64) {
    (-task.half_extent.x, -task.half_extent.y)
}

/// Maximum coordinates of the world, m.
fn high(task: &Task) -> (f64, f64) {
    (task.half_extent.x, task.half_extent.y)
}

/// A map of the whole world without known cells.
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
            // Before the first local map, only the edge of the world is known.
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
        // Single precision: relative positions near the vehicle are finer than world coordinates.
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
    /// Rollouts as x, y, x, y, … one after the other, their costs, and the effective sample size.
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
