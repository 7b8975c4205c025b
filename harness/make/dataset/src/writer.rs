//! Writing a dataset, file by file, so that nothing is lost or doubled if the program is killed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use vb_files::sha256;
use vb_record::{FolderLock, NewFolder, StoreError};
use vb_world::Suite;

use crate::episode::{Episode, EpisodeInfo};
use crate::error::DatasetError;
use crate::feature::Feature;
use crate::format::{Batch, Files, Place, Row, Summary, Whole, json};
use crate::header::Header;
use crate::reader::{HEADER, WORLDS, read_header};
use crate::stats::Stats;
use crate::sums::{SUMS, SUMS_SO_FAR, Sums, files, hash_file, must_be_whole};

/// The bytes of frames in a data file, at most and before compression, unless one episode has more.
const FILE_BYTES: usize = 48 << 20;
/// The episodes of a data file, at most.
const FILE_EPISODES: usize = 256;

/// A dataset while it is written, by this process alone.
///
/// Episodes are gathered until a data file is full. First the data file is written, whole and synced, then the file that tells
/// of its episodes: an episode is in the dataset once it is in the latter. `SHA256SUMS` comes last.
pub struct DatasetWriter {
    dir: PathBuf,
    lock: FolderLock,
    /// What the folder is the content of, if it is one that is there only when it is whole.
    folder: Option<NewFolder>,
    header: Header,
    /// The files of its format.
    format: &'static dyn Files,
    features: Vec<Feature>,
    /// Episodes of a data file.
    per_file: usize,
    /// The number of the data file that is gathered.
    file: usize,
    batch: Batch,
    rows: Vec<Row>,
    /// The first frame that is in no file.
    from: usize,
    done: Whole,
    /// The hashes, as they were written, of the files that stay as they are: worlds, header, frames and episodes.
    sums: Sums,
}

impl DatasetWriter {
    /// Begins a dataset in a folder that must not exist or be empty, with a copy of the suite that its worlds are of. `frames` is
    /// the most that an episode may have.
    ///
    /// # Errors
    /// Returns an error if the folder holds something, is in use or can't be written.
    pub fn create(dir: &Path, header: Header, worlds: &Suite, frames: usize) -> Result<Self, DatasetError> {
        let lock = FolderLock::take_empty(dir).map_err(|e| match e {
            StoreError::NotEmpty(dir) => DatasetError::NotEmpty { dir },
            e => e.into(),
        })?;
        Self::begin(dir, lock, header, worlds, frames)
    }

    /// The same in a new folder, whose content is there only when it is whole.
    pub fn create_whole(
        folder: NewFolder,
        header: Header,
        worlds: &Suite,
        frames: usize,
    ) -> Result<Self, DatasetError> {
        let mut writer = Self::create(&folder.dir(), header, worlds, frames)?;
        writer.folder = Some(folder);
        Ok(writer)
    }

    fn begin(
        dir: &Path,
        lock: FolderLock,
        header: Header,
        worlds: &Suite,
        frames: usize,
    ) -> Result<Self, DatasetError> {
        let mut writer = Self::new(dir, lock, header, frames);
        // First: where it is and the header isn't, what is there is ours.
        writer.write_sums()?;
        writer.sums = copy_suite(worlds, dir)?;
        let header = json(&writer.header)?;
        writer.sums.add(Path::new(HEADER), &header);
        writer.write_sums()?;
        // Last: where it is, the worlds are whole.
        writer.write(Path::new(HEADER), &header)?;
        Ok(writer)
    }

    /// Goes on with a dataset that was begun in a folder; begins it if nothing was.
    ///
    /// # Errors
    /// Returns an error if it was begun with other settings, is in use or damaged, or can't be read or written.
    pub fn resume(dir: &Path, header: Header, worlds: &Suite, frames: usize) -> Result<Self, DatasetError> {
        if !dir.join(HEADER).is_file() {
            if !dir.join(SUMS_SO_FAR).is_file() {
                return Self::create(dir, header, worlds, frames);
            }
            let lock = FolderLock::take(dir)?;
            if dir.join(HEADER).is_file() {
                // Somebody else was faster.
                drop(lock);
                return Self::resume(dir, header, worlds, frames);
            }
            // Killed while the worlds were copied; nothing else is there.
            let begun = dir.join(WORLDS);
            if begun.is_dir() {
                fs::remove_dir_all(&begun).map_err(DatasetError::io("remove", &begun))?;
            }
            return Self::begin(dir, lock, header, worlds, frames);
        }
        let before = read_header(dir)?;
        if let Some((field, before, now)) = before.difference(&header) {
            return Err(DatasetError::Other { dir: dir.to_owned(), field, before, now });
        }
        let mut writer = Self::new(dir, FolderLock::take(dir)?, header, frames);
        writer.sums = trusted(dir, writer.format)?;
        writer.read_on()?;
        writer.write_sums()?;
        Ok(writer)
    }

    /// Takes over what is on disk.
    fn read_on(&mut self) -> Result<(), DatasetError> {
        loop {
            let (data, episodes) = (self.format.data_path(self.file), self.format.episodes_path(self.file));
            let path = self.dir.join(&episodes);
            if !path.is_file() {
                // Killed between the two files: these frames are of no episode, and are driven again.
                let frames = self.dir.join(&data);
                return match fs::remove_file(&frames) {
                    Err(e) if e.kind() != ErrorKind::NotFound => Err(DatasetError::io("remove", &frames)(e)),
                    _ => Ok(()),
                };
            }
            let rows = self.format.read_episodes(&path)?;
            if !self.sums.has(&episodes) {
                self.adopt(&data, &episodes, &rows)?;
            }
            for row in rows {
                self.done.add(&row);
            }
            self.from = self.done.frames;
            self.file += 1;
        }
    }

    /// Takes over the files that were written last, which a kill left without hashes. Files are written whole, so that they need
    /// only fit to each other.
    fn adopt(&mut self, data: &Path, episodes: &Path, rows: &[Row]) -> Result<(), DatasetError> {
        let path = self.dir.join(data);
        let frames = self.format.read_data(&path, &self.features)?.len();
        let wanted = rows.last().map_or(0, |row| row.place.to.saturating_sub(self.from));
        if frames != wanted {
            return Err(DatasetError::damaged(&path, &format!("it has {frames} frames, not {wanted}")));
        }
        for file in [data, episodes] {
            let path = self.dir.join(file);
            let bytes = vb_files::read(&path, vb_files::DATA).map_err(DatasetError::io("read", &path))?;
            self.sums.add(file, &bytes);
        }
        Ok(())
    }

    fn new(dir: &Path, lock: FolderLock, header: Header, frames: usize) -> Self {
        let features = header.layout.features();
        let episode_bytes = header.layout.frame_bytes().saturating_mul(frames.max(1));
        let per_file = (FILE_BYTES / episode_bytes).clamp(1, FILE_EPISODES);
        let batch = Batch::new(&features);
        let (rows, done) = (Vec::new(), Whole::default());
        Self {
            dir: dir.to_owned(),
            lock,
            folder: None,
            format: header.format.files(),
            header,
            features,
            per_file,
            file: 0,
            batch,
            rows,
            from: 0,
            done,
            sums: Sums::default(),
        }
    }

    /// The columns of each frame.
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

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
        let stats = stats.map(|(f, values)| (f.name.to_owned(), Stats::of(f, values)));
        // Of LeRobot's own columns, too, which all of its sets have.
        let first = self.batch.len() - episode.frames;
        let whole = |column: &[i64]| Stats::of_numbers(column[first..].iter().map(|v| *v as f64));
        let timestamp = Stats::of_numbers(self.batch.timestamp[first..].iter().map(|v| f64::from(*v)));
        let own = [
            ("timestamp", timestamp),
            ("frame_index", whole(&self.batch.frame_index)),
            ("episode_index", whole(&self.batch.episode_index)),
            ("index", whole(&self.batch.index)),
            ("task_index", whole(&self.batch.task_index)),
        ];
        let stats = stats.chain(own.map(|(name, stats)| (name.to_owned(), stats))).collect();
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
        for (path, bytes) in [
            (self.format.data_path(self.file), self.format.write_data(&self.features, &self.batch)?),
            (self.format.episodes_path(self.file), self.format.write_episodes(&self.rows)?),
        ] {
            self.write(&path, &bytes)?;
            self.sums.add(&path, &bytes);
        }
        self.write_sums()?;
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

    /// Writes the hashes until now, by which a command that goes on knows that all is as it was.
    fn write_sums(&self) -> Result<(), DatasetError> {
        self.write(Path::new(SUMS_SO_FAR), self.sums.text().as_bytes())
    }

    /// Writes what is left, what tells of the whole, and the hashes of all files; the hash of the dataset.
    ///
    /// # Errors
    /// Returns an error if there is no episode, or a file can't be written.
    pub fn finish(mut self) -> Result<Finished, DatasetError> {
        let finished = self.save()?;
        let so_far = self.dir.join(SUMS_SO_FAR);
        fs::remove_file(&so_far).map_err(DatasetError::io("remove", &so_far))?;
        self.lock.remove();
        if let Some(folder) = self.folder {
            folder.finish(SUMS)?;
        }
        Ok(finished)
    }

    /// Makes a whole dataset of what there is, to which more can be added: the episodes of people come one by one, and each is
    /// to be safe.
    pub fn save(&mut self) -> Result<Finished, DatasetError> {
        self.flush()?;
        let Whole { episodes, frames, .. } = self.done;
        if episodes == 0 {
            return Err(DatasetError::Empty("no frame meets the conditions".into()));
        }
        let mut sums = self.sums.clone();
        let contents = self.format.write_whole(&self.header, &self.features, &self.done)?;
        for (file, bytes) in self.format.whole_paths().iter().map(Path::new).zip(contents) {
            self.write(file, &bytes)?;
            sums.add(file, &bytes);
        }
        let sums = sums.text();
        self.write(Path::new(SUMS), sums.as_bytes())?;
        let summary = self.done.summary.clone();
        Ok(Finished { episodes, frames, hash: sha256(sums.as_bytes()), summary })
    }
}

/// A finished dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    pub episodes: usize,
    pub frames: usize,
    /// The hash of the dataset: the SHA-256 of its `SHA256SUMS`.
    pub hash: String,
    pub summary: Summary,
}

/// The hashes of what was begun in a folder, after all was held against them.
fn trusted(dir: &Path, format: &dyn Files) -> Result<Sums, DatasetError> {
    if dir.join(SUMS_SO_FAR).is_file() {
        let sums = Sums::read(dir, SUMS_SO_FAR)?;
        sums.must_hold(dir)?;
        return Ok(sums);
    }
    must_be_whole(dir)?;
    Ok(Sums::read(dir, SUMS)?.without(format.whole_paths()))
}

/// Copies a suite's files into a dataset; the hashes that they have there.
fn copy_suite(suite: &Suite, to: &Path) -> Result<Sums, DatasetError> {
    let mut sums = Sums::default();
    for file in files(suite.dir())? {
        let (from, file) = (suite.dir().join(&file), Path::new(WORLDS).join(&file));
        let hash = hash_file(&from).map_err(DatasetError::io("read", &from))?;
        let to = to.join(&file);
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(DatasetError::io("create", parent))?;
        }
        fs::copy(&from, &to).map_err(DatasetError::io("write", &to))?;
        sums.add_hash(&file, hash);
    }
    Ok(sums)
}
