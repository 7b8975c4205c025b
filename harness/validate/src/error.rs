//! What can go wrong in validating a vehicle.

use std::path::PathBuf;

/// An error of a validation. A check that fails is none: it is a result.
#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    /// A file of references can't be read.
    #[error("{}: {reason}", path.display())]
    ReferencesUnreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A file of references has a wrong shape or value.
    #[error("{file}: {field}: {reason}")]
    ReferencesInvalid {
        /// The file.
        file: String,
        /// Path of the field, e.g. `events.braking[2].value`.
        field: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] vb_vehicle::VehicleError),
    /// The vehicle can't be simulated.
    #[error(transparent)]
    Simulation(#[from] vb_sim::SimError),
    /// An event that doesn't exist.
    #[error("there is no event {name} (one of: {known})")]
    UnknownEvent {
        /// As given.
        name: String,
        /// All names.
        known: String,
    },
    /// An event that says nothing of the vehicle.
    #[error("the event {name} is for {kind} vehicles; {vehicle} is none")]
    NotForVehicle {
        /// The event.
        name: String,
        /// wheeled or tracked
        kind: &'static str,
        /// Name of the vehicle.
        vehicle: String,
    },
    /// A step that no simulation can use.
    #[error("step {step} s: must be between 0.01 and 10 ms")]
    Step {
        /// As given, s.
        step: f64,
    },
    /// A file of the report can't be written.
    #[error("{}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}
