//! Runs a planner over the tasks of a suite and records what happened.
//!
//! [`run`] takes everything that decides a result as a [`RunConfig`], drives the tasks on worker threads and hands
//! each result to the run store as it comes. A task's result depends on its own inputs only: not on the number of
//! workers, on the order of tasks, or on what ran before.

mod brief;
pub mod conformance;
mod driver;
mod episode;
mod error;
mod fail_fast;
mod merge;
mod recent;
mod ride;
mod run;
mod setting;
mod shape;
mod trial;

pub use brief::planner_vehicle;
pub use driver::{Driver, Metered, PluginDriver, Witness};
pub use episode::{Episode, commanded_gear, sample};
pub use error::RunError;
pub use fail_fast::{FAILED_STARTS, FailedStart, HUNG_STARTS};
pub use merge::{MergeError, Merged, merge, shards_in};
pub use run::{
    Event, RunConfig, RunReport, Soils, Vehicle, check, check_control_period, check_perception, run,
};
pub use setting::{Keep, Place, Setting, Wants, is_time_step, start};
pub use shape::{StaticShape, static_shape};
pub use trial::{Trial, TrialResult, panic_text};
pub use vb_sim::{SAMPLE_PERIOD, StateHash};
