//! Reading a dataset.

use std::path::{Path, PathBuf};

use vb_world::Suite;

use crate::episode::{Episode, EpisodeInfo};
use crate::error::DatasetError;
use crate::feature::{Feature, Values};
use crate::format::{Batch, Files, Row};
use crate::formats::Format;
use crate::header::{DATASET_SCHEMA, Header};
use crate::sums::{Flaw, SUMS, Sums, hash_file, must_be_whole};
use crate::values;

/// The file that says what a dataset follows from.
pub(crate) const HEADER: &str = "dataset.json";
/// The folder of the suite that the worlds are of.
pub(crate) const WORLDS: &str = "suite";

/// Reads `dataset.json`.
pub(crate) fn read_header(dir: &Path) -> Result<Header, DatasetError> {
    let path = dir.join(HEADER);
    if !path.is_file() {
        let dir = dir.to_owned();
        return Err(if Format::ALL.iter().any(|format| format.files().are_in(&dir)) {
            DatasetError::Foreign { dir }
        } else {
            DatasetError::Missing { dir }
        });
    }
    let text = vb_files::read_text(&path, vb_files::DOCUMENT).map_err(DatasetError::io("read", &path))?;
    let damaged = |e: serde_json::Error| DatasetError::damaged(&path, &e.to_string());
    let value: serde_json::Value = serde_json::from_str(&text).map_err(damaged)?;
    let found = value.get("schema").and_then(serde_json::Value::as_u64).unwrap_or(0);
    if found > u64::from(DATASET_SCHEMA) {
        return Err(DatasetError::Schema { path, found, supported: DATASET_SCHEMA });
    }
    let header: Header = serde_json::from_value(value).map_err(damaged)?;
    header.flaw().map_or(Ok(header), |flaw| Err(DatasetError::damaged(&path, &flaw)))
}

/// Reads `dataset.json` of a dataset that must be finished.
pub(crate) fn finished_header(dir: &Path) -> Result<Header, DatasetError> {
    let header = read_header(dir)?;
    if dir.join(SUMS).is_file() { Ok(header) } else { Err(DatasetError::Unfinished { dir: dir.to_owned() }) }
}

/// A finished dataset in a folder.
pub struct Dataset {
    dir: PathBuf,
    header: Header,
    features: Vec<Feature>,
    rows: Vec<Row>,
}

impl Dataset {
    /// Opens the dataset in a folder.
    ///
    /// # Errors
    /// Returns an error if there is none, it isn't finished, or what tells of its episodes can't be read.
    pub fn open(dir: &Path) -> Result<Self, DatasetError> {
        let header = finished_header(dir)?;
        let format = header.format.files();
        let sums = Sums::read(dir, SUMS)?;
        let mut rows = Vec::new();
        for number in 0.. {
            let file = format.episodes_path(number);
            let path = dir.join(&file);
            if !path.is_file() {
                // Files are numbered without gaps: one that is lost must not look like the end.
                if sums.has(&file) {
                    return Err(Flaw::missing(file).of(dir));
                }
                break;
            }
            for row in format.read_episodes(&path)? {
                let first = rows.last().map_or(0, |last: &Row| last.place.to);
                if let Some(flaw) = row.flaw(rows.len(), first, number) {
                    return Err(DatasetError::damaged(&path, &flaw));
                }
                rows.push(row);
            }
        }
        let features = header.layout.features();
        Ok(Self { dir: dir.to_owned(), header, features, rows })
    }

    /// The same after each file was held against its hash, for what makes another dataset of it: damage must not get new hashes,
    /// by which it would look as it should.
    ///
    /// # Errors
    /// Returns [`DatasetError::Changed`] for the first file that is not as it was written, missing or not of the dataset, and the
    /// errors of [`Dataset::open`].
    pub fn open_whole(dir: &Path) -> Result<Self, DatasetError> {
        finished_header(dir)?;
        must_be_whole(dir)?;
        Self::open(dir)
    }

    /// Refuses to write within the dataset: what isn't of it makes it another.
    ///
    /// # Errors
    /// Returns [`DatasetError::Within`].
    pub fn must_not_hold(&self, out: &Path) -> Result<(), DatasetError> {
        let real = |path: &Path| std::fs::canonicalize(path).map_err(DatasetError::io("read", path));
        let absolute = std::path::absolute(out).map_err(DatasetError::io("find", out))?;
        // A folder that isn't there yet will be in the nearest that is.
        let there = absolute.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("/"));
        if real(there)?.starts_with(real(&self.dir)?) {
            return Err(DatasetError::Within { out: out.to_owned(), dir: self.dir.clone() });
        }
        Ok(())
    }

    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The files of its format.
    pub(crate) fn format(&self) -> &'static dyn Files {
        self.header.format.files()
    }

    /// The columns of each frame.
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// What is said of each episode, with the number of its frames, in order.
    pub fn infos(&self) -> impl ExactSizeIterator<Item = (&EpisodeInfo, usize)> {
        self.rows.iter().map(|r| (&r.info, r.place.to - r.place.from))
    }

    /// What is known of each episode.
    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The hash of the dataset: the SHA-256 of its `SHA256SUMS`.
    pub fn hash(&self) -> Result<String, DatasetError> {
        let path = self.dir.join(SUMS);
        hash_file(&path).map_err(DatasetError::io("read", &path))
    }

    /// The hash of the frames alone, which is the same whatever version of the harness made them: the SHA-256 of the lines of
    /// `SHA256SUMS` that are of data files.
    pub fn frames_hash(&self) -> Result<String, DatasetError> {
        let path = self.dir.join(SUMS);
        let text = vb_files::read_text(&path, vb_files::DOCUMENT).map_err(DatasetError::io("read", &path))?;
        let lines: String =
            text.lines().filter(|l| l.contains("  data/")).map(|l| format!("{l}\n")).collect();
        Ok(vb_files::sha256(lines.as_bytes()))
    }

    #[must_use]
    pub fn frames(&self) -> usize {
        self.rows.last().map_or(0, |r| r.place.to)
    }

    /// The suite with the worlds.
    pub fn worlds(&self) -> Result<Suite, DatasetError> {
        Ok(Suite::open(self.dir.join(WORLDS))?)
    }

    /// The episodes in order, one data file in memory at a time. After an error nothing comes any more.
    pub fn episodes(&self) -> impl Iterator<Item = Result<Episode, DatasetError>> + '_ {
        self.select(0..self.rows.len())
    }

    /// Some of the episodes, by their numbers in ascending order, one data file in memory at a time. After an error, or a
    /// number that no episode has, nothing comes any more.
    pub fn select<'a>(
        &'a self,
        numbers: impl IntoIterator<Item = usize> + 'a,
    ) -> impl Iterator<Item = Result<Episode, DatasetError>> + 'a {
        let mut open: Option<(usize, Batch, usize)> = None;
        let mut failed = false;
        numbers.into_iter().map_while(move |number| {
            if failed {
                return None;
            }
            let episode = self.episode(self.rows.get(number)?, &mut open);
            failed = episode.is_err();
            Some(episode)
        })
    }

    fn episode(&self, row: &Row, open: &mut Option<(usize, Batch, usize)>) -> Result<Episode, DatasetError> {
        let path = self.dir.join(self.format().data_path(row.place.file));
        let (batch, first) = match open {
            Some((file, batch, first)) if *file == row.place.file => (batch, *first),
            _ => {
                let batch = self.format().read_data(&path, &self.features)?;
                // Those before it in the file come first, whether they are asked for or not.
                let first = self.rows.partition_point(|r| r.place.file < row.place.file);
                let (_, batch, first) = open.insert((row.place.file, batch, self.rows[first].place.from));
                (batch, *first)
            }
        };
        let (from, to) = (row.place.from.wrapping_sub(first), row.place.to.wrapping_sub(first));
        if from > to || to > batch.len() {
            let detail = format!("it has no frames {} to {}", row.place.from, row.place.to);
            return Err(DatasetError::damaged(&path, &detail));
        }
        if let Some(flaw) = values::flaw(&self.features, &batch.columns, from..to) {
            let detail = format!("episode {}: {flaw}", row.index);
            return Err(DatasetError::damaged(&path, &detail));
        }
        let columns = self.features.iter().zip(&batch.columns);
        let columns = columns.map(|(f, all)| {
            let mut own = Values::new(f.dtype);
            own.append(all, from * f.width()..to * f.width());
            own
        });
        Ok(Episode { info: row.info.clone(), frames: to - from, columns: columns.collect() })
    }
}
