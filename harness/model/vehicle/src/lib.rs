//! Vehicles as data: the file format of `tasks/vehicles`, what it refuses, and the linkages of suspension and steering,
//! solved once. Nothing here moves; `vb-sim` does that.
//!
//! - [`VehicleSpec`] is a file; its parts are in [`suspension`], [`tyre`], [`powertrain`], [`tracks`] and [`skid`].
//! - [`VehicleSpec::load`] reads one and refuses what no vehicle can be ([`DocumentError`]).
//! - [`VehicleModel`] is a vehicle with its linkages solved ([`kinematics`]): what simulations share.
//!
//! The body axes are x forward, y left, z up (ISO 8855). Units are SI, angles in radians.

#![deny(missing_docs)]

mod check;
mod describe;
mod field;
pub mod kinematics;
mod model;
pub mod powertrain;
pub mod skid;
pub mod suspension;
pub mod table;
pub mod tracks;
pub mod tyre;
mod vehicle;

pub use model::{MAX_WHEELS, VehicleModel};
pub use tyre::TyreSpec;
pub use vb_files::DocumentError;
pub use vb_world::GRAVITY;
pub use vehicle::{Axle, Chassis, Point, Vehicle, VehicleSpec};

type V3 = nalgebra::Vector3<f64>;

/// The scales that a world may have: a length of it over the same length of the full-size world.
pub const SCALES: std::ops::RangeInclusive<f64> = 0.01..=10.0;
