//! What can go wrong in setting up or advancing a simulation.

use std::path::PathBuf;

/// An error of the simulator.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] vb_vehicle::VehicleError),
    /// A soil file can't be read.
    #[error("{}: {reason}", path.display())]
    SoilsUnreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A soil file has a wrong shape or a value that no soil can have.
    #[error("{file}: {field}: {reason}")]
    SoilsInvalid {
        /// The file.
        file: String,
        /// Path of the field, e.g. `soils.snow.n`.
        field: String,
        /// The value and what is wrong with it.
        reason: String,
    },
    /// The world has a deformable class of which the soil file has no soil.
    #[error("world {world} has {class}, for which the soil set {set} has no soil")]
    NoSoil {
        /// Name of the world.
        world: String,
        /// The class.
        class: &'static str,
        /// Name of the set.
        set: String,
    },
    /// The state became one that no vehicle can have: a fault of the simulator, not of the planner.
    #[error("the simulation diverged at t = {time:.3} s: {what}; {state}")]
    Diverged {
        /// Simulated time, s.
        time: f64,
        /// What no vehicle can have.
        what: &'static str,
        /// Pose, velocities and wheels at that time.
        state: String,
    },
}
