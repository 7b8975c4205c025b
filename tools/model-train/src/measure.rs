//! How good the model is in worlds that it has not seen, as planners roll it out: with the table of what its network makes of the
//! ground at the nodes of the map.

use std::collections::BTreeMap;

use hybrid::{DT, Kinodynamics, Learned, State};
use serde::Serialize;
use vb_sdk::Vehicle;
use vb_sdk::mppi::{LANES, Lanes, Model as _};
use vb_sdk::nn::Weights;

use crate::TrainError;
use crate::data::{Data, Moment, PlaceOf, Point, STEPS, Window};

/// Windows and moments that are measured, at most.
const MEASURED: usize = 32_768;

/// Mean errors at a time.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// The time, s.
    pub time_s: f64,
    /// Of the place, m.
    pub position_m: f64,
    /// Of the heading, rad.
    pub yaw_rad: f64,
    pub speed_m_per_s: f64,
    pub roll_rad: f64,
    pub pitch_rad: f64,
}

/// The ways to predict, by their names: speed, yaw rate, roll and pitch stay as they are; the bicycle on the plane; the model.
pub const WAYS: [&str; 3] = ["constant velocity", "bicycle and plane", "learned"];
/// The times at full scale for which errors are told, and the steps that they are the mean of: 0.5 s lies between two.
const TOLD: [(f64, usize, usize); 3] = [(0.5, 2, 3), (1.0, 5, 5), (3.0, 15, 15)];

/// Sums of errors after each step, and their number.
#[derive(Clone, Copy, Default)]
struct Sums([[f64; 5]; STEPS + 1], f64);

/// The bicycle at a place, and the model.
fn models(place: &PlaceOf, weights: &Weights, vehicle: &Vehicle) -> Result<[Kinodynamics; 2], TrainError> {
    let terrain = place.terrain.clone();
    let model = Kinodynamics::new(&place.heights, terrain, weights, vehicle, Learned::All);
    let model = model.map_err(|e| TrainError::Weights(e.to_string()))?;
    Ok([model.clone().hearing(Learned::Nothing), model])
}

/// States of vehicles, eight at most; the last stands for those that there aren't.
fn states(points: &[Point], model: &Kinodynamics) -> State {
    let all =
        |f: fn(&Point) -> f32| -> Lanes { std::array::from_fn(|l| f(&points[l.min(points.len() - 1)])) };
    let (x, y) = (all(|p| p.x), all(|p| p.y));
    let cos = all(|p| vb_math::cos(f64::from(p.yaw)) as f32);
    let sin = all(|p| vb_math::sin(f64::from(p.yaw)) as f32);
    State {
        plane: model.terrain().plane([&x, &y], [&cos, &sin]),
        x,
        y,
        cos,
        sin,
        speed: all(|p| p.speed),
        side: all(|p| p.side),
        turn: all(|p| p.turn),
        steering: all(|p| p.steering),
        slip: all(|p| p.slip),
        roll: all(|p| p.roll),
        pitch: all(|p| p.pitch),
        stuck: [0.0; LANES],
        over: [0.0; LANES],
    }
}

fn commands(points: &[Point]) -> [Lanes; 2] {
    std::array::from_fn(|c| std::array::from_fn(|l| points[l.min(points.len() - 1)].command[c]))
}

/// Moves the vehicles on as they are: with their speed and yaw rate.
fn constant(s: &mut State, dt: f32) {
    for l in 0..LANES {
        let yaw = vb_math::atan2(f64::from(s.sin[l]), f64::from(s.cos[l])) + f64::from(s.turn[l] * dt);
        let middle = yaw - 0.5 * f64::from(s.turn[l] * dt);
        s.x[l] += s.speed[l] * dt * vb_math::cos(middle) as f32;
        s.y[l] += s.speed[l] * dt * vb_math::sin(middle) as f32;
        (s.cos[l], s.sin[l]) = (vb_math::cos(yaw) as f32, vb_math::sin(yaw) as f32);
    }
}

impl Sums {
    /// Adds the errors after a step.
    fn add(&mut self, step: usize, s: &State, truth: &[Point]) {
        for (l, p) in truth.iter().enumerate() {
            let off = |a: f32, b: f32| f64::from((a - b).abs());
            let yaw = vb_math::atan2(f64::from(s.sin[l]), f64::from(s.cos[l])) - f64::from(p.yaw);
            let turn = std::f64::consts::TAU;
            let own = [
                vb_math::hypot(f64::from(s.x[l] - p.x), f64::from(s.y[l] - p.y)),
                (yaw - turn * (yaw / turn).round()).abs(),
                off(s.speed[l], p.speed),
                off(s.roll[l], p.roll),
                off(s.pitch[l], p.pitch),
            ];
            self.0[step].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
    }

    /// The mean errors, of steps of this time (s).
    fn errors(&self, step: f32) -> Vec<Errors> {
        let at = |(time_s, a, b): (f64, usize, usize)| {
            let mean = |i: usize| 0.5 * (self.0[a][i] + self.0[b][i]) / self.1.max(1.0);
            Errors {
                time_s: time_s * f64::from(step / DT),
                position_m: mean(0),
                yaw_rad: mean(1),
                speed_m_per_s: mean(2),
                roll_rad: mean(3),
                pitch_rad: mean(4),
            }
        };
        TOLD.map(at).to_vec()
    }
}

/// Some of all, at equal distances, by their places.
fn by_place<'a, T>(all: &[&'a T], place: impl Fn(&T) -> usize) -> BTreeMap<usize, Vec<&'a T>> {
    let mut places: BTreeMap<usize, Vec<&T>> = BTreeMap::new();
    for one in all.iter().step_by(all.len().div_ceil(MEASURED).max(1)) {
        places.entry(place(one)).or_default().push(one);
    }
    places
}

pub struct Measured {
    /// The mean errors of each of [`WAYS`], by the ground of the worlds: `all`, `rigid`, `deformable`, `mixed`.
    pub errors: BTreeMap<String, [Vec<Errors>; 3]>,
    /// How getting stuck and tipping over are foreseen.
    pub hazards: [Foresight; 2],
}

/// Measures weights on windows in which the vehicle moves, and on moments.
///
/// # Errors
/// Returns an error if the weights lack a network.
pub fn measure(
    weights: &Weights,
    vehicle: &Vehicle,
    data: &Data,
    (windows, moments): (&[&Window], &[&Moment]),
) -> Result<Measured, TrainError> {
    let mut sums: BTreeMap<String, [Sums; 3]> = BTreeMap::new();
    let mut seen: [Vec<(f32, bool)>; 2] = Default::default();
    let dt = data.timing.step();
    let mut watched = by_place(moments, |m| m.window.place);
    for (place, windows) in by_place(windows, |w| w.place) {
        let here = &data.places[place];
        let [bicycle, learned] = models(here, weights, vehicle)?;
        let mut own = [Sums::default(); 3];
        for group in windows.chunks(LANES) {
            let at = |k: usize| group.iter().map(|w| w.points[k]).collect::<Vec<Point>>();
            let mut rolled = std::array::from_fn::<State, 3, _>(|_| states(&at(0), &learned));
            for k in 0..STEPS {
                let (command, truth) = (commands(&at(k)), at(k + 1));
                constant(&mut rolled[0], dt);
                bicycle.step(&mut rolled[1], &command, dt);
                learned.step(&mut rolled[2], &command, dt);
                own.iter_mut().zip(&rolled).for_each(|(sums, s)| sums.add(k + 1, s, &truth));
            }
            own.iter_mut().for_each(|sums| sums.1 += group.len() as f64);
        }
        for kind in ["all", here.kind.name()] {
            let all = sums.entry(kind.to_owned()).or_default();
            for (all, own) in all.iter_mut().zip(&own) {
                let numbers = all.0.iter_mut().flatten().zip(own.0.iter().flatten());
                numbers.for_each(|(all, own)| *all += own);
                all.1 += own.1;
            }
        }
        for group in watched.remove(&place).unwrap_or_default().chunks(LANES) {
            let points: Vec<Point> = group.iter().map(|m| m.window.points[0]).collect();
            let mut s = states(&points, &learned);
            learned.step(&mut s, &commands(&points), dt);
            for (l, m) in group.iter().enumerate() {
                seen[0].push((s.stuck[l], m.stuck));
                seen[1].push((s.over[l], m.over));
            }
        }
    }
    let errors = sums.into_iter().map(|(kind, sums)| (kind, sums.map(|s| s.errors(dt)))).collect();
    Ok(Measured { errors, hazards: seen.map(Foresight::of) })
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

impl Foresight {
    /// Of probabilities, and whether the hazard came.
    fn of(mut all: Vec<(f32, bool)>) -> Self {
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let came = all.iter().filter(|(_, c)| *c).count();
        // Wilcoxon's rank sum.
        let ranks: f64 = all.iter().enumerate().filter(|(_, (_, c))| *c).map(|(k, _)| k as f64 + 1.0).sum();
        let (p, n) = (came as f64, (all.len() - came) as f64);
        let auc = (ranks - 0.5 * p * (p + 1.0)) / (p * n).max(1.0);
        let mut bins = vec![(0.0, 0.0, 0_usize); 10];
        for (p, c) in &all {
            let p = f64::from(*p);
            let bin = &mut bins[((10.0 * p) as usize).min(9)];
            *bin = (bin.0 + p, bin.1 + f64::from(u8::from(*c)), bin.2 + 1);
        }
        let mean = |(p, c, n): (f64, f64, usize)| (p / n.max(1) as f64, c / n.max(1) as f64, n);
        Self { rate: p / all.len().max(1) as f64, auc, calibration: bins.into_iter().map(mean).collect() }
    }
}
