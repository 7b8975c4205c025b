//! What can be wrong with a vehicle file.

use std::path::PathBuf;

/// A vehicle that can't be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VehicleError {
    /// The file can't be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// It has a wrong shape or a value that no vehicle can have.
    #[error("{file}: {field}: {reason}")]
    Invalid {
        /// The file.
        file: String,
        /// Path of the field, e.g. `axles[1].suspension.spring.stiffness`.
        field: String,
        /// The value and what is wrong with it.
        reason: String,
    },
}
