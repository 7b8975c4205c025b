//! Why a report can't be made.

use std::path::{Path, PathBuf};

use vb_record::StoreError;

/// An error of a report. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A run can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A run has no finished task.
    #[error("run {} has no finished task yet (wait for one, or go on with it by run --resume)", .0.display())]
    Empty(PathBuf),
    /// Runs of different suites were given.
    #[error(
        "runs {} and {} are of different suites, {first_suite} and {second_suite}: their tasks are not the same (report \
         them one by one)", .first.display(), .second.display()
    )]
    Suites {
        /// A run.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Name and hash of the suite of the one.
        first_suite: String,
        /// And of the other.
        second_suite: String,
    },
    /// The same run was given twice.
    #[error("run {} is given twice (name each run once)", .0.display())]
    Twice(PathBuf),
    /// No run was given.
    #[error("no run given (name the directory of one)")]
    NoRuns,
    /// A label is of no run.
    #[error("label `{given}`: no run of that name (write RUN=TEXT, where RUN is one of {})", .runs.join(", "))]
    Label {
        /// What was given.
        given: String,
        /// The directories of the runs.
        runs: Vec<String>,
    },
    /// A label would be that of two runs, or a run would have two, or none.
    #[error("label `{given}`: {reason}")]
    LabelTaken {
        /// What was given.
        given: String,
        /// What is wrong with it, and what to do.
        reason: String,
    },
    /// A file can't be written.
    #[error("cannot write {}: {source} (choose another place, or free some space)", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}

impl ReportError {
    pub(crate) fn write<E: Into<Box<dyn std::error::Error + Send + Sync>>>(
        path: &Path,
    ) -> impl Fn(E) -> Self {
        let path = path.to_owned();
        move |e| Self::Write { path: path.clone(), source: std::io::Error::other(e) }
    }
}
