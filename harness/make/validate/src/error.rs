//! What can go wrong in validating a vehicle.

use std::path::PathBuf;

use vb_files::DocumentError;

/// An error of a validation. A check that fails is none: it is a result.
#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    /// The vehicle or its references can't be used.
    #[error(transparent)]
    Document(#[from] DocumentError),
    #[error(transparent)]
    Simulation(#[from] vb_sim::SimError),
    #[error("unknown event {name} (events: {known})")]
    UnknownEvent { name: String, known: String },
    #[error("the event {name} is for {kind} vehicles; {vehicle} is not one")]
    NotForVehicle {
        name: String,
        /// Such as wheeled or tracked.
        kind: &'static str,
        vehicle: String,
    },
    #[error("step {step} s: must be between 0.01 and 10 ms")]
    Step {
        /// As given, s.
        step: f64,
    },
    #[error("{}: {reason}", path.display())]
    Write { path: PathBuf, reason: String },
}
