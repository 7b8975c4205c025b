//! The reasons why a dataset can't be made or read.

use std::path::{Path, PathBuf};

use vb_record::StoreError;
use vb_trial::TrialError;
use vb_world::SuiteError;

/// What to do about an error of the operating system.
fn hint(source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            " (free some space, then give the same command and --resume; what was written is safe)"
        }
        std::io::ErrorKind::PermissionDenied => " (give another --out, or change its permissions)",
        _ => "",
    }
}

/// An error of a dataset. Each message is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The operating system refuses.
    #[error("cannot {action} {}: {source}{}", .path.display(), hint(.source))]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A file isn't what it should be.
    #[error("{}: {detail} (the file is truncated, damaged or not of a dataset of this harness)", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        detail: String,
    },
    /// A file is not as it was written.
    #[error(
        "{}: {problem} (take the dataset from where it is whole, or make it again by the command in its dataset.json; `vb-harness dataset validate` tells all that is wrong)",
        .path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A table can't be encoded.
    #[error("a table can't be encoded: {detail}; please report it")]
    Encode {
        /// What is wrong.
        detail: String,
    },
    /// The folder isn't empty.
    #[error("{} holds something already (give another --out, or go on with --resume)", .dir.display())]
    NotEmpty {
        /// The folder.
        dir: PathBuf,
    },
    /// The dataset is one of LeRobot's, but not one of ours.
    #[error(
        "{}: a LeRobot dataset, but not one of Verti-Bench: dataset.json, which has vehicle, worlds and units, is missing (give the folder \
         that `vb-harness dataset` wrote)",
        .dir.display()
    )]
    Foreign {
        /// The folder.
        dir: PathBuf,
    },
    /// There is no dataset.
    #[error("{}: no dataset is here: dataset.json is missing (give the folder that `vb-harness dataset` wrote)", .dir.display())]
    Missing {
        /// The folder.
        dir: PathBuf,
    },
    /// The dataset is of a newer version.
    #[error("{}: version {found} of datasets, this build reads version {supported} (use a newer vb-harness)", .path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
        /// The version that is read.
        supported: u32,
    },
    /// The folder is in a dataset.
    #[error("{} is in the dataset {}, which would no longer be what it was (give another --out)", .out.display(), .dir.display())]
    Within {
        /// The folder.
        out: PathBuf,
        /// The dataset.
        dir: PathBuf,
    },
    /// The dataset was begun with other settings.
    #[error("cannot resume {}: {field} is {now}, and was {before} (give the same options, or another --out)", .dir.display())]
    Other {
        /// The folder.
        dir: PathBuf,
        /// The setting.
        field: String,
        /// What it was.
        before: String,
        /// What it is now.
        now: String,
    },
    /// The dataset isn't finished.
    #[error("{}: the dataset is not finished (finish it with the command in its dataset.json and --resume)", .dir.display())]
    Unfinished {
        /// The folder.
        dir: PathBuf,
    },
    /// A world belongs to a suite, on which planners are judged.
    #[error(
        "world {world} is {suite}/{of}: a dataset for training must not have worlds of a suite (take worlds that `vb-harness suite generate --training` makes)"
    )]
    SuiteWorld {
        /// The world.
        world: String,
        /// The suite.
        suite: String,
        /// The world's name in that suite.
        of: String,
    },
    /// A driver can't have frames at that rate.
    #[error(
        "{hz} frames a second are not possible: {driver} decides every {period} s, and a frame is a whole number of its steps (give --hz {possible})"
    )]
    Rate {
        /// The rate, Hz.
        hz: u32,
        /// The driver.
        driver: String,
        /// Its period, s.
        period: f64,
        /// A rate that is possible.
        possible: String,
    },
    /// A planner fails before it has driven.
    #[error("{task}: {reason}")]
    Planner {
        /// The task.
        task: String,
        /// Who failed, where and why, and what to do.
        reason: String,
    },
    /// There is nowhere to start.
    #[error(
        "world {world} has no place where {vehicle} may start (loosen the exploration's start.tilt_deg or start.clearance_m)"
    )]
    NoStart {
        /// The world.
        world: String,
        /// The vehicle.
        vehicle: String,
    },
    /// A recorded trial doesn't come to its end again.
    #[error(
        "{task} can't be repeated by its trace: another version of the harness drove it, or the trace is too coarse (drive the run again, with --trace full)"
    )]
    NotRepeated {
        /// The task.
        task: String,
    },
    /// A run's record can't be read.
    #[error(transparent)]
    Record(#[from] StoreError),
    /// Nothing is left to be recorded.
    #[error("no episode is left: {0}")]
    Empty(String),
    /// Datasets don't fit together.
    #[error("{} and {} don't fit together: {what} (merge datasets that were made with the same options)", .a.display(), .b.display())]
    Unlike {
        /// The first.
        a: PathBuf,
        /// The other.
        b: PathBuf,
        /// In what they differ.
        what: String,
    },
    /// The same dataset is there twice.
    #[error(
        "all episodes of {} are in {} too, and would count twice (name each dataset once, and none that is a part of another)",
        .inner.display(), .outer.display()
    )]
    Repeated {
        /// The dataset.
        inner: PathBuf,
        /// The dataset that has its episodes.
        outer: PathBuf,
    },
    /// Parts are no split of a dataset.
    #[error("--parts: {problem} (give them as in train=0.8,validation=0.1,test=0.1)")]
    Parts {
        /// What is wrong.
        problem: String,
    },
    /// A trial can't start.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// The system can't start a thread.
    #[error("can't start a worker thread: {0} (use fewer with --jobs)")]
    Thread(std::io::Error),
    /// The worlds can't be read or written.
    #[error(transparent)]
    Suite(#[from] SuiteError),
}

impl DatasetError {
    /// An error of the operating system.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { action, path, source }
    }

    /// A damaged file; the detail becomes one line.
    pub(crate) fn damaged(path: &Path, detail: &str) -> Self {
        let detail = detail.split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Damaged { path: path.to_owned(), detail }
    }
}
