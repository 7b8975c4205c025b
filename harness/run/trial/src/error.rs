//! The reasons why a trial can't start.

use vb_files::DocumentError;
use vb_sense::SenseError;
use vb_sim::SimError;
use vb_vehicle::SCALES;

/// An error of a trial's setting. What goes wrong during a trial is not such an error but its outcome.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] DocumentError),
    /// The vehicle can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// The planner asks for what the perception profile doesn't offer.
    #[error("planner {planner}: {source}")]
    Perception {
        /// The name of the planner.
        planner: String,
        /// What it asks for, and what there is.
        source: SenseError,
    },
    /// The scale is one that no world has.
    #[error("a scale of {0} is not in {least} to {most}", least = SCALES.start(), most = SCALES.end())]
    Scale(f64),
}
