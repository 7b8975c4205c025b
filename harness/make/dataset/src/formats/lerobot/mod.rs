//! The layout of LeRobot's datasets, version 3.0: where the files are, and what is in them.
//!
//! Facts: the documentation "LeRobotDataset v3.0" of huggingface/lerobot, and its `src/lerobot/datasets`.

mod card;
mod data;
mod episodes;
mod info;
mod tasks;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use vb_record::ParquetBounds;

use crate::error::DatasetError;
use crate::feature::{Dtype, Feature};
use crate::format::json;
use crate::format::{Batch, Files, Row, Whole};
use crate::header::Header;

/// The version of the layout.
const CODEBASE_VERSION: &str = "v3.0";
/// The number of files in a folder.
const CHUNK: usize = 1000;

/// The content of a Parquet file that is within bounds.
fn open(path: &Path, bounds: &ParquetBounds) -> Result<Bytes, DatasetError> {
    vb_record::read_parquet(path, bounds).map_err(|e| match e.kind() {
        ErrorKind::InvalidData => DatasetError::damaged(path, &e.to_string()),
        _ => DatasetError::io("read", path)(e),
    })
}

/// Reads a file by a decoder that may panic on a damaged one.
fn decoded<T>(path: &Path, read: impl FnOnce() -> Result<T, DatasetError>) -> Result<T, DatasetError> {
    vb_files::decoding(read).unwrap_or_else(|problem| Err(DatasetError::damaged(path, &problem)))
}

/// Chunk and file of the data file with this number.
fn place(number: usize) -> (usize, usize) {
    (number / CHUNK, number % CHUNK)
}

/// The columns of LeRobot's own, which come last.
const OWN: [(&str, Dtype); 5] = [
    ("timestamp", Dtype::F32),
    ("frame_index", Dtype::I64),
    ("episode_index", Dtype::I64),
    ("index", Dtype::I64),
    ("task_index", Dtype::I64),
];

/// What LeRobot reads first.
const INFO: &str = "meta/info.json";

/// The format of LeRobot.
pub(crate) struct LeRobot;

impl Files for LeRobot {
    fn data_path(&self, number: usize) -> PathBuf {
        let (chunk, file) = place(number);
        PathBuf::from(format!("data/chunk-{chunk:03}/file-{file:03}.parquet"))
    }

    fn episodes_path(&self, number: usize) -> PathBuf {
        let (chunk, file) = place(number);
        PathBuf::from(format!("meta/episodes/chunk-{chunk:03}/file-{file:03}.parquet"))
    }

    fn write_data(&self, features: &[Feature], batch: &Batch) -> Result<Vec<u8>, DatasetError> {
        data::write_data(features, batch)
    }

    fn read_data(&self, path: &Path, features: &[Feature]) -> Result<Batch, DatasetError> {
        decoded(path, || data::read_data(path, features))
    }

    fn write_episodes(&self, rows: &[Row]) -> Result<Vec<u8>, DatasetError> {
        episodes::write_episodes(rows)
    }

    fn read_episodes(&self, path: &Path) -> Result<Vec<Row>, DatasetError> {
        decoded(path, || episodes::read_episodes(path))
    }

    fn whole_paths(&self) -> &'static [&'static str] {
        &[INFO, "meta/stats.json", "meta/tasks.parquet", "README.md"]
    }

    fn write_whole(
        &self,
        header: &Header,
        features: &[Feature],
        whole: &Whole,
    ) -> Result<Vec<Vec<u8>>, DatasetError> {
        let value = |s| serde_json::to_value(s).expect("statistics are lists of numbers");
        let stats: serde_json::Map<_, _> = whole.stats.iter().map(|(n, s)| (n.clone(), value(s))).collect();
        Ok(vec![
            json(&info::info(header, features, whole))?,
            json(&stats)?,
            tasks::write_tasks(&whole.tasks)?,
            card::card(header, features, whole).into_bytes(),
        ])
    }

    fn total_flaws(&self, dir: &Path, episodes: usize, frames: usize) -> Vec<String> {
        let totals = vb_files::read_text(&dir.join(INFO), vb_files::DOCUMENT).ok();
        let totals: Option<serde_json::Value> = totals.and_then(|text| serde_json::from_str(&text).ok());
        let total = |name: &str| totals.as_ref().and_then(|t| t[name].as_u64());
        [("total_frames", frames), ("total_episodes", episodes)]
            .into_iter()
            .filter(|(name, is)| total(name) != Some(*is as u64))
            .map(|(name, is)| format!("{INFO}: {name} is not {is}, the sum over the episodes"))
            .collect()
    }

    fn are_in(&self, dir: &Path) -> bool {
        dir.join(INFO).is_file()
    }
}
