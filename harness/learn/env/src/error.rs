//! The reasons why an environment can't be made or go on.

use std::panic::{AssertUnwindSafe, catch_unwind};

use vb_catalog::CatalogError;
use vb_files::{DocumentError, panic_text};
use vb_sdk::PlannerError;
use vb_sim::SimError;
use vb_trial::TrialError;
use vb_world::{SelectorError, SuiteError, TaskId, TaskIdError};

/// An error of an environment. Each message is one line with what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// Something that was named can't be had.
    #[error(transparent)]
    Catalog(#[from] CatalogError),
    /// The suite can't be read.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// The tasks that were asked for aren't there.
    #[error(transparent)]
    Tasks(#[from] SelectorError),
    /// Rules, reward or curriculum can't be used.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Vehicle, perception or scale don't fit.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// The vehicle can't be put at the start of a task.
    #[error("{task}: {source}")]
    Start {
        /// The name of the task.
        task: TaskId,
        /// What went wrong.
        source: SimError,
    },
    /// The observation can't be made.
    #[error("observation: {0}")]
    Observation(PlannerError),
    /// An option has a value that makes no sense.
    #[error("{option}: {value}: {problem}")]
    Option {
        /// The name of the option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A world of training belongs to a suite that judges planners.
    #[error(
        "{world} of the training worlds is world {of} of the evaluation suite {suite}: use another world_seed"
    )]
    SuiteWorld {
        /// The training world.
        world: String,
        /// The suite.
        suite: String,
        /// The world of the suite.
        of: String,
    },
    /// A text is not the name of a task.
    #[error(transparent)]
    TaskId(#[from] TaskIdError),
    /// There is no such task among those of the environment.
    #[error("there is no task {task} among the {count} tasks of this environment (the first are {first})")]
    NoTask {
        /// The name that was given.
        task: TaskId,
        /// How many there are.
        count: usize,
        /// The names of the first.
        first: String,
    },
    /// The numbers of an action are too many or too few.
    #[error("an action has {wanted} numbers ({names}), not {given}")]
    ActionLength {
        /// How many there are in an action.
        wanted: usize,
        /// What they are called.
        names: String,
        /// How many were given.
        given: usize,
    },
    /// An action is no number.
    #[error("action[{index}] ({name}) is {value}: give a finite number")]
    Action {
        /// The index of the number.
        index: usize,
        /// The name of the number.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// An environment is named twice in one call.
    #[error("environment {0} is given twice")]
    Twice(usize),
    /// A state is that of an environment that was made with other options.
    #[error(
        "the state is from an environment with other options: restore it in an environment with equal options"
    )]
    Unlike,
    /// Bytes that should be a state are none.
    #[error("the state can't be read: {0}; use a state pickled with this version of the package")]
    State(String),
    /// The drive that led to a state ends elsewhere now.
    #[error("the replay of {task} does not reproduce the state: the suite has changed")]
    Elsewhere {
        /// The name of the task.
        task: TaskId,
    },
    /// The environment has no episode.
    #[error("no episode is active: call reset first")]
    NoEpisode,
    /// The episode has ended.
    #[error("the episode has ended ({0}): call reset")]
    Ended(String),
    /// Steps and resets are under way.
    #[error("{0} environments are still stepping: call recv first")]
    Pending(usize),
    /// There is nothing to be received.
    #[error("no environment is stepping: call send or reset first")]
    Nothing,
    /// There is no such environment.
    #[error("there is no environment {index}: there are {count}")]
    NoEnv {
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A picture can't be taken.
    #[error(transparent)]
    Picture(#[from] vb_render::RenderError),
    /// The harness failed.
    #[error("the harness panicked: {0}; please report it (close the environment and create a new one)")]
    Panic(String),
    /// The system can't start a thread.
    #[error("can't start a worker thread: {0} (use fewer workers)")]
    Thread(std::io::Error),
}

impl EnvError {
    /// Whether the simulation failed at the start of a task.
    #[must_use]
    pub fn is_divergence(&self) -> bool {
        matches!(self, Self::Start { source: SimError::Diverged { .. }, .. })
    }
}

/// Does some work; a panic, which is a fault of the harness, becomes an error, so that who called goes on.
///
/// # Errors
/// Returns the error of the work, or [`EnvError::Panic`].
pub fn guarded<T>(work: impl FnOnce() -> Result<T, EnvError>) -> Result<T, EnvError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(EnvError::Panic(panic_text(&*panic))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_with_its_text() {
        let told = guarded::<()>(|| panic!("wheel {} is gone", 3)).unwrap_err().to_string();
        assert!(told.starts_with("the harness panicked: wheel 3 is gone; please report it"), "{told}");
        assert_eq!(guarded(|| Ok(7)).unwrap(), 7);
    }
}
