//! Formats of datasets: what is in memory of the files of any format, and what a format has to do.

use std::path::{Path, PathBuf};

use crate::episode::EpisodeInfo;
use crate::error::DatasetError;
use crate::feature::{Feature, Values};
use crate::header::Header;
use crate::stats::{Stats, pooled};

/// The files of a format. Paths are relative to the folder of the dataset, which holds `dataset.json`, the worlds and the hashes in
/// every format.
pub(crate) trait Files: Sync {
    /// The path of the data file with this number, which is below `data`.
    fn data_path(&self, number: usize) -> PathBuf;

    /// The path of the file that describes the episodes in the data file with this number.
    fn episodes_path(&self, number: usize) -> PathBuf;

    /// The content of a data file.
    ///
    /// # Errors
    /// Returns an error if the frames can't be encoded.
    fn write_data(&self, features: &[Feature], batch: &Batch) -> Result<Vec<u8>, DatasetError>;

    /// Reads a data file with these features. Its bytes may be of strangers.
    ///
    /// # Errors
    /// Returns an error if it can't be read, is too large, or its columns are not those of the features.
    fn read_data(&self, path: &Path, features: &[Feature]) -> Result<Batch, DatasetError>;

    /// The content of a file that describes episodes, which all lie in the same data file.
    ///
    /// # Errors
    /// Returns an error if the rows can't be encoded.
    fn write_episodes(&self, rows: &[Row]) -> Result<Vec<u8>, DatasetError>;

    /// Reads a file that describes episodes. Its bytes may be of strangers.
    ///
    /// # Errors
    /// Returns an error if it can't be read, is too large, or lacks a column.
    fn read_episodes(&self, path: &Path) -> Result<Vec<Row>, DatasetError>;

    /// The paths of the files that describe the whole, which are written again when it grows.
    fn whole_paths(&self) -> &'static [&'static str];

    /// The contents of these files, in their order.
    ///
    /// # Errors
    /// Returns an error if one can't be encoded.
    fn write_whole(
        &self,
        header: &Header,
        features: &[Feature],
        whole: &Whole,
    ) -> Result<Vec<Vec<u8>>, DatasetError>;

    /// The errors of the totals in these files for a dataset of so many episodes and frames.
    fn total_flaws(&self, dir: &Path, episodes: usize, frames: usize) -> Vec<String>;

    /// Whether a folder has a dataset in this format, of whatever program.
    fn are_in(&self, dir: &Path) -> bool;
}

/// The frames of one file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Batch {
    /// The values of each feature.
    pub(crate) columns: Vec<Values>,
    /// The time since the start of the episode, s.
    pub(crate) timestamp: Vec<f32>,
    pub(crate) frame_index: Vec<i64>,
    pub(crate) episode_index: Vec<i64>,
    pub(crate) index: Vec<i64>,
    pub(crate) task_index: Vec<i64>,
}

impl Batch {
    pub(crate) fn new(features: &[Feature]) -> Self {
        let columns = features.iter().map(|f| Values::new(f.dtype)).collect();
        Self { columns, ..Self::default() }
    }

    pub(crate) fn len(&self) -> usize {
        self.index.len()
    }
}

/// Where an episode's frames are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// The number of the data file.
    pub(crate) file: usize,
    /// The index of the first frame in the dataset.
    pub(crate) from: usize,
    /// The index after the last.
    pub(crate) to: usize,
}

/// What is known of an episode.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) index: usize,
    pub(crate) place: Place,
    pub(crate) info: EpisodeInfo,
    /// The statistics of each feature, by name; none when read.
    pub(crate) stats: Vec<(String, Stats)>,
}

impl Row {
    /// The first error of the row of episode `number`, whose frames must begin at `first` and lie in data file `file`.
    pub(crate) fn flaw(&self, number: usize, first: usize, file: usize) -> Option<String> {
        let Place { from, to, .. } = self.place;
        if self.index != number || from != first || to <= from {
            let index = self.index;
            return Some(format!(
                "episode {number}: its index is {index} with frames {from} to {to}, after {first}"
            ));
        }
        if self.place.file != file {
            let (is, should) = (self.place.file, file);
            return Some(format!("episode {number}: its data file is {is}, not {should}"));
        }
        Some(format!("episode {number}: {}", self.info.flaw()?))
    }
}

/// The episodes on disk as a whole.
#[derive(Default)]
pub(crate) struct Whole {
    pub(crate) episodes: usize,
    pub(crate) frames: usize,
    /// The tasks in words, in the order of their indices.
    pub(crate) tasks: Vec<String>,
    /// The statistics of each feature, by name.
    pub(crate) stats: Vec<(String, Stats)>,
    pub(crate) summary: Summary,
    /// The next drive of the command.
    pub(crate) next_drive: u64,
}

/// Outcomes and distance of the episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// The number of episodes by their outcome.
    pub outcomes: std::collections::BTreeMap<String, usize>,
    /// The length of all ways, m.
    pub distance_m: f64,
}

impl Whole {
    pub(crate) fn add(&mut self, row: &Row) {
        self.episodes += 1;
        self.frames = row.place.to;
        self.next_drive = row.info.drive + 1;
        if !self.tasks.contains(&row.info.instruction) {
            self.tasks.push(row.info.instruction.clone());
        }
        *self.summary.outcomes.entry(row.info.outcome.name().to_owned()).or_default() += 1;
        self.summary.distance_m += row.info.distance_m;
        if self.stats.is_empty() {
            self.stats.clone_from(&row.stats);
            return;
        }
        for (name, all) in &mut self.stats {
            if let Some((_, own)) = row.stats.iter().find(|(n, _)| n == name) {
                *all = pooled([&*all, own].into_iter());
            }
        }
    }
}

/// A value as indented JSON with a line break at the end.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, DatasetError> {
    let text = serde_json::to_string_pretty(value);
    let text = text.map_err(|e| DatasetError::Encode { detail: e.to_string() })?;
    Ok((text + "\n").into_bytes())
}
