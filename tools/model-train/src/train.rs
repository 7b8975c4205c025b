//! The loop of training, and how good the model is in worlds that it has not seen.

use candle_core::{Result, Tensor};
use candle_nn::{AdamW, Optimizer as _, ParamsAdamW};
use serde::Serialize;
use vb_math::rng::Stream;
use vb_sdk::mppi::LANES;

use crate::data::{Data, Moment, STEPS, Window};
use crate::model::{Motion, truth};

/// Windows of a step of training, in groups of one world each.
const GROUPS: usize = 48;
/// The learning rate at its highest.
const RATE: f64 = 3e-3;
/// The fraction of windows in which the vehicle stands.
const STANDING: f64 = 0.15;
/// The weight of the hazards' cross entropy in the loss.
const HAZARD: f64 = 4.0;
/// Windows on which the error is measured, at most.
const MEASURED: usize = 16_384;

/// Units in which the errors of x and y, yaw, speed, roll and pitch count alike: m, rad, m/s, rad.
const UNITS: [f64; 9] = [0.3, 0.3, 0.1, 0.4, 0.4, 0.2, 1.0, 0.05, 0.05];
/// What is learned: all but the steering, which follows its command.
const LEARNED: [usize; 8] = [0, 1, 2, 3, 4, 5, 7, 8];

/// Windows by world, of which groups are drawn.
struct Drawn<'a, T> {
    /// Of each world, those that are usual, and those that aren't.
    worlds: Vec<[Vec<&'a T>; 2]>,
    /// The fraction of the latter that is drawn.
    unusual: f64,
    random: Stream,
}

impl<'a, T> Drawn<'a, T> {
    /// Of all these, with the place of each, and whether it is unusual.
    fn new(all: &[&'a T], kind: impl Fn(&T) -> (usize, bool), unusual: f64, seed: u64) -> Self {
        let last = all.iter().map(|w| kind(w).0).max().unwrap_or(0);
        let mut worlds: Vec<[Vec<&T>; 2]> = (0..=last).map(|_| [Vec::new(), Vec::new()]).collect();
        for w in all {
            let (place, is_unusual) = kind(w);
            worlds[place][usize::from(is_unusual)].push(w);
        }
        worlds.retain(|w| w[0].len() >= LANES);
        Self { worlds, unusual, random: Stream::new(seed, &["model", "batches"]) }
    }

    /// Groups of [`LANES`] windows, each group in one world; worlds come as often as they have windows.
    fn batch(&mut self, groups: usize) -> Vec<&'a T> {
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
                let stands = self.random.unit() < self.unusual && !world[1].is_empty();
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

/// The mean cross entropy of the hazards.
fn foresight(model: &Motion, data: &Data, moments: &[&Moment]) -> Result<Tensor> {
    let windows: Vec<&Window> = moments.iter().map(|m| &m.window).collect();
    let logits = model.foresee(data, &windows)?;
    let should: Vec<f32> =
        moments.iter().flat_map(|m| [m.stuck, m.over].map(|b| f32::from(u8::from(b)))).collect();
    let should = Tensor::from_vec(should, (moments.len(), 2), logits.device())?;
    // log(1 + exp(-|z|)) + max(z, 0) - z y.
    let soft = (((logits.abs()? * -1.0)?.exp()? + 1.0)?.log()? + logits.relu()?)?;
    (soft - (logits * should)?)?.mean_all()
}

/// Trains for so many steps.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn train(
    model: &Motion,
    data: &Data,
    (windows, moments): (&[&Window], &[&Moment]),
    steps: usize,
    seed: u64,
    mut tell: impl FnMut(usize, f32),
) -> Result<()> {
    let variables = model.ground.variables().chain(model.motion.variables()).chain(model.hazards.variables());
    let variables = variables.collect();
    let params = ParamsAdamW { lr: RATE, weight_decay: 1e-4, ..ParamsAdamW::default() };
    let mut optimiser = AdamW::new(variables, params)?;
    let mut drawn = Drawn::new(windows, |w| (w.place, w.stands), STANDING, seed);
    // As often as they are: what is learned are probabilities.
    let mut watched = Drawn::new(moments, |m| (m.window.place, false), 0.0, seed);
    for step in 0..steps {
        let part = step as f64 / steps as f64;
        // Up in the first hundredth, then down along a cosine.
        let warm = (part / 0.01).min(1.0);
        optimiser.set_learning_rate(
            RATE * warm * (0.02 + 0.98 * 0.5 * (1.0 + vb_math::cos(std::f64::consts::PI * part))),
        );
        // First a second, then all three.
        let horizon = if part < 0.3 {
            5
        } else if part < 0.6 {
            10
        } else {
            STEPS
        };
        let batch = drawn.batch(GROUPS);
        let ahead = foresight(model, data, &watched.batch(GROUPS))?;
        let loss = (loss(model, data, &batch, horizon)? + (ahead * HAZARD)?)?;
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
    let mut drawn = Drawn::new(windows, |w| (w.place, false), 0.0, 0);
    while count < MEASURED as f64 && !drawn.worlds.is_empty() {
        let batch = drawn.batch(64);
        let batch: Vec<&Window> = batch
            .chunks_exact(LANES)
            .filter(|g| g.iter().all(|w| w.place == g[0].place))
            .flatten()
            .copied()
            .collect();
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
                    vb_math::hypot(f64::from(values[0][i] - p.x), f64::from(values[1][i] - p.y)),
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

/// How well a hazard is foreseen.
#[derive(Clone, Debug, Serialize)]
pub struct Foresight {
    /// The fraction of moments after which it comes.
    pub rate: f64,
    /// The area under the receiver operating characteristic.
    pub auc: f64,
    /// Of ten bins of the probability: the mean of what was foreseen, the fraction of what came, and the number of moments.
    pub calibration: Vec<(f64, f64, usize)>,
}

/// How well getting stuck and tipping over are foreseen over moments.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn foreseen(model: &Motion, data: &Data, moments: &[&Moment]) -> Result<[Foresight; 2]> {
    let mut drawn = Drawn::new(moments, |m| (m.window.place, false), 0.0, 0);
    let mut seen: [Vec<(f32, bool)>; 2] = Default::default();
    while seen[0].len() < MEASURED && !drawn.worlds.is_empty() {
        let batch = drawn.batch(64);
        let windows: Vec<&Window> = batch.iter().map(|m| &m.window).collect();
        let logits = model.foresee(data, &windows)?.to_vec2::<f32>()?;
        for (m, z) in batch.iter().zip(logits) {
            seen[0].push((z[0], m.stuck));
            seen[1].push((z[1], m.over));
        }
    }
    Ok(seen.map(|mut all| {
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let came = all.iter().filter(|(_, c)| *c).count();
        // Wilcoxon's rank sum.
        let ranks: f64 = all.iter().enumerate().filter(|(_, (_, c))| *c).map(|(k, _)| k as f64 + 1.0).sum();
        let (p, n) = (came as f64, (all.len() - came) as f64);
        let auc = (ranks - 0.5 * p * (p + 1.0)) / (p * n).max(1.0);
        let mut bins = vec![(0.0, 0.0, 0_usize); 10];
        for (z, c) in &all {
            let p = f64::from(hybrid::probability(*z));
            let bin = &mut bins[((10.0 * p) as usize).min(9)];
            *bin = (bin.0 + p, bin.1 + f64::from(u8::from(*c)), bin.2 + 1);
        }
        let mean = |(p, c, n): (f64, f64, usize)| (p / n.max(1) as f64, c / n.max(1) as f64, n);
        Foresight {
            rate: p / all.len().max(1) as f64,
            auc,
            calibration: bins.into_iter().map(mean).collect(),
        }
    }))
}
