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
    #[error(
        "world {world} has a granular bed with grains of radius {grain} m, larger than the vehicle's wheels of radius {wheel} m: \
         choose smaller grains or a larger vehicle"
    )]
    Grains {
        world: String,
        /// The maximum radius of the grains, m.
        grain: f64,
        /// The minimum radius of the wheels, m.
        wheel: f64,
    },
    #[error("world {world} has a granular bed that can't be filled: {source}")]
    Bed { world: String, source: vb_granular::PackingError },
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
