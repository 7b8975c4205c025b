//! A vehicle as data. The file format is `tasks/vehicles/*.yaml`; see there for a commented example.

mod check;
mod powertrain;
mod suspension;
mod tyre;

pub use powertrain::{Converter, Differential, Driveline, DrivenAxle, Engine, Gearbox, LockUp, Powertrain};
use serde::{Deserialize, Serialize};
pub use suspension::{Damper, Hardpoints, Spring, Steering, Stops, Suspension};
pub use tyre::TyreSpec;

/// A point of the chassis frame, or relative to an axle's reference point, m.
pub type Point = [f64; 3];

/// A wheeled vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSpec {
    /// Version of this format; 1.
    pub schema: u32,
    /// Short name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Overall length, m.
    pub length: f64,
    /// Overall width, m.
    pub width: f64,
    /// Overall height, m.
    pub height: f64,
    /// Top speed on flat ground, m/s.
    pub max_speed: f64,
    /// The sprung body.
    pub chassis: Chassis,
    /// Front to back.
    pub axles: Vec<Axle>,
    /// Steering gear.
    pub steering: Steering,
    /// All tyres.
    pub tyre: TyreSpec,
    /// Engine, gearbox and driveline.
    pub powertrain: Powertrain,
}

/// The sprung body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chassis {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the chassis frame, m.
    pub com: Point,
    /// Principal moments about the centre of mass along the chassis axes, kg m².
    pub inertia: [f64; 3],
    /// Friction coefficient of the hull.
    pub friction: f64,
    /// Resistance of the air, and of what else grows with speed, as points \[speed m/s, force N\]: linear between
    /// and constant beyond them, against the motion, at the centre of mass. None if empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resistance: Vec<[f64; 2]>,
    /// Convex parts that touch ground and obstacles, as point clouds in the chassis frame, m.
    pub hull: Vec<Vec<Point>>,
}

/// An axle with a wheel at each side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axle {
    /// Name for people.
    pub name: String,
    /// Reference point of the hardpoints in the chassis frame, m.
    pub position: Point,
    /// Whether the rack moves its inner tie-rod joints.
    pub steered: bool,
    /// Whether the engine drives it.
    pub driven: bool,
    /// Unsprung mass a wheel, kg.
    pub unsprung_mass: f64,
    /// Spin inertia a wheel, kg m².
    pub spin_inertia: f64,
    /// Greatest brake torque a wheel, N m.
    pub brake_torque: f64,
    /// How the wheels are guided.
    pub suspension: Suspension,
}
