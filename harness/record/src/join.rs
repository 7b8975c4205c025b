//! One run made of several, each of which has some of its tasks.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::checksums::{CHECKSUMS, Checksums, record_name};
use crate::files::{sync_dir, write_atomic};
use crate::store::{
    HEADER, LOCK, SUMMARY, TASKS, debug_name, names, pretty, refuse_unless_empty, trace_name,
};
use crate::{RunHeader, RunReader, StoreError};

/// A run directory that is made of records which are there already. It gets its name only when it is whole.
#[derive(Debug)]
pub struct RunJoiner {
    out: PathBuf,
    /// Where it is made.
    dir: PathBuf,
    checksums: Checksums,
    /// The checksums of each run that was taken from; `None` where it has none.
    sources: BTreeMap<PathBuf, Option<Checksums>>,
    names: Vec<String>,
    records: Vec<u8>,
}

impl Drop for RunJoiner {
    fn drop(&mut self) {
        // What has its name is elsewhere, and what has none yet never will.
        let _ = fs::remove_dir_all(&self.dir);
    }
}

impl RunJoiner {
    /// Starts a run that will be in `out`, which must be empty or missing.
    ///
    /// # Errors
    /// Returns [`StoreError::NotEmpty`], or an error of the file system.
    pub fn new(out: &Path, header: &RunHeader) -> Result<Self, StoreError> {
        if out.exists() {
            refuse_unless_empty(out)?;
        }
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let dir = out.with_file_name(format!(".{name}.joined"));
        // From a process that was killed: whoever joins now has the same parts.
        match fs::remove_dir_all(&dir) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(StoreError::io("remove", &dir)(e)),
            _ => {}
        }
        fs::create_dir_all(&dir).map_err(StoreError::io("make directory", &dir))?;
        let mut checksums = Checksums::default();
        let header = pretty("run.json", header)?;
        checksums.add(HEADER, &header);
        write_atomic(&dir.join(HEADER), &header)?;
        let out = out.to_owned();
        Ok(Self { out, dir, checksums, sources: BTreeMap::new(), names: Vec::new(), records: Vec::new() })
    }

    /// Adds a task: the line of its record, and its trace and debug series in the run that drove it. Tasks are added in the order
    /// of the suite.
    ///
    /// # Errors
    /// Returns [`StoreError::TaskName`], [`StoreError::Damaged`] if a file isn't as it was written, or an error of the file system.
    pub fn add(&mut self, task: &str, line: &[u8], from: &RunReader) -> Result<(), StoreError> {
        for name in [trace_name(task)?, debug_name(task)?] {
            if from.dir().join(&name).exists() {
                self.copy(&name, from)?;
            }
        }
        self.checksums.add(&record_name(task), line);
        self.names.push(task.to_owned());
        self.records.extend_from_slice(line);
        self.records.push(b'\n');
        Ok(())
    }

    fn copy(&mut self, name: &str, from: &RunReader) -> Result<(), StoreError> {
        let source = from.dir().join(name);
        let bytes = vb_files::read(&source, vb_files::DATA).map_err(StoreError::io("read", &source))?;
        let sums = match self.sources.entry(from.dir().to_owned()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Checksums::read(from.dir())?),
        };
        if let Some(sums) = sums {
            sums.check(&source, name, &bytes)?;
        }
        let path = self.dir.join(name);
        let parent = path.parent().unwrap_or(&path);
        fs::create_dir_all(parent).map_err(StoreError::io("make directory", parent))?;
        fs::write(&path, &bytes).map_err(StoreError::io("write", &path))?;
        self.checksums.add(name, &bytes);
        Ok(())
    }

    /// Writes the rest, and gives the run its name.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn finish<T: Serialize>(self, summary: &T) -> Result<(), StoreError> {
        let order = names(&self.names)?;
        write_atomic(&self.dir.join(LOCK), b"")?;
        write_atomic(
            &self.dir.join(CHECKSUMS),
            self.checksums.text(order.iter().map(String::as_str)).as_bytes(),
        )?;
        write_atomic(&self.dir.join(TASKS), &self.records)?;
        write_atomic(&self.dir.join(SUMMARY), &pretty("summary.json", summary)?)?;
        if self.out.exists() {
            // An empty directory can be replaced on some systems only.
            refuse_unless_empty(&self.out)?;
            fs::remove_dir_all(&self.out).map_err(StoreError::io("remove", &self.out))?;
        }
        fs::rename(&self.dir, &self.out).map_err(StoreError::io("rename to", &self.out))?;
        self.out.parent().map(sync_dir);
        Ok(())
    }
}
