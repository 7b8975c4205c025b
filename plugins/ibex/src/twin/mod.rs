//! Internal forward model of the vehicle: the simplest simulation that predicts immobilisation.
//!
//! A body with six degrees of freedom stands on four massless wheels, each at the end of a spring and a damper along
//! the body's vertical. A wheel touches the triangles of the map with its circumference (`contact`); its tyre is a
//! spring and a damper, and its tread a brush model (`wheel`); its torque comes through a lock between the axles and
//! limited-slip differentials (`drive`). The hull is convex and can carry load. Deformable soil sinks under the wheels
//! and resists them.
//!
//! It uses the data of the planner interface and the HMMWV's proportions, and is independent of the harness's
//! simulator. `vb-twin-check` measures its accuracy (`docs/planners.md`). Its steps are seventeen times as long, and it
//! computes [`LANES`] vehicles at once.

mod body;
mod contact;
mod drive;
mod ground;
mod hull;
mod shape;
mod soil;
mod vector;
mod wheel;

use vb_sdk::mppi::{LANES, Lanes, Model};
use vb_sdk::{HeightMap, LabelMap, Observation, PlannerError, Vehicle};
use wide::f32x8;

use body::Push;
use contact::Contact;
use ground::Ground;
use shape::Shape;
use vector::{V3, all, attitude, within};
use wheel::{Given, Wheel};

/// Standard gravity, m/s².
const GRAVITY: f32 = 9.81;
/// The outer wheels: those of the first and of the last axle.
const WHEELS: usize = 4;
/// Internal steps per rollout step, and the number of internal steps between contact searches.
const STEPS: usize = 6;
const LOOKS: usize = 2;
/// Gains of the speed controller, as in [`vb_sdk::speed::SpeedKeeper`].
const GAINS: [f32; 2] = [0.6, 0.15];

/// The states of [`LANES`] vehicles.
#[derive(Clone, Debug)]
pub struct State {
    /// Positions of the centres of mass, m.
    place: V3,
    /// Velocities in world axes, m/s.
    velocity: V3,
    /// Attitudes.
    attitude: vector::Quaternion,
    /// Angular velocities, rad/s, body axes.
    rotation: V3,
    /// Front to rear, left before right.
    wheels: [Wheel; WHEELS],
    /// Load on the hull, N.
    hull: f32x8,
    /// Wheel steering, -1 to 1.
    steering: f32x8,
    /// Engine speed, rad/s at full scale.
    engine: f32x8,
    /// The integral of the speed controller, as throttle.
    integral: f32x8,
    /// Gear: 1 forward, -1 reverse, between them during a change.
    gear: f32x8,
    /// Positions of the reference points, m.
    pub x: Lanes,
    /// Positions of the reference points, m.
    pub y: Lanes,
    /// Cosines of the headings.
    pub cos: Lanes,
    /// Sines of the headings.
    pub sin: Lanes,
    /// Forward speeds, m/s.
    pub speed: Lanes,
    /// Sines of roll (left side up) and pitch (nose up).
    pub tilt: [Lanes; 2],
    /// Cosines of the angle between the bodies' up and the vertical.
    pub upright: Lanes,
    /// Fraction of the weight on the hull; above 1 on impact.
    pub borne: Lanes,
}

/// Driver commands of a step.
struct Controls {
    steering: f32x8,
    /// Throttle, or brake if negative.
    pedal: f32x8,
    /// 1 forward, -1 in reverse.
    way: f32x8,
}

/// The model: terrain and vehicle.
#[derive(Clone, Debug)]
pub struct Twin {
    ground: Ground,
    shape: Shape,
    /// Root of the scale of the world, the factor of the speed controller.
    pace: f32,
}

impl Twin {
    /// Builds the model of a vehicle on the terrain of these maps; the elevation map has at least 2 × 2 samples.
    /// `margin` lowers the hull, m at full scale, to allow for errors of terrain and motion.
    #[must_use]
    pub fn new(map: &HeightMap, kinds: Option<&LabelMap>, vehicle: &Vehicle, margin: f64) -> Self {
        Self {
            ground: Ground::new(map, kinds, vehicle),
            shape: Shape::of(vehicle, margin as f32),
            pace: vehicle.scale.sqrt() as f32,
        }
    }

    /// Replaces the maps; depth estimates remain.
    pub(crate) fn see(&mut self, map: &HeightMap, kinds: Option<&LabelMap>, vehicle: &Vehicle) {
        self.ground = self.ground.of(map, kinds, vehicle);
    }

    /// The observed state, equal for all vehicles, with this integral of the speed controller.
    ///
    /// # Errors
    /// Returns an error if the observation has no pose.
    pub fn state(&self, o: &Observation, integral: f64) -> Result<State, PlannerError> {
        let p = o.pose()?;
        let vector = |v: vb_sdk::Vec3| V3::all([v.x, v.y, v.z].map(|c| c as f32));
        let one = |v: f64| all(v as f32);
        let count = o.wheels.len();
        let wheel = |i: usize| {
            let told = o.wheels.get(if i < 2 { i } else { (count + i).wrapping_sub(WHEELS) });
            let told = told.copied().unwrap_or_default();
            Wheel { travel: one(told.travel), spin: one(told.spin), ..Wheel::default() }
        };
        let mut s = State {
            place: vector(p.position),
            velocity: vector(p.linear_velocity),
            attitude: attitude(p.roll, p.pitch, p.yaw),
            rotation: vector(p.angular_velocity),
            wheels: std::array::from_fn(wheel),
            hull: all(0.0),
            steering: one(o.steering),
            engine: one(o.engine_speed * f64::from(self.shape.root))
                .max(all(drive::IDLE))
                .min(all(drive::GOVERNED[1])),
            integral: one(integral),
            gear: one(o.gear.direction()),
            x: [0.0; LANES],
            y: [0.0; LANES],
            cos: [0.0; LANES],
            sin: [0.0; LANES],
            speed: [0.0; LANES],
            tilt: [[0.0; LANES]; 2],
            upright: [0.0; LANES],
            borne: [0.0; LANES],
        };
        let centre = V3::all(self.shape.centre);
        let axes = s.axes();
        s.place += axes.out(centre);
        s.velocity = axes.out(s.velocity + s.rotation.cross(centre));
        self.look(&mut s);
        for i in 0..WHEELS {
            if s.wheels[i].depth.simd_gt(all(0.0)).any() {
                s.wheels[i].sunk = self.sinkage(i, &s.wheels[i], &s).0;
            }
        }
        self.tell(&mut s);
        Ok(s)
    }

    /// Velocity of the reference point (m/s) and angular velocity (rad/s) of the first vehicle, body axes.
    #[must_use]
    pub fn motion(&self, s: &State) -> [f64; 6] {
        let v = s.axes().within(s.velocity) + s.rotation.cross(V3::all(self.shape.centre)) * all(-1.0);
        [v.x, v.y, v.z, s.rotation.x, s.rotation.y, s.rotation.z].map(|c| f64::from(c.to_array()[0]))
    }

    /// Whether the gearbox changes direction at a speed, m/s.
    pub(crate) fn is_slow(&self, speed: f64) -> bool {
        (speed as f32).abs() < self.shape.change_speed
    }

    /// The terrain properties under the wheels.
    fn look(&self, s: &mut State) {
        let axes = s.axes();
        for (i, w) in s.wheels.iter_mut().enumerate() {
            let hub = s.place + axes.out(self.shape.hub(i, w.travel));
            let (x, y) = (hub.x.to_array(), hub.y.to_array());
            let [mut friction, mut depth, mut compaction] = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let kind = self.ground.kind(x[l], y[l]);
                (friction[l], depth[l]) = (kind.friction, kind.sinkage * self.shape.radius);
                compaction[l] = kind.compaction;
            }
            (w.friction, w.depth) = (f32x8::from(friction), f32x8::from(depth));
            w.compaction = f32x8::from(compaction);
        }
    }

    /// Updates the outputs that costs use.
    fn tell(&self, s: &mut State) {
        let axes = s.axes();
        let reference = s.place + axes.out(V3::all(self.shape.centre)) * all(-1.0);
        let f = axes.forward;
        let level = (f.x * f.x + f.y * f.y).sqrt().max(all(1e-3));
        (s.x, s.y) = (reference.x.to_array(), reference.y.to_array());
        (s.cos, s.sin) = ((f.x / level).to_array(), (f.y / level).to_array());
        s.speed = s.velocity.dot(f).to_array();
        s.tilt = [axes.left.z.to_array(), f.z.to_array()];
        s.upright = axes.up.z.to_array();
        s.borne = (s.hull * all(1.0 / (GRAVITY * self.shape.mass))).to_array();
    }

    /// Driver commands for a target speed (m/s, negative in reverse) over the time `dt`, s.
    fn controls(&self, s: &mut State, steering: f32x8, target: f32x8, dt: f32) -> Controls {
        let (zero, one) = (all(0.0), all(1.0));
        let speed = f32x8::from(s.speed);
        let way = target.simd_lt(zero).select(-one, one);
        let slow = speed.abs().simd_lt(all(self.shape.change_speed));
        let changed = within(s.gear + way * all(2.0 * dt / self.shape.change), one);
        let is_in = |gear: f32x8| (gear * way).simd_ge(all(0.99));
        s.gear = (is_in(s.gear) | !slow).select(s.gear, changed);
        let engaged = is_in(s.gear);
        let error = (target - speed) * way * all(1.0 / self.pace);
        let integral = s.integral + error * all(GAINS[1] * dt);
        let wanted = error * all(GAINS[0]) + integral;
        let moves = wanted.abs().simd_le(one) | (wanted * error).simd_lt(zero);
        s.integral = engaged.select(moves.select(integral, s.integral), zero);
        // A change of direction brakes first.
        let pedal = engaged.select(within(wanted, one), slow.select(zero, -one));
        Controls { steering, pedal, way }
    }

    /// A step of `dt` s, with or without a contact search of the wheels.
    fn step_once(&self, s: &mut State, c: &Controls, contacts: &mut [Contact; WHEELS], looks: bool, dt: f32) {
        let body = s.body();
        let mut push = Push::weight(self.shape.mass);
        s.steering += within(c.steering - s.steering, all(self.shape.steer_rate * dt));
        let angle = s.steering * all(self.shape.steer);
        let square = angle * angle;
        // To the fourth and the fifth order, exact to 0.0004 at 35 degrees.
        let cos = all(1.0) - square * (all(0.5) - square * all(1.0 / 24.0));
        let sin = angle * (all(1.0) - square * (all(1.0 / 6.0) - square * all(1.0 / 120.0)));
        let (forward, left) = (body.axes.forward, body.axes.left);
        let steered = [forward * cos + left * sin, left * cos + forward * -sin];
        let (torques, brakes) = self.torques(&s.wheels, &mut s.engine, c, dt);
        let mut gained = torques;
        for (i, (w, gained)) in s.wheels.iter_mut().zip(&mut gained).enumerate() {
            let directions = if i < 2 { steered } else { [forward, left] };
            let given = Given { directions, torque: torques[i], brakes, looks };
            *gained = self.roll((i, w), &mut contacts[i], &body, &given, (&mut push, dt));
        }
        drive::spin_up(&mut s.wheels, gained);
        let frictions = s.wheels.map(|w| w.friction);
        let friction = (frictions[0] + frictions[1] + frictions[2] + frictions[3]) * all(0.25);
        s.hull = self.scrape(&body, (friction, s.hull), (&mut push, dt));
        s.advance(&self.shape, &push, dt);
    }
}

impl Model<2> for Twin {
    type State = State;

    /// Commands are the steering and the speed, m/s, negative in reverse.
    fn step(&self, s: &mut State, [steering, target]: &[Lanes; 2], dt: f32) {
        self.look(s);
        let controls = self.controls(s, f32x8::from(*steering), f32x8::from(*target), dt);
        let (part, mut contacts) = (dt / STEPS as f32, [Contact::default(); WHEELS]);
        // Forces at the middle of a step, for second-order accuracy (Störmer–Verlet).
        s.drift(0.5 * part);
        for k in 0..STEPS {
            self.step_once(s, &controls, &mut contacts, k.is_multiple_of(LOOKS), part);
        }
        s.drift(-0.5 * part);
        self.tell(s);
    }
}

#[cfg(test)]
mod tests;
