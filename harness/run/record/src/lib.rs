//! The run store: what a run leaves on disk, and how it survives being killed.
//!
//! A run directory holds `run.json` (what was run: [`RunHeader`]), `tasks.jsonl` (one line for each finished task,
//! appended and synced when it ends), `checksums.txt` (the SHA-256 of each file and record, by which damage is found),
//! `traces/<world>/<task>.parquet` ([`Trace`]), the planner's own series in `traces/<world>/<task>.debug.parquet`
//! ([`DebugSeries`]), and at the end `summary.json`. The crate knows nothing of rules: records and summaries are
//! whatever its callers serialise.

#![deny(missing_docs)]

mod bounded;
mod checksums;
mod debug;
mod difference;
mod error;
mod folder;
mod header;
mod join;
mod log_mode;
mod parquet_io;
mod plugin_kind;
mod recording;
mod sample;
mod scope;
mod settings;
mod store;
mod thrift;
mod trace;

pub use bounded::{ParquetBounds, read_parquet};
pub use debug::{DebugEntry, DebugSeries};
pub use difference::{Difference, differences};
pub use error::StoreError;
pub use folder::{FolderLock, NewFolder};
pub use header::{
    DataHeader, PluginHeader, RUN_SCHEMA, RulesHeader, RunHeader, SandboxHeader, ShardHeader, SuiteHeader,
};
pub use join::RunJoiner;
pub use log_mode::LogMode;
pub use plugin_kind::PluginKind;
pub use recording::{AppliedCommand, RECORDING_SCHEMA, Recording};
pub use sample::{Sample, WheelSample};
pub use scope::{planner_with_params, suite_with_selection};
pub use settings::{SOIL_RESOLUTIONS, TIME_STEPS, is_time_step};
pub use store::{RunReader, RunStore};
pub use trace::{TRACE_SCHEMA, Trace, TraceMeta, TraceMode, TraceRecorder};
