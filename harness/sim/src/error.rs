//! What can go wrong in setting up or advancing a simulation.

use std::path::PathBuf;

/// An error of the simulator.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A vehicle file can't be read.
    #[error("{}: {reason}", path.display())]
    VehicleUnreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A vehicle file has a wrong shape or a value that no vehicle can have.
    #[error("{file}: {field}: {reason}")]
    VehicleInvalid {
        /// The file.
        file: String,
        /// Path of the field, e.g. `axles[1].suspension.spring.stiffness`.
        field: String,
        /// The value and what is wrong with it.
        reason: String,
    },
    /// The world has ground that yields, which this version can't simulate.
    #[error(
        "world {world} has deformable ground ({class}), which this version cannot simulate; \
         choose tasks on rigid ground (--tasks terrain=rigid)"
    )]
    DeformableGround {
        /// Name of the world.
        world: String,
        /// The first deformable class met.
        class: &'static str,
    },
    /// The state stopped being finite: a fault of the simulator, not of the planner.
    #[error("the simulation diverged at t = {time:.3} s: {what} is not finite")]
    Diverged {
        /// Simulated time, s.
        time: f64,
        /// The quantity.
        what: &'static str,
    },
}
