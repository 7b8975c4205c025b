//! The errors of submissions and leaderboards.

use std::io;
use std::path::{Path, PathBuf};

use vb_host::LoadError;
use vb_record::StoreError;
use vb_report::ReportError;
use vb_runner::RunError;

/// The reason why a submission or a site can't be made or read. If a submission tells what isn't so, this is not an
/// error but a [`Finding`](crate::Finding). Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SubmissionError {
    /// The operating system refused an operation on a file that is read.
    #[error("cannot read {}: {source} (is the path right?)", .path.display())]
    Read {
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file can't be written.
    #[error("cannot write {}: {source} (choose another place, or free some space)", .path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The run is a part of a larger one.
    #[error("{} is shard {index} of {of} of a run (join the shards with merge first)", .path.display())]
    Shard {
        /// The run directory.
        path: PathBuf,
        /// The number of the shard.
        index: u32,
        /// The number of shards.
        of: u32,
    },
    /// The directory to be written holds something else.
    #[error("output directory {} is not empty (choose another with --out)", .0.display())]
    NotEmpty(PathBuf),
    /// A file, a line or a number of files is larger than what is read.
    #[error("{}: {what} beyond {limit} (no submission that this harness makes is so large)", .path.display())]
    TooLarge {
        /// The file or directory.
        path: PathBuf,
        /// The thing that is too large, e.g. `a file of more bytes`.
        what: &'static str,
        /// The greatest size that is read.
        limit: u64,
    },
    /// Something lies in a submission that may not: a link, a name that isn't plain.
    #[error("{}: {what} (a submission holds the files that `submit` writes and nothing else)", .path.display())]
    Unsafe {
        /// The place where it lies.
        path: PathBuf,
        /// The kind of thing that it is.
        what: &'static str,
    },
    /// There is no submission in the directory.
    #[error("{} holds no submission: submission.json is missing (give the directory that `submit --out` named)", .0.display())]
    NoSubmission(PathBuf),
    /// A file is of a version that this harness doesn't read.
    #[error("{}: schema {found} is not supported, this version reads up to {supported} (use the version that wrote it)", .path.display())]
    Schema {
        /// The path of the file.
        path: PathBuf,
        /// The schema version of the file.
        found: u64,
        /// The newest schema version that is read.
        supported: u32,
    },
    /// A file is not what it should be.
    #[error("{}: {detail} (take the file as `vb-harness` wrote it)", .path.display())]
    Damaged {
        /// The path of the file.
        path: PathBuf,
        /// A text on what is wrong.
        detail: String,
    },
    /// The results are of another version of the harness, which may drive otherwise.
    #[error("{} was made by version {made} of the harness, this is {this} (use version {made}, or run it again with this one)", .path.display())]
    Version {
        /// The run or submission.
        path: PathBuf,
        /// The version that made them.
        made: String,
        /// The version of this harness.
        this: String,
    },
    /// The run isn't finished.
    #[error("run {} is not finished: {missing} of {tasks} tasks are missing or failed by the machine (go on with it by run --resume)", .path.display())]
    Unfinished {
        /// The run directory.
        path: PathBuf,
        /// The number of tasks without a result.
        missing: u64,
        /// The number of tasks of the run.
        tasks: u64,
    },
    /// The run was made with something else than what is at hand.
    #[error("run {}: its {what} is {recorded}, this one is {found} (name the one of the run)", .path.display())]
    Other {
        /// The run directory.
        path: PathBuf,
        /// The thing that differs, e.g. `plugin`.
        what: &'static str,
        /// The hash in the run.
        recorded: String,
        /// The hash at hand.
        found: String,
    },
    /// A command can't be submitted.
    #[error("a command can't be submitted: nobody else has what it starts (build the planner as WASM)")]
    Command,
    /// What the entrant says about himself can't be shown.
    #[error("{field}: {problem}")]
    Entrant {
        /// The option that holds it.
        field: &'static str,
        /// A text on what is wrong.
        problem: String,
    },
    /// A task whose replay is wanted has no trace.
    #[error("--replays: {task}: {problem}")]
    Replay {
        /// The name of the task.
        task: String,
        /// A text on what is wrong.
        problem: String,
    },
    /// The machine failed while tasks were driven again: nothing is known of the submission.
    #[error(
        "the machine failed {failed} of the tasks that were driven again, {example} for one (verify it again)"
    )]
    Machine {
        /// The number of such tasks.
        failed: usize,
        /// The first of them.
        example: String,
    },
    /// The verification was stopped.
    #[error("stopped before all tasks were driven again (verify it again)")]
    Interrupted,
    /// A folder of a leaderboard can't be shown.
    #[error("entry {}: {problem}", .dir.display())]
    Entry {
        /// The folder.
        dir: PathBuf,
        /// A text on what is wrong, and what to do.
        problem: String,
    },
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
