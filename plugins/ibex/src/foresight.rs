//! Rollouts of the internal forward model.

use hybrid::{Hybrid, Objective, beyond};
use vb_sdk::mppi::{Cost, LANES, Lanes, Mppi, Settings};
use vb_sdk::speed::SpeedKeeper;
use vb_sdk::{Command, HeightMap, LabelMap, Observation, PlannerError, Task, Vehicle};

use crate::escape::Escape;
use crate::twin::{State, Twin};

/// Step length of rollouts, s at full scale, and steps per rollout.
pub(crate) const DT: f64 = 0.1;
const HORIZON: usize = 30;
/// Spacing of sampled commands, steps.
const SPACING: usize = 10;
/// Fraction of the rollouts sampled around the plan of the hybrid planner.
const GUIDED: f64 = 0.4;
/// Cosine of the angle between the vehicle's up axis and the vertical at which tipping begins, and at which it is
/// complete.
const TIPPING: [f32; 2] = [0.8, 0.6];

/// A plan around which rollouts are sampled.
pub(crate) trait Proposal {
    /// Steering and speed (m/s) after so many seconds.
    fn planned(&self, time: f64) -> [f64; 2];
}

impl Proposal for Hybrid {
    fn planned(&self, time: f64) -> [f64; 2] {
        Self::planned(self, time)
    }
}

/// MPPI with the internal forward model.
pub(crate) struct Foresight {
    twin: Twin,
    mppi: Mppi<2>,
    weights: Weights,
    keeper: SpeedKeeper,
    escape: Option<Escape>,
    /// Root of the scale, the factor of times.
    root: f64,
    period: f64,
}

/// Weights of quantities that only the internal model provides.
#[derive(Clone, Copy, Debug)]
struct Weights {
    hull: f32,
    over: f32,
}

/// Cost of a rollout: that of the hybrid planner, with hazards from the internal model.
pub(crate) struct Price<'a> {
    pub(crate) objective: &'a Objective,
    weights: Weights,
    /// Steps per rollout.
    steps: f32,
}

impl Price<'_> {
    /// The cost for rollouts of another length.
    pub(crate) fn over(&self, steps: usize) -> Self {
        Self { steps: steps as f32, ..*self }
    }
}

impl Cost<State, 2> for Price<'_> {
    fn running(&self, s: &State, [steering, _]: &[Lanes; 2], _: usize) -> Lanes {
        let o = self.objective;
        let w = o.weights;
        let (place, direction) = ([&s.x, &s.y], [&s.cos, &s.sin]);
        let away = o.away(place, direction);
        let (front, rear) = (o.near(place, direction, o.axle), o.near(place, direction, -o.axle));
        std::array::from_fn(|l| {
            let pace = s.speed[l] / o.target - 1.0;
            let tilt = beyond(s.tilt[0][l], o.comfort[0]) + beyond(s.tilt[1][l], o.comfort[1]);
            let tipped = ((TIPPING[0] - s.upright[l]) / (TIPPING[0] - TIPPING[1])).clamp(0.0, 1.0);
            let cost = w.goal * away[l]
                + w.obstacle * (front[l] + rear[l])
                + w.pace * pace * pace
                + w.effort * steering[l] * steering[l]
                + w.tilt * tilt
                + self.weights.over * tipped
                + self.weights.hull * s.borne[l].min(1.0);
            cost / self.steps
        })
    }

    fn terminal(&self, s: &State) -> Lanes {
        let o = self.objective;
        o.away([&s.x, &s.y], [&s.cos, &s.sin]).map(|away| o.weights.goal * away)
    }
}

impl Foresight {
    /// The planner of a task; none with `foresight` 0 or a map of fewer than 2 x 2 samples.
    pub(crate) fn new(
        task: &Task,
        heights: &HeightMap,
        kinds: Option<&LabelMap>,
    ) -> Result<Option<Self>, PlannerError> {
        let samples: usize = task.param_as("foresight")?;
        let weight = |key| crate::weight(task, key);
        let weights = Weights { hull: weight("hull")?, over: weight("over")? };
        let margin = f64::from(weight("clearance")?);
        let frame = heights.frame;
        // The hybrid planner reports maps of fewer than 2 x 2 samples.
        if samples == 0 || frame.rows.min(frame.cols) < 2 {
            return Ok(None);
        }
        let vehicle = &task.vehicle;
        let root = vehicle.scale.sqrt();
        let target = task.param_positive("speed")? * root;
        let settings = Settings {
            samples,
            horizon: HORIZON,
            dt: (DT * root) as f32,
            spacing: SPACING,
            spread: [0.4, root as f32],
            low: [-1.0, 0.0],
            high: [1.0, vehicle.max_speed.min(2.0 * target) as f32],
            effective: 0.05,
        };
        let recovers = task.param_as::<u8>("recover")? != 0;
        Ok(Some(Self {
            twin: Twin::new(heights, kinds, vehicle, margin),
            mppi: Mppi::new(settings, [0.0, target as f32], task.seed),
            weights,
            keeper: SpeedKeeper::new(vehicle.scale),
            escape: recovers.then(|| Escape::new(task)),
            root,
            period: task.control_period,
        }))
    }

    /// Replaces the maps.
    pub(crate) fn see(&mut self, heights: &HeightMap, kinds: Option<&LabelMap>, vehicle: &Vehicle) {
        self.twin.see(heights, kinds, vehicle);
    }

    /// The command for an observation, and whether the vehicle has just been detected as stuck.
    pub(crate) fn step(
        &mut self,
        o: &Observation,
        objective: &Objective,
        proposal: &impl Proposal,
    ) -> Result<(Command, bool), PlannerError> {
        let start = self.twin.state(o, self.keeper.integral())?;
        self.twin.learn(&start, o.time);
        let price = Price { objective, weights: self.weights, steps: HORIZON as f32 };
        let (manoeuvre, stuck) = match &mut self.escape {
            Some(escape) => escape.update(o, &self.twin, &price, &start)?,
            None => (None, false),
        };
        let [steering, target] = match manoeuvre {
            Some(m) if m.is_backing => m.command,
            m => {
                let proposed = |knot: usize| match &m {
                    Some(m) => m.command,
                    None => proposal.planned((knot * SPACING) as f64 * DT * self.root),
                };
                let guide: Vec<[f32; 2]> =
                    (0..self.mppi.knots()).map(|knot| proposed(knot).map(|v| v as f32)).collect();
                self.mppi.propose(&guide, GUIDED);
                self.mppi.improve(&self.twin, &price, &start);
                let command = self.mppi.command(0.0);
                self.mppi.advance(self.period);
                command
            }
        };
        self.keeper.aim(target);
        let speed = o.pose()?.linear_velocity.x;
        let (mut throttle, mut brake, gear) = self.keeper.update(speed, self.period);
        if gear != o.gear {
            // The gearbox changes direction only at low speed.
            throttle = 0.0;
            brake = if self.twin.is_slow(speed) { 0.0 } else { 1.0 };
        }
        let steering = steering.clamp(-1.0, 1.0);
        Ok((Command { steering, throttle, brake, gear, ..Command::default() }, stuck))
    }
}

/// Evaluates a function for each rollout of a block.
pub(crate) fn lanes(of: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn::<f32, LANES, _>(|l| of(l) as f32)
}
