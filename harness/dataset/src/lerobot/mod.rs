//! The layout of LeRobot's datasets, version 3.0: where the files are, and what is in them.
//!
//! Facts: the documentation "LeRobotDataset v3.0" of huggingface/lerobot, and its `src/lerobot/datasets`.

mod data;
mod episodes;
mod info;
mod stats;
mod tasks;

pub(crate) use data::{Batch, read_data, write_data};
pub(crate) use episodes::{Place, Row, read_episodes, write_episodes};
pub(crate) use info::{Totals, info};
pub(crate) use stats::{Stats, pooled};
pub(crate) use tasks::write_tasks;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use vb_record::ParquetBounds;

use crate::error::DatasetError;

/// The version of the layout.
pub const CODEBASE_VERSION: &str = "v3.0";
/// The number of files in a folder.
pub(crate) const CHUNK: usize = 1000;

/// The content of a Parquet file that is within bounds.
fn open(path: &Path, bounds: &ParquetBounds) -> Result<Bytes, DatasetError> {
    vb_record::read_parquet(path, bounds).map_err(|e| match e.kind() {
        ErrorKind::InvalidData => DatasetError::damaged(path, &e.to_string()),
        _ => DatasetError::io("read", path)(e),
    })
}

/// Chunk and file of the data file with this number.
pub(crate) fn place(number: usize) -> (usize, usize) {
    (number / CHUNK, number % CHUNK)
}

pub(crate) fn data_path(number: usize) -> PathBuf {
    let (chunk, file) = place(number);
    PathBuf::from(format!("data/chunk-{chunk:03}/file-{file:03}.parquet"))
}

/// The path of the file that tells of the episodes in the data file with this number.
pub(crate) fn episodes_path(number: usize) -> PathBuf {
    let (chunk, file) = place(number);
    PathBuf::from(format!("meta/episodes/chunk-{chunk:03}/file-{file:03}.parquet"))
}
