//! Why a task can't be replayed.

use std::path::PathBuf;

use vb_record::StoreError;

/// An error of a replay. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("run {}: task {task} is not among its {done} finished tasks (name one of tasks.jsonl, e.g. {example})", .dir.display())]
    NoTask { dir: PathBuf, task: String, done: usize, example: String },
    #[error("run {}: no trace of task {task} (run it again with --trace 10hz or full)", .dir.display())]
    NoTrace { dir: PathBuf, task: String },
    #[error("runs {} and {} differ in {field}: they can't be shown in one world (replay them one by one)", .first.display(), .second.display())]
    Differ { first: PathBuf, second: PathBuf, field: &'static str },
    #[error(
        "world {world} has no task {task}: the suite is not that of the run (name the right one with --suite)"
    )]
    OtherSuite { world: String, task: String },
    #[error("cannot write {}: {detail} (choose another place, or free some space)", .path.display())]
    Mcap { path: PathBuf, detail: String },
}
