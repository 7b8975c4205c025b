//! The model of motion, as it is rolled out in training: the same sums as [`hybrid::Kinodynamics`] has, on tensors.

use candle_core::{Result, Tensor};
use hybrid::{ACCELERATION, DT, LAG, OUTPUTS, SCALES, SLIP_KEPT, SLIP_LIMIT, TOLD, Units};
use vb_sdk::Vehicle;

use crate::data::{Data, Point, Window};
use crate::network::Dense;
use crate::repeatable::{self, column};
use crate::sight::{Ground, Sight};

/// The networks of the model, and the vehicle.
pub struct Motion {
    /// What of the ground they see.
    pub sight: Sight,
    /// From state, commands and ground to corrections.
    pub motion: Dense,
    /// From the same to the logits of getting stuck and of tipping over.
    pub hazards: Dense,
    units: Units,
    curvature: f64,
    steer_rate: f64,
    /// The time of a step, s.
    dt: f64,
    /// The same in steps at full scale.
    part: f64,
}

/// Hidden values of the networks.
const MOTION: usize = 32;
const HAZARD: usize = 32;

/// The state of many windows, one number each.
pub struct State {
    /// x, y, yaw, speed, side, turn, steering, roll, pitch, slip.
    pub values: [Tensor; 10],
}

impl Motion {
    /// A model of a vehicle with steps of this time (s) that corrects nothing yet.
    pub fn new(vehicle: &Vehicle, sight: Sight, step: f32, seed: u64) -> Result<Self> {
        let units = Units::of(vehicle);
        let inputs = TOLD + sight.seen();
        Ok(Self {
            sight,
            motion: Dense::new("motion", &[inputs, MOTION, MOTION, OUTPUTS], seed)?,
            hazards: Dense::new("hazards", &[inputs, HAZARD, hybrid::HAZARDS], seed)?,
            units,
            curvature: 1.0 / vehicle.min_turn_radius,
            steer_rate: vehicle.max_steer_rate,
            dt: f64::from(step),
            part: f64::from(step) / f64::from(units.rate) / f64::from(DT),
        })
    }

    #[must_use]
    pub fn networks(&self) -> Vec<&Dense> {
        let mut all = self.sight.networks();
        all.extend([&self.motion, &self.hazards]);
        all
    }

    /// What a unit of each value of a [`State`] at full scale is for the vehicle, in the value's own unit (Froude's rule).
    #[must_use]
    pub fn measure(&self) -> [f64; 10] {
        let (speed, rate) = (1.0 / f64::from(self.units.speed), 1.0 / f64::from(self.units.rate));
        // Lengths go with the square of times.
        let length = f64::from(self.units.rate) * f64::from(self.units.rate);
        [length, length, 1.0, speed, speed, rate, 1.0, 1.0, 1.0, speed]
    }

    /// The state at the start of windows.
    pub fn start(windows: &[&Window]) -> Result<State> {
        let fields: [fn(&Point) -> f32; 10] = [
            |p| p.x,
            |p| p.y,
            |p| p.yaw,
            |p| p.speed,
            |p| p.side,
            |p| p.turn,
            |p| p.steering,
            |p| p.roll,
            |p| p.pitch,
            |p| p.slip,
        ];
        let values = fields.map(|f| column(windows.iter().map(|w| f(&w.points[0])).collect()));
        Ok(State { values: all(values)? })
    }

    /// What the networks are told and see: the state, the plane and the commands, and the ground.
    fn inputs(&self, s: &State, [steer, pace]: [&Tensor; 2], ground: &Ground) -> Result<Tensor> {
        let [_, _, _, speed, side, turn, steering, roll, pitch, slip] = &s.values;
        let (per_speed, per_rate) = (f64::from(self.units.speed), f64::from(self.units.rate));
        let [bank, rise] = &ground.plane;
        let parts = [
            (speed * (0.25 * per_speed))?,
            (side * per_speed)?,
            (turn * (2.0 * per_rate))?,
            (roll * 3.0)?,
            (pitch * 3.0)?,
            (bank * 3.0)?,
            (rise * 3.0)?,
            steering.clone(),
            steer.clone(),
            (pace * (0.25 * per_speed))?,
            (slip * (0.25 * per_speed))?,
        ];
        let told = Tensor::cat(&parts, 1)?;
        let seen = self.sight.see(&told, ground)?;
        Tensor::cat(&[told, seen], 1)
    }

    /// The ground under windows' vehicles, as the networks see it.
    fn ground(&self, data: &Data, windows: &[&Window], s: &State) -> Result<Ground> {
        let [x, y, yaw, ..] = &s.values;
        Ground::look(Some(&self.sight), data, windows, [x, y, yaw])
    }

    /// The logits of the hazards at the start of windows.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn foresee(&self, data: &Data, windows: &[&Window]) -> Result<Tensor> {
        let s = Self::start(windows)?;
        let command = |c: usize| column(windows.iter().map(|w| w.points[0].command[c]).collect());
        let ground = self.ground(data, windows, &s)?;
        self.hazards.forward(&self.inputs(&s, [&command(0)?, &command(1)?], &ground)?)
    }

    /// Moves the windows' vehicles on by a step.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn step(&self, data: &Data, windows: &[&Window], s: &State, index: usize) -> Result<State> {
        let [x, y, yaw, speed, _, _, steering, _, _, slip] = &s.values;
        let command = |c: usize| column(windows.iter().map(|w| w.points[index].command[c]).collect());
        let (steer, pace) = (command(0)?, command(1)?);
        let ground = self.ground(data, windows, s)?;
        let (per_speed, per_rate) = (f64::from(self.units.speed), f64::from(self.units.rate));
        let out = self.motion.forward(&self.inputs(s, [&steer, &pace], &ground)?)?;
        let correction = |k: usize| out.narrow(1, k, 1)? * f64::from(SCALES[k]);
        let dt = self.dt;
        let most = self.steer_rate * dt;
        let steering = (steering + (&steer - steering)?.clamp(-most, most)?)?;
        let gain = (self.part * f64::from(DT) / f64::from(LAG)).min(1.0);
        let change = f64::from(ACCELERATION) * dt;
        let own = ((&pace - speed)? * gain)?.clamp(-change, change)?;
        // Within a longer step more happens, as planners have it.
        let next = ((speed + own)? + ((correction(0)? * self.part)? / per_speed)?)?;
        let way = ((speed + &next)? * (0.5 * dt))?;
        let turn = ((&next * self.curvature)? * &steering)?.add(&(correction(1)? / per_rate)?)?;
        let side = (correction(2)? / per_speed)?;
        let kept = (slip * (f64::from(SLIP_KEPT) * per_speed))?;
        let slip = ((kept + correction(5)?)?.clamp(-SLIP_LIMIT, SLIP_LIMIT)? / per_speed)?;
        let level = ((ground.plane[1].sqr()? * -0.5)? + 1.0)?;
        let way = (way * level)?;
        let middle = (yaw + (&turn * (0.5 * dt))?)?;
        let (cos, sin) = (repeatable::cos(&middle)?, repeatable::sin(&middle)?);
        let aside = (&side * dt)?;
        let x = ((x + (&way * &cos)?)? - (&aside * &sin)?)?;
        let y = ((y + (&way * &sin)?)? + (&aside * &cos)?)?;
        let yaw = (yaw + (&turn * dt)?)?;
        let [bank, rise] = Ground::look(None, data, windows, [&x, &y, &yaw])?.plane;
        let (roll, pitch) = ((bank + correction(3)?)?, (rise + correction(4)?)?);
        Ok(State { values: [x, y, yaw, next, side, turn, steering, roll, pitch, slip] })
    }
}

fn all<const N: usize>(values: [Result<Tensor>; N]) -> Result<[Tensor; N]> {
    let values = values.into_iter().collect::<Result<Vec<_>>>()?;
    values.try_into().map_err(|_| candle_core::Error::Msg("another number of tensors".into()))
}

/// Where the windows' vehicles were at the end of a step: x, y, yaw, speed, side, turn, steering, roll, pitch, slip.
///
/// # Errors
/// Returns an error if there is no memory.
pub fn truth(windows: &[&Window], index: usize) -> Result<[Tensor; 10]> {
    let ended: Vec<Window> = windows
        .iter()
        .map(|w| Window { place: w.place, points: vec![w.points[index]], stands: w.stands })
        .collect();
    Ok(Motion::start(&ended.iter().collect::<Vec<_>>())?.values)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::data::{PlaceOf, Timing};
    use crate::repeatable::numbers;
    use hybrid::{Kinodynamics, Learned, Terrain};
    use vb_sdk::mppi::LANES;
    use vb_sdk::mppi::Model as _;
    use vb_sdk::nn::Weights;
    use vb_sdk::{GridFrame, Map};

    const FRAME: GridFrame =
        GridFrame { rows: 81, cols: 81, resolution: 1.0, origin_x: -40.0, origin_y: -40.0 };

    /// The HMMWV at a scale, with a wheelbase that may be another vehicle's.
    pub(crate) fn vehicle(scale: f64, wheelbase: f64) -> Vehicle {
        Vehicle {
            wheelbase: scale * wheelbase,
            track: scale * 1.8,
            min_turn_radius: scale * 5.2,
            max_steer_rate: 1.5 / scale.sqrt(),
            scale,
            ..Vehicle::default()
        }
    }

    /// A slope of gravel, whose patches are alike everywhere: what a table interpolates is then what the network gives.
    pub(crate) fn terrain(vehicle: &Vehicle) -> (Map<f32>, Terrain) {
        let height = |k: usize| 0.08 * (k % 81) as f32 - 0.05 * (k / 81) as f32;
        let heights = Map { frame: FRAME, data: (0..81 * 81).map(height).collect() };
        let classes = Map { frame: FRAME, data: vec![4; 81 * 81] };
        let terrain = Terrain::new(&heights, Some(&classes), vehicle).unwrap();
        (heights, terrain)
    }

    /// So that weights of the HMMWV come out as they did when all was in its measure.
    #[test]
    fn in_the_measure_of_the_hmmwv_nothing_is_scaled() {
        let model = Motion::new(&vehicle(1.0, 3.302), Sight::patch(3).unwrap(), DT, 3).unwrap();
        assert_eq!((model.part, model.measure()), (1.0, [1.0; 10]));
        let car = Motion::new(&vehicle(0.1, 3.302), Sight::patch(3).unwrap(), DT, 3).unwrap();
        let [length, _, _, speed, _, rate, ..] = car.measure();
        let root = 0.1_f64.sqrt();
        for (own, froude) in [(length, 0.1), (speed, root), (rate, 1.0 / root)] {
            assert!((own / froude - 1.0).abs() < 1e-6, "{own} for {froude}");
        }
    }

    #[test]
    fn planners_roll_out_what_was_trained() {
        for sight in [Sight::patch(3), Sight::attention(3)] {
            held_against_each_other(sight.unwrap(), &vehicle(1.0, 3.302), 10);
        }
    }

    /// The step is 0.2 s whatever the wheelbase is, and at 1/10 three frames of 0.02 s make one of 0.06 s, which is not quite Froude's.
    #[test]
    fn so_they_do_with_vehicles_of_other_sizes() {
        for (vehicle, hz) in [(vehicle(1.0, 4.5), 10), (vehicle(0.1, 3.302), 50)] {
            held_against_each_other(Sight::patch(3).unwrap(), &vehicle, hz);
        }
    }

    fn held_against_each_other(sight: Sight, vehicle: &Vehicle, hz: u32) {
        let scale = vehicle.scale as f32;
        let root = scale.sqrt();
        let note = ("sight".to_owned(), sight.name().to_owned());
        let timing = Timing::new(hz, vehicle).unwrap();
        let model = Motion::new(vehicle, sight, timing.step(), 3).unwrap();
        let mut points = vec![Point::default(); 16];
        for (k, p) in points.iter_mut().enumerate() {
            p.command = [0.6 * vb_math::sin(0.4 * k as f64) as f32, root * (2.0 + 0.2 * k as f32)];
        }
        points[0] = Point {
            x: scale * 1.5,
            y: scale * -2.0,
            yaw: 0.3,
            speed: root,
            side: 0.1 * root,
            turn: 0.05 / root,
            slip: 0.7 * root,
            ..points[0]
        };
        let window = Window { place: 0, points, stands: false };
        let windows = [&window; LANES];
        let (heights, terrain) = terrain(vehicle);
        let place = PlaceOf {
            hash: String::new(),
            kind: vb_world::Terrain::Rigid,
            heights: heights.clone(),
            terrain: terrain.clone(),
        };
        let data = Data { places: vec![place], ..Data::new(timing) };

        // Through the file, as planners have them.
        let layers = model.networks().into_iter().map(Dense::layers);
        let layers = layers.collect::<Result<Vec<_>>>().unwrap().concat();
        let weights = Weights::parse(&Weights { notes: vec![note], layers }.bytes()).unwrap();
        let own = Kinodynamics::new(&heights, terrain, &weights, vehicle, Learned::All).unwrap();

        let p = window.points[0];
        let all = |v: f32| [v; LANES];
        let (cos, sin) = (vb_math::cos(f64::from(p.yaw)) as f32, vb_math::sin(f64::from(p.yaw)) as f32);
        let mut s = hybrid::State {
            plane: own.terrain().plane([&all(p.x), &all(p.y)], [&all(cos), &all(sin)]),
            x: all(p.x),
            y: all(p.y),
            cos: all(cos),
            sin: all(sin),
            speed: all(p.speed),
            side: all(p.side),
            turn: all(p.turn),
            steering: all(p.steering),
            slip: all(p.slip),
            roll: all(p.roll),
            pitch: all(p.pitch),
            stuck: all(0.0),
            over: all(0.0),
        };
        let mut state = Motion::start(&windows).unwrap();
        let logits = model.foresee(&data, &windows).unwrap().to_vec2::<f32>().unwrap();
        for k in 0..15 {
            state = model.step(&data, &windows, &state, k).unwrap();
            own.step(&mut s, &window.points[k].command.map(all), timing.step());
            if k == 0 {
                assert!((s.stuck[0] - hybrid::probability(logits[0][0])).abs() < 1e-3);
                assert!((s.over[0] - hybrid::probability(logits[0][1])).abs() < 1e-3);
            }
            let trained = state.values.each_ref().map(|t| numbers(t).unwrap()[0]);
            let yaw = vb_math::atan2(f64::from(s.sin[0]), f64::from(s.cos[0])) as f32;
            let rolled =
                [s.x, s.y, [yaw; LANES], s.speed, s.side, s.turn, s.steering, s.roll, s.pitch, s.slip];
            for (i, (a, b)) in trained.iter().zip(rolled.map(|v| v[0])).enumerate() {
                // Planners turn headings by small angles' sines, which after 3 s is off by some millimetres at full scale.
                let unit = [scale, scale, 1.0, root, root, 1.0 / root, 1.0, 1.0, 1.0, root][i];
                assert!((a - b).abs() < 0.01 * unit, "value {i} after step {k}: trained {a}, rolled out {b}");
            }
        }
        // It has gone somewhere, by a curve.
        let yaw = vb_math::atan2(f64::from(s.sin[0]), f64::from(s.cos[0]));
        assert!(s.x[0] / scale - 1.5 > 5.0 && (yaw - f64::from(p.yaw)).abs() > 0.1, "{s:?}");
    }
}
