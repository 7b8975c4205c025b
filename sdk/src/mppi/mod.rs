//! Model predictive path integral control (MPPI).
//!
//! Command sequences for the next seconds are sampled around a plan and rolled out through a model of the vehicle; the
//! plan becomes their mean, weighted by cost (Williams et al., *Information theoretic MPC for model-based reinforcement
//! learning*, ICRA 2017). Model, cost and sampling are separate: [`Model`] and [`Cost`] are traits, [`Mppi`] samples
//! and computes weights, [`Bicycle`] and [`Field`] are an example model and cost map.
//!
//! Properties:
//! - Commands are linear between *knots* some steps apart: samples are smooth, few random numbers are needed, and the
//!   plan can be shifted by any elapsed time ([`Mppi::advance`]).
//! - Samples come in antithetic pairs, mirrored at the plan; the plan itself is a sample.
//! - Costs are relative to the minimum, in units of the mean, and the temperature adapts to the effective sample size:
//!   the result is independent of the scale of the cost.
//! - Arithmetic runs on [`LANES`] samples in arrays of fixed size, which compilers vectorise, with identical bits
//!   natively and as WASM.

mod bicycle;
mod field;
#[cfg(test)]
mod tests;

pub use bicycle::{Bicycle, BicycleState};
pub use field::Field;

use crate::math;
use crate::rng::Rng;

/// The number of samples that are rolled out at once.
pub const LANES: usize = 8;
/// One number for each of [`LANES`] samples.
pub type Lanes = [f32; LANES];

/// The motion model of a vehicle. `C` is the number of commands.
pub trait Model<const C: usize> {
    /// The states of [`LANES`] vehicles.
    type State: Clone;

    /// Advances the states by one step of `dt` seconds with these commands.
    fn step(&self, state: &mut Self::State, command: &[Lanes; C], dt: f32);
}

/// The cost of a plan, in any unit; only differences between samples matter.
pub trait Cost<State, const C: usize> {
    /// The running costs of these states after step `index` (from 0) with these commands.
    fn running(&self, state: &State, command: &[Lanes; C], index: usize) -> Lanes;

    /// The terminal costs of these states.
    fn terminal(&self, state: &State) -> Lanes;
}

/// The settings of sampling and weighting.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings<const C: usize> {
    /// The number of samples, rounded up to a multiple of [`LANES`].
    pub samples: usize,
    /// The number of steps of a rollout.
    pub horizon: usize,
    /// The step length, s.
    pub dt: f32,
    /// The number of steps between knots.
    pub spacing: usize,
    /// The standard deviation of each command at the knots, in the command's unit.
    pub spread: [f32; C],
    /// The minimum of each command.
    pub low: [f32; C],
    /// The maximum of each command.
    pub high: [f32; C],
    /// The effective sample fraction, in (0, 1), that the temperature targets.
    pub effective: f64,
}

/// The statistics of the last weighting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weighing {
    /// The minimum cost of the samples.
    pub least: f64,
    /// The mean cost of the samples.
    pub mean: f64,
    /// The effective sample size: (Σ w)² / Σ w² (Kish 1965).
    pub effective: f64,
    /// The temperature, in units of the mean cost above the minimum.
    pub temperature: f64,
}

/// The state of the sampler: the plan and the samples.
#[derive(Clone, Debug)]
pub struct Mppi<const C: usize> {
    settings: Settings<C>,
    rng: Rng,
    /// The plan: each command at each knot.
    plan: Vec<[f32; C]>,
    /// A proposed plan, around which the last blocks are sampled, and the number of these blocks.
    guide: (Vec<[f32; C]>, usize),
    /// Commands of all samples: by block of [`LANES`], knot, command.
    draws: Vec<[Lanes; C]>,
    costs: Vec<f32>,
    weights: Vec<f32>,
    temperature: f64,
    weighing: Weighing,
}

/// Bounds of the temperature, in units of the mean cost above the minimum.
const TEMPERATURE: [f64; 2] = [1e-3, 1e3];
/// Exponent with which the temperature adapts to the effective sample size from one call to the next.
const FOLLOW: f64 = 0.5;

impl<const C: usize> Mppi<C> {
    /// Creates a sampler with the constant plan `command`. The `seed` determines the samples.
    #[must_use]
    pub fn new(settings: Settings<C>, command: [f32; C], seed: u64) -> Self {
        let blocks = settings.samples.div_ceil(LANES).max(1);
        let knots = settings.horizon.max(1).div_ceil(settings.spacing.max(1)) + 1;
        Self {
            rng: Rng::new(seed),
            plan: vec![command; knots],
            guide: (Vec::new(), 0),
            draws: vec![[[0.0; LANES]; C]; blocks * knots],
            costs: vec![0.0; blocks * LANES],
            weights: vec![0.0; blocks * LANES],
            temperature: 0.2,
            weighing: Weighing::default(),
            settings,
        }
    }

    /// The planned commands in `time` seconds; after the end of the plan, the last commands.
    #[must_use]
    pub fn command(&self, time: f64) -> [f64; C] {
        let at = (time / (f64::from(self.settings.dt) * self.settings.spacing.max(1) as f64)).max(0.0);
        let last = self.plan.len() - 1;
        // The cast saturates.
        let knot = (at as usize).min(last);
        let part = if knot == last { 0.0 } else { at - knot as f64 };
        let (from, to) = (self.plan[knot], self.plan[(knot + 1).min(last)]);
        std::array::from_fn(|c| f64::from(from[c]) + part * f64::from(to[c] - from[c]))
    }

    /// Shifts the plan by the elapsed time, s. The last commands are repeated at its end.
    pub fn advance(&mut self, elapsed: f64) {
        let spacing = f64::from(self.settings.dt) * self.settings.spacing.max(1) as f64;
        let plan = (0..self.plan.len()).map(|k| self.command(k as f64 * spacing + elapsed).map(|v| v as f32));
        self.plan = plan.collect();
    }

    /// The number of knots of a plan: one every `spacing` steps of a rollout, and one at or after its end.
    #[must_use]
    pub fn knots(&self) -> usize {
        self.plan.len()
    }

    /// Samples a fraction of the rollouts, in [0, 1], around a proposed plan with a command per knot, e.g. from a
    /// search or a policy. Weights depend only on costs, so a poor proposal costs samples but does not bias the plan.
    ///
    /// # Panics
    /// Panics if the number of commands is not the number of knots.
    pub fn propose(&mut self, guide: &[[f32; C]], part: f64) {
        assert_eq!(guide.len(), self.plan.len(), "a proposal has a command for each knot");
        let blocks = self.costs.len() / LANES;
        // The first block contains the plan.
        self.guide = (guide.to_vec(), ((part * blocks as f64) as usize).min(blocks - 1));
    }

    /// Samples commands, rolls them out from `start`, and moves the plan to their weighted mean. Returns the statistics
    /// of the weighting.
    pub fn improve<M, K>(&mut self, model: &M, cost: &K, start: &M::State) -> Weighing
    where
        M: Model<C>,
        K: Cost<M::State, C>,
    {
        self.draw();
        for block in 0..self.costs.len() / LANES {
            let costs = self.roll_out(block, model, cost, start);
            self.costs[block * LANES..][..LANES].copy_from_slice(&costs);
        }
        self.weigh();
        self.average();
        self.weighing
    }

    /// The costs of the last rollouts, in sample order.
    #[must_use]
    pub fn costs(&self) -> &[f32] {
        &self.costs
    }

    /// Rolls a block of [`LANES`] of the last samples out again and passes every state, including the first, to `see`,
    /// e.g. for visualisation.
    pub fn replay<M: Model<C>>(
        &self,
        block: usize,
        model: &M,
        start: &M::State,
        mut see: impl FnMut(&M::State),
    ) {
        let mut state = start.clone();
        see(&state);
        for index in 0..self.settings.horizon {
            model.step(&mut state, &self.drawn(block, index), self.settings.dt);
            see(&state);
        }
    }

    /// Rolls the plan out, identically in all lanes, and passes every state, including the first, to `see`.
    pub fn unfold<M: Model<C>>(&self, model: &M, start: &M::State, mut see: impl FnMut(&M::State)) {
        let mut state = start.clone();
        see(&state);
        for index in 0..self.settings.horizon {
            let command = self.command(f64::from(self.settings.dt) * index as f64);
            model.step(&mut state, &command.map(|c| [c as f32; LANES]), self.settings.dt);
            see(&state);
        }
    }

    fn draw(&mut self) {
        let knots = self.plan.len();
        let Settings { spread, low, high, .. } = self.settings;
        let (guide, guided) = (&self.guide.0, self.guide.1 * knots);
        let first = self.draws.len() - guided;
        for (i, draw) in self.draws.iter_mut().enumerate() {
            let mean = if i < first { self.plan[i % knots] } else { guide[i % knots] };
            for c in 0..C {
                for lane in 0..LANES / 2 {
                    // The first pair is the plan and the proposal.
                    let noise = if (i < knots || (first..first + knots).contains(&i)) && lane == 0 {
                        0.0
                    } else {
                        spread[c] * normal(&mut self.rng)
                    };
                    draw[c][lane] = (mean[c] + noise).clamp(low[c], high[c]);
                    draw[c][lane + LANES / 2] = (mean[c] - noise).clamp(low[c], high[c]);
                }
            }
        }
    }

    /// The commands of a block at a step, linear between two knots.
    fn drawn(&self, block: usize, index: usize) -> [Lanes; C] {
        let (knots, spacing) = (self.plan.len(), self.settings.spacing.max(1));
        let (knot, part) = (index / spacing, (index % spacing) as f32 / spacing as f32);
        let from = &self.draws[block * knots + knot];
        let to = &self.draws[block * knots + knot + 1];
        std::array::from_fn(|c| std::array::from_fn(|l| from[c][l] + part * (to[c][l] - from[c][l])))
    }

    fn roll_out<M, K>(&self, block: usize, model: &M, cost: &K, start: &M::State) -> Lanes
    where
        M: Model<C>,
        K: Cost<M::State, C>,
    {
        let mut state = start.clone();
        let mut total = [0.0; LANES];
        for index in 0..self.settings.horizon {
            let command = self.drawn(block, index);
            model.step(&mut state, &command, self.settings.dt);
            let running = cost.running(&state, &command, index);
            for l in 0..LANES {
                total[l] += running[l];
            }
        }
        let terminal = cost.terminal(&state);
        std::array::from_fn(|l| total[l] + terminal[l])
    }

    /// Weights from costs. Samples with a NaN cost have weight 0.
    fn weigh(&mut self) {
        let known = || self.costs.iter().copied().filter(|c| c.is_finite());
        let least = known().fold(f32::INFINITY, f32::min);
        let count = known().count();
        if count == 0 {
            // All costs are equal: the plan is unchanged.
            self.weights.fill(0.0);
            self.weighing = Weighing { temperature: self.temperature, ..Weighing::default() };
            return;
        }
        let mean = known().map(|c| f64::from(c - least)).sum::<f64>() / count as f64;
        let scale = 1.0 / (self.temperature * mean).max(1e-12);
        let (mut sum, mut squares) = (0.0, 0.0);
        for (weight, cost) in self.weights.iter_mut().zip(&self.costs) {
            *weight = if cost.is_finite() { math::exp(-f64::from(cost - least) * scale) as f32 } else { 0.0 };
            let w = f64::from(*weight);
            sum += w;
            squares += w * w;
        }
        let effective = sum * sum / squares;
        self.weighing = Weighing {
            least: f64::from(least),
            mean: f64::from(least) + mean,
            effective,
            temperature: self.temperature,
        };
        let wanted = self.settings.effective * self.costs.len() as f64;
        let factor = math::pow(wanted / effective, FOLLOW).clamp(0.5, 2.0);
        self.temperature = (self.temperature * factor).clamp(TEMPERATURE[0], TEMPERATURE[1]);
    }

    /// Moves the plan to the weighted mean of the samples.
    fn average(&mut self) {
        let total: f32 = self.weights.iter().sum();
        if total <= 0.0 {
            return;
        }
        let knots = self.plan.len();
        for (k, plan) in self.plan.iter_mut().enumerate() {
            for (c, mean) in plan.iter_mut().enumerate() {
                let mut sums = [0.0; LANES];
                for (block, weights) in self.weights.chunks_exact(LANES).enumerate() {
                    let draw = &self.draws[block * knots + k][c];
                    for l in 0..LANES {
                        sums[l] += weights[l] * draw[l];
                    }
                }
                *mean = sums.iter().sum::<f32>() / total;
            }
        }
    }
}

/// An approximately standard normal number: the sum of four uniform numbers of 16 bits, without a logarithm.
fn normal(rng: &mut Rng) -> f32 {
    let bits = rng.next_u64();
    let sum: u64 = (0..4).map(|i| (bits >> (16 * i)) & 0xffff).sum();
    // Each has mean 65535/2 and variance (65536² − 1)/12.
    (sum as f32 - 2.0 * 65535.0) * (1.0 / (65536.0 * 0.577_350_27))
}
