//! The reasons why something is not found, or can't be used.

use std::path::PathBuf;

use vb_files::DocumentError;
use vb_suite::generate::{GenerateError, TRAINING_SEEDS};
use vb_world::SuiteError;

/// The reason why something that was named can't be had. Each message is one line with what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum CatalogError {
    #[error(
        "the built-in tasks were not found (run in a checkout of the project, or set {} to its tasks directory)",
        crate::TASKS_VAR
    )]
    NoTasks,
    #[error(
        "{}: this directory contains no {noun} (set {} to the tasks directory of a checkout, or unset it)",
        .tasks.display(),
        crate::TASKS_VAR
    )]
    Nothing { noun: &'static str, tasks: PathBuf },
    #[error(
        "no folder for the unpacked built-in tasks is defined (set {}, or HOME, or {} to a tasks directory)",
        crate::DATA_VAR,
        crate::TASKS_VAR
    )]
    NoDataFolder,
    #[error(
        "{}: cannot unpack the built-in tasks: {source} (set {} to a writable directory)",
        .path.display(),
        crate::DATA_VAR
    )]
    Unpack { path: PathBuf, source: std::io::Error },
    #[error("there is no {noun} {name} (give {instead}, or one of: {known})")]
    Unknown { noun: &'static str, name: String, instead: &'static str, known: String },
    #[error("{}: {source}", .path.display())]
    List { path: PathBuf, source: std::io::Error },
    #[error("cannot read {noun} {}: {source} (give a file, or a name)", .path.display())]
    Read { noun: &'static str, path: PathBuf, source: std::io::Error },
    /// A suite can't be used.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// A vehicle, a soil set or a perception profile can't be used.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// The terrain model can't be used.
    #[error("elevation.model: {0}")]
    Terrain(String),
    #[error(
        "--seed {0}: the seeds {first} to {last} are reserved for training worlds (use another seed, or --training)",
        first = TRAINING_SEEDS.start(),
        last = TRAINING_SEEDS.end()
    )]
    KeptForTraining(u64),
    #[error(
        "seed {0}: training worlds need a seed from {first} to {last}, which no suite uses",
        first = TRAINING_SEEDS.start(),
        last = TRAINING_SEEDS.end()
    )]
    NoTrainingSeed(u64),
    #[error(transparent)]
    Generate(#[from] GenerateError),
    #[error("{}: {source}", .path.display())]
    Write { path: PathBuf, source: std::io::Error },
}
