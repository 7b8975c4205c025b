//! The base of the hybrid planners.

use vb_sdk::mppi::{Field, Mppi, Settings};
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, GridFrame, LogLevel, Observation, PlannerError, Point2, Task, Vehicle, log};

use crate::explanation::Explanation;
use crate::guide::descend;
use crate::kinodynamics::{DT, Kinodynamics, Learned, State};
use crate::models;
use crate::objective::{Objective, Weights};
use crate::table::HEADINGS;
use crate::terrain::Terrain;
use crate::traversability::{Prices, Values, costs};

/// Gains of the speed controller in the model's training data: s/m, and 1/m.
const GAINS: (f64, f64) = (0.6, 0.15);

/// The target of the rollouts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// A point on the global path at the look-ahead distance.
    Path,
    /// The goal, along the path of minimum cost with the parameters `price_*`.
    Traversability,
}

/// The prediction model of a planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prediction {
    /// Which network outputs it uses.
    pub learned: Learned,
    /// Whether the networks attend to positions ahead, or use only the patch around the vehicle.
    pub attention: bool,
}

/// The factor of hazard probabilities at the level `risk`, 1 / (1 − level).
fn caution(task: &Task) -> Result<f32, PlannerError> {
    let level = task.param_f64("risk")?;
    if !(0.0..=0.99).contains(&level) {
        return Err(PlannerError::new(format!("parameter `risk`: {level} is not from 0 to 0.99")));
    }
    Ok((1.0 / (1.0 - level)) as f32)
}

/// A position on the traversability map, with a heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The row of the elevation map, from the south.
    pub row: u32,
    /// The column of the elevation map, from the west.
    pub col: u32,
    /// Its position, m.
    pub at: Point2,
    /// The heading, as an index of [`heading`](crate::heading).
    pub heading: usize,
}

struct Traversability {
    frame: GridFrame,
    /// Path cost per metre at each position, by heading, row and column.
    costs: Vec<f32>,
    goal: Point2,
}

impl Traversability {
    /// Adds a cost to each position.
    fn add(&mut self, mut extra_cost: impl FnMut(Place) -> f32) {
        let (frame, area) = (self.frame, self.costs.len() / HEADINGS);
        for (heading, costs) in self.costs.chunks_exact_mut(area).enumerate() {
            for (k, cost) in costs.iter_mut().enumerate() {
                let (row, col) = (k as u32 / frame.cols, k as u32 % frame.cols);
                let (x, y) = frame.position(row, col);
                *cost += extra_cost(Place { row, col, at: Point2 { x, y }, heading });
            }
        }
    }

    /// The cost-to-go of all positions.
    fn values(&self) -> Values {
        Values::new(self.frame, &self.costs, self.goal)
    }
}

/// MPPI with learned dynamics. The plugins declare the parameters.
pub struct Hybrid {
    follower: Follower,
    lookahead: f64,
    model: Kinodynamics,
    vehicle: Vehicle,
    objective: Objective,
    /// The target speed without increase, m/s.
    target: f32,
    map: Option<Traversability>,
    mppi: Mppi<2>,
    speed: SpeedController,
    /// The fraction of rollouts sampled around the cost-to-go descent.
    guided: f64,
    spacing: usize,
    /// The step length of rollouts, s.
    dt: f32,
    root: f64,
    period: f64,
    explanation: Option<Explanation>,
}

impl Hybrid {
    /// Initialises the planner for a task.
    ///
    /// # Errors
    /// Returns an error for an invalid parameter, or a task without maps.
    pub fn new(task: &Task, aim: Aim, prediction: Prediction) -> Result<Self, PlannerError> {
        Self::over(task, aim, prediction, None::<fn(Place) -> f32>)
    }

    /// Initialises the planner for a task with additional path costs per metre, `extra_cost`, for each position. `extra_cost`
    /// is used only with [`Aim::Traversability`].
    ///
    /// # Errors
    /// Returns an error for an invalid parameter, or a task without maps.
    pub fn over(
        task: &Task,
        aim: Aim,
        Prediction { learned, attention }: Prediction,
        extra_cost: Option<impl FnMut(Place) -> f32>,
    ) -> Result<Self, PlannerError> {
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
            .ok_or_else(|| PlannerError::new("the elevation map has fewer than 2 x 2 samples"))?;
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
                // Planners without hazard prediction have no hazard weights.
                stuck: if learned == Learned::All { weight("stuck")? } else { 0.0 },
                over: if learned == Learned::All { weight("over")? } else { 0.0 },
                caution: if learned == Learned::All { caution(task)? } else { 1.0 },
            },
            axle: (0.5 * vehicle.wheelbase) as f32,
            radius: radius as f32,
            margin: margin as f32,
            comfort: [positive("roll")?.to_radians() as f32, positive("pitch")?.to_radians() as f32],
            clearance,
        };
        let weights = models::weights(&vehicle.name, attention)?;
        let known = weights.note("vehicle").unwrap_or_default();
        if known != vehicle.name {
            let text = format!(
                "the model was learned with the {known}, and not with the {}: expect less",
                vehicle.name
            );
            log(LogLevel::Warn, &text);
        }
        let learned = if task.param_as::<u8>("learned")? == 0 { Learned::Nothing } else { learned };
        let model = Kinodynamics::new(heights, terrain, &weights, vehicle, learned)?;
        let courses: usize = task.param_as("explain")?;
        let mut explanation = (courses > 0).then(|| Explanation::new(courses, task.control_period / root));
        let (mut guided, mut map) = (0.0, None);
        if aim == Aim::Traversability {
            guided = task.param_f64("guided")?;
            if !(0.0..=0.9).contains(&guided) {
                return Err(PlannerError::new(format!("parameter `guided`: {guided} is not from 0 to 0.9")));
            }
            let price = |key: &str| weight(&format!("price_{key}"));
            let prices = Prices {
                stuck: price("stuck")?,
                over: price("over")?,
                slow: price("slow")?,
                obstacle: price("obstacle")?,
            };
            let reach = (objective.radius, objective.margin);
            let costs = costs(heights.frame, &model, &objective.clearance, reach, target as f32, &prices);
            let mut places = Traversability { frame: heights.frame, costs, goal: task.goal };
            if let Some(extra_cost) = extra_cost {
                places.add(extra_cost);
            }
            if let Some(explanation) = &mut explanation {
                explanation.show(heights.frame, &model, &places.costs);
            }
            objective.values = Some(places.values());
            map = Some(places);
        }
        Ok(Self {
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            model,
            vehicle: vehicle.clone(),
            target: objective.target,
            objective,
            map,
            guided,
            spacing: settings.spacing,
            dt: settings.dt,
            mppi: Mppi::new(settings, [0.0, target as f32], task.seed),
            speed: SpeedController::new(GAINS.0, GAINS.1),
            root,
            period: task.control_period,
            explanation,
        })
    }

    /// Adds a cost to each position as in [`Hybrid::over`], and recomputes the cost-to-go.
    pub fn avoid(&mut self, extra_cost: impl FnMut(Place) -> f32) {
        if let Some(map) = &mut self.map {
            map.add(extra_cost);
            self.objective.values = Some(map.values());
        }
    }

    #[must_use]
    pub fn objective(&self) -> &Objective {
        &self.objective
    }

    /// The planned command after so many seconds: steering, and speed (m/s).
    #[must_use]
    pub fn planned(&self, time: f64) -> [f64; 2] {
        self.mppi.command(time)
    }

    /// Multiplies the target speed of the parameters by a factor.
    pub fn hurry(&mut self, times: f64) {
        self.objective.target = (f64::from(self.target) * times) as f32;
    }

    /// Computes the command for an observation.
    ///
    /// # Errors
    /// Returns an error if the observation has no pose.
    pub fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let start = State::of(o, self.model.terrain(), &self.vehicle)?;
        let pose = o.pose()?;
        let (p, v) = (pose.position, pose.linear_velocity);
        let slip = f64::from(start.slip[0]);
        let rate = pose.angular_velocity.z;
        let told = [p.x, p.y, pose.roll, pose.pitch, pose.yaw, v.x, v.y, rate, o.steering, slip];
        if let Some(wrong) = told.iter().find(|value| !value.is_finite()) {
            return Err(PlannerError::new(format!(
                "the observation has the value {wrong}: nothing can be planned from it"
            )));
        }
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(self.lookahead);
        self.objective.goal = [goal.x as f32, goal.y as f32];
        if self.guided > 0.0 {
            let guide =
                descend(&self.model, &self.objective, &start, (self.mppi.knots(), self.spacing, self.dt));
            self.mppi.propose(&guide, self.guided);
        }
        let weighing = self.mppi.improve(&self.model, &self.objective, &start);
        let [steering, target] = self.mppi.command(0.0);
        let debug = match &mut self.explanation {
            Some(explanation) => {
                let commands = [steering as f32, target as f32];
                explanation.tell((&self.mppi, weighing), &self.model, &self.objective, (&start, commands))
            }
            None => Vec::new(),
        };
        self.mppi.advance(self.period);
        // The controller expects speeds at full scale.
        let speed = pose.linear_velocity.x / self.root;
        let (throttle, brake) = self.speed.update(target / self.root, speed, self.period);
        Ok(Command { steering: steering.clamp(-1.0, 1.0), throttle, brake, debug, ..Command::default() })
    }
}

#[cfg(test)]
mod tests;
