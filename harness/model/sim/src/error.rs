//! The errors of setting up or advancing a simulation.

use vb_files::DocumentError;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] DocumentError),
    #[error("world {world} has {class}, for which the soil set {set} has no soil")]
    NoSoil { world: String, class: &'static str, set: String },
    /// The vehicle's state became one that no vehicle can have: a fault of the simulator, not of the planner.
    #[error("the simulation diverged at t = {time:.3} s: {what}; {state}")]
    Diverged {
        /// The simulated time at which it happened, s.
        time: f64,
        what: &'static str,
        /// The pose, the velocities and the wheels at that time.
        state: String,
    },
}
