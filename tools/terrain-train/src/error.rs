//! Why a training ends without a model.

use std::path::{Path, PathBuf};

use thiserror::Error;
use vb_terrain::data::DataError;

#[derive(Debug, Error)]
pub enum TrainError {
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("{0}: give more or larger elevation data")]
    TooLittle(String),
    #[error("{}: {problem}", path.display())]
    Checkpoint { path: PathBuf, problem: String },
    #[error("{}: can't be written: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    /// A fault of this program or of the library it computes with.
    #[error("training failed: {0}")]
    Internal(String),
}

impl From<candle_core::Error> for TrainError {
    fn from(e: candle_core::Error) -> Self {
        Self::Internal(vb_files::one_line(&e.to_string()))
    }
}

/// Writes a file as a whole or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), TrainError> {
    vb_files::write(path, bytes).map_err(|source| TrainError::Write { path: path.to_owned(), source })
}
