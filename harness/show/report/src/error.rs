//! Why a report can't be made.

use std::path::{Path, PathBuf};

use vb_record::StoreError;

/// An error of a report. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("run {} has no finished task (wait for one, or continue it with run --resume)", .0.display())]
    Empty(PathBuf),
    #[error(
        "runs {} and {} are of different suites, {first_suite} and {second_suite}: their tasks differ (create one \
         report per suite)", .first.display(), .second.display()
    )]
    Suites {
        first: PathBuf,
        second: PathBuf,
        /// Name and hash of the suite of `first`.
        first_suite: String,
        /// Name and hash of the suite of `second`.
        second_suite: String,
    },
    #[error("run {} is given twice (name each run once)", .0.display())]
    Twice(PathBuf),
    #[error("no run given (name a run directory)")]
    NoRuns,
    #[error("label `{given}`: no run of that name (write RUN=TEXT, where RUN is one of {})", .runs.join(", "))]
    Label { given: String, runs: Vec<String> },
    /// A label would be that of two runs, or a run would have two, or none.
    #[error("label `{given}`: {reason}")]
    LabelTaken { given: String, reason: String },
    #[error("cannot write {}: {source} (choose another place, or free some space)", .path.display())]
    Write { path: PathBuf, source: std::io::Error },
}

impl ReportError {
    pub(crate) fn write<E: Into<Box<dyn std::error::Error + Send + Sync>>>(
        path: &Path,
    ) -> impl Fn(E) -> Self {
        let path = path.to_owned();
        move |e| Self::Write { path: path.clone(), source: std::io::Error::other(e) }
    }
}
