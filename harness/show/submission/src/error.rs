//! The errors of submissions and leaderboards.

use std::io;
use std::path::{Path, PathBuf};

use vb_host::LoadError;
use vb_record::StoreError;
use vb_report::ReportError;
use vb_runner::RunError;
use vb_world::TaskId;

/// The reason why a submission or a site can't be made or read. If a submission tells what isn't so, this is not an
/// error but a [`Finding`](crate::Finding). Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SubmissionError {
    #[error("cannot read {}: {source} (check the path)", .path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("cannot write {}: {source} (choose another place, or free some space)", .path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("{} is shard {index} of {of} of a run (join the shards with merge first)", .path.display())]
    Shard { path: PathBuf, index: u32, of: u32 },
    #[error("output directory {} is not empty (choose another with --out)", .0.display())]
    NotEmpty(PathBuf),
    #[error("{}: {what} exceeds {limit} (submissions of this harness are smaller)", .path.display())]
    TooLarge {
        path: PathBuf,
        /// The thing that is too large, e.g. `a file of more bytes`.
        what: &'static str,
        limit: u64,
    },
    /// Something lies in a submission that may not: a link, a name that isn't plain.
    #[error("{}: {what} (a submission contains only the files that `submit` writes)", .path.display())]
    Unsafe { path: PathBuf, what: &'static str },
    #[error("{} is not a submission: submission.json is missing (give the directory of `submit --out`)", .0.display())]
    NoSubmission(PathBuf),
    #[error("{}: schema {found} is not supported; this version reads up to {supported} (use the version that wrote it)", .path.display())]
    Schema { path: PathBuf, found: u64, supported: u32 },
    #[error("{}: {detail} (use the unmodified file from `vb-harness`)", .path.display())]
    Damaged { path: PathBuf, detail: String },
    #[error("{} was created with version {made} of the harness; this is {this} (use version {made}, or re-run with this version)", .path.display())]
    Version { path: PathBuf, made: String, this: String },
    #[error("run {} is not finished: {missing} of {tasks} tasks are missing or failed because of the machine (continue with run --resume)", .path.display())]
    Unfinished { path: PathBuf, missing: u64, tasks: u64 },
    #[error("run {}: its {what} is {recorded}, not {found} (give the {what} of the run)", .path.display())]
    Other {
        path: PathBuf,
        /// The thing that differs, e.g. `plugin`.
        what: &'static str,
        recorded: String,
        found: String,
    },
    #[error(
        "a command or a ROS 2 node can't be submitted, because it cannot be re-run elsewhere (build the planner as WASM, or submit the \
         recorded commands of its run: vb-harness commands RUN --out FILE)"
    )]
    NoFile,
    #[error("{field}: {problem}")]
    Entrant { field: &'static str, problem: String },
    #[error("--replays: {task}: {problem}")]
    Replay { task: TaskId, problem: String },
    /// The machine failed while tasks were driven again: nothing is known of the submission.
    #[error("{failed} of the re-run tasks failed because of the machine, e.g. {example} (verify again)")]
    Machine { failed: usize, example: TaskId },
    #[error("stopped before all tasks were re-run (verify again)")]
    Interrupted,
    #[error("entry {}: {problem}", .dir.display())]
    Entry { dir: PathBuf, problem: String },
    /// A run can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A run can't be reported.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The plugin can't be loaded.
    #[error("{} ({})", .0, .0.code())]
    Plugin(#[from] LoadError),
    /// Tasks can't be driven again.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl SubmissionError {
    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Read { path, source }
    }

    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }

    pub(crate) fn damaged(path: &Path, detail: impl std::fmt::Display) -> Self {
        Self::Damaged { path: path.to_owned(), detail: detail.to_string() }
    }
}
