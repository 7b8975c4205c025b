//! The hashes of a dataset's files, by which damage is found before it is handed on.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::ops::ControlFlow;
use std::path::{Component, Path, PathBuf};

use vb_files::{Hash, sha256};

use crate::error::DatasetError;

/// The file with the hashes of all others, which is written last.
pub(crate) const SUMS: &str = "SHA256SUMS";
/// The same of the files that stay as they are, while a dataset is made. It is hidden, since it is none of the dataset's.
pub(crate) const SUMS_SO_FAR: &str = ".SHA256SUMS";

/// The most bytes of such a file: that of a dataset of half a million files.
const MOST: u64 = 64 << 20;

const MISSING: &str = "it is missing";

/// Hashes of files, by their paths in the dataset.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sums(BTreeMap<PathBuf, String>);

pub(crate) struct Flaw {
    /// Its path in the dataset.
    pub(crate) file: PathBuf,
    pub(crate) problem: String,
}

impl Sums {
    pub(crate) fn read(dir: &Path, file: &str) -> Result<Self, DatasetError> {
        let path = dir.join(file);
        let text = vb_files::read_text(&path, MOST).map_err(|e| match e.kind() {
            ErrorKind::NotFound => Flaw::missing(file.into()).of(dir),
            _ => DatasetError::io("read", &path)(e),
        })?;
        let mut sums = BTreeMap::new();
        for line in text.lines() {
            let (hash, name) = line
                .split_once("  ")
                // A name that leads out of the folder is nobody's file.
                .filter(|(_, name)| Path::new(name).components().all(|c| matches!(c, Component::Normal(_))))
                .ok_or_else(|| {
                    let begin: String = line.chars().take(100).collect();
                    DatasetError::damaged(&path, &format!("line \"{begin}\" is not a hash and a file name"))
                })?;
            sums.insert(PathBuf::from(name), hash.to_owned());
        }
        Ok(Self(sums))
    }

    pub(crate) fn add(&mut self, file: &Path, bytes: &[u8]) {
        self.add_hash(file, sha256(bytes));
    }

    pub(crate) fn add_hash(&mut self, file: &Path, hash: String) {
        self.0.insert(file.to_owned(), hash);
    }

    pub(crate) fn without(mut self, files: &[&str]) -> Self {
        self.0.retain(|file, _| files.iter().all(|f| file != Path::new(f)));
        self
    }

    pub(crate) fn has(&self, file: &Path) -> bool {
        self.0.contains_key(file)
    }

    /// What `sha256sum` would print.
    pub(crate) fn text(&self) -> String {
        self.0.iter().map(|(file, hash)| format!("{hash}  {}\n", name(file))).collect()
    }

    /// Holds each file of a dataset against its hash, and tells what is wrong, until it is told to stop.
    pub(crate) fn check(&self, dir: &Path, mut tell: impl FnMut(Flaw) -> ControlFlow<()>) {
        for (file, hash) in &self.0 {
            let problem = match hash_file(&dir.join(file)) {
                Ok(own) if own == *hash => continue,
                Ok(_) => "its SHA-256 differs".to_owned(),
                Err(e) if e.kind() == ErrorKind::NotFound => MISSING.to_owned(),
                Err(e) => format!("it can't be read: {e}"),
            };
            if tell(Flaw { file: file.clone(), problem }).is_break() {
                return;
            }
        }
    }

    /// Refuses a dataset of which a file is not as it was written, or missing.
    pub(crate) fn must_hold(&self, dir: &Path) -> Result<(), DatasetError> {
        let mut first = None;
        self.check(dir, |flaw| {
            first = Some(flaw);
            ControlFlow::Break(())
        });
        first.map_or(Ok(()), |flaw| Err(flaw.of(dir)))
    }

    /// The files of a dataset that have no hash.
    pub(crate) fn strangers(&self, dir: &Path) -> Result<Vec<Flaw>, DatasetError> {
        let strange = files(dir)?.into_iter().filter(|file| file != Path::new(SUMS) && !self.has(file));
        let problem = format!("it does not belong to the dataset ({SUMS} does not list it)");
        Ok(strange.map(|file| Flaw { file, problem: problem.clone() }).collect())
    }
}

impl Flaw {
    pub(crate) fn missing(file: PathBuf) -> Self {
        Self { file, problem: MISSING.to_owned() }
    }

    /// The error of a dataset that can't be used because of it.
    pub(crate) fn of(self, dir: &Path) -> DatasetError {
        DatasetError::Changed { path: dir.join(self.file), problem: self.problem }
    }
}

impl std::fmt::Display for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", name(&self.file), self.problem)
    }
}

/// Refuses a finished dataset unless all its files are as they were written, and there are no others.
pub(crate) fn must_be_whole(dir: &Path) -> Result<(), DatasetError> {
    let sums = Sums::read(dir, SUMS)?;
    sums.must_hold(dir)?;
    sums.strangers(dir)?.into_iter().next().map_or(Ok(()), |flaw| Err(flaw.of(dir)))
}

/// How a file is called on every system.
fn name(file: &Path) -> String {
    file.to_string_lossy().replace('\\', "/")
}

/// The files of a folder and those below it, sorted by name. What is hidden is left out: folders of version control, and what
/// belongs to a write that is going on or was interrupted.
pub(crate) fn files(dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(at) = open.pop() {
        let folder = dir.join(&at);
        for entry in fs::read_dir(&folder).map_err(DatasetError::io("read", &folder))? {
            let entry = entry.map_err(DatasetError::io("read", &folder))?;
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            let path = at.join(entry.file_name());
            if entry.path().is_dir() {
                open.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The SHA-256 of a file, which is read piece by piece.
pub(crate) fn hash_file(path: &Path) -> std::io::Result<String> {
    use std::io::Read as _;
    let mut file = vb_files::open(path)?;
    let (mut hash, mut piece) = (Hash::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hash.hex()),
            n => hash.update(&piece[..n]),
        }
    }
}
