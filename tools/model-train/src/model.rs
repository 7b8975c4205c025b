//! The model of motion, as it is rolled out in training: the same sums as [`hybrid::Kinodynamics`] has, on tensors.

use candle_core::{Device, Result, Tensor};
use hybrid::{CHANNELS, DT, INPUTS, OUTPUTS, PATCH, SCALES, Units, heading, heading_of};
use vb_sdk::Vehicle;
use vb_sdk::mppi::{LANES, Lanes};

use crate::data::{Data, Point, Window};
use crate::network::Dense;

/// The networks of the model, and the vehicle.
pub struct Motion {
    /// From a patch to [`CHANNELS`] numbers.
    pub ground: Dense,
    /// From state, commands and ground to corrections.
    pub motion: Dense,
    /// From the same to the logits of getting stuck and of tipping over.
    pub hazards: Dense,
    units: Units,
    curvature: f64,
    steer_rate: f64,
    dt: f64,
}

/// Hidden values of the networks.
const GROUND: usize = 24;
const MOTION: usize = 24;
const HAZARD: usize = 16;

/// The state of many windows, one number each.
pub struct State {
    /// x, y, yaw, speed, side, turn, steering, roll, pitch.
    pub values: [Tensor; 9],
}

fn column(values: Vec<f32>) -> Result<Tensor> {
    let n = values.len();
    Tensor::from_vec(values, (n, 1), &Device::Cpu)
}

fn numbers(t: &Tensor) -> Result<Vec<f32>> {
    t.flatten_all()?.to_vec1()
}

/// The plane under the vehicles, and the patches where they are wanted: computed eight at a time, each eight in one world.
fn ground(
    data: &Data,
    windows: &[&Window],
    at: [&Tensor; 3],
    patches: bool,
) -> Result<([Tensor; 2], Option<Tensor>)> {
    let [x, y, yaw] = [numbers(at[0])?, numbers(at[1])?, numbers(at[2])?];
    let n = windows.len();
    let (mut bank, mut rise) = (vec![0.0; n], vec![0.0; n]);
    let mut all = vec![0.0; if patches { n * PATCH } else { 0 }];
    let mut patch = [[0.0; LANES]; PATCH];
    for first in (0..n).step_by(LANES) {
        let terrain = &data.places[windows[first].place].terrain;
        let of = |v: &[f32]| -> Lanes { std::array::from_fn(|l| v[first + l]) };
        let (px, py) = (of(&x), of(&y));
        let angles: [(f64, f64); LANES] = of(&yaw).map(|a| vb_math::sin_cos(f64::from(a)));
        let (cos, sin) = (angles.map(|a| a.1 as f32), angles.map(|a| a.0 as f32));
        let [_, b, r] = terrain.plane([&px, &py], [&cos, &sin]);
        bank[first..first + LANES].copy_from_slice(&b);
        rise[first..first + LANES].copy_from_slice(&r);
        if patches {
            // Planners have patches at some headings only.
            let headings: [[f32; 2]; LANES] = std::array::from_fn(|l| heading(heading_of(cos[l], sin[l])));
            let (cos, sin) = (headings.map(|h| h[0]), headings.map(|h| h[1]));
            terrain.patch([&px, &py], [&cos, &sin], &mut patch);
            for l in 0..LANES {
                for (k, values) in patch.iter().enumerate() {
                    all[(first + l) * PATCH + k] = values[l];
                }
            }
        }
    }
    let patches = patches.then(|| Tensor::from_vec(all, (n, PATCH), &Device::Cpu)).transpose()?;
    Ok(([column(bank)?, column(rise)?], patches))
}

impl Motion {
    /// A model of a vehicle that corrects nothing yet.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn new(vehicle: &Vehicle, seed: u64) -> Result<Self> {
        let units = Units::of(vehicle);
        Ok(Self {
            ground: Dense::new("ground", &[PATCH, GROUND, CHANNELS], seed)?,
            motion: Dense::new("motion", &[INPUTS, MOTION, MOTION, OUTPUTS], seed)?,
            hazards: Dense::new("hazards", &[INPUTS, HAZARD, hybrid::HAZARDS], seed)?,
            units,
            curvature: 1.0 / vehicle.min_turn_radius,
            steer_rate: vehicle.max_steer_rate,
            // Of steps at the vehicle's own scale.
            dt: f64::from(DT) * f64::from(units.rate),
        })
    }

    /// The state at the start of windows.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn start(windows: &[&Window]) -> Result<State> {
        let fields: [fn(&Point) -> f32; 9] = [
            |p| p.x,
            |p| p.y,
            |p| p.yaw,
            |p| p.speed,
            |p| p.side,
            |p| p.turn,
            |p| p.steering,
            |p| p.roll,
            |p| p.pitch,
        ];
        let values = fields.map(|f| column(windows.iter().map(|w| f(&w.points[0])).collect()));
        Ok(State { values: all(values)? })
    }

    /// What the networks are told: the state, the plane and the commands, and the ground.
    fn inputs(&self, s: &State, [bank, rise, steer, pace]: [Tensor; 4], patches: &Tensor) -> Result<Tensor> {
        let [_, _, _, speed, side, turn, steering, roll, pitch] = &s.values;
        let (per_speed, per_rate) = (f64::from(self.units.speed), f64::from(self.units.rate));
        let parts = [
            (speed * (0.25 * per_speed))?,
            (side * per_speed)?,
            (turn * (2.0 * per_rate))?,
            (roll * 3.0)?,
            (pitch * 3.0)?,
            (bank * 3.0)?,
            (rise * 3.0)?,
            steering.clone(),
            steer,
            (pace * (0.25 * per_speed))?,
            self.ground.forward(patches)?,
        ];
        Tensor::cat(&parts, 1)
    }

    /// The logits of the hazards at the start of windows.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn foresee(&self, data: &Data, windows: &[&Window]) -> Result<Tensor> {
        let s = Self::start(windows)?;
        let command = |c: usize| column(windows.iter().map(|w| w.points[0].command[c]).collect());
        let [x, y, yaw, ..] = &s.values;
        let ([bank, rise], patches) = ground(data, windows, [x, y, yaw], true)?;
        let patches = patches.ok_or_else(|| candle_core::Error::Msg("no patches".into()))?;
        self.hazards.forward(&self.inputs(&s, [bank, rise, command(0)?, command(1)?], &patches)?)
    }

    /// Moves the windows' vehicles on by a step; without `learned`, as a bicycle on the plane.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn step(
        &self,
        data: &Data,
        windows: &[&Window],
        s: &State,
        index: usize,
        learned: bool,
    ) -> Result<State> {
        let [x, y, yaw, speed, _, _, steering, _, _] = &s.values;
        let command = |c: usize| column(windows.iter().map(|w| w.points[index].command[c]).collect());
        let (steer, pace) = (command(0)?, command(1)?);
        let ([bank, rise], patches) = ground(data, windows, [x, y, yaw], learned)?;
        let (per_speed, per_rate) = (f64::from(self.units.speed), f64::from(self.units.rate));
        let out = match patches {
            Some(patches) => {
                let own = [bank.clone(), rise.clone(), steer.clone(), pace.clone()];
                self.motion.forward(&self.inputs(s, own, &patches)?)?
            }
            None => Tensor::zeros((windows.len(), OUTPUTS), candle_core::DType::F32, &Device::Cpu)?,
        };
        let correction = |k: usize| out.narrow(1, k, 1)? * f64::from(SCALES[k]);
        let dt = self.dt;
        let most = self.steer_rate * dt;
        let steering = (steering + (&steer - steering)?.clamp(-most, most)?)?;
        // Lag of 0.5 s and 3 m/s² of change at most, as in the planners.
        let gain = f64::from(DT) / 0.5;
        let own = ((&pace - speed)? * gain)?.clamp(-3.0 * dt, 3.0 * dt)?;
        let next = ((speed + own)? + (correction(0)? / per_speed)?)?;
        let way = ((speed + &next)? * (0.5 * dt))?;
        let turn = ((&next * self.curvature)? * &steering)?.add(&(correction(1)? / per_rate)?)?;
        let side = (correction(2)? / per_speed)?;
        let level = ((rise.sqr()? * -0.5)? + 1.0)?;
        let way = (way * level)?;
        let middle = (yaw + (&turn * (0.5 * dt))?)?;
        let (cos, sin) = (middle.cos()?, middle.sin()?);
        let aside = (&side * dt)?;
        let x = ((x + (&way * &cos)?)? - (&aside * &sin)?)?;
        let y = ((y + (&way * &sin)?)? + (&aside * &cos)?)?;
        let yaw = (yaw + (&turn * dt)?)?;
        let ([bank, rise], _) = ground(data, windows, [&x, &y, &yaw], false)?;
        let (roll, pitch) = ((bank + correction(3)?)?, (rise + correction(4)?)?);
        Ok(State { values: [x, y, yaw, next, side, turn, steering, roll, pitch] })
    }
}

fn all<const N: usize>(values: [Result<Tensor>; N]) -> Result<[Tensor; N]> {
    let values = values.into_iter().collect::<Result<Vec<_>>>()?;
    values.try_into().map_err(|_| candle_core::Error::Msg("another number of tensors".into()))
}

/// Where the windows' vehicles were at the end of a step: x, y, yaw, speed, side, turn, steering, roll, pitch.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn truth(windows: &[&Window], index: usize) -> Result<[Tensor; 9]> {
    let ended: Vec<Window> = windows
        .iter()
        .map(|w| Window { place: w.place, points: vec![w.points[index]], stands: w.stands })
        .collect();
    Ok(Motion::start(&ended.iter().collect::<Vec<_>>())?.values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::PlaceOf;
    use hybrid::{Kinodynamics, Learned, Table, Terrain};
    use vb_sdk::mppi::Model as _;
    use vb_sdk::nn::{Network, Weights};
    use vb_sdk::{GridFrame, Map};

    const FRAME: GridFrame =
        GridFrame { rows: 81, cols: 81, resolution: 1.0, origin_x: -40.0, origin_y: -40.0 };

    fn vehicle() -> Vehicle {
        Vehicle {
            wheelbase: 3.302,
            track: 1.8,
            min_turn_radius: 5.2,
            max_steer_rate: 1.5,
            ..Vehicle::default()
        }
    }

    /// A slope of gravel, whose patches are alike everywhere: what a table interpolates is then what the network gives.
    fn terrain() -> Terrain {
        let height = |k: usize| 0.08 * (k % 81) as f32 - 0.05 * (k / 81) as f32;
        let heights = Map { frame: FRAME, data: (0..81 * 81).map(height).collect() };
        let classes = Map { frame: FRAME, data: vec![4; 81 * 81] };
        Terrain::new(&heights, Some(&classes), &vehicle()).unwrap()
    }

    #[test]
    fn planners_roll_out_what_was_trained() {
        let model = Motion::new(&vehicle(), 3).unwrap();
        let mut points = vec![Point::default(); 16];
        for (k, p) in points.iter_mut().enumerate() {
            p.command = [0.6 * vb_math::sin(0.4 * k as f64) as f32, 2.0 + 0.2 * k as f32];
        }
        points[0] = Point { x: 1.5, y: -2.0, yaw: 0.3, speed: 1.0, side: 0.1, turn: 0.05, ..points[0] };
        let window = Window { place: 0, points, stands: false };
        let windows = [&window; LANES];
        let place = PlaceOf { hash: String::new(), kind: "rigid".into(), terrain: terrain() };
        let data = Data { places: vec![place], ..Data::default() };

        // Through the file, as planners have them.
        let layers = [model.ground.layers(), model.motion.layers(), model.hazards.layers()];
        let layers = layers.into_iter().collect::<Result<Vec<_>>>().unwrap().concat();
        let weights = Weights::parse(&Weights { notes: Vec::new(), layers }.bytes()).unwrap();
        let network = |name: &str, i, o| -> Network { weights.network(name, i, o).unwrap() };
        let table = Table::new(FRAME, &terrain(), &network("ground", PATCH, CHANNELS));
        let networks = [network("motion", INPUTS, OUTPUTS), network("hazards", INPUTS, hybrid::HAZARDS)];
        let own = Kinodynamics::new(terrain(), table, networks, &vehicle(), Learned::All);

        let p = window.points[0];
        let all = |v: f32| [v; LANES];
        let mut s = hybrid::State {
            x: all(p.x),
            y: all(p.y),
            cos: all(vb_math::cos(f64::from(p.yaw)) as f32),
            sin: all(vb_math::sin(f64::from(p.yaw)) as f32),
            speed: all(p.speed),
            side: all(p.side),
            turn: all(p.turn),
            steering: all(p.steering),
            roll: all(p.roll),
            pitch: all(p.pitch),
            stuck: all(0.0),
            over: all(0.0),
        };
        let mut state = Motion::start(&windows).unwrap();
        let logits = model.foresee(&data, &windows).unwrap().to_vec2::<f32>().unwrap();
        for k in 0..15 {
            state = model.step(&data, &windows, &state, k, true).unwrap();
            own.step(&mut s, &window.points[k].command.map(all), DT);
            if k == 0 {
                assert!((s.stuck[0] - hybrid::probability(logits[0][0])).abs() < 1e-3);
                assert!((s.over[0] - hybrid::probability(logits[0][1])).abs() < 1e-3);
            }
            let trained = state.values.each_ref().map(|t| numbers(t).unwrap()[0]);
            let yaw = vb_math::atan2(f64::from(s.sin[0]), f64::from(s.cos[0])) as f32;
            let rolled =
                [s.x[0], s.y[0], yaw, s.speed[0], s.side[0], s.turn[0], s.steering[0], s.roll[0], s.pitch[0]];
            for (i, (a, b)) in trained.iter().zip(rolled).enumerate() {
                // Planners turn headings by small angles' sines, which after 3 s is off by some millimetres.
                assert!((a - b).abs() < 0.01, "value {i} after step {k}: trained {a}, rolled out {b}");
            }
        }
        // It has gone somewhere, by a curve.
        assert!(s.x[0] - 1.5 > 5.0 && s.cos[0] < 0.99, "{s:?}");
    }
}
