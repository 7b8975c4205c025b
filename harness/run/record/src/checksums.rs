//! Checksums of what a run wrote: damage on disk is found, not reported as a result.
//!
//! `checksums.txt` has a line for each file, and one for each record: the SHA-256 and the name, as `sha256sum` writes them. A
//! record's line is there before the record itself, and a later line of a name replaces an earlier one. So a run that is killed
//! at any time, or goes on while it is read, has the checksum of all that counts. This guards against accidents: whoever changes
//! results on purpose changes this file, too.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use vb_files::{durable, sha256};
use vb_world::TaskId;

use crate::StoreError;

/// The file in a run directory.
pub(crate) const CHECKSUMS: &str = "checksums.txt";
/// Length of a SHA-256 in hexadecimal.
const HEX: usize = 64;

const HINT: &str = "the disk or a copy is damaged: restore the run from an intact copy, or re-run";

/// The name by which a task's record has its checksum.
pub(crate) fn record_name(task: &TaskId) -> String {
    format!("tasks.jsonl {task}")
}

/// The checksums of a run, for reading.
#[derive(Debug, Default)]
pub(crate) struct Checksums {
    sums: BTreeMap<Box<str>, Box<str>>,
}

impl Checksums {
    /// The checksums of the run in `dir`; none if it has none, as runs in submissions, which have the
    /// hashes of their manifest.
    pub(crate) fn read(dir: &Path) -> Result<Option<Self>, StoreError> {
        let path = dir.join(CHECKSUMS);
        let text = match vb_files::read(&path, vb_files::DATA) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(StoreError::io("read", &path)(e)),
        };
        let mut sums = BTreeMap::new();
        for (k, line) in text.split_inclusive(|b| *b == b'\n').enumerate() {
            // Torn when the process was killed: what it is of was not written yet.
            let Some(line) = line.strip_suffix(b"\n") else { break };
            let (sum, name) = std::str::from_utf8(line)
                .ok()
                .and_then(|l| l.split_once("  "))
                .filter(|(sum, name)| sum.len() == HEX && !name.is_empty())
                .ok_or_else(|| damaged(&path, format!("line {} is not a checksum", k + 1)))?;
            sums.insert(name.into(), sum.into());
        }
        Ok(Some(Self { sums }))
    }

    pub(crate) fn add(&mut self, name: &str, bytes: &[u8]) {
        self.sums.insert(name.into(), sha256(bytes).into());
    }

    /// The file, with those of these names first, in their order.
    pub(crate) fn text<'a>(&self, first: impl IntoIterator<Item = &'a str>) -> String {
        let mut rest = self.sums.clone();
        let mut text = String::new();
        let mut write = |name: &str, sum: &str| {
            text.push_str(sum);
            text.push_str("  ");
            text.push_str(name);
            text.push('\n');
        };
        for name in first {
            if let Some(sum) = rest.remove(name) {
                write(name, &sum);
            }
        }
        for (name, sum) in &rest {
            write(name, sum);
        }
        text
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.sums.contains_key(name)
    }

    /// Checks what `path` holds under this name.
    pub(crate) fn check(&self, path: &Path, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        match self.sums.get(name) {
            None => Err(damaged(path, format!("{name} has no checksum in {CHECKSUMS}"))),
            Some(sum) if **sum == *sha256(bytes) => Ok(()),
            Some(_) => Err(damaged(path, format!("{name} has another checksum than when it was written"))),
        }
    }
}

fn damaged(path: &Path, detail: String) -> StoreError {
    StoreError::Damaged { path: path.to_owned(), detail, hint: HINT }
}

/// The error of a file that was written and isn't there.
pub(crate) fn missing(path: &Path) -> StoreError {
    StoreError::Damaged {
        path: path.to_owned(),
        detail: format!("the file is missing, but {CHECKSUMS} lists it"),
        hint: "restore it from an intact copy; if it was removed on purpose, delete the run's checksums.txt",
    }
}

/// The checksums of a run, for writing.
#[derive(Debug)]
pub(crate) struct ChecksumWriter {
    path: PathBuf,
    file: File,
    /// Length of what is known to be whole lines, bytes.
    len: u64,
}

impl ChecksumWriter {
    /// Begins the file, or goes on behind its last whole line.
    pub(crate) fn open(dir: &Path) -> Result<Self, StoreError> {
        let path = dir.join(CHECKSUMS);
        let len = match vb_files::read(&path, vb_files::DATA) {
            Ok(bytes) => bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at as u64 + 1),
            Err(e) if e.kind() == ErrorKind::NotFound => 0,
            Err(e) => return Err(StoreError::io("read", &path)(e)),
        };
        let mut options = OpenOptions::new();
        let mut file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(StoreError::io("create", &path))?;
        file.set_len(len).map_err(StoreError::io("cut", &path))?;
        file.seek(SeekFrom::Start(len)).map_err(StoreError::io("seek in", &path))?;
        Ok(Self { path, file, len })
    }

    /// Adds the checksum of `bytes`. After an error the file holds what it held before.
    pub(crate) fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let line = format!("{}  {name}\n", sha256(bytes));
        let written = self.file.write_all(line.as_bytes()).map_err(StoreError::io("write", &self.path));
        if written.is_ok() {
            self.len += line.len() as u64;
        } else {
            // If this fails too, the torn line is found by whoever reads it.
            let _ = self.file.set_len(self.len).and_then(|()| self.file.seek(SeekFrom::Start(self.len)));
        }
        written
    }

    /// Makes durable what was added.
    pub(crate) fn sync(&self) -> Result<(), StoreError> {
        durable(self.file.sync_data()).map_err(StoreError::io("sync", &self.path))
    }
}
