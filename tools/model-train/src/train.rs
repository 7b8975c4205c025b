//! The loop of training.

use candle_core::{Result, Tensor};
use candle_nn::{AdamW, Optimizer as _, ParamsAdamW};
use vb_math::rng::Stream;
use vb_sdk::mppi::LANES;

use crate::data::{Data, Moment, STEPS, Window};
use crate::model::{Motion, truth};
use crate::repeatable::{mean, soft_plus};

/// Windows of a step of training, in groups of one world each.
const GROUPS: usize = 48;
/// The learning rate at its highest.
const RATE: f64 = 3e-3;
/// The fraction of windows in which the vehicle stands.
const STANDING: f64 = 0.15;
/// The weight of the hazards' cross entropy in the loss.
const HAZARD: f64 = 4.0;

/// Units in which the errors of x and y, yaw, speeds, yaw rate, steering, roll, pitch and slip count alike, at full scale: m, rad,
/// m/s, rad/s, 1, rad, m/s.
const UNITS: [f64; 10] = [0.3, 0.3, 0.1, 0.4, 0.4, 0.2, 1.0, 0.05, 0.05, 1.0];
/// What is learned: all but the steering, which follows its command.
const LEARNED: [usize; 9] = [0, 1, 2, 3, 4, 5, 7, 8, 9];

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
    let measure = model.measure();
    let units: [f64; 10] = std::array::from_fn(|i| UNITS[i] * measure[i]);
    let mut total: Option<Tensor> = None;
    for k in 0..steps {
        state = model.step(data, windows, &state, k)?;
        for (i, should) in truth(windows, k + 1)?.iter().enumerate().filter(|(i, _)| LEARNED.contains(i)) {
            let e = ((&state.values[i] - should)? / units[i])?;
            // Headings differ by less than half a turn.
            let e = if i == 2 { around(&e, units[2])? } else { e };
            let own = mean(&((e.sqr()? + 1.0)?.sqrt()? - 1.0)?)?;
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
    // log(1 + exp(z)) - z y.
    mean(&(soft_plus(&logits)? - (logits * should)?)?)
}

/// Trains for so many steps.
pub fn train(
    model: &Motion,
    data: &Data,
    (windows, moments): (&[&Window], &[&Moment]),
    steps: usize,
    seed: u64,
    mut tell: impl FnMut(usize, f32),
) -> Result<()> {
    let variables = model.networks().into_iter().flat_map(|n| n.variables().collect::<Vec<_>>()).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{PlaceOf, Point, Timing};
    use crate::model::tests::{terrain, vehicle};
    use crate::sight::Sight;
    use vb_sdk::nn::Weights;

    /// Weights that a processor of another kind would make as well: `cargo xtask targets --emulate` runs this test on some. The hashes
    /// are a snapshot; what trains better may change them.
    #[test]
    fn training_gives_the_same_bits_on_every_machine() {
        let vehicle = vehicle(1.0, 3.302);
        let timing = Timing::new(10, &vehicle).unwrap();
        let (heights, terrain) = terrain(&vehicle);
        let place = PlaceOf { hash: String::new(), kind: vb_world::Terrain::Rigid, heights, terrain };
        let data = Data { places: vec![place], ..Data::new(timing) };
        let mut random = Stream::new(7, &["test"]);
        let mut draw = |scale: f64| random.normal(0.0, scale) as f32;
        let windows: Vec<Window> = (0..2 * LANES)
            .map(|k| {
                let points = (0..=STEPS).map(|_| Point {
                    x: draw(5.0),
                    y: draw(5.0),
                    yaw: draw(1.0),
                    roll: draw(0.1),
                    pitch: draw(0.1),
                    speed: 3.0 + draw(1.0),
                    side: draw(0.2),
                    turn: draw(0.3),
                    steering: draw(0.3),
                    slip: draw(0.5),
                    command: [draw(0.4), 3.0 + draw(1.0)],
                });
                Window { place: 0, points: points.collect(), stands: k > LANES }
            })
            .collect();
        let moments: Vec<Moment> = windows
            .iter()
            .enumerate()
            .map(|(k, w)| Moment { window: w.clone(), stuck: k % 3 == 0, over: k % 5 == 0 })
            .collect();
        let (windows, moments): (Vec<_>, Vec<_>) = (windows.iter().collect(), moments.iter().collect());
        let hashes = [Sight::patch(3), Sight::attention(3)].map(|sight| {
            let model = Motion::new(&vehicle, sight.unwrap(), timing.step(), 3).unwrap();
            train(&model, &data, (&windows, &moments), 4, 3, |_, _| ()).unwrap();
            let layers = model.networks().into_iter().flat_map(|n| n.layers().unwrap()).collect();
            vb_files::sha256(&Weights { notes: Vec::new(), layers }.bytes())
        });
        let should = [
            "2ce02679a45ab41f35b86ff445bfa60fa6bfe1309dbfbac2751ec8001dc3e54c",
            "5916e39dbb5dea4410de7718abc1df2ee1aaabd0b6f40da403f08345a78109e9",
        ];
        assert_eq!(hashes, should);
    }
}
