//! The reasons why a dataset can't be made or read.

use std::path::{Path, PathBuf};

use vb_record::StoreError;
use vb_trial::TrialError;
use vb_world::{SuiteError, TaskId};

/// What to do about an error of the operating system.
fn hint(source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            " (free some space, then repeat the command with --resume; written data are kept)"
        }
        std::io::ErrorKind::PermissionDenied => " (give another --out, or change its permissions)",
        _ => "",
    }
}

/// An error of a dataset. Each message is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    #[error("cannot {action} {}: {source}{}", .path.display(), hint(.source))]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{}: {detail} (the file is truncated, damaged or not from a dataset of this harness)", .path.display())]
    Damaged { path: PathBuf, detail: String },
    #[error(
        "{}: {problem} (copy the intact dataset, or re-create it with the command in its dataset.json; `vb-harness dataset validate` lists all errors)",
        .path.display()
    )]
    Changed { path: PathBuf, problem: String },
    #[error("a table can't be encoded: {detail}; please report it")]
    Encode { detail: String },
    #[error("{} is not empty (give another --out, or continue with --resume)", .dir.display())]
    NotEmpty { dir: PathBuf },
    #[error(
        "{}: a LeRobot dataset, but not one of Verti-Bench: dataset.json, which has vehicle, worlds and units, is missing (give the folder \
         that `vb-harness dataset` created)",
        .dir.display()
    )]
    Foreign { dir: PathBuf },
    #[error("{}: not a dataset: dataset.json is missing (give the folder that `vb-harness dataset` created)", .dir.display())]
    Missing { dir: PathBuf },
    #[error("{}: dataset version {found} is not supported; this build reads version {supported} (use a newer vb-harness)", .path.display())]
    Schema { path: PathBuf, found: u64, supported: u32 },
    #[error("{} is within the dataset {} and would change it (give another --out)", .out.display(), .dir.display())]
    Within { out: PathBuf, dir: PathBuf },
    #[error("cannot resume {}: {field} is {now}, not {before} (give the same options, or another --out)", .dir.display())]
    Other { dir: PathBuf, field: String, before: String, now: String },
    #[error("{}: the dataset is not finished (finish it with the command in its dataset.json and --resume)", .dir.display())]
    Unfinished { dir: PathBuf },
    #[error(
        "world {world} is {suite}/{of}: datasets for training must not contain worlds of a suite (use worlds of `vb-harness suite generate --training`)"
    )]
    SuiteWorld { world: String, suite: String, of: String },
    #[error(
        "{hz} frames per second are not possible: the control period of {driver} is {period} s, and a frame is a whole number of control periods (give --hz {possible})"
    )]
    Rate {
        /// The rate, Hz.
        hz: u32,
        driver: String,
        /// The period of the driver, s.
        period: f64,
        possible: String,
    },
    #[error("{task}: {reason}")]
    Planner {
        task: TaskId,
        /// Who failed, where and why, and what to do.
        reason: String,
    },
    #[error(
        "world {world} has no valid start position for {vehicle} (relax start.tilt_deg or start.clearance_m of the exploration rules)"
    )]
    NoStart { world: String, vehicle: String },
    #[error(
        "{task} cannot be reproduced from its trace: it is from another version of the harness, or too coarse (re-run with --trace full)"
    )]
    NotRepeated { task: TaskId },
    #[error(transparent)]
    Record(#[from] StoreError),
    #[error("no episodes: {0}")]
    Empty(String),
    #[error("{} and {} are incompatible: {what} (merge datasets with equal options)", .a.display(), .b.display())]
    Unlike { a: PathBuf, b: PathBuf, what: String },
    #[error(
        "all episodes of {} are also in {}, and would be duplicates (give each dataset once, and no dataset with its parts)",
        .inner.display(), .outer.display()
    )]
    Repeated { inner: PathBuf, outer: PathBuf },
    #[error("--parts: {problem} (give them as in train=0.8,validation=0.1,test=0.1)")]
    Parts { problem: String },
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
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { action, path, source }
    }

    /// A damaged file; the detail becomes one line.
    pub(crate) fn damaged(path: &Path, detail: &str) -> Self {
        Self::Damaged { path: path.to_owned(), detail: vb_files::one_line(detail) }
    }
}
