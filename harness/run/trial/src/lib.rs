//! One task of the benchmark from start to verdict: the vehicle in its world, its sensors, a driver, the scorer and the recorder.
//!
//! A [`Setting`] holds what the trials of a run have in common. [`Setting::drive`] lets a [`Driver`] drive a task;
//! [`Witness`]es observe it. An [`Episode`] is the same task stepped from outside, as environments do. A trial's result
//! depends on its inputs only.
//!
//! Plugins are drivers in `vb-runner`; nothing here loads or hosts one.

mod brief;
mod cache;
pub mod defaults;
mod driver;
mod episode;
mod error;
mod gear;
mod recent;
mod ride;
mod setting;
mod shape;
mod trial;

pub use brief::planner_vehicle;
pub use cache::Cache;
pub use driver::{Driver, DriverFault, Fuel, Log, Witness};
pub use episode::{Episode, sample};
pub use error::TrialError;
pub use gear::{commanded_gear, gear_number, numbered_gear, planner_gear, simulated_gear};
pub use setting::{Keep, Place, Setting, Wants, is_time_step, start};
pub use shape::{SkidShape, StaticShape, static_shape};
pub use trial::{Trial, TrialResult};
