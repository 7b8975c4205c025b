//! Why a task can't be replayed.

use std::path::PathBuf;

use vb_record::StoreError;
use vb_world::TaskId;

/// An error of a replay. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("run {}: task {task} is not one of its {done} finished tasks (give a task of tasks.jsonl, e.g. {example})", .dir.display())]
    NoTask { dir: PathBuf, task: TaskId, done: usize, example: String },
    #[error("run {}: no trace of task {task} (re-run with --trace 10hz or full)", .dir.display())]
    NoTrace { dir: PathBuf, task: TaskId },
    #[error("runs {} and {} differ in {field}, so they need separate replays (replay them one by one)", .first.display(), .second.display())]
    Differ { first: PathBuf, second: PathBuf, field: &'static str },
    #[error(
        "the suite contains no task {0}, so it is not the suite of the run (give the right suite with --suite)"
    )]
    OtherSuite(TaskId),
    #[error("cannot write {}: {detail} (choose another place, or free some space)", .path.display())]
    Mcap { path: PathBuf, detail: String },
}
