//! The powertrain against closed forms. Wheels turn freely here: the tyres' moments are what a test says.

mod driveline;
mod engine;
mod reverse;
mod sides;

use super::*;
use vb_vehicle::powertrain::{Converter, Differential, DrivenAxle, Engine, LockUp};

const DT: f64 = 1e-3;
/// Of the HMMWV's tyres, m.
const RADIUS: f64 = 0.467;

fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv").unwrap()
}

/// The HMMWV with all differentials alike.
fn with(differential: Differential) -> VehicleSpec {
    let mut v = hmmwv();
    v.powertrain.driveline.centre = differential;
    for a in &mut v.powertrain.driveline.axles {
        a.differential = differential;
    }
    v
}

/// The HMMWV on `n` driven axles, all differentials alike.
fn multi_axle(n: usize, differential: Differential) -> VehicleSpec {
    let mut v = with(differential);
    v.axles = (0..n).map(|_| v.axles[0].clone()).collect();
    let axle = DrivenAxle { fraction: 1.0 / n as f64, ..v.powertrain.driveline.axles[0] };
    v.powertrain.driveline.axles = vec![axle; n];
    v
}

/// An engine that always gives the same torque, N m, whatever its speed.
fn constant(torque: f64, inertia: f64) -> Engine {
    let map = vec![[0.0, torque]];
    Engine::Map { full_throttle: map.clone(), closed_throttle: map, inertia }
}

/// The HMMWV's other engine: map with its losses added (vehicles/hmmwv.yaml, engine_shafts), inertia 1.1 with the
/// gearbox' motor shaft 0.5.
fn shafts_engine() -> Engine {
    Engine::Map {
        full_throttle: vec![[0.0, 309.1], [83.775804, 336.2], [125.663706, 652.0], [167.551608, 731.0]]
            .into_iter()
            .chain([[209.43951, 658.0], [261.799388, 478.0], [282.743339, -484.0]])
            .collect(),
        closed_throttle: vec![[0.0, 0.0], [5.236, -30.0], [104.72, -50.0], [209.44, -70.0], [314.16, -90.0]],
        inertia: 1.6,
    }
}

/// Of the same vehicle (transmission_shafts_with_torque_converter).
fn converter() -> Converter {
    Converter {
        idle_speed: 80.0,
        capacity: vec![[0.0, 15.0], [0.25, 15.0], [0.5, 15.0], [0.75, 16.0], [0.9, 18.0], [1.0, 35.0]],
        torque_ratio: vec![[0.0, 2.0], [0.25, 1.8], [0.5, 1.5], [0.75, 1.15], [1.0, 1.0]],
        lock_up: None,
    }
}

fn with_converter() -> VehicleSpec {
    let mut v = with(Differential::Open {});
    v.powertrain.engine = shafts_engine();
    v.powertrain.converter = Some(converter());
    v
}

/// The same on a dynamometer, which keeps the wheels' speed.
fn dynamometer() -> VehicleSpec {
    let mut v = with_converter();
    for a in &mut v.axles {
        a.spin_inertia = 1e12;
    }
    v
}

struct Bench {
    drive: Drive,
    spins: Vec<f64>,
    moments: Vec<f64>,
    brakes: Vec<f64>,
    torques: Vec<f64>,
    gear: Gear,
    steering: f64,
}

impl Bench {
    fn new(v: &VehicleSpec, spin: f64) -> Self {
        let n = 2 * v.axles.len();
        Self {
            drive: Drive::new(&Load::wheels(v)),
            spins: vec![spin; n],
            moments: vec![0.0; n],
            brakes: vec![0.0; n],
            torques: vec![0.0; n],
            gear: Gear::Forward,
            steering: 0.0,
        }
    }

    /// A step of a vehicle whose wheels roll on the ground.
    fn step(&mut self, throttle: f64, dt: f64) {
        let speed = RADIUS * self.spins.iter().sum::<f64>() / self.spins.len() as f64;
        let mut wheels = Wheels {
            spins: &mut self.spins,
            moments: &self.moments,
            brakes: &self.brakes,
            torques: &mut self.torques,
        };
        self.drive.advance(
            &Demand { throttle, gear: self.gear, speed, steering: self.steering },
            &mut wheels,
            dt,
        );
    }

    /// A step from a speed that all wheels are given.
    fn hold(&mut self, throttle: f64, spin: f64, dt: f64) {
        self.spins.fill(spin);
        self.step(throttle, dt);
    }

    /// Kinetic energy of wheels, shafts and boxes, J.
    fn energy(&self, v: &VehicleSpec) -> f64 {
        let d = &v.powertrain.driveline;
        let mut e = 0.0;
        let mut shaft = 0.0;
        for (k, a) in d.axles.iter().enumerate() {
            let (l, r) = (self.spins[2 * k], self.spins[2 * k + 1]);
            let mean = 0.5 * (l + r);
            e += 0.5 * v.axles[k].spin_inertia * (l * l + r * r)
                + 0.5 * (a.box_inertia + a.shaft_inertia / a.final_drive / a.final_drive) * mean * mean;
            shaft += a.fraction * mean / a.final_drive;
        }
        e + 0.5 * d.shaft_inertia * shaft * shaft
    }
}
