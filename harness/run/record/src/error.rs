//! The errors of a run directory.

use std::io;
use std::path::{Path, PathBuf};

/// An error of the run store. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The operating system refused an operation.
    #[error("cannot {action} {}: {source}{}", .path.display(), hint(action, .source))]
    Io {
        /// The action that was tried, e.g. `write`.
        action: &'static str,
        /// The file or directory on which it was tried.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A new run was asked for in a directory that holds something.
    #[error(
        "output directory {} is not empty (choose another with --out, or continue its run with --resume)",
        .0.display()
    )]
    NotEmpty(PathBuf),
    /// Something else that is made as a whole was asked for there.
    #[error("output directory {} is not empty (choose another with --out)", .0.display())]
    Taken(PathBuf),
    /// There is no run in the directory.
    #[error("{} is not a run: run.json is missing (give the directory of a run)", .0.display())]
    NoRun(PathBuf),
    /// Another process writes to this directory.
    #[error("{} is in use by another process (wait for it to end, or choose another --out)", .0.display())]
    Locked(PathBuf),
    /// The run in the directory was made with something else than what is to be resumed.
    #[error(
        "cannot resume {}: {field} differs: the run has {recorded}, this command has {wanted} (repeat the settings \
         of the run, or start a new run with another --out)",
        .dir.display()
    )]
    Differs {
        /// The run directory.
        dir: PathBuf,
        /// The field of run.json that differs, e.g. `plugin.sha256`.
        field: String,
        /// The value of the field in run.json.
        recorded: String,
        /// The value of the field now.
        wanted: String,
    },
    /// run.json was written by a version that this one doesn't read.
    #[error("{}: schema {found} is not supported; this version reads schema {supported} (use the version that wrote it)", .path.display())]
    Schema {
        /// The path of the file.
        path: PathBuf,
        /// The schema version of the file.
        found: u64,
        /// The schema version that is supported.
        supported: u32,
    },
    /// A file is not what it should be.
    #[error("{}: {detail} ({hint})", .path.display())]
    Damaged {
        /// The path of the file.
        path: PathBuf,
        /// The problem, with line or field.
        detail: String,
        /// A hint on what to do.
        hint: &'static str,
    },
    /// A value can't be written as JSON or Parquet.
    #[error("cannot encode {what}: {detail} (this is an error of the harness: please report it)")]
    Encode {
        /// The object that was to be written.
        what: &'static str,
        /// The reason why it can't be written.
        detail: String,
    },
}

impl StoreError {
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { action, path, source }
    }

    /// Tells whether it is about where something is to be written, and not about what is read.
    #[must_use]
    pub fn is_of_output(&self) -> bool {
        match self {
            Self::Io { action, .. } => !action.starts_with("read"),
            Self::NotEmpty(_) | Self::Taken(_) | Self::Locked(_) | Self::Differs { .. } => true,
            _ => false,
        }
    }

    /// Tells whether the disk (or a quota) is full.
    #[must_use]
    pub fn is_disk_full(&self) -> bool {
        matches!(self, Self::Io { source, .. } if disk_full(source))
    }
}

fn disk_full(e: &io::Error) -> bool {
    matches!(
        e.kind(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge
    )
}

/// What to do about an error of the operating system, in parentheses; empty where there is no good advice.
fn hint(action: &str, e: &io::Error) -> &'static str {
    // What is read is named by the user as it is, and not every command that reads writes anywhere else.
    let reads = action.starts_with("read");
    match e.kind() {
        io::ErrorKind::PermissionDenied if reads => " (ask its owner for the permission to read it)",
        io::ErrorKind::NotADirectory if reads => " (a part of the path is a file)",
        _ if disk_full(e) => {
            " (recorded tasks are kept: free some space, then continue with the same command and --resume; a new run \
              with --trace none needs the minimum)"
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            " (choose a directory that you may write to with --out)"
        }
        io::ErrorKind::AlreadyExists => " (a file with that name exists: choose another --out)",
        io::ErrorKind::NotADirectory => " (a part of the path is a file: choose another --out)",
        io::ErrorKind::NotFound => " (check the path)",
        _ => "",
    }
}
