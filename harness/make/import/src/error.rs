//! Failures of a conversion.

use std::fmt::Display;
use std::path::Path;

/// The reason why a file is not converted: one line with file, place in the file and next step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", message(.file, .at, .problem))]
pub struct ImportError {
    /// The file.
    pub file: String,
    /// The place within the file; empty if the file as a whole is meant.
    pub at: String,
    /// The problem and its remedy.
    pub problem: String,
}

fn message(file: &str, at: &str, problem: &str) -> String {
    let place = if at.is_empty() { String::new() } else { format!("{at}: ") };
    vb_files::cut_line(&format!("{file}: {place}{problem}"), 1200)
}

impl ImportError {
    pub(crate) fn new(file: impl Display, at: impl Display, problem: impl Display) -> Self {
        Self { file: file.to_string(), at: at.to_string(), problem: problem.to_string() }
    }

    pub(crate) fn reading(file: &Path, e: &std::io::Error) -> Self {
        Self::new(file.display(), "", e)
    }

    /// The converted vehicle is not one that the simulator has.
    pub(crate) fn invalid(e: vb_files::DocumentError) -> Self {
        let problem = format!("{} (the value follows from the source's; correct it there)", e.problem);
        Self::new(e.file, e.field, problem)
    }
}
