//! Writing a dataset, file by file, so that nothing is lost or doubled if the program is killed.

use std::fs;
use std::path::{Path, PathBuf};

use vb_files::{Hash, sha256};
use vb_world::Suite;

use crate::card::card;
use crate::episode::{Episode, EpisodeInfo};
use crate::error::DatasetError;
use crate::feature::Feature;
use crate::header::Header;
use crate::lerobot::{
    Batch, Place, Row, Stats, Totals, data_path, episodes_path, info, pooled, read_episodes, write_data,
    write_episodes, write_tasks,
};
use crate::reader::{HEADER, SUMS, WORLDS, read_header};

/// The bytes of frames in a data file, at most and before compression, unless one episode has more.
const FILE_BYTES: usize = 48 << 20;
/// The episodes of a data file, at most.
const FILE_EPISODES: usize = 256;

/// A dataset while it is written.
///
/// Episodes are gathered until a data file is full. First the data file is written, whole and synced, then the file that tells
/// of its episodes: an episode is in the dataset once it is in the latter. `SHA256SUMS` comes last.
pub struct DatasetWriter {
    dir: PathBuf,
    header: Header,
    features: Vec<Feature>,
    /// Episodes of a data file.
    per_file: usize,
    /// The number of the data file that is gathered.
    file: usize,
    batch: Batch,
    rows: Vec<Row>,
    /// The first frame that is in no file.
    from: usize,
    done: Done,
}

/// What is on disk.
#[derive(Default)]
struct Done {
    episodes: usize,
    frames: usize,
    tasks: Vec<String>,
    stats: Vec<(String, Stats)>,
    summary: Summary,
    /// The next drive of the command.
    next_drive: u64,
}

/// What the card says of the episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// The number of episodes by their outcome.
    pub outcomes: std::collections::BTreeMap<String, usize>,
    /// The length of all ways, m.
    pub distance_m: f64,
}

impl Done {
    fn add(&mut self, row: &Row) {
        self.episodes += 1;
        self.frames = row.place.to;
        self.next_drive = row.info.drive + 1;
        if !self.tasks.contains(&row.info.instruction) {
            self.tasks.push(row.info.instruction.clone());
        }
        *self.summary.outcomes.entry(row.info.outcome.clone()).or_default() += 1;
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

impl DatasetWriter {
    /// Begins a dataset in a folder that must not exist or be empty, with a copy of the suite that its worlds are of. `frames` is
    /// the most that an episode may have.
    ///
    /// # Errors
    /// Returns an error if the folder holds something or can't be written.
    pub fn create(dir: &Path, header: Header, worlds: &Suite, frames: usize) -> Result<Self, DatasetError> {
        if fs::read_dir(dir).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(DatasetError::NotEmpty { dir: dir.to_owned() });
        }
        fs::create_dir_all(dir).map_err(DatasetError::io("create", dir))?;
        copy_suite(worlds, &dir.join(WORLDS))?;
        let writer = Self::new(dir, header, frames);
        // Last: where it is, the worlds are whole.
        writer.write(Path::new(HEADER), &json(&writer.header)?)?;
        Ok(writer)
    }

    /// Goes on with a dataset that was begun in a folder; begins it if nothing was.
    ///
    /// # Errors
    /// Returns an error if it was begun with other settings, or can't be read or written.
    pub fn resume(dir: &Path, header: Header, worlds: &Suite, frames: usize) -> Result<Self, DatasetError> {
        if !dir.join(HEADER).is_file() {
            // Killed while the worlds were copied; nothing else is there.
            let begun = dir.join(WORLDS);
            if begun.is_dir() {
                fs::remove_dir_all(&begun).map_err(DatasetError::io("remove", &begun))?;
            }
            return Self::create(dir, header, worlds, frames);
        }
        let before = read_header(dir)?;
        if let Some((field, before, now)) = before.difference(&header) {
            return Err(DatasetError::Other { dir: dir.to_owned(), field, before, now });
        }
        let mut writer = Self::new(dir, header, frames);
        loop {
            let path = dir.join(episodes_path(writer.file));
            if !path.is_file() {
                break;
            }
            for row in read_episodes(&path)? {
                writer.done.add(&row);
            }
            writer.file += 1;
        }
        writer.from = writer.done.frames;
        Ok(writer)
    }

    fn new(dir: &Path, header: Header, frames: usize) -> Self {
        let features = header.layout.features();
        let episode_bytes = header.layout.frame_bytes() * frames.max(1);
        let per_file = (FILE_BYTES / episode_bytes).clamp(1, FILE_EPISODES);
        let batch = Batch::new(&features);
        let (rows, done) = (Vec::new(), Done::default());
        Self { dir: dir.to_owned(), header, features, per_file, file: 0, batch, rows, from: 0, done }
    }

    /// The columns of each frame.
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// The number of episodes until now.
    #[must_use]
    pub fn episodes(&self) -> usize {
        self.done.episodes + self.rows.len()
    }

    /// The drive of the command that is next: the one after the last whose episode is on disk.
    #[must_use]
    pub fn next_drive(&self) -> u64 {
        self.done.next_drive
    }

    /// The number of frames until now.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.from + self.batch.len()
    }

    /// Adds an episode. One without frames is left out.
    ///
    /// # Errors
    /// Returns an error if a file can't be written.
    pub fn add(&mut self, episode: &Episode) -> Result<(), DatasetError> {
        if episode.frames == 0 {
            return Ok(());
        }
        let (index, from) = (self.episodes(), self.frames());
        let task = self.task(&episode.info);
        for (to, own) in self.batch.columns.iter_mut().zip(&episode.columns) {
            to.append(own, 0..own.len());
        }
        let whole = |v: usize| i64::try_from(v).unwrap_or(i64::MAX);
        for k in 0..episode.frames {
            self.batch.timestamp.push((k as f64 / f64::from(self.header.hz)) as f32);
            self.batch.frame_index.push(whole(k));
            self.batch.episode_index.push(whole(index));
            self.batch.index.push(whole(from + k));
            self.batch.task_index.push(whole(task));
        }
        let stats = self.features.iter().zip(&episode.columns);
        let stats = stats.map(|(f, values)| (f.name.to_owned(), Stats::of(f, values))).collect();
        let place = Place { file: self.file, from, to: from + episode.frames };
        self.rows.push(Row { index, place, info: episode.info.clone(), stats });
        if self.rows.len() == self.per_file {
            self.flush()?;
        }
        Ok(())
    }

    /// The index of an episode's task in words.
    fn task(&self, info: &EpisodeInfo) -> usize {
        let mut known: Vec<&str> = self.done.tasks.iter().map(String::as_str).collect();
        for row in &self.rows {
            if !known.contains(&row.info.instruction.as_str()) {
                known.push(&row.info.instruction);
            }
        }
        known.iter().position(|t| *t == info.instruction).unwrap_or(known.len())
    }

    fn flush(&mut self) -> Result<(), DatasetError> {
        if self.rows.is_empty() {
            return Ok(());
        }
        self.write(&data_path(self.file), &write_data(&self.features, &self.batch)?)?;
        self.write(&episodes_path(self.file), &write_episodes(&self.rows)?)?;
        for row in std::mem::take(&mut self.rows) {
            self.done.add(&row);
        }
        self.from = self.done.frames;
        self.batch = Batch::new(&self.features);
        self.file += 1;
        Ok(())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
        let path = self.dir.join(path);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(DatasetError::io("create", parent))?;
        }
        vb_files::write(&path, bytes).map_err(DatasetError::io("write", &path))
    }

    /// Writes what is left, what tells of the whole, and the hashes of all files; the hash of the dataset.
    ///
    /// # Errors
    /// Returns an error if there is no episode, or a file can't be written.
    pub fn finish(mut self) -> Result<Finished, DatasetError> {
        self.save()
    }

    /// Makes a whole dataset of what there is, to which more can be added: the episodes of people come one by one, and each is
    /// to be safe.
    ///
    /// # Errors
    /// As [`DatasetWriter::finish`].
    pub fn save(&mut self) -> Result<Finished, DatasetError> {
        self.flush()?;
        let Done { episodes, frames, .. } = self.done;
        if episodes == 0 {
            return Err(DatasetError::Empty("none had a frame that is to be kept".into()));
        }
        let totals = Totals { episodes, frames, tasks: self.done.tasks.len() };
        let robot = &self.header.vehicle.name;
        self.write(
            Path::new("meta/info.json"),
            &json(&info(robot, self.header.hz, &self.features, totals))?,
        )?;
        let stats: serde_json::Map<_, _> = self
            .done
            .stats
            .iter()
            .filter_map(|(name, s)| Some((name.clone(), serde_json::to_value(s).ok()?)))
            .collect();
        self.write(Path::new("meta/stats.json"), &json(&stats)?)?;
        self.write(Path::new("meta/tasks.parquet"), &write_tasks(&self.done.tasks)?)?;
        let text = card(&self.header, &self.features, (episodes, frames), &self.done.summary);
        self.write(Path::new("README.md"), text.as_bytes())?;
        let sums = sums(&self.dir)?;
        self.write(Path::new(SUMS), sums.as_bytes())?;
        let summary = self.done.summary.clone();
        Ok(Finished { episodes, frames, hash: sha256(sums.as_bytes()), summary })
    }
}

/// A finished dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// The number of episodes.
    pub episodes: usize,
    /// The number of frames.
    pub frames: usize,
    /// The hash of the dataset: the SHA-256 of its `SHA256SUMS`.
    pub hash: String,
    /// What its card says of the episodes.
    pub summary: Summary,
}

fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, DatasetError> {
    let text = serde_json::to_string_pretty(value);
    let text = text.map_err(|e| DatasetError::Encode { detail: e.to_string() })?;
    Ok((text + "\n").into_bytes())
}

/// The files of a folder and those below it, sorted by name, but for the sums themselves and what an interrupted write left.
pub(crate) fn files(dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(at) = open.pop() {
        let folder = dir.join(&at);
        for entry in fs::read_dir(&folder).map_err(DatasetError::io("read", &folder))? {
            let entry = entry.map_err(DatasetError::io("read", &folder))?;
            let path = at.join(entry.file_name());
            if entry.path().is_dir() {
                open.push(path);
            } else if !entry.file_name().to_string_lossy().starts_with('.') && path != Path::new(SUMS) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The SHA-256 of a file, which is read piece by piece.
pub(crate) fn hash_file(path: &Path) -> Result<String, DatasetError> {
    use std::io::Read as _;
    let mut file = vb_files::open(path).map_err(DatasetError::io("read", path))?;
    let (mut hash, mut piece) = (Hash::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut piece).map_err(DatasetError::io("read", path))? {
            0 => return Ok(hash.hex()),
            n => hash.update(&piece[..n]),
        }
    }
}

/// What `sha256sum` would print of all files.
fn sums(dir: &Path) -> Result<String, DatasetError> {
    let mut text = String::new();
    for path in files(dir)? {
        let name = path.to_string_lossy().replace('\\', "/");
        text += &format!("{}  {name}\n", hash_file(&dir.join(&path))?);
    }
    Ok(text)
}

/// Copies a suite's files.
fn copy_suite(suite: &Suite, to: &Path) -> Result<(), DatasetError> {
    for path in files(suite.dir())? {
        let (from, to) = (suite.dir().join(&path), to.join(&path));
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(DatasetError::io("create", parent))?;
        }
        fs::copy(&from, &to).map_err(DatasetError::io("write", &to))?;
    }
    Ok(())
}
