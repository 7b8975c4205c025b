//! The errors of a suite on disk.

use super::SCHEMA;
use crate::Flaw;
use std::path::{Path, PathBuf};

/// The reason why a suite could not be read or written. Each message names the place and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    /// A file or directory could not be read.
    #[error("{}: cannot read: {source}; {hint}", path.display())]
    Read {
        /// The path of the file or directory.
        path: PathBuf,
        /// A hint on what to do.
        hint: &'static str,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file or directory could not be written.
    #[error("{}: cannot write: {source}; check that the place is writable and the disk is not full", path.display())]
    Write {
        /// The path of the file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The content of a file is not what it must be.
    #[error("{}: {field}: {problem}", file.display())]
    Invalid {
        /// The path of the file.
        file: PathBuf,
        /// The field, e.g. `tasks[2].goal`.
        field: String,
        /// The value, and what would be right.
        problem: String,
    },
    /// The file is of another version of the format.
    #[error("{}: schema: version {found} is not supported, this build reads version {SCHEMA}; use a harness of the suite's age or make the suite anew", file.display())]
    Schema {
        /// The path of the file.
        file: PathBuf,
        /// The version that the file states.
        found: u32,
    },
    /// A world's files are not those that the suite was made with.
    #[error("{}: worlds: the content hash of {world} is {found}, but suite.yaml states {stated}; its files were changed or damaged: restore them or make the suite anew", file.display())]
    Hash {
        /// The suite file.
        file: PathBuf,
        /// The world.
        world: String,
        /// The hash in the suite file.
        stated: String,
        /// The hash of the world's files.
        found: String,
    },
    /// The suite has no world of this id.
    #[error("{}: no world is called {world:?}; there are {}", file.display(), known)]
    UnknownWorld {
        /// The suite file.
        file: PathBuf,
        /// The id that was asked for.
        world: String,
        /// The ids that exist.
        known: String,
    },
    /// The output directory already holds something.
    #[error("{}: already exists and is not empty; choose another directory or remove it first", path.display())]
    NotEmpty {
        /// The directory.
        path: PathBuf,
    },
}

impl SuiteError {
    pub(crate) fn invalid(file: &Path, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { file: file.into(), field: field.into(), problem: problem.into() }
    }

    /// A flaw of a world whose files lie in `folder`.
    pub(crate) fn flaw(folder: &Path, flaw: Flaw) -> Self {
        Self::invalid(&folder.join(flaw.part.file_name()), flaw.field, flaw.problem)
    }

    pub(crate) fn write(path: &Path, source: std::io::Error) -> Self {
        Self::Write { path: path.into(), source }
    }
}

/// A list of ids, shortened in the middle.
pub(crate) fn list(ids: &[&str]) -> String {
    match ids {
        [] => "none".into(),
        [first, .., last] if ids.len() > 12 => format!("{} from {first} to {last}", ids.len()),
        few => few.join(", "),
    }
}
