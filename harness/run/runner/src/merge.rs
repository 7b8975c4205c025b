//! One run of the shards that several machines have driven.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use vb_record::{RunHeader, RunJoiner, RunReader, StoreError, TraceMode};
use vb_score::{Outcome, Rules, Summary, TaskRecord};
use vb_world::{Selector, SelectorError, Suite, TaskId};

/// An error of a merge. Nothing was written then.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A run can't be read, or the new one not be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A folder has no shards.
    #[error("{}: neither a run nor a shard (give the directory of --out)", .0.display())]
    Nothing(PathBuf),
    /// A run is no shard.
    #[error("{}: the run is not a shard (report compares complete runs)", .0.display())]
    NoShard(PathBuf),
    /// Two shards are not of one run.
    #[error(
        "{} and {} belong to different runs: {field} differs: {first} and {second} (merge only shards of the same \
         command and version)",
        .paths[0].display(), .paths[1].display()
    )]
    Mixed {
        /// The runs.
        paths: [PathBuf; 2],
        /// The field of run.json in which they differ, e.g. `plugin.sha256`.
        field: String,
        /// Its value in the first.
        first: String,
        /// Its value in the second.
        second: String,
    },
    /// The suite is not that of the runs.
    #[error(
        "suite {suite} is not the suite of the shards: its hash is {found}, not {recorded} (give theirs with --suite)"
    )]
    OtherSuite {
        /// The name of the suite.
        suite: String,
        /// Its hash.
        found: String,
        /// The hash in the runs.
        recorded: String,
    },
    /// The recorded selector can't be used.
    #[error(transparent)]
    Selector(#[from] SelectorError),
    /// The recorded rules can't be used.
    #[error("{}: rules.profile: {problem}", .path.display())]
    Rules {
        /// The run.
        path: PathBuf,
        /// What is wrong with them.
        problem: String,
    },
    /// Two shards have different records of a task.
    #[error(
        "{} and {} have different records of {task}, although results are deterministic (to find the faulty machine: \
         re-run the task, and see check)",
        .paths[0].display(), .paths[1].display()
    )]
    Conflict {
        task: TaskId,
        /// The runs.
        paths: [PathBuf; 2],
    },
    /// A shard has a task that is none of the run's.
    #[error("{}: tasks.jsonl has {task}, which is not a task of the run (delete its line)", .path.display())]
    Foreign {
        task: TaskId,
        /// The run.
        path: PathBuf,
    },
}

/// The result of a merge.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The summary of the tasks that are done.
    pub summary: Summary,
    /// The tasks that no shard has done, in the order of the suite. Those that the harness or the machine failed count among them.
    pub missing: Vec<TaskId>,
    /// The tasks that several shards have done, all with the same record.
    pub twice: Vec<TaskId>,
    /// The tasks of which the run would have a trace, but the shard has none, and no checksums that tell of it.
    pub untraced: Vec<TaskId>,
}

/// The runs in a folder: itself if it is one, or the shards in it, in order.
///
/// # Errors
/// Returns [`MergeError::Nothing`], or an error of the file system.
pub fn shards_in(dir: &Path) -> Result<Vec<PathBuf>, MergeError> {
    let is_run = |dir: &Path| dir.join("run.json").is_file();
    if is_run(dir) {
        return Ok(vec![dir.to_owned()]);
    }
    let io = |source| StoreError::Io { action: "read directory", path: dir.to_owned(), source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let is_shard = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("shard-"));
        if is_shard && is_run(&path) {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() { Err(MergeError::Nothing(dir.to_owned())) } else { Ok(found) }
}

/// Joins shards of one run into a run in `out`, whose files have the bytes that they would have had if one machine had driven all
/// tasks; only the time of its start is that of the shard that began first. `suite` is the one that they were driven on.
///
/// Shards may be missing, and tasks in them: the run that is made can be resumed.
///
/// # Errors
/// Returns an error if the shards don't belong together, contradict each other, lack a file that they had, or can't be read, or if
/// `out` can't be written.
pub fn merge(shards: &[PathBuf], suite: &Suite, out: &Path) -> Result<Merged, MergeError> {
    let runs = shards.iter().map(|dir| RunReader::open(dir)).collect::<Result<Vec<_>, _>>()?;
    let header = common_header(&runs)?;
    if header.suite.hash != suite.hash() {
        let (suite, found) = (suite.meta().name.clone(), suite.hash());
        return Err(MergeError::OtherSuite { suite, found, recorded: header.suite.hash });
    }
    let selector = header.selector.as_deref().map_or_else(|| Ok(Selector::default()), Selector::parse)?;
    let tasks = selector.select(suite)?;
    let rules = Rules::recorded(&header)
        .map_err(|e| MergeError::Rules { path: runs[0].dir().to_owned(), problem: e.to_string() })?;

    let mut done: BTreeMap<TaskId, Done> = tasks.iter().map(|t| (t.clone(), Done::default())).collect();
    for run in &runs {
        let mut flaw = None;
        run.each_line(|record: TaskRecord, line| {
            if record.outcome != Outcome::HostError {
                flaw = flaw.take().or_else(|| take(&mut done, record, line, run).err());
            }
        })?;
        if let Some(flaw) = flaw {
            return Err(flaw);
        }
    }

    let mut joiner = RunJoiner::new(out, &header)?;
    let (mut records, mut missing, mut twice, mut untraced) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for task in tasks {
        let Some(Done { by: Some((record, line, run)), again }) = done.remove(&task) else {
            missing.push(task);
            continue;
        };
        joiner.add(&task, &line, run)?;
        // Who ended before the first sample has no trace.
        if header.trace != TraceMode::None && record.metrics.is_some() && !run.has_trace(&task)? {
            untraced.push(task.clone());
        }
        records.push(record);
        if again {
            twice.push(task);
        }
    }
    let summary = Summary::new(&header, &rules, &records, Vec::new());
    joiner.finish(&summary)?;
    Ok(Merged { summary, missing, twice, untraced })
}

/// Who has done a task.
#[derive(Default)]
struct Done<'a> {
    by: Option<(TaskRecord, Vec<u8>, &'a RunReader)>,
    again: bool,
}

fn take<'a>(
    done: &mut BTreeMap<TaskId, Done<'a>>,
    record: TaskRecord,
    line: &[u8],
    run: &'a RunReader,
) -> Result<(), MergeError> {
    let Some(entry) = done.get_mut(&record.task) else {
        return Err(MergeError::Foreign { task: record.task, path: run.dir().to_owned() });
    };
    match &entry.by {
        None => entry.by = Some((record, line.to_vec(), run)),
        Some((_, known, _)) if known == line => entry.again = true,
        Some((_, _, first)) => {
            let paths = [first.dir().to_owned(), run.dir().to_owned()];
            return Err(MergeError::Conflict { task: record.task, paths });
        }
    }
    Ok(())
}

/// The description of the run that all shards are of.
fn common_header(runs: &[RunReader]) -> Result<RunHeader, MergeError> {
    let Some(first) = runs.first() else {
        return Err(MergeError::Nothing(PathBuf::new()));
    };
    let mut header = first.header().whole();
    for run in runs {
        if run.header().shard.is_none() {
            return Err(MergeError::NoShard(run.dir().to_owned()));
        }
        let mixed = |(field, first_value, second)| {
            let paths = [first.dir().to_owned(), run.dir().to_owned()];
            MergeError::Mixed { paths, field, first: first_value, second }
        };
        let whole = run.header().whole();
        if let Some(difference) = header.difference(&whole) {
            return Err(mixed(difference));
        }
        let of = |run: &RunReader| run.header().shard.map_or(1, |s| s.of).to_string();
        if of(first) != of(run) {
            return Err(mixed(("shard.of".to_owned(), of(first), of(run))));
        }
        header.started_at = header.started_at.min(whole.started_at);
    }
    Ok(header)
}
