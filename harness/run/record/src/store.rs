//! The run directory.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::checksums::{CHECKSUMS, ChecksumWriter, Checksums, missing, record_name};
use crate::folder::FolderLock;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use vb_files::{durable, is_temporary, lock, sync_dir};
use vb_world::TaskId;

use crate::{DebugEntry, DebugSeries, RUN_SCHEMA, RunHeader, StoreError, Trace, TraceMode};

pub(crate) const HEADER: &str = "run.json";
pub(crate) const TASKS: &str = "tasks.jsonl";
pub(crate) const SUMMARY: &str = "summary.json";
/// The lock is on a file of its own, since run.json is replaced by renaming.
pub(crate) const LOCK: &str = "run.lock";
/// The directory with all traces and debug series.
const TRACES: &str = "traces";
/// Longest record that is read, bytes; logs in it are bounded far below.
const LINE: u64 = 64 << 20;

/// A run directory that is open for writing, by this process alone. Workers share it.
#[derive(Debug)]
pub struct RunStore {
    dir: PathBuf,
    tasks: Mutex<TaskFile>,
    checksums: Mutex<ChecksumWriter>,
    /// Held as long as it is open.
    _lock: FolderLock,
}

#[derive(Debug)]
struct TaskFile {
    file: File,
    /// Length of what is known to be whole lines on disk, bytes.
    len: u64,
}

impl RunStore {
    /// Starts a run in `dir`, which is made if need be and must be empty.
    ///
    /// # Errors
    /// Returns [`StoreError::NotEmpty`], [`StoreError::Locked`], or an error of the file system.
    pub fn create(dir: &Path, header: &RunHeader) -> Result<Self, StoreError> {
        let lock = FolderLock::of_empty(dir, LOCK, is_begun)?;
        let header = pretty("run.json", header)?;
        let mut checksums = ChecksumWriter::open(dir)?;
        checksums.add(HEADER, &header)?;
        checksums.sync()?;
        write_atomic(&dir.join(HEADER), &header)?;
        let path = dir.join(TASKS);
        let file = File::create(&path).map_err(StoreError::io("create", &path))?;
        durable(file.sync_all()).map_err(StoreError::io("sync", &path))?;
        sync_dir(dir);
        let (tasks, checksums) = (Mutex::new(TaskFile { file, len: 0 }), Mutex::new(checksums));
        Ok(Self { dir: dir.to_owned(), tasks, checksums, _lock: lock })
    }

    /// Goes on with the run in `dir`, which must have been made with the same settings: see [`RunHeader::difference`].
    /// It returns the records of those finished tasks for which `counts` is true. The others' lines are deleted, and a
    /// line torn by a killed process is cut away.
    ///
    /// # Errors
    /// Returns [`StoreError::NoRun`], [`StoreError::Differs`], [`StoreError::Locked`], [`StoreError::Damaged`], or an
    /// error of the file system.
    pub fn resume<T: DeserializeOwned>(
        dir: &Path,
        header: &RunHeader,
        counts: impl Fn(&T) -> bool,
    ) -> Result<(Self, Vec<T>), StoreError> {
        if !dir.join(HEADER).exists() {
            return Err(StoreError::NoRun(dir.to_owned()));
        }
        let lock = FolderLock::by(dir, LOCK)?;
        let recorded = read_header(dir)?;
        if let Some((field, recorded, wanted)) = recorded.difference(header) {
            return Err(StoreError::Differs { dir: dir.to_owned(), field, recorded, wanted });
        }
        let path = dir.join(TASKS);
        let (mut records, mut len) = read_tasks::<T>(dir)?;
        let has_sums = dir.join(CHECKSUMS).exists();
        let mut checksums = ChecksumWriter::open(dir)?;
        if !has_sums {
            adopt(dir, len, &mut checksums)?;
        }
        let checksums = Mutex::new(checksums);
        if !records.iter().all(&counts) {
            let bytes = fs::read(&path).map_err(StoreError::io("read", &path))?;
            // Every whole line is a record, in the same order.
            let lines = bytes[..len as usize].split_inclusive(|&b| b == b'\n');
            let kept: Vec<u8> = lines
                .zip(&records)
                .filter(|(_, record)| counts(record))
                .flat_map(|(line, _)| line)
                .copied()
                .collect();
            write_atomic(&path, &kept)?;
            len = kept.len() as u64;
            records.retain(&counts);
        }
        // Not `append`: after a failed write the file is cut back, and the next line goes where that one began.
        let mut file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(StoreError::io("open", &path))?;
        file.set_len(len).map_err(StoreError::io("cut", &path))?;
        file.seek(SeekFrom::Start(len)).map_err(StoreError::io("seek in", &path))?;
        durable(file.sync_all()).map_err(StoreError::io("sync", &path))?;
        let tasks = Mutex::new(TaskFile { file, len });
        Ok((Self { dir: dir.to_owned(), tasks, checksums, _lock: lock }, records))
    }

    /// The run directory.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Appends the record of a finished task, which must have a string field `task`, and syncs it to disk. After
    /// an error the file holds what it held before.
    ///
    /// # Errors
    /// Returns an error of the file system, a full disk for instance.
    pub fn append<T: Serialize>(&self, record: &T) -> Result<(), StoreError> {
        let mut line = serde_json::to_vec(record)
            .map_err(|e| StoreError::Encode { what: "a task record", detail: e.to_string() })?;
        let key: Key = serde_json::from_slice(&line)
            .map_err(|e| StoreError::Encode { what: "a task record", detail: e.to_string() })?;
        {
            // Before the record: what counts has its checksum. Those of the task's files become durable along with it.
            let mut checksums = lock(&self.checksums);
            checksums.add(&record_name(&key.task), &line)?;
            checksums.sync()?;
        }
        line.push(b'\n');
        let path = self.dir.join(TASKS);
        // A panic elsewhere can't have left the state half changed: it is changed last.
        let mut tasks = lock(&self.tasks);
        let written = tasks
            .file
            .write_all(&line)
            .map_err(StoreError::io("write", &path))
            .and_then(|()| durable(tasks.file.sync_data()).map_err(StoreError::io("sync", &path)));
        if written.is_err() {
            let len = tasks.len;
            // If this fails too, the torn line is found on resume.
            let _ = tasks.file.set_len(len).and_then(|()| tasks.file.seek(SeekFrom::Start(len)));
            return written;
        }
        tasks.len += line.len() as u64;
        Ok(())
    }

    /// Writes a task's trajectory to `traces/<world>/<task>.parquet`. Call it before [`RunStore::append`], so that
    /// a task that is done has its trace.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn write_trace(&self, trace: &Trace) -> Result<(), StoreError> {
        self.write_file(&trace_name(&trace.meta.task), &trace.encode()?)
    }

    /// Writes a planner's series of a task to `traces/<world>/<task>.debug.parquet`. It writes nothing if there are
    /// none.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn write_debug(&self, task: &TaskId, series: &DebugSeries) -> Result<(), StoreError> {
        if series.is_empty() {
            return Ok(());
        }
        self.write_file(&debug_name(task), &series.encode()?)
    }

    /// Writes a file below the run directory, its checksum first.
    fn write_file(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let path = self.dir.join(name);
        self.make_parent(&path)?;
        lock(&self.checksums).add(name, bytes)?;
        write_atomic(&path, bytes)
    }

    /// Makes the directory of a file below `traces`, durably.
    fn make_parent(&self, path: &Path) -> Result<(), StoreError> {
        let parent = path.parent().unwrap_or(path);
        if !parent.is_dir() {
            fs::create_dir_all(parent).map_err(StoreError::io("make directory", parent))?;
            parent.parent().map(sync_dir);
            sync_dir(&self.dir);
        }
        Ok(())
    }

    /// Writes `summary.json`, replacing an earlier one, and ends the run for now.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn finish<T: Serialize>(self, summary: &T) -> Result<(), StoreError> {
        write_atomic(&self.dir.join(SUMMARY), &pretty("summary.json", summary)?)
    }

    /// The same for a run whose tasks are all done: its records are put into the order of `tasks`, so that the files of a run are
    /// the same bytes whichever task ended first.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn finish_whole<T: Serialize>(self, tasks: &[TaskId], summary: &T) -> Result<(), StoreError> {
        let mut lines = BTreeMap::new();
        each_task(&self.dir, |key: Key, line| {
            lines.insert(key.task, line.to_vec());
        })?;
        let text: Vec<u8> = tasks.iter().filter_map(|task| lines.remove(task)).flatten().collect();
        // Both have what they had before, so that it doesn't matter if the process is killed between them.
        if let Some(sums) = Checksums::read(&self.dir)? {
            write_atomic(
                &self.dir.join(CHECKSUMS),
                sums.text(names(tasks).iter().map(String::as_str)).as_bytes(),
            )?;
        }
        write_atomic(&self.dir.join(TASKS), &text)?;
        self.finish(summary)
    }
}

/// A run directory that is open for reading; it may belong to a run that is still going on.
#[derive(Debug)]
pub struct RunReader {
    dir: PathBuf,
    header: RunHeader,
}

impl RunReader {
    /// Whether a path is that of a file which a run in this directory may have. Both are absolute.
    #[must_use]
    pub fn owns(dir: &Path, path: &Path) -> bool {
        path.strip_prefix(dir).is_ok_and(|own| {
            [HEADER, TASKS, CHECKSUMS, SUMMARY, LOCK].iter().any(|name| own == Path::new(name))
                || own.starts_with(TRACES)
        })
    }

    /// Opens a run.
    ///
    /// # Errors
    /// Returns [`StoreError::NoRun`], [`StoreError::Schema`], [`StoreError::Damaged`] or an error of the file system.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        Ok(Self { dir: dir.to_owned(), header: read_header(dir)? })
    }

    /// The run directory.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The description of what was run.
    #[must_use]
    pub fn header(&self) -> &RunHeader {
        &self.header
    }

    /// The records of the tasks that are done, in the order in which they ended. A torn last line is left out.
    ///
    /// # Errors
    /// Returns [`StoreError::Damaged`] or an error of the file system.
    pub fn records<T: DeserializeOwned>(&self) -> Result<Vec<T>, StoreError> {
        Ok(read_tasks(&self.dir)?.0)
    }

    /// Hands the same records to `take` one by one, so that they need not all be in memory.
    ///
    /// # Errors
    /// Returns [`StoreError::Damaged`] or an error of the file system.
    pub fn each_record<T: DeserializeOwned>(&self, mut take: impl FnMut(T)) -> Result<(), StoreError> {
        each_task(&self.dir, |record, _| take(record)).map(drop)
    }

    /// Hands the same records to `take` with their lines as they are in the file, without the end of the line.
    ///
    /// # Errors
    /// Returns [`StoreError::Damaged`] or an error of the file system.
    pub fn each_line<T: DeserializeOwned>(&self, mut take: impl FnMut(T, &[u8])) -> Result<(), StoreError> {
        each_task(&self.dir, |record, line| take(record, line.strip_suffix(b"\n").unwrap_or(line))).map(drop)
    }

    /// Tells whether the run has a trace of this task.
    ///
    /// # Errors
    /// Returns [`StoreError::Damaged`] if the trace was written and is lost.
    pub fn has_trace(&self, task: &TaskId) -> Result<bool, StoreError> {
        Ok(self.header.trace != TraceMode::None && self.is_there(&trace_name(task))?)
    }

    /// Whether a file of the run is there, which must be if it has a checksum.
    fn is_there(&self, name: &str) -> Result<bool, StoreError> {
        let path = self.dir.join(name);
        if path.exists() {
            return Ok(true);
        }
        match Checksums::read(&self.dir)? {
            Some(sums) if sums.has(name) => Err(missing(&path)),
            _ => Ok(false),
        }
    }

    /// The trajectory of a task.
    ///
    /// # Errors
    /// Returns an error of [`Trace::read`].
    pub fn trace(&self, task: &TaskId) -> Result<Trace, StoreError> {
        Trace::read(&self.checked(&trace_name(task))?)
    }

    /// The series that the planner sent in a task, in the order of time; empty if it sent none.
    ///
    /// # Errors
    /// Returns an error of [`DebugSeries::read`].
    pub fn debug(&self, task: &TaskId) -> Result<Vec<DebugEntry>, StoreError> {
        let name = debug_name(task);
        if self.is_there(&name)? { DebugSeries::read(&self.checked(&name)?) } else { Ok(Vec::new()) }
    }

    /// The path of a file of the run, which is as it was written.
    fn checked(&self, name: &str) -> Result<PathBuf, StoreError> {
        let path = self.dir.join(name);
        if let Some(sums) = Checksums::read(&self.dir)? {
            let bytes = vb_files::read(&path, vb_files::DATA).map_err(StoreError::io("read", &path))?;
            sums.check(&path, name, &bytes)?;
        }
        Ok(path)
    }
}

/// The names by which the files and records of a run have their checksums, in the order in which they are written if the tasks
/// are driven one after the other.
pub(crate) fn names(tasks: &[TaskId]) -> Vec<String> {
    let of = |task| [trace_name(task), debug_name(task), record_name(task)];
    std::iter::once(HEADER.to_owned()).chain(tasks.iter().flat_map(of)).collect()
}

/// Where a task's trace lies in a run.
pub(crate) fn trace_name(task: &TaskId) -> String {
    format!("{TRACES}/{task}.parquet")
}

/// Where a task's debug series lie in a run.
pub(crate) fn debug_name(task: &TaskId) -> String {
    format!("{TRACES}/{task}.debug.parquet")
}

/// Whether a process that was killed before it wrote run.json may have left a file of this name.
fn is_begun(name: &str) -> bool {
    name == CHECKSUMS || is_temporary(name)
}

/// Writes a file as a whole or not at all.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    vb_files::write(path, bytes).map_err(StoreError::io("write", path))
}

/// A document as it is written.
pub(crate) fn pretty<T: Serialize>(what: &'static str, value: &T) -> Result<Vec<u8>, StoreError> {
    let mut text =
        serde_json::to_vec_pretty(value).map_err(|e| StoreError::Encode { what, detail: e.to_string() })?;
    text.push(b'\n');
    Ok(text)
}

/// Adds the checksums of all that is in a run's directory, whose records take up `len` bytes: without its checksums, a run is taken as
/// it is.
fn adopt(dir: &Path, len: u64, checksums: &mut ChecksumWriter) -> Result<(), StoreError> {
    let read = |path: &Path| fs::read(path).map_err(StoreError::io("read", path));
    checksums.add(HEADER, &read(&dir.join(HEADER))?)?;
    let records = if len > 0 { read(&dir.join(TASKS))? } else { Vec::new() };
    for line in records[..len as usize].split(|b| *b == b'\n').filter(|line| !line.is_empty()) {
        let key: Key = serde_json::from_slice(line)
            .map_err(|e| StoreError::Encode { what: "a task record", detail: e.to_string() })?;
        for name in [trace_name(&key.task), debug_name(&key.task)] {
            let path = dir.join(&name);
            if path.exists() {
                checksums.add(&name, &read(&path)?)?;
            }
        }
        checksums.add(&record_name(&key.task), line)?;
    }
    Ok(())
}

fn read_header(dir: &Path) -> Result<RunHeader, StoreError> {
    let path = dir.join(HEADER);
    let bytes = vb_files::read(&path, vb_files::DOCUMENT).map_err(|source| {
        if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) {
            StoreError::NoRun(dir.to_owned())
        } else {
            StoreError::Io { action: "read", path: path.clone(), source }
        }
    })?;
    let damaged = |detail: String| StoreError::Damaged {
        path: path.clone(),
        detail,
        hint: "restore the file, or start a new run",
    };
    let unread = |e: serde_json::Error| damaged(e.to_string());
    let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(unread)?;
    match value.get("schema").and_then(serde_json::Value::as_u64) {
        Some(found) if found != u64::from(RUN_SCHEMA) => {
            Err(StoreError::Schema { path, found, supported: RUN_SCHEMA })
        }
        _ => {
            if let Some(sums) = Checksums::read(dir)? {
                sums.check(&path, HEADER, &bytes)?;
            }
            let header: RunHeader = serde_json::from_value(value).map_err(unread)?;
            match header.flaw() {
                Some(flaw) => Err(damaged(flaw)),
                None => Ok(header),
            }
        }
    }
}

#[derive(Deserialize)]
struct Key {
    #[serde(deserialize_with = "task")]
    task: TaskId,
}

/// Reads the task of a record; the message of an error names the field.
fn task<'de, D: Deserializer<'de>>(from: D) -> Result<TaskId, D::Error> {
    TaskId::deserialize(from).map_err(|e| D::Error::custom(format!("task: {e}")))
}

/// The records in tasks.jsonl and the length of their lines.
fn read_tasks<T: DeserializeOwned>(dir: &Path) -> Result<(Vec<T>, u64), StoreError> {
    let mut records = Vec::new();
    let len = each_task(dir, |record, _| records.push(record))?;
    Ok((records, len))
}

/// Hands over each record in tasks.jsonl with its line and returns the length of their lines. A last line that is not whole was torn
/// when its process was killed; any other bad line is damage that nobody should overlook.
fn each_task<T: DeserializeOwned>(dir: &Path, mut take: impl FnMut(T, &[u8])) -> Result<u64, StoreError> {
    let path = &dir.join(TASKS);
    let mut sums = Checksums::read(dir)?;
    let mut file = match vb_files::open(path) {
        Ok(file) => BufReader::new(file),
        // Killed between run.json and the first task.
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(0),
        Err(e) => return Err(StoreError::io("read", path)(e)),
    };
    let mut seen = BTreeSet::new();
    let (mut len, mut number) = (0, 0);
    let mut line = Vec::new();
    loop {
        line.clear();
        (&mut file).take(LINE + 1).read_until(b'\n', &mut line).map_err(StoreError::io("read", path))?;
        if line.is_empty() {
            return Ok(len);
        }
        number += 1;
        let damaged = |detail: String| StoreError::Damaged {
            path: path.to_owned(),
            detail: format!("line {number}: {detail}"),
            hint: "delete the line, then run --resume re-runs its task",
        };
        if line.len() as u64 > LINE {
            return Err(damaged(format!("longer than {LINE} bytes")));
        }
        let parsed =
            serde_json::from_slice::<Key>(&line).and_then(|key| Ok((key, serde_json::from_slice(&line)?)));
        // With checksums a line that is ended is known to have been written whole: one that can't be read is damaged, not torn.
        let torn = !line.ends_with(b"\n") || (parsed.is_err() && sums.is_none());
        if torn {
            let last = file.fill_buf().map_err(StoreError::io("read", path))?.is_empty();
            if last {
                return Ok(len);
            }
        }
        let (key, record) = parsed.map_err(|e| damaged(e.to_string()))?;
        if let Some(known) = &sums {
            let name = record_name(&key.task);
            // The run may have gone on since its checksums were read.
            if !known.has(&name) {
                sums = Checksums::read(dir)?;
            }
            if let Some(known) = &sums {
                known.check(path, &name, line.strip_suffix(b"\n").unwrap_or(&line))?;
            }
        }
        if seen.contains(&key.task) {
            return Err(damaged(format!("task {} is a duplicate", key.task)));
        }
        seen.insert(key.task);
        take(record, &line);
        len += line.len() as u64;
    }
}
