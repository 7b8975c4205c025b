//! The planner that the hybrid ones are variants of.

use vb_sdk::mppi::{Field, LANES, Mppi, Settings};
use vb_sdk::nn;
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, LogLevel, Observation, PlannerError, Series, Task, log};

use crate::kinodynamics::{DT, HAZARDS, INPUTS, Kinodynamics, Learned, OUTPUTS, State};
use crate::objective::{Objective, Weights};
use crate::table::{CHANNELS, Table};
use crate::terrain::{PATCH, Terrain};
use crate::traversability::{Prices, Values, costs};

/// The networks of the HMMWV.
static WEIGHTS: &[u8] = include_bytes!("../weights/hmmwv.vbnn");
/// The gains of the speed controller with which the model was learned: s/m, and 1/m.
const GAINS: (f64, f64) = (0.6, 0.15);

/// What courses are to come nearer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// A point on the global path, the look-ahead away.
    Path,
    /// The goal, over the ground that costs least by the parameters `price_*`.
    Traversability,
}

/// MPPI over learned motion. The parameters are those that the plugins declare.
pub struct Hybrid {
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

impl Hybrid {
    /// The planner of a task.
    ///
    /// # Errors
    /// Returns an error if a parameter is wrong, or the task has no maps.
    pub fn new(task: &Task, aim: Aim, learned: Learned) -> Result<Self, PlannerError> {
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
        task.occupancy()?;
        let clearance = Field::clearance(task, radius + margin)
            .ok_or_else(|| PlannerError::new("the occupancy map has fewer than 2 x 2 samples"))?;
        let effective = positive("effective")?;
        if effective >= 1.0 {
            return Err(PlannerError::new(format!("parameter `effective`: {effective} is not below 1")));
        }
        let settings = Settings {
            samples: count("samples")?,
            horizon: count("horizon")?,
            dt: DT * root as f32,
            spacing: count("spacing")?,
            spread: [positive("steer_spread")? as f32, (positive("speed_spread")? * root) as f32],
            low: [-1.0, 0.0],
            high: [1.0, vehicle.max_speed.min(2.0 * target) as f32],
            effective,
        };
        let mut objective = Objective {
            values: None,
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
                // Who doesn't foresee them has no weights of hazards.
                stuck: if learned == Learned::All { weight("stuck")? } else { 0.0 },
                over: if learned == Learned::All { weight("over")? } else { 0.0 },
            },
            axle: (0.5 * vehicle.wheelbase) as f32,
            radius: radius as f32,
            margin: margin as f32,
            comfort: [positive("roll")?.to_radians() as f32, positive("pitch")?.to_radians() as f32],
            clearance,
        };
        let weights = nn::Weights::parse(WEIGHTS)?;
        let known = weights.note("vehicle").unwrap_or_default();
        if known != vehicle.name {
            let text = format!(
                "the model was learned with the {known}, and not with the {}: expect less",
                vehicle.name
            );
            log(LogLevel::Warn, &text);
        }
        let learned = if task.param_as::<u8>("learned")? == 0 { Learned::Nothing } else { learned };
        let ground = weights.network("ground", PATCH, CHANNELS)?;
        let motion = weights.network("motion", INPUTS, OUTPUTS)?;
        let hazards = weights.network("hazards", INPUTS, HAZARDS)?;
        let table = Table::new(heights.frame, &terrain, &ground);
        let model = Kinodynamics::new(terrain, table, [motion, hazards], vehicle, learned);
        if aim == Aim::Traversability {
            let price = |key: &str| weight(&format!("price_{key}"));
            let prices = Prices {
                stuck: price("stuck")?,
                over: price("over")?,
                slow: price("slow")?,
                obstacle: price("obstacle")?,
            };
            let reach = (objective.radius, objective.margin);
            let places = costs(heights.frame, &model, &objective.clearance, reach, target as f32, &prices);
            objective.values = Some(Values::new(heights.frame, &places, task.goal));
        }
        Ok(Self {
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            model,
            objective,
            mppi: Mppi::new(settings, [0.0, target as f32], task.seed),
            speed: SpeedController::new(GAINS.0, GAINS.1),
            root,
            period: task.control_period,
            explain: task.param_as("explain")?,
        })
    }

    /// The command at an observation.
    ///
    /// # Errors
    /// Returns an error if the observation has no pose.
    pub fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let start = State::of(o)?;
        let pose = o.pose()?;
        let (p, v) = (pose.position, pose.linear_velocity);
        let told = [p.x, p.y, pose.roll, pose.pitch, pose.yaw, v.x, v.y, pose.angular_velocity.z, o.steering];
        if let Some(wrong) = told.iter().find(|value| !value.is_finite()) {
            return Err(PlannerError::new(format!(
                "the observation has the value {wrong}: nothing can be planned from it"
            )));
        }
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

#[cfg(test)]
mod tests;
