//! The loop of training, and how good the model is in worlds that it has not seen.

use candle_core::{Result, Tensor};
use candle_nn::{AdamW, Optimizer as _, ParamsAdamW};
use serde::Serialize;
use vb_math::rng::Stream;
use vb_sdk::mppi::LANES;

use crate::data::{Data, STEPS, Window};
use crate::model::{Motion, truth};

/// Windows of a step of training, in groups of one world each.
const GROUPS: usize = 48;
/// The learning rate at its highest.
const RATE: f64 = 3e-3;
/// The fraction of windows in which the vehicle stands.
const STANDING: f64 = 0.15;
/// Windows on which the error is measured, at most.
const MEASURED: usize = 16_384;

/// Units in which the errors of x and y, yaw, speed, roll and pitch count alike: m, rad, m/s, rad.
const UNITS: [f64; 9] = [0.3, 0.3, 0.1, 0.4, 0.4, 0.2, 1.0, 0.05, 0.05];
/// What is learned: all but the steering, which follows its command.
const LEARNED: [usize; 8] = [0, 1, 2, 3, 4, 5, 7, 8];

/// Windows by world, of which groups are drawn.
struct Drawn<'a> {
    /// Of each world, windows that move and windows that stand.
    worlds: Vec<[Vec<&'a Window>; 2]>,
    random: Stream,
}

impl<'a> Drawn<'a> {
    fn new(windows: &[&'a Window], seed: u64) -> Self {
        let last = windows.iter().map(|w| w.place).max().unwrap_or(0);
        let mut worlds: Vec<[Vec<&Window>; 2]> = (0..=last).map(|_| [Vec::new(), Vec::new()]).collect();
        for w in windows {
            worlds[w.place][usize::from(w.stands)].push(w);
        }
        worlds.retain(|w| w[0].len() >= LANES);
        Self { worlds, random: Stream::new(seed, &["model", "batches"]) }
    }

    /// Groups of [`LANES`] windows, each group in one world; worlds come as often as they have windows.
    fn batch(&mut self, groups: usize) -> Vec<&'a Window> {
        let total: usize = self.worlds.iter().map(|w| w[0].len()).sum();
        let mut batch = Vec::with_capacity(groups * LANES);
        for _ in 0..groups {
            let mut at = (self.random.unit() * total as f64) as usize;
            let found = self.worlds.iter().find(|w| {
                let here = at < w[0].len();
                at = at.saturating_sub(w[0].len());
                here
            });
            let world = found.unwrap_or(&self.worlds[0]);
            for _ in 0..LANES {
                let stands = self.random.unit() < STANDING && !world[1].is_empty();
                let own = &world[usize::from(stands)];
                batch.push(own[(self.random.unit() * own.len() as f64) as usize % own.len()]);
            }
        }
        batch
    }
}

/// The mean loss over the steps of windows: pseudo-Huber, so that a few wild windows don't decide.
fn loss(model: &Motion, data: &Data, windows: &[&Window], steps: usize) -> Result<Tensor> {
    let mut state = Motion::start(windows)?;
    let mut total: Option<Tensor> = None;
    for k in 0..steps {
        state = model.step(data, windows, &state, k, true)?;
        for (i, should) in truth(windows, k + 1)?.iter().enumerate().filter(|(i, _)| LEARNED.contains(i)) {
            let e = ((&state.values[i] - should)? / UNITS[i])?;
            // Headings differ by less than half a turn.
            let e = if i == 2 { around(&e, UNITS[2])? } else { e };
            let own = ((e.sqr()? + 1.0)?.sqrt()? - 1.0)?.mean_all()?;
            total = Some(match total {
                Some(total) => (total + own)?,
                None => own,
            });
        }
    }
    let total = total.ok_or_else(|| candle_core::Error::Msg("no steps".into()))?;
    total / steps as f64
}

/// An angle in units, less whole turns.
fn around(e: &Tensor, unit: f64) -> Result<Tensor> {
    let turn = std::f64::consts::TAU / unit;
    let turns = ((e / turn)?.round()? * turn)?;
    e - turns.detach()
}

/// Trains for so many steps.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn train(
    model: &Motion,
    data: &Data,
    windows: &[&Window],
    steps: usize,
    seed: u64,
    mut tell: impl FnMut(usize, f32),
) -> Result<()> {
    let variables = model.ground.variables().chain(model.motion.variables()).collect();
    let params = ParamsAdamW { lr: RATE, weight_decay: 1e-4, ..ParamsAdamW::default() };
    let mut optimiser = AdamW::new(variables, params)?;
    let mut drawn = Drawn::new(windows, seed);
    for step in 0..steps {
        let part = step as f64 / steps as f64;
        // Up in the first hundredth, then down along a cosine.
        let warm = (part / 0.01).min(1.0);
        optimiser.set_learning_rate(RATE * warm * (0.02 + 0.98 * 0.5 * (1.0 + vb_math::cos(std::f64::consts::PI * part))));
        // First a second, then all three.
        let horizon = if part < 0.3 { 5 } else if part < 0.6 { 10 } else { STEPS };
        let batch = drawn.batch(GROUPS);
        let loss = loss(model, data, &batch, horizon)?;
        optimiser.backward_step(&loss)?;
        if (step + 1).is_multiple_of(100) {
            tell(step + 1, loss.to_scalar()?);
        }
    }
    Ok(())
}

/// Mean errors at a time.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// The time, s.
    pub time_s: f64,
    /// Of the place, m.
    pub position_m: f64,
    /// Of the heading, rad.
    pub yaw_rad: f64,
    /// m/s.
    pub speed_m_per_s: f64,
    /// rad.
    pub roll_rad: f64,
    /// rad.
    pub pitch_rad: f64,
}

/// How a way to predict does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Speed, yaw rate, roll and pitch stay as they are.
    Constant,
    /// The bicycle on the plane.
    Bicycle,
    /// The model.
    Learned,
}

/// The steps after which errors are told: 1 s and 3 s, and those about 0.5 s, between which it lies.
const TOLD: [(f64, usize, usize); 3] = [(0.5, 2, 3), (1.0, 5, 5), (3.0, 15, 15)];

/// The mean errors of a way to predict over windows in which the vehicle moves.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn measure(model: &Motion, data: &Data, windows: &[&Window], way: Way) -> Result<Vec<Errors>> {
    let mut sums = [[0.0_f64; 5]; STEPS + 1];
    let mut count = 0.0;
    let mut drawn = Drawn::new(windows, 0);
    while count < MEASURED as f64 && !drawn.worlds.is_empty() {
        let batch = drawn.batch(64);
        let batch: Vec<&Window> =
            batch.chunks_exact(LANES).filter(|g| g.iter().all(|w| w.place == g[0].place)).flatten().copied().collect();
        let mut state = Motion::start(&batch)?;
        for k in 0..STEPS {
            state = match way {
                Way::Constant => constant(&state, f64::from(hybrid::DT))?,
                Way::Bicycle => model.step(data, &batch, &state, k, false)?,
                Way::Learned => model.step(data, &batch, &state, k, true)?,
            };
            let values = state.values.each_ref().map(|t| t.flatten_all().and_then(|t| t.to_vec1::<f32>()));
            let values = values.into_iter().collect::<Result<Vec<_>>>()?;
            for (i, w) in batch.iter().enumerate() {
                let p = w.points[k + 1];
                let off = |a: f32, b: f32| f64::from((a - b).abs());
                let yaw = f64::from(values[2][i] - p.yaw);
                let turn = std::f64::consts::TAU;
                let own = [
                    f64::from((values[0][i] - p.x).hypot(values[1][i] - p.y)),
                    (yaw - turn * (yaw / turn).round()).abs(),
                    off(values[3][i], p.speed),
                    off(values[7][i], p.roll),
                    off(values[8][i], p.pitch),
                ];
                for (sum, own) in sums[k + 1].iter_mut().zip(own) {
                    *sum += own;
                }
            }
        }
        count += batch.len() as f64;
    }
    let at = |(time_s, a, b): (f64, usize, usize)| {
        let mean = |i: usize| 0.5 * (sums[a][i] + sums[b][i]) / count.max(1.0);
        Errors {
            time_s,
            position_m: mean(0),
            yaw_rad: mean(1),
            speed_m_per_s: mean(2),
            roll_rad: mean(3),
            pitch_rad: mean(4),
        }
    };
    Ok(TOLD.map(at).to_vec())
}

fn constant(s: &crate::model::State, dt: f64) -> Result<crate::model::State> {
    let [x, y, yaw, speed, side, turn, steering, roll, pitch] = s.values.clone();
    let middle = (&yaw + (&turn * (0.5 * dt))?)?;
    let way = (&speed * dt)?;
    let x = (x + (&way * middle.cos()?)?)?;
    let y = (y + (&way * middle.sin()?)?)?;
    let yaw = (yaw + (&turn * dt)?)?;
    Ok(crate::model::State { values: [x, y, yaw, speed, side, turn, steering, roll, pitch] })
}
