//! Vehicle dynamics: suspension, tyres, powertrain, contacts.
//!
//! The vehicle is a chassis with six degrees of freedom and one corner a wheel, each with a suspension travel and a
//! spin; two wheels on a solid axle share a beam. Corners and beams are eliminated from the equations of motion in the
//! manner of articulated bodies, so a step costs one 6 × 6 solve. State and integration are our own, in f64, with
//! symplectic Euler at a fixed step and linearly implicit dampers; rapier resolves contacts of the chassis hull with
//! ground and obstacles, and parry finds contacts of wheels with obstacles, only when something is near.
//!
//! The world axes are x east, y north, z up; the body axes are x forward, y left, z up (ISO 8855). Units are SI, angles
//! in radians.

mod collision;
mod dynamics;
mod error;
mod granular;
mod monitor;
mod powertrain;
mod simulation;
pub mod soil;
mod state;
mod state_hash;
pub mod track;
pub mod tyre;

pub use collision::Surroundings;
pub use dynamics::WheelStand;
pub use error::SimError;
pub use granular::check_grains;
pub use powertrain::DriveState;
#[cfg(feature = "rig")]
pub use simulation::Rig;
pub use simulation::{Diagnostics, SimOptions, Simulation, Start};
pub use soil::{SoilSet, Soils};
pub use state::{Controls, Gear, VehicleState, WheelState};
pub use state_hash::{SAMPLE_PERIOD, StateHash};

pub(crate) type V3 = nalgebra::Vector3<f64>;
pub(crate) type M3 = nalgebra::Matrix3<f64>;
pub(crate) type Quat = nalgebra::UnitQuaternion<f64>;

/// A rotation that takes the y axis to a unit vector, an axle's: its other two axes are any.
pub(crate) fn turn_to_axle(axis: &V3) -> Quat {
    Quat::rotation_between(&V3::y(), axis)
        .unwrap_or_else(|| Quat::from_axis_angle(&V3::x_axis(), std::f64::consts::PI))
}

/// The unit normal of a surface that rises by `dzdx` and `dzdy` a metre along x and y.
#[inline]
pub(crate) fn normal_of([dzdx, dzdy]: [f64; 2]) -> V3 {
    let inv = 1.0 / (1.0 + dzdx * dzdx + dzdy * dzdy).sqrt();
    V3::new(-dzdx * inv, -dzdy * inv, inv)
}
