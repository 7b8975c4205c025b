//! The errors of setting up or advancing a simulation.

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
        /// The path of the file.
        path: PathBuf,
        /// The reason for which it can't be read.
        reason: String,
    },
    /// A soil file has a wrong shape or a value that no soil can have.
    #[error("{file}: {field}: {reason}")]
    SoilsInvalid {
        /// The name of the file.
        file: String,
        /// The path of the field in the file, e.g. `soils.snow.n`.
        field: String,
        /// The value, and what is wrong with it.
        reason: String,
    },
    /// The world has a deformable class for which the soil file has no soil.
    #[error("world {world} has {class}, for which the soil set {set} has no soil")]
    NoSoil {
        /// The name of the world.
        world: String,
        /// The name of the class.
        class: &'static str,
        /// The name of the set of soils.
        set: String,
    },
    /// The vehicle's state became one that no vehicle can have: a fault of the simulator, not of the planner.
    #[error("the simulation diverged at t = {time:.3} s: {what}; {state}")]
    Diverged {
        /// The simulated time at which it happened, s.
        time: f64,
        /// The part of the state that no vehicle can have.
        what: &'static str,
        /// The pose, the velocities and the wheels at that time.
        state: String,
    },
}
