//! Runs a planner over the tasks of a suite and records what happened.
//!
//! [`run`] takes everything that decides a result as a [`RunConfig`], drives the tasks on worker threads and hands
//! each result to the run store as it comes. A task's result depends on its own inputs only: not on the number of
//! workers, on the order of tasks, or on what ran before. A single trial is `vb-trial`'s.

pub mod conformance;
mod driver;
mod error;
mod fail_fast;
mod merge;
mod recording;
mod run;
pub mod sweep;

pub use driver::{PluginDriver, wants};
pub use error::RunError;
pub use fail_fast::{FAILED_STARTS, FailedStart, HUNG_STARTS};
pub use merge::{MergeError, Merged, merge, shards_in};
pub use recording::{recorded, recorded_kind};
pub use run::{Event, RunConfig, RunReport, check, check_control_period, check_perception, run};
