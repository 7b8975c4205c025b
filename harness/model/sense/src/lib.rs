//! Perception: the prior maps that planners receive, and the sensors of a driving vehicle.
//!
//! - [`Profile`] is data: what is known beforehand, which sensors there are, and how wrong they are
//!   (`tasks/perception/*.yaml`, explained in docs/perception.md).
//! - [`PriorMaps`] are the maps at the start.
//! - [`Perception`] is the vehicle's sensors in a trial: it takes the true state every 10 ms and gives readings at the
//!   planner's steps. Only what the planner needs is computed.
//! - [`rays`] is how lidar and depth camera see the ground, obstacles and ruts.
//! - [`noise`] has the random processes, each with a stream of its own that is named by the run's seed, the task and the
//!   sensor, so that all numbers are the same bits everywhere and one sensor changes no other's.
//!
//! The world axes are x east, y north, z up; the body axes are x forward, y left, z up (ISO 8855). Units are SI, angles
//! in radians.

mod error;
mod frame;
mod mount;
pub mod noise;
mod perception;
mod prior;
pub mod profile;
pub mod rays;
mod sensors;

pub use error::SenseError;
pub use noise::Seed;
pub use perception::{Perception, Readings, Truth, check_needs};
pub use prior::PriorMaps;
pub use profile::Profile;

pub(crate) type V3 = nalgebra::Vector3<f64>;
pub(crate) type Quat = nalgebra::UnitQuaternion<f64>;
