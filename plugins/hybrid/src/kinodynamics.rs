//! Learned 6-DoF kinodynamics.

use std::cell::RefCell;

use vb_sdk::mppi::{LANES, Lanes, Model};
use vb_sdk::nn::{FixedNetwork, FixedScratch, Pair, Weights, WeightsError, from_fixed};
use vb_sdk::{HeightMap, Observation, PlannerError, Vehicle, math};

use crate::attention::{PLACES, place};
use crate::sight::{SEEN, Sight};
use crate::terrain::Terrain;

/// Step length at full scale, s.
pub const DT: f32 = 0.2;
/// State and command inputs of the networks; terrain features follow.
pub const TOLD: usize = 11;
/// Outputs of the network: corrections of the speed change, yaw rate, lateral speed, roll and pitch of a bicycle on a
/// plane, and of the wheels' slip speed relative to half of its last value, in units of [`SCALES`].
pub const OUTPUTS: usize = 6;
/// Units of the outputs: m/s, rad/s, m/s, rad, rad, m/s at full scale.
pub const SCALES: [f32; OUTPUTS] = [0.5, 0.3, 0.5, 0.1, 0.1, 1.0];
/// Fraction of the wheels' slip speed that remains after a step, before the correction.
pub const SLIP_KEPT: f32 = 0.5;
/// Bound of the slip speed input of the networks, m/s at full scale.
pub const SLIP_LIMIT: f32 = 8.0;
/// Outputs of the hazard network: the logits of getting stuck and of tipping over within [`SOON`].
pub const HAZARDS: usize = 2;
/// Prediction horizon of hazards, at full scale, s.
pub const SOON: f32 = 1.5;
/// The wheelbase at full scale, m: that of the HMMWV.
const FULL: f64 = 3.302;

/// Factors that convert lengths, speeds and rates to full scale (Froude scaling: times scale with the root of lengths).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Factor of speeds.
    pub speed: f32,
    /// Factor of angular velocities.
    pub rate: f32,
}

impl Units {
    #[must_use]
    pub fn of(vehicle: &Vehicle) -> Self {
        let root = (vehicle.wheelbase / FULL).sqrt() as f32;
        Self { speed: 1.0 / root, rate: root }
    }

    /// Factor of times.
    #[must_use]
    pub fn time(self) -> f32 {
        1.0 / self.rate
    }
}

/// The states of [`LANES`] vehicles; the reference point lies halfway between the outer axles.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Positions, m.
    pub x: Lanes,
    /// Positions, m.
    pub y: Lanes,
    /// Cosines of the headings.
    pub cos: Lanes,
    /// Sines of the headings.
    pub sin: Lanes,
    /// Forward speeds, m/s.
    pub speed: Lanes,
    /// Speeds to the left, m/s.
    pub side: Lanes,
    /// Yaw rates, rad/s.
    pub turn: Lanes,
    /// Wheel steering, -1 to 1.
    pub steering: Lanes,
    /// Slip speeds of the wheels, as computed by [`slip`], m/s.
    pub slip: Lanes,
    /// Rolls, rad, positive with the right side down.
    pub roll: Lanes,
    /// Pitches, rad, positive with the nose down.
    pub pitch: Lanes,
    /// Probabilities of getting stuck within [`SOON`].
    pub stuck: Lanes,
    /// Probabilities of tipping over within [`SOON`].
    pub over: Lanes,
    /// The planes through their wheels, as returned by [`Terrain::plane`]: looked up at the end of a step for the next
    /// step.
    pub plane: [Lanes; 3],
}

impl State {
    /// The observed state on this terrain, equal for all vehicles.
    ///
    /// # Errors
    /// Returns an error if the observation has no pose.
    pub fn of(o: &Observation, terrain: &Terrain, vehicle: &Vehicle) -> Result<Self, PlannerError> {
        let p = o.pose()?;
        let (sin, cos) = math::sin_cos(p.yaw);
        let all = |v: f64| [v as f32; LANES];
        let place = [&all(p.position.x), &all(p.position.y)];
        Ok(Self {
            plane: terrain.plane(place, [&all(cos), &all(sin)]),
            x: all(p.position.x),
            y: all(p.position.y),
            cos: all(cos),
            sin: all(sin),
            speed: all(p.linear_velocity.x),
            side: all(p.linear_velocity.y),
            turn: all(p.angular_velocity.z),
            steering: all(o.steering),
            slip: all(slip(o.wheels.iter().map(|w| w.spin), p.linear_velocity.x, vehicle)),
            roll: all(p.roll),
            pitch: all(p.pitch),
            stuck: all(0.0),
            over: all(0.0),
        })
    }

    /// The state of one vehicle, copied to all.
    #[must_use]
    pub fn all_as(&self, lane: usize) -> Self {
        let all = |v: &Lanes| [v[lane]; LANES];
        Self {
            x: all(&self.x),
            y: all(&self.y),
            cos: all(&self.cos),
            sin: all(&self.sin),
            speed: all(&self.speed),
            side: all(&self.side),
            turn: all(&self.turn),
            steering: all(&self.steering),
            slip: all(&self.slip),
            roll: all(&self.roll),
            pitch: all(&self.pitch),
            stuck: all(&self.stuck),
            over: all(&self.over),
            plane: self.plane.each_ref().map(all),
        }
    }
}

/// The slip speed of a vehicle: mean over the wheels of tread speed less vehicle speed, m/s, from angular velocities
/// (rad/s) and speed (m/s). 0 without wheels.
#[must_use]
pub fn slip(spins: impl ExactSizeIterator<Item = f64>, speed: f64, vehicle: &Vehicle) -> f64 {
    let wheels = spins.len();
    if wheels == 0 {
        return 0.0;
    }
    let most = f64::from(SLIP_LIMIT) * vehicle.scale.sqrt();
    (vehicle.wheel_radius * spins.sum::<f64>() / wheels as f64 - speed).clamp(-most, most)
}

/// Which network outputs the model uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learned {
    All,
    /// Roll and pitch; position and heading are those of a bicycle, and hazards are not predicted.
    Attitude,
    /// None: a bicycle on the plane through its wheels.
    Nothing,
}

/// A bicycle on the plane through its wheels, corrected by a network.
#[derive(Clone, Debug)]
pub struct Kinodynamics {
    learned: Learned,
    terrain: Terrain,
    sight: Sight,
    network: FixedNetwork,
    hazards: FixedNetwork,
    units: Units,
    /// Path curvature at full lock, 1/m.
    curvature: f32,
    /// Steering rate, 1/s.
    steer_rate: f32,
    scratch: RefCell<FixedScratch>,
}

/// Network inputs in pairs: state and commands, then terrain features.
type Inputs = [Pair; TOLD.div_ceil(2) + SEEN / 2];

/// The logit of a hazard that is practically impossible.
const CERTAIN: f32 = -6.0;
/// Time constant of the bicycle's speed response, s at full scale.
pub const LAG: f32 = 0.5;
/// Maximum acceleration of the bicycle, m/s² at any scale.
pub const ACCELERATION: f32 = 3.0;

impl Kinodynamics {
    /// The network inputs, and the attention weight of each position if the model has attention.
    fn inputs(
        &self,
        s: &State,
        command: &[Lanes; 2],
        scratch: &mut FixedScratch,
    ) -> (Inputs, Option<[Lanes; PLACES.len()]>) {
        let mut input = Inputs::default();
        let (told, seen) = input.split_at_mut(TOLD.div_ceil(2));
        Pair::fill(told, &inputs(s, command, self.units));
        let seen = &mut seen[..self.network.pairs() - told.len()];
        let attention = self.sight.look(s, self.terrain.size().0, told, seen, scratch);
        (input, attention)
    }

    /// Evaluates the networks: corrections, and logits of hazards.
    fn ask(&self, s: &State, command: &[Lanes; 2]) -> ([Lanes; OUTPUTS], [Lanes; HAZARDS]) {
        let scratch = &mut self.scratch.borrow_mut();
        let (mut out, mut ahead) = ([[0.0; LANES]; OUTPUTS], [[CERTAIN; LANES]; HAZARDS]);
        if self.learned == Learned::Nothing {
            return (out, ahead);
        }
        let (input, _) = self.inputs(s, command, scratch);
        let input = &input[..self.network.pairs()];
        let (mut corrections, mut logits) = ([[0; LANES]; OUTPUTS], [[0; LANES]; HAZARDS]);
        self.network.run(input, &mut corrections, scratch);
        out = corrections.map(|v| v.map(from_fixed));
        match self.learned {
            Learned::All => {
                self.hazards.run(input, &mut logits, scratch);
                ahead = logits.map(|v| v.map(from_fixed));
            }
            _ => {
                out[..3].fill([0.0; LANES]);
                out[5] = [0.0; LANES];
            }
        }
        (out, ahead)
    }

    /// The attention weight of each of [`PLACES`], if the model has attention.
    #[must_use]
    pub fn attention(&self, s: &State, command: &[Lanes; 2]) -> Option<[Lanes; PLACES.len()]> {
        self.inputs(s, command, &mut self.scratch.borrow_mut()).1
    }

    /// The attended positions, if the model has attention, m.
    #[must_use]
    pub fn places(&self, s: &State) -> [[Lanes; 2]; PLACES.len()] {
        std::array::from_fn(|k| place(k, [&s.x, &s.y], [&s.cos, &s.sin], self.terrain.size().0))
    }

    /// Builds the model of a vehicle on a terrain from weights, over the elevation map of the terrain.
    ///
    /// # Errors
    /// Returns an error if the weights lack a network, or have a network of another shape.
    pub fn new(
        heights: &HeightMap,
        terrain: Terrain,
        weights: &Weights,
        vehicle: &Vehicle,
        learned: Learned,
    ) -> Result<Self, WeightsError> {
        let sight = Sight::new(heights, &terrain, weights)?;
        Ok(Self {
            learned,
            network: weights.fixed_network("motion", sight.parts(), OUTPUTS)?,
            hazards: weights.fixed_network("hazards", sight.parts(), HAZARDS)?,
            terrain,
            sight,
            units: Units::of(vehicle),
            curvature: (1.0 / vehicle.min_turn_radius) as f32,
            steer_rate: vehicle.max_steer_rate as f32,
            scratch: RefCell::default(),
        })
    }

    /// The same weights with another selection of outputs.
    #[must_use]
    pub fn hearing(self, learned: Learned) -> Self {
        Self { learned, ..self }
    }

    /// Hazards of driving straight at a speed from these positions in a direction: the probabilities of getting stuck
    /// and of tipping over, and the fraction of speed lost within a second (0 for a gain).
    #[must_use]
    pub fn hazards_at(&self, place: [&Lanes; 2], [cos, sin]: [f32; 2], speed: f32) -> [Lanes; 3] {
        let (cos, sin) = ([cos; LANES], [sin; LANES]);
        let plane = self.terrain.plane(place, [&cos, &sin]);
        let zero = [0.0; LANES];
        let s = State {
            x: *place[0],
            y: *place[1],
            cos,
            sin,
            speed: [speed; LANES],
            side: zero,
            turn: zero,
            steering: zero,
            slip: zero,
            roll: plane[1],
            pitch: plane[2],
            stuck: zero,
            over: zero,
            plane,
        };
        let (out, ahead) = self.ask(&s, &[zero, [speed; LANES]]);
        let per_second = SCALES[0] / (DT * self.units.speed * speed);
        [ahead[0].map(probability), ahead[1].map(probability), out[0].map(|o| (-o * per_second).max(0.0))]
    }

    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }
}

/// State and command inputs of the network, at full scale.
#[must_use]
pub fn inputs(s: &State, command: &[Lanes; 2], units: Units) -> [Lanes; TOLD] {
    let scaled = |v: &Lanes, by: f32| v.map(|v| v * by);
    let [_, bank, rise] = &s.plane;
    [
        scaled(&s.speed, 0.25 * units.speed),
        scaled(&s.side, units.speed),
        scaled(&s.turn, 2.0 * units.rate),
        scaled(&s.roll, 3.0),
        scaled(&s.pitch, 3.0),
        scaled(bank, 3.0),
        scaled(rise, 3.0),
        s.steering,
        command[0],
        scaled(&command[1], 0.25 * units.speed),
        scaled(&s.slip, 0.25 * units.speed),
    ]
}

/// The logistic function with an error below 0.012: Lambert's fraction for tanh, without an exponential.
#[must_use]
pub fn probability(logit: f32) -> f32 {
    let t = (0.5 * logit).clamp(-3.0, 3.0);
    let square = t * t;
    0.5 + 0.5 * t * (27.0 + square) / (27.0 + 9.0 * square)
}

impl Model<2> for Kinodynamics {
    type State = State;

    fn step(&self, s: &mut State, command: &[Lanes; 2], dt: f32) {
        let units = self.units;
        let (out, ahead) = self.ask(s, command);
        (s.stuck, s.over) = (ahead[0].map(probability), ahead[1].map(probability));
        // The network is trained for one step length; its corrections scale with the length of the step.
        let part = dt * units.time() / DT;
        let most = self.steer_rate * dt;
        let gain = (dt * units.time() / LAG).min(1.0);
        let change = ACCELERATION * dt;
        for l in 0..LANES {
            s.steering[l] += (command[0][l] - s.steering[l]).clamp(-most, most);
            let before = s.speed[l];
            s.speed[l] += (gain * (command[1][l] - before)).clamp(-change, change)
                + part * SCALES[0] * out[0][l] / units.speed;
            let way = 0.5 * dt * (before + s.speed[l]);
            s.turn[l] = s.speed[l] * self.curvature * s.steering[l] + SCALES[1] * out[1][l] / units.rate;
            s.side[l] = SCALES[2] * out[2][l] / units.speed;
            let slip = SLIP_KEPT * s.slip[l] * units.speed + SCALES[5] * out[5][l];
            s.slip[l] = slip.clamp(-SLIP_LIMIT, SLIP_LIMIT) / units.speed;
            let (turn, aside) = (s.turn[l] * dt, s.side[l] * dt);
            // The horizontal distance on a slope is shorter by the cosine of the pitch.
            let level = 1.0 - 0.5 * s.plane[2][l] * s.plane[2][l];
            let (way, half, square) = (way * level, 0.5 * turn, turn * turn);
            let (c, n) = (s.cos[l], s.sin[l]);
            // Along the heading at the middle of the step.
            let (mc, mn) = (c - half * n, n + half * c);
            s.x[l] += way * mc - aside * mn;
            s.y[l] += way * mn + aside * mc;
            let (a, b) = (1.0 - 0.5 * square, turn * (1.0 - square / 6.0));
            let (c, n) = (c * a - n * b, n * a + c * b);
            let length = 1.5 - 0.5 * (c * c + n * n);
            (s.cos[l], s.sin[l]) = (c * length, n * length);
        }
        s.plane = self.terrain.plane([&s.x, &s.y], [&s.cos, &s.sin]);
        let [_, bank, rise] = s.plane;
        for l in 0..LANES {
            s.roll[l] = bank[l] + SCALES[3] * out[3][l];
            s.pitch[l] = rise[l] + SCALES[4] * out[4][l];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_of_the_logistic_function() {
        for k in -100..=100 {
            let logit = 0.1 * k as f32;
            let exact = 1.0 / (1.0 + math::exp(-f64::from(logit)));
            assert!((f64::from(probability(logit)) - exact).abs() < 0.012, "{logit}");
        }
        assert!(probability(f32::NAN).is_nan());
    }
}
