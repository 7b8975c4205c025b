//! The errors of loading a plugin.

use std::path::PathBuf;

use crate::FaultCause;
use crate::abi::{self, AbiVersion};
use crate::hint;
use vb_sdk::fault::FaultCode;

/// The reason why a file can't be used as a planner plugin. Every message is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    #[error("{}: no such plugin file; {}", .path.display(), hint::missing(.path))]
    NotFound { path: PathBuf },
    #[error("{}: can't read the plugin: {source}", .path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: the plugin file is empty; rebuild it", .path.display())]
    Empty { path: PathBuf },
    #[error("{}: not a planner plugin: {reason}", .path.display())]
    NotAPlugin { path: PathBuf, reason: String },
    #[error("{}: the plugin is truncated or damaged: {reason}; rebuild it", .path.display())]
    Damaged { path: PathBuf, reason: String },
    #[error("{}: the plugin's metadata can't be read: {source}{}", .path.display(), hint::metadata(.source))]
    Metadata { path: PathBuf, source: vb_sdk::metadata::MetadataError },
    #[error(
        "{}: the plugin was built for planner ABI {found}; this harness supports {}. {}",
        .path.display(), AbiVersion::window(), abi::advice(.found)
    )]
    AbiVersion { path: PathBuf, found: String },
    #[error(
        "{}: the plugin imports {}, which is not available to planners; {}",
        .path.display(), hint::shown(.imports), hint::imports(.imports)
    )]
    ForbiddenImports {
        path: PathBuf,
        /// The names of the imports: interfaces, or `MODULE.NAME` for a core module.
        imports: Vec<String>,
    },
    /// The WebAssembly code is not valid, or the native library can't be opened.
    #[error("{}: the plugin can't be loaded: {reason}", .path.display())]
    Unloadable { path: PathBuf, reason: String },
    #[error("{}: the plugin has {found} {what}; the limit is {limit}", .path.display())]
    TooLarge {
        path: PathBuf,
        /// The kind of thing of which there is too much, e.g. `bytes`.
        what: &'static str,
        found: u64,
        limit: u64,
    },
    #[error(
        "{}: compiling the plugin takes more than {limit} {what}; split its largest functions, or raise {field} \
         (run --limits)",
        .path.display()
    )]
    TooCostly {
        path: PathBuf,
        /// The kind of thing that is limited, e.g. `bytes of memory`.
        what: &'static str,
        limit: u64,
        field: &'static str,
    },
    /// The process that should have opened the plugin failed.
    #[error("{}: the plugin can't be loaded: {cause}; {}", .path.display(), .cause.hint())]
    Faulty {
        /// The path of the file, or the command.
        path: PathBuf,
        cause: FaultCause,
    },
    /// Plugins of this kind don't run on this system.
    #[error("{}: {reason}", .path.display())]
    NotHere {
        path: PathBuf,
        /// The reason, and what to do instead.
        reason: &'static str,
    },
    #[error("{}: the plugin's data layout differs from the harness's: {reason}. Rebuild it with the harness's vb-sdk", .path.display())]
    LayoutMismatch { path: PathBuf, reason: String },
}

impl LoadError {
    /// The stable name of the error.
    #[must_use]
    pub fn code(&self) -> FaultCode {
        match self {
            Self::NotFound { .. } => FaultCode::NotFound,
            Self::Io { .. } => FaultCode::Unreadable,
            Self::Empty { .. } | Self::NotAPlugin { .. } => FaultCode::NotAPlugin,
            Self::Damaged { .. } => FaultCode::Damaged,
            Self::Metadata { .. } => FaultCode::Metadata,
            Self::AbiVersion { .. } | Self::LayoutMismatch { .. } => FaultCode::AbiMismatch,
            Self::ForbiddenImports { .. } => FaultCode::ImportDenied,
            Self::TooLarge { .. } => FaultCode::TooLarge,
            Self::TooCostly { .. } => FaultCode::TooCostly,
            Self::Unloadable { .. } | Self::NotHere { .. } => FaultCode::Unloadable,
            Self::Faulty { cause, .. } => cause.code(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamError {
    #[error("--param {key}: the planner `{planner}` has no such parameter; it has {known}")]
    Unknown { key: String, planner: String, known: String },
    #[error("--param {key}: \"{value}\" is not {kind}{help}; its default is {default}")]
    Kind {
        key: String,
        value: String,
        /// What a value must be, in words.
        kind: &'static str,
        /// What the parameter means, in brackets with a space before it; empty if the planner doesn't say it.
        help: String,
        default: String,
    },
    #[error("--param {key}: given twice; give it once")]
    Twice { key: String },
}
