//! Making a submission of a finished run.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

use vb_host::Plugin;
use vb_record::{PluginKind, RUN_SCHEMA, RunHeader, RunReader, ShardHeader, TraceMode};
use vb_report::{Beside, Report, Runs};
use vb_runner::recorded_kind;
use vb_score::{Outcome, Rules, Summary, TaskRecord};
use vb_world::{Suite, TaskId};

use crate::SubmissionError;
use crate::division::{Shipped, division, open_reasons};
use crate::files::{self, MANIFEST, REPORT, RUN, SERIES, TRACE};
use crate::manifest::{Entrant, Manifest, SUBMISSION_SCHEMA, TaskEntry};

/// Replays that are carried along at most.
pub(crate) const REPLAYS: usize = 20;
/// Replays that are carried along if nothing is said.
const OWN_CHOICE: usize = 4;

/// The things that a submission is made of.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    pub suite: &'a Suite,
    pub plugin: &'a Plugin,
    /// The suites, vehicles and soils that may be ranked.
    pub shipped: &'a Shipped,
    pub harness_version: &'a str,
    pub entrant: Entrant,
    /// The tasks whose traces are carried along; `None` means the first task of each outcome, four at most.
    pub replays: Option<Vec<TaskId>>,
}

/// Makes a submission of the run in `run`, in `out`, which must not exist or be empty. The manifest is written last:
/// what a killed process leaves behind is not a submission.
///
/// # Errors
/// Returns an error if the run is not finished, was made by another version of the harness or with another plugin or
/// suite, or something can't be read or written.
pub fn make(run: &Path, out: &Path, request: &Request<'_>) -> Result<Manifest, SubmissionError> {
    request.entrant.check()?;
    let reader = RunReader::open(run)?;
    let header = reader.header();
    fits(run, header, request)?;
    let survey = survey(&reader, request.replays.as_deref())?;
    let header = published(header, &survey.replays);

    files::empty_dir(out)?;
    let own = out.join(RUN);
    fs::create_dir_all(&own).map_err(SubmissionError::write(&own))?;
    let path = own.join("run.json");
    files::write(&path, &files::pretty(&path, &header)?)?;
    let records = copy_records(&reader, &own)?;
    let rules = Rules::recorded(&header)
        .map_err(|e| SubmissionError::damaged(&run.join("run.json"), format!("rules.profile: {e}")))?;
    let summary = Summary::new(&header, &rules, &records, Vec::new());
    let path = own.join("summary.json");
    files::write(&path, &files::pretty(&path, &summary)?)?;
    for task in &survey.replays {
        copy_trace(run, &own, task)?;
    }
    files::write(&out.join(REPORT), report(out)?.as_bytes())?;

    let mut hashes = std::collections::BTreeMap::new();
    for name in files::list(out)?.into_keys() {
        let hash = files::sha256_file(&out.join(&name))?;
        hashes.insert(name, hash);
    }
    let reasons = open_reasons(&header, request.shipped);
    let manifest = Manifest {
        schema: SUBMISSION_SCHEMA,
        entrant: request.entrant.clone(),
        division: division(&header, &reasons),
        open_because: reasons,
        abi: request.plugin.abi().name().to_owned(),
        suite_version: request.suite.meta().version.clone(),
        run: header,
        results: summary.all,
        replays: survey.replays,
        tasks: records.iter().map(|r| (r.task.clone(), TaskEntry::from(r))).collect(),
        files: hashes,
    };
    let path = out.join(MANIFEST);
    files::write(&path, &files::pretty(&path, &manifest)?)?;
    Ok(manifest)
}

/// Whether a run is one of this harness, plugin and suite.
fn fits(run: &Path, header: &RunHeader, request: &Request<'_>) -> Result<(), SubmissionError> {
    let is_fileless = |kind| matches!(kind, PluginKind::Command | PluginKind::Ros);
    if is_fileless(recorded_kind(request.plugin.kind())) || is_fileless(header.plugin.kind) {
        return Err(SubmissionError::NoFile);
    }
    if header.schema != RUN_SCHEMA || header.harness_version != request.harness_version {
        return Err(SubmissionError::Version {
            path: run.to_owned(),
            made: header.harness_version.clone(),
            this: request.harness_version.to_owned(),
        });
    }
    if let Some(ShardHeader { index, of, .. }) = header.shard {
        return Err(SubmissionError::Shard { path: run.to_owned(), index, of });
    }
    let pairs = [
        ("plugin", &header.plugin.sha256, request.plugin.sha256().to_owned()),
        ("suite", &header.suite.hash, request.suite.hash()),
    ];
    for (what, recorded, found) in pairs {
        if *recorded != found {
            return Err(SubmissionError::Other {
                path: run.to_owned(),
                what,
                recorded: recorded.clone(),
                found,
            });
        }
    }
    Ok(())
}

/// The header as everybody may see it: paths are the entrant's own affair.
pub(crate) fn published(header: &RunHeader, replays: &[TaskId]) -> RunHeader {
    let mut header = header.clone();
    header.suite.path.clear();
    header.plugin.path.clear();
    if replays.is_empty() {
        header.trace = TraceMode::None;
    }
    header
}

struct Survey {
    replays: Vec<TaskId>,
}

/// Checks that a submission can carry the replays of all these tasks.
pub fn check_replays(wanted: &[TaskId]) -> Result<(), SubmissionError> {
    match wanted {
        [first, ..] if wanted.len() > REPLAYS => Err(SubmissionError::Replay {
            task: first.clone(),
            problem: format!(
                "one of {} tasks; a submission contains at most {REPLAYS} replays",
                wanted.len()
            ),
        }),
        _ => Ok(()),
    }
}

/// Looks through a run: whether it is finished, and which tasks are to be shown.
fn survey(reader: &RunReader, wanted: Option<&[TaskId]>) -> Result<Survey, SubmissionError> {
    let header = reader.header();
    let (mut done, mut lost) = (0, None);
    let mut names = BTreeSet::new();
    let mut first: std::collections::BTreeMap<Outcome, TaskId> = std::collections::BTreeMap::new();
    reader.each_record(|r: TaskRecord| {
        if r.outcome == Outcome::HostError {
            return;
        }
        done += 1;
        if wanted.is_some_and(|w| w.contains(&r.task)) {
            names.insert(r.task.clone());
        }
        match reader.has_trace(&r.task) {
            Ok(true) => {
                let best = first.entry(r.outcome).or_insert_with(|| r.task.clone());
                if r.task < *best {
                    *best = r.task;
                }
            }
            Ok(false) => {}
            Err(e) => lost = Some(e),
        }
    })?;
    if let Some(e) = lost {
        return Err(e.into());
    }
    if done != header.tasks {
        return Err(SubmissionError::Unfinished {
            path: reader.dir().to_owned(),
            missing: header.tasks.saturating_sub(done),
            tasks: header.tasks,
        });
    }
    let Some(wanted) = wanted else {
        let mut replays: Vec<TaskId> = first.into_values().take(OWN_CHOICE).collect();
        replays.sort();
        return Ok(Survey { replays });
    };
    check_replays(wanted)?;
    let fail = |task: &TaskId, problem: String| Err(SubmissionError::Replay { task: task.clone(), problem });
    for task in wanted {
        if !names.contains(task) {
            return fail(task, "not a task of the run".into());
        }
        if !reader.has_trace(task)? {
            return fail(task, "the run has no trace of it (run with --trace 10hz)".into());
        }
    }
    Ok(Survey { replays: names.into_iter().collect() })
}

/// Copies the records, and returns what summaries need of them.
fn copy_records(reader: &RunReader, own: &Path) -> Result<Vec<TaskRecord>, SubmissionError> {
    let path = own.join("tasks.jsonl");
    let fail = SubmissionError::write;
    let mut file = BufWriter::new(File::create(&path).map_err(fail(&path))?);
    let mut records = Vec::new();
    let mut failure = None;
    reader.each_record(|r: TaskRecord| {
        let written =
            serde_json::to_vec(&r).map_err(|e| SubmissionError::damaged(&path, e)).and_then(|mut line| {
                line.push(b'\n');
                file.write_all(&line).map_err(fail(&path))
            });
        if let Err(e) = written {
            failure.get_or_insert(e);
        }
        records.push(slim(r));
    })?;
    if let Some(e) = failure {
        return Err(e);
    }
    file.flush().map_err(fail(&path))?;
    Ok(records)
}

/// A record without its texts, which may be long and which no figure needs.
pub(crate) fn slim(mut record: TaskRecord) -> TaskRecord {
    (record.log, record.backtrace) = (Vec::new(), Vec::new());
    (record.reason, record.evidence) = (String::new(), String::new());
    record
}

/// Names of a task's files in a run.
pub(crate) fn trace_files(task: &TaskId) -> [String; 2] {
    [format!("traces/{task}.parquet"), format!("traces/{task}.debug.parquet")]
}

fn copy_trace(run: &Path, own: &Path, task: &TaskId) -> Result<(), SubmissionError> {
    let [trace, series] = trace_files(task);
    files::write(&own.join(&trace), &files::read(&run.join(&trace), TRACE)?)?;
    // Long ones are left out: a submission stays small.
    let from = run.join(&series);
    if from.metadata().is_ok_and(|m| m.len() <= SERIES) {
        files::write(&own.join(&series), &files::read(&from, SERIES)?)?;
    }
    Ok(())
}

/// The report of the run in a submission. It is the same wherever the submission lies.
pub(crate) fn report(submission: &Path) -> Result<String, SubmissionError> {
    let mut runs = Runs::read(&[submission.join(RUN)])?;
    for run in &mut runs.runs {
        run.dir = RUN.into();
    }
    Ok(Report::new(runs).page(&Beside::default()))
}
