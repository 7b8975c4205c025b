//! Why a run can't start or go on.

use vb_host::ParamError;
use vb_record::StoreError;
use vb_sim::SimError;
use vb_vehicle::VehicleError;
use vb_world::SuiteError;

/// An error of a run. What planners do wrong is none: it is a task's outcome.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The suite can't be read.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// The run directory can't be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A parameter that the planner doesn't have.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The vehicle can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// The planner wants to be called at a rate that doesn't fit the simulation.
    #[error(
        "planner {planner} wants a control period of {period} s, which is no multiple of the simulation's step of {step} s"
    )]
    ControlPeriod {
        /// Name of the planner.
        planner: String,
        /// s.
        period: f64,
        /// s.
        step: f64,
    },
    /// The system gives no thread.
    #[error("can't start a worker thread: {0} (use fewer with --jobs)")]
    Thread(std::io::Error),
    /// A run that is resumed has a task that is none of those chosen.
    #[error(
        "cannot resume {}: tasks.jsonl has {task}, which is none of the run's tasks (delete its line, or start a new run with \
         another --out)",
        .dir.display()
    )]
    ForeignTask {
        /// The run directory.
        dir: std::path::PathBuf,
        /// The task.
        task: String,
    },
    /// Nothing to do.
    #[error("no task is chosen")]
    NoTasks,
    /// A factor that no world can have.
    #[error("a scale of {0} is not a positive number")]
    Scale(f64),
}
