//! One run made of several, each of which has some of its tasks.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vb_world::TaskId;

use crate::checksums::{CHECKSUMS, Checksums, missing, record_name};
use crate::folder::NewFolder;
use crate::store::{HEADER, LOCK, SUMMARY, TASKS, debug_name, names, pretty, trace_name, write_atomic};
use crate::{RunHeader, RunReader, StoreError};

/// A run directory that is made of records which are there already. It is there only when it is whole.
#[derive(Debug)]
pub struct RunJoiner {
    folder: NewFolder,
    checksums: Checksums,
    /// The checksums of each run that was taken from; `None` where it has none.
    sources: BTreeMap<PathBuf, Option<Checksums>>,
    tasks: Vec<TaskId>,
    records: Vec<u8>,
}

impl RunJoiner {
    /// Starts a run that will be in `out`, which must be empty or missing.
    ///
    /// # Errors
    /// Returns [`StoreError::Taken`], [`StoreError::Locked`], or an error of the file system.
    pub fn new(out: &Path, header: &RunHeader) -> Result<Self, StoreError> {
        let folder = NewFolder::new(out)?;
        let mut checksums = Checksums::default();
        let header = pretty("run.json", header)?;
        checksums.add(HEADER, &header);
        write_atomic(&folder.dir().join(HEADER), &header)?;
        Ok(Self { folder, checksums, sources: BTreeMap::new(), tasks: Vec::new(), records: Vec::new() })
    }

    /// Adds a task: the line of its record, and its trace and debug series in the run that drove it. Tasks are added in the order
    /// of the suite.
    ///
    /// # Errors
    /// Returns [`StoreError::Damaged`] if a file isn't as it was written, or an error of the file system.
    pub fn add(&mut self, task: &TaskId, line: &[u8], from: &RunReader) -> Result<(), StoreError> {
        for name in [trace_name(task), debug_name(task)] {
            self.copy(&name, from)?;
        }
        self.checksums.add(&record_name(task), line);
        self.tasks.push(task.clone());
        self.records.extend_from_slice(line);
        self.records.push(b'\n');
        Ok(())
    }

    /// Takes over a file if the other run wrote one.
    fn copy(&mut self, name: &str, from: &RunReader) -> Result<(), StoreError> {
        let source = from.dir().join(name);
        let sums = match self.sources.entry(from.dir().to_owned()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Checksums::read(from.dir())?),
        };
        let bytes = match vb_files::read(&source, vb_files::DATA) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => {
                return match sums {
                    // What has a checksum was written before its task counted as done.
                    Some(sums) if sums.has(name) => Err(missing(&source)),
                    _ => Ok(()),
                };
            }
            Err(e) => return Err(StoreError::io("read", &source)(e)),
        };
        if let Some(sums) = sums {
            sums.check(&source, name, &bytes)?;
        }
        let path = self.folder.dir().join(name);
        let parent = path.parent().unwrap_or(&path);
        fs::create_dir_all(parent).map_err(StoreError::io("make directory", parent))?;
        fs::write(&path, &bytes).map_err(StoreError::io("write", &path))?;
        self.checksums.add(name, &bytes);
        Ok(())
    }

    /// Writes the rest, and puts the run in its place.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn finish<T: Serialize>(self, summary: &T) -> Result<(), StoreError> {
        let order = names(&self.tasks);
        let dir = self.folder.dir();
        write_atomic(&dir.join(LOCK), b"")?;
        write_atomic(&dir.join(CHECKSUMS), self.checksums.text(order.iter().map(String::as_str)).as_bytes())?;
        write_atomic(&dir.join(TASKS), &self.records)?;
        write_atomic(&dir.join(SUMMARY), &pretty("summary.json", summary)?)?;
        self.folder.finish(HEADER)
    }
}
