//! The reasons why a run can't start or go on.

use vb_host::ParamError;
use vb_record::StoreError;
use vb_trial::TrialError;
use vb_world::{SuiteError, TaskId};

/// An error of a run. What planners do wrong is not such an error but a task's outcome.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The suite can't be read.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// The run directory can't be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The planner doesn't have a parameter.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// Vehicle, scale or perception profile can't be used.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// The planner wants to be called at a rate that doesn't fit the simulation.
    #[error(
        "the control period of planner {planner}, {period} s, is not a multiple of the simulation step of {step} s"
    )]
    ControlPeriod {
        /// The name of the planner.
        planner: String,
        /// The control period that the planner wants, s.
        period: f64,
        /// The time step of the simulation, s.
        step: f64,
    },
    /// The system can't start a thread.
    #[error("can't start a worker thread: {0} (use fewer with --jobs)")]
    Thread(std::io::Error),
    /// A run that is resumed has a task that is none of those chosen.
    #[error(
        "cannot resume {}: tasks.jsonl has {task}, which is not a task of the run (delete its line, or start a new run with \
         another --out)",
        .dir.display()
    )]
    ForeignTask {
        /// The run directory.
        dir: std::path::PathBuf,
        /// The name of the task.
        task: TaskId,
    },
    /// A recording is to drive under other settings than those under which it was made.
    #[error(
        "the recording does not match this run: {field} is {found}, in the recording {recorded} (use the settings of the recorded run)"
    )]
    Recorded {
        /// The field of run.json.
        field: &'static str,
        /// Its value in the recording, as JSON.
        recorded: String,
        /// Its value in the run, as JSON.
        found: String,
    },
    /// There are no tasks to run.
    #[error("no task is selected")]
    NoTasks,
}
