//! Trains the models of the hybrid planners: what a bicycle on the plane through its wheels gets wrong about motion over rough
//! ground, learned from datasets of exploration. The networks are those that `hybrid` and `vb_sdk::nn` evaluate in planners.

pub mod data;
pub mod measure;
pub mod model;
pub mod network;
mod repeatable;
pub mod sight;
pub mod train;

use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    #[error(transparent)]
    Dataset(#[from] vb_dataset::DatasetError),
    #[error("{}: {why}", dir.display())]
    Unfit { dir: PathBuf, why: String },
    /// The vehicle can't be used.
    #[error("{0}")]
    Vehicle(String),
    /// Weights can't be used.
    #[error("{0}")]
    Weights(String),
    /// A file can't be written.
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("internal error: {0}")]
    Tensor(#[from] candle_core::Error),
}
