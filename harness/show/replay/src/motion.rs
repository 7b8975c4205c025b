//! How vehicle and wheels moved, from a simulation repeated by the recorded commands or from the samples alone.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector3;
use vb_record::{Sample, Trace};
use vb_sense::Truth;
use vb_sim::{Controls, SimOptions, Simulation, SoilSet, StateHash, VehicleState};
use vb_trial::{commanded_gear, sample};
use vb_vehicle::{VehicleModel, kinematics::Side};
use vb_world::{Task, World};

use crate::grains::Grains;
use crate::sensed::{Sensed, Sensors};

/// Time between the frames of a repeated simulation, s.
const FRAME_PERIOD: f64 = 0.02;
/// Samples between two looks at the ruts.
const LOOK_AT_RUTS: u64 = 10;
/// A rut is told again when the ground in it lies lower or higher by this, m.
const DEEPER: f64 = 0.005;
/// The least speed to which slip refers at scale 1, m/s.
const SLOW: f64 = 0.1;
/// Ruts that are told at most.
const RUTS: usize = 150_000;

/// One wheel at one instant, in the frame of the chassis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelFrame {
    /// Its centre, m.
    pub hub: [f64; 3],
    /// Its axis of spin, to the left.
    pub axis: [f64; 3],
    /// The angle that it has turned since the start, rad.
    pub angle: f64,
    /// The suspension travel from the design position, m, positive in compression.
    pub travel: f64,
}

/// What the ground and a wheel do to each other at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelContact {
    /// The normal force of ground and obstacles, N.
    pub load: f64,
    /// The speed of the rim less that of the wheel's centre along its heading, over the larger of both, in [-2, 2]: positive
    /// where it spins, −1 where it is locked, 0 at rest.
    pub slip: f64,
    /// The depth in soil, m.
    pub sinkage: f64,
}

/// A cell of the ground that yielded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rut {
    /// When it was there, s.
    pub time: f64,
    /// Its centre, m.
    pub at: [f64; 2],
    /// Depth below the surface that the heap has raised, m.
    pub depth: f64,
    /// Height of the heap, m.
    pub raised: f64,
}

impl Rut {
    /// By how much the ground is higher than it was at first, m.
    #[must_use]
    pub fn change(&self) -> f64 {
        self.raised - self.depth
    }
}

/// Where what is shown comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeat {
    /// The simulation was repeated, and its state hash is that of the record.
    Exact,
    /// It can't be repeated: these are the recorded samples, with wheels placed by their travel.
    Samples,
}

/// The motion of one trial.
#[derive(Clone, Debug)]
pub struct Motion {
    pub repeat: Repeat,
    /// The vehicle's state and commands, frame by frame.
    pub frames: Vec<Sample>,
    /// The steering of each frame after the rate limit, in [-1, 1], positive to the left; from samples, the command.
    pub steering: Vec<f64>,
    pub wheels: usize,
    /// `frames.len() * wheels` entries: the wheels of the first frame, those of the second, …
    pub wheel_frames: Vec<WheelFrame>,
    /// What wheels and ground do to each other, as many entries as `wheel_frames`; none from samples.
    pub contacts: Vec<WheelContact>,
    /// Ruts in the order of time; none from samples.
    pub ruts: Vec<Rut>,
    /// The side of the cells in which ruts are told, m; 0 from samples.
    pub soil_resolution: f64,
    /// The grains of granular beds; none from samples.
    pub grains: Grains,
}

/// What a simulation takes beside the trace.
pub struct Setting<'a> {
    /// The world, scaled.
    pub world: &'a Arc<World>,
    pub task: &'a Task,
    pub vehicle: &'a VehicleModel,
    pub soils: &'a SoilSet,
    pub options: SimOptions,
}

impl Motion {
    /// The motion by the simulation repeated in `setting`, and what the sensors measured in it, if some are given; none if it
    /// doesn't come to the `state_hash` of the record.
    #[must_use]
    pub fn repeated(
        trace: &Trace,
        setting: &Setting<'_>,
        sensors: Option<Sensors>,
        state_hash: &str,
    ) -> Option<(Self, Sensed)> {
        let mut perception = sensors.map(|s| s.perception);
        let mut sensed = perception.as_ref().map(Sensed::new).unwrap_or_default();
        let period = trace.meta.sample_period;
        let end = trace.samples.last()?.time;
        let samples = (end / period).round() as u64;
        let steps = (period / setting.options.step).round() as u64;
        let every = ((FRAME_PERIOD / period).round() as u64).max(1);
        let start = setting.task.start;
        let mut sim =
            Simulation::new(setting.world.clone(), setting.vehicle, setting.soils, start, setting.options)
                .ok()?;
        let mut hash = StateHash::default();
        let mut motion = Self {
            repeat: Repeat::Exact,
            frames: Vec::new(),
            steering: Vec::new(),
            wheels: 2 * setting.vehicle.axles().len(),
            wheel_frames: Vec::new(),
            contacts: Vec::new(),
            ruts: Vec::new(),
            soil_resolution: sim.soil_resolution(),
            grains: Grains::of(&sim),
        };
        let mut told = BTreeMap::new();
        let mut told_grains = motion.grains.start.clone();
        let mut angles = vec![0.0; motion.wheels];
        let mut commands = trace.samples.iter().peekable();
        let mut controls = Controls::default();
        for k in 0..=samples {
            if k > 0 {
                // A sample carries the command that was applied up to it.
                let now = k as f64 * period;
                while commands.next_if(|s| s.time < now - 0.25 * period).is_some() {}
                let s = commands.peek()?;
                controls = Controls {
                    steering: s.steering,
                    throttle: s.throttle,
                    brake: s.brake,
                    gear: commanded_gear(s.gear),
                };
                sim.advance(controls, steps).ok()?;
            }
            sim.visit_state(|x| hash.push(x));
            let state = sim.state();
            if let Some(perception) = &mut perception {
                perception.sample(Truth { state: &state, ruts: Some(&sim) });
                sensed.take(perception, &state);
            }
            for (angle, wheel) in angles.iter_mut().zip(&state.wheels) {
                *angle += wheel.speed * if k > 0 { period } else { 0.0 };
            }
            if k % every == 0 || k == samples {
                let travels: Vec<f64> = state.wheels.iter().map(|w| w.deflection).collect();
                motion.push(sample(&state, controls), setting.vehicle, &travels, &angles, state.steering);
                motion.steering.push(state.steering);
                motion.push_contacts(&state, setting);
            }
            if k % LOOK_AT_RUTS == 0 || k == samples {
                motion.look_at_ruts(&sim, &mut told);
                motion.grains.look(&sim, &mut told_grains);
            }
        }
        motion.grains = motion.grains.seen(setting.world);
        (hash.hex() == state_hash).then_some((motion, sensed))
    }

    /// The motion as it was sampled; of a vehicle with other wheels than the trace's, without wheels.
    #[must_use]
    pub fn sampled(trace: &Trace, vehicle: Option<&VehicleModel>) -> Self {
        let vehicle = vehicle.filter(|v| 2 * v.axles().len() == trace.wheels);
        let wheels = if vehicle.is_some() { trace.wheels } else { 0 };
        let mut motion = Self {
            repeat: Repeat::Samples,
            frames: Vec::with_capacity(trace.samples.len()),
            steering: trace.samples.iter().map(|s| s.steering).collect(),
            wheels,
            wheel_frames: Vec::with_capacity(trace.samples.len() * wheels),
            contacts: Vec::new(),
            ruts: Vec::new(),
            soil_resolution: 0.0,
            grains: Grains::default(),
        };
        let mut angles = vec![0.0; trace.wheels];
        let mut last = 0.0;
        for (k, s) in trace.samples.iter().enumerate() {
            let own = &trace.wheel_samples[k * trace.wheels..(k + 1) * trace.wheels];
            for (angle, wheel) in angles.iter_mut().zip(own) {
                *angle += wheel.speed * (s.time - last);
            }
            last = s.time;
            match vehicle {
                Some(vehicle) => {
                    let travels: Vec<f64> = own.iter().map(|w| w.deflection).collect();
                    motion.push(*s, vehicle, &travels, &angles, s.steering);
                }
                None => motion.frames.push(*s),
            }
        }
        motion
    }

    fn push(&mut self, s: Sample, vehicle: &VehicleModel, travels: &[f64], angles: &[f64], steering: f64) {
        self.frames.push(s);
        for (a, (axle, solved)) in vehicle.spec().axles.iter().zip(vehicle.axles()).enumerate() {
            let own = [travels[2 * a], travels[2 * a + 1]];
            for (i, side) in [Side::Left, Side::Right].into_iter().enumerate() {
                let pose = solved.wheel(side, own, steering);
                let hub = Vector3::from(axle.position) + pose.hub;
                let axis = pose.axis.normalize();
                // To the left whatever side it is on, so that a positive angle rolls forward.
                let axis = if axis.y < 0.0 { -axis } else { axis };
                self.wheel_frames.push(WheelFrame {
                    hub: hub.into(),
                    axis: axis.into(),
                    angle: angles[2 * a + i],
                    travel: own[i],
                });
            }
        }
    }

    /// What the wheels of the last frame and the ground do to each other.
    fn push_contacts(&mut self, state: &VehicleState, setting: &Setting<'_>) {
        let spec = setting.vehicle.spec();
        let radii = spec.axles.iter().flat_map(|axle| [spec.tyre_of(axle).radius(); 2]);
        let placed = &self.wheel_frames[self.wheel_frames.len() - self.wheels..];
        // As slow as this a vehicle stands.
        let slow = SLOW * setting.world.scale.sqrt();
        let contacts = state.wheels.iter().zip(placed).zip(radii).map(|((wheel, frame), radius)| {
            let heading = Vector3::from(frame.axis).cross(&Vector3::z()).normalize();
            let hub = state.velocity_body + state.angular_velocity_body.cross(&Vector3::from(frame.hub));
            let (rim, speed) = (wheel.speed * radius, hub.dot(&heading));
            let slip = (rim - speed) / rim.abs().max(speed.abs()).max(slow);
            WheelContact { load: wheel.load, slip, sinkage: wheel.sinkage }
        });
        self.contacts.extend(contacts);
    }

    fn look_at_ruts(&mut self, sim: &Simulation, told: &mut BTreeMap<(i64, i64), f64>) {
        let time = sim.time();
        for (at, depth, raised) in sim.ruts() {
            let key = ((at[0] * 1000.0).round() as i64, (at[1] * 1000.0).round() as i64);
            // A heap may be pressed down again: both ways count.
            let change = raised - depth;
            let before = told.get(&key).copied().unwrap_or(0.0);
            if (change - before).abs() < DEEPER || self.ruts.len() >= RUTS {
                continue;
            }
            told.insert(key, change);
            self.ruts.push(Rut { time, at, depth, raised });
        }
    }

    /// Time of the last frame, s.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.frames.last().map_or(0.0, |f| f.time)
    }
}
