//! The reasons why something is not found, or can't be used.

use std::path::PathBuf;

use vb_sense::SenseError;
use vb_sim::SimError;
use vb_suite::generate::{GenerateError, TRAINING_SEEDS};
use vb_vehicle::VehicleError;
use vb_world::SuiteError;

/// The reason why something that was named can't be had. Each message is one line with what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum CatalogError {
    /// There is no folder with what comes with the harness.
    #[error(
        "the built-in tasks are not found (run in a checkout of the project, or set {} to its tasks directory)",
        crate::TASKS_VAR
    )]
    NoTasks,
    /// The folder has nothing of the kind in it.
    #[error(
        "{}: there is no {noun} in this directory (set {} to the tasks directory of a checkout, or to nothing)",
        .tasks.display(),
        crate::TASKS_VAR
    )]
    Nothing {
        /// What was looked for.
        noun: &'static str,
        /// The folder.
        tasks: PathBuf,
    },
    /// The system names no folder for the user's data.
    #[error(
        "there is no folder to unpack the built-in tasks into (set {}, or HOME, or {} to a tasks directory)",
        crate::DATA_VAR,
        crate::TASKS_VAR
    )]
    NoDataFolder,
    /// The tasks that the program carries within itself can't be put where they can be read.
    #[error(
        "{}: cannot unpack the built-in tasks: {source} (set {} to a directory that you may write to)",
        .path.display(),
        crate::DATA_VAR
    )]
    Unpack {
        /// The folder that they were to have.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// There is nothing of this name.
    #[error("there is no {noun} {name} (give {instead}, or one of: {known})")]
    Unknown {
        /// What was looked for.
        noun: &'static str,
        /// The name that was given.
        name: String,
        /// What may be given instead of a name.
        instead: &'static str,
        /// The names that there are.
        known: String,
    },
    /// A folder can't be listed.
    #[error("{}: {source}", .path.display())]
    List {
        /// The path of the folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A data file can't be read.
    #[error("cannot read {noun} {}: {source} (give a file, or a name)", .path.display())]
    Read {
        /// What it is.
        noun: &'static str,
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A suite can't be used.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// A vehicle can't be used.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// A set of soils can't be used.
    #[error(transparent)]
    Soils(#[from] SimError),
    /// A perception profile can't be used.
    #[error(transparent)]
    Perception(#[from] SenseError),
    /// The terrain model can't be used.
    #[error("elevation.model: {0}")]
    Terrain(String),
    /// A seed that is kept for training worlds.
    #[error(
        "--seed {0}: the seeds {first} to {last} are kept for training worlds, on which planners are tuned (take another seed, or say --training)",
        first = TRAINING_SEEDS.start(),
        last = TRAINING_SEEDS.end()
    )]
    KeptForTraining(u64),
    /// A seed that is not one of training worlds.
    #[error(
        "seed {0}: training worlds have a seed from {first} to {last}, so that no suite has one of them",
        first = TRAINING_SEEDS.start(),
        last = TRAINING_SEEDS.end()
    )]
    NoTrainingSeed(u64),
    /// Training worlds can't be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// Training worlds can't be put away.
    #[error("{}: {source}", .path.display())]
    Write {
        /// The folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
}
