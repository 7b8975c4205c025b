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
    /// There is no such file.
    #[error("{}: no such plugin file; {}", .path.display(), hint::missing(.path))]
    NotFound {
        /// The path of the file.
        path: PathBuf,
    },
    /// The file can't be read.
    #[error("{}: can't read the plugin: {source}", .path.display())]
    Io {
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is empty.
    #[error("{}: the plugin file is empty; build it again", .path.display())]
    Empty {
        /// The path of the file.
        path: PathBuf,
    },
    /// The file is not a plugin.
    #[error("{}: not a planner plugin: {reason}", .path.display())]
    NotAPlugin {
        /// The path of the file.
        path: PathBuf,
        /// What the file is instead, or what it lacks.
        reason: String,
    },
    /// The file is damaged.
    #[error("{}: the plugin is truncated or damaged: {reason}; build it again", .path.display())]
    Damaged {
        /// The path of the file.
        path: PathBuf,
        /// The damage and its place.
        reason: String,
    },
    /// The metadata can't be read.
    #[error("{}: the plugin's metadata can't be read: {source}{}", .path.display(), hint::metadata(.source))]
    Metadata {
        /// The path of the file.
        path: PathBuf,
        /// The problem with the metadata.
        source: vb_sdk::metadata::MetadataError,
    },
    /// The plugin speaks a version of the planner interface outside of the harness's window.
    #[error(
        "{}: the plugin was built for planner ABI {found}; this harness supports {}. {}",
        .path.display(), AbiVersion::window(), abi::advice(.found)
    )]
    AbiVersion {
        /// The path of the file.
        path: PathBuf,
        /// The version that the plugin speaks.
        found: String,
    },
    /// The plugin wants something from the outside that planners don't get.
    #[error(
        "{}: the plugin imports {}, which planners don't get; {}",
        .path.display(), hint::shown(.imports), hint::imports(.imports)
    )]
    ForbiddenImports {
        /// The path of the file.
        path: PathBuf,
        /// The names of the imports: interfaces, or `MODULE.NAME` for a core module.
        imports: Vec<String>,
    },
    /// The WebAssembly code is not valid, or the native library can't be opened.
    #[error("{}: the plugin can't be loaded: {reason}", .path.display())]
    Unloadable {
        /// The path of the file.
        path: PathBuf,
        /// The reason that the engine or the system gives.
        reason: String,
    },
    /// The file, or something in it, is larger than it may be.
    #[error("{}: the plugin has {found} {what}, it may have {limit}", .path.display())]
    TooLarge {
        /// The path of the file.
        path: PathBuf,
        /// The kind of thing of which there is too much, e.g. `bytes`.
        what: &'static str,
        /// The amount that there is.
        found: u64,
        /// The greatest amount that there may be.
        limit: u64,
    },
    /// Compiling the plugin takes more than it may.
    #[error(
        "{}: compiling the plugin takes more than {limit} {what}; make its largest functions smaller and fewer, or raise {field} \
         (run --limits)",
        .path.display()
    )]
    TooCostly {
        /// The path of the file.
        path: PathBuf,
        /// The kind of thing that is limited, e.g. `bytes of memory`.
        what: &'static str,
        /// The greatest amount that compiling may take.
        limit: u64,
        /// The name of the limit.
        field: &'static str,
    },
    /// The process that should have opened the plugin failed.
    #[error("{}: the plugin can't be loaded: {cause}; {}", .path.display(), .cause.hint())]
    Faulty {
        /// The path of the file, or the command.
        path: PathBuf,
        /// The way in which the process failed.
        cause: FaultCause,
    },
    /// Plugins of this kind don't run on this system.
    #[error("{}: {reason}", .path.display())]
    NotHere {
        /// The path of the file.
        path: PathBuf,
        /// The reason, and what to do instead.
        reason: &'static str,
    },
    /// A native plugin lays its data out in another way than the harness does.
    #[error("{}: the plugin's data layout differs from the harness's: {reason}. Rebuild it with the harness's vb-sdk", .path.display())]
    LayoutMismatch {
        /// The path of the file.
        path: PathBuf,
        /// The first difference.
        reason: String,
    },
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

/// The reason why parameters don't fit a planner.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamError {
    /// The planner declares no such parameter.
    #[error("--param {key}: the planner `{planner}` has no such parameter; it has {known}")]
    Unknown {
        /// The name of the parameter.
        key: String,
        /// The name of the planner.
        planner: String,
        /// The parameters that it has.
        known: String,
    },
    /// A parameter is of another kind than its default.
    #[error("--param {key}: \"{value}\" is not {kind}{help}; its default is {default}")]
    Kind {
        /// The name of the parameter.
        key: String,
        /// The value that was given.
        value: String,
        /// What a value must be, in words.
        kind: &'static str,
        /// What the parameter means, in brackets with a space before it; empty if the planner doesn't say it.
        help: String,
        /// The default.
        default: String,
    },
    /// A parameter is given twice.
    #[error("--param {key}: given twice; give it once")]
    Twice {
        /// The name of the parameter.
        key: String,
    },
}
