//! Why a task can't be replayed.

use std::path::PathBuf;

use vb_record::StoreError;

/// An error of a replay. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The run can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The run has no such finished task.
    #[error("run {}: task {task} is not among its {done} finished tasks (name one of tasks.jsonl, e.g. {example})", .dir.display())]
    NoTask {
        /// The run directory.
        dir: PathBuf,
        /// The task asked for.
        task: String,
        /// Number of finished tasks.
        done: usize,
        /// One of them.
        example: String,
    },
    /// The run kept no trace of the task.
    #[error("run {}: no trace of task {task} (run it again with --trace 10hz or full)", .dir.display())]
    NoTrace {
        /// The run directory.
        dir: PathBuf,
        /// The task.
        task: String,
    },
    /// Runs differ in what they would share on the page.
    #[error("runs {} and {} differ in {field}: they can't be shown in one world (replay them one by one)", .first.display(), .second.display())]
    Differ {
        /// A run.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// What differs.
        field: &'static str,
    },
    /// The world has no such task.
    #[error(
        "world {world} has no task {task}: the suite is not that of the run (name the right one with --suite)"
    )]
    OtherSuite {
        /// The world.
        world: String,
        /// The task.
        task: String,
    },
    /// An MCAP file can't be written.
    #[error("cannot write {}: {detail} (choose another place, or free some space)", .path.display())]
    Mcap {
        /// The file.
        path: PathBuf,
        /// Why not.
        detail: String,
    },
}
