//! The errors that a vehicle file can have.

use std::path::PathBuf;

/// The reason why a vehicle can't be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VehicleError {
    /// The file can't be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The path of the file.
        path: PathBuf,
        /// The reason for which it can't be read.
        reason: String,
    },
    /// The file has a wrong shape, or holds a value that no vehicle can have.
    #[error("{file}: {field}: {reason}")]
    Invalid {
        /// The name of the file.
        file: String,
        /// The path of the field in the file, e.g. `axles[1].suspension.spring.stiffness`.
        field: String,
        /// The value, and what is wrong with it.
        reason: String,
    },
}
