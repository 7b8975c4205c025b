//! Holding a submission against itself and against what it says it was made with.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use vb_host::Plugin;
use vb_record::{RUN_SCHEMA, RunHeader, TraceMode, differences};
use vb_score::{Outcome, Summary, TaskRecord};
use vb_sense::Profile;
use vb_sim::{SAMPLE_PERIOD, Soils};
use vb_vehicle::Vehicle;
use vb_world::{Selector, Suite, TaskId, WorldInfo};

use crate::SubmissionError;
use crate::division::{Shipped, division, open_reasons};
use crate::files::{self, DOCUMENT, HOLDOUT, MANIFEST, PAGE, REPORT, RUN, SMALL, VERDICT};
use crate::make::{REPLAYS, published, report, slim, trace_files};
use crate::manifest::{Manifest, SUBMISSION_SCHEMA, TaskEntry};
use crate::verdict::{Check, DIFFERENCES, Finding, Findings};

/// Of a document that says the same, but in other bytes.
const UNLIKE_OURS: &str =
    "differs from the format of `submit`: a duplicate or unknown field, or another form";

const MISSING: &str = "is missing";
/// The beginning of what is said of a file above its limit.
const TOO_LARGE: &str = "is larger than";

/// What is said of a file above its limit, both in bytes.
pub(crate) fn too_large(size: u64, limit: u64) -> String {
    format!("{TOO_LARGE} its limit: {size} bytes, at most {limit}")
}

/// Lines of `tasks.jsonl` that are looked at beyond the number of tasks: enough findings for a verdict.
const LINES_MORE: usize = Findings::MOST;

/// A submission on disk.
#[derive(Clone, Debug)]
pub struct Submission {
    dir: PathBuf,
    manifest: Manifest,
    bytes: Vec<u8>,
}

/// The things that a submission says it was made with, as they are at hand. The plugin itself is loaded, and compiled,
/// only where all else is as it should be ([`verify`](crate::verify)).
#[derive(Clone, Debug)]
pub struct Expected<'a> {
    pub suite: &'a Suite,
    /// The SHA-256 of the plugin's file, hexadecimal.
    pub plugin_sha256: &'a str,
    pub vehicle: &'a Vehicle,
    pub soils: &'a Soils,
    pub perception: &'a Profile,
    /// The suites, vehicles and soils that may be ranked.
    pub shipped: &'a Shipped,
    pub harness_version: &'a str,
}

impl Submission {
    /// Reads the manifest of the submission in `dir`.
    ///
    /// # Errors
    /// Returns an error if there is no manifest, or it can't be read or is of a newer version.
    pub fn open(dir: &Path) -> Result<Self, SubmissionError> {
        let path = dir.join(MANIFEST);
        if !path.exists() {
            return Err(SubmissionError::NoSubmission(dir.to_owned()));
        }
        let (manifest, bytes) = files::read_json(&path, DOCUMENT, SUBMISSION_SCHEMA, |bytes| {
            // Each task has an entry of its own, of known fields. The rest is a page of text.
            if files::length_without(bytes, "tasks") as u64 > SMALL {
                let what = "a manifest without tasks, in bytes,";
                return Err(SubmissionError::TooLarge { path: path.clone(), what, limit: SMALL });
            }
            Ok(())
        })?;
        Ok(Self { dir: dir.to_owned(), manifest, bytes })
    }

    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    #[must_use]
    pub fn into_manifest(self) -> Manifest {
        self.manifest
    }

    /// The SHA-256 of the manifest's file.
    #[must_use]
    pub fn sha256(&self) -> String {
        files::sha256(&self.bytes)
    }

    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    #[must_use]
    pub fn run_dir(&self) -> PathBuf {
        self.dir.join(RUN)
    }

    /// The files that are not as the manifest says, or that are there and shouldn't be.
    pub(crate) fn check_files(&self) -> Result<Findings, SubmissionError> {
        let mut found = Findings::default();
        let mut there = files::list(&self.dir)?;
        for own in [MANIFEST, VERDICT, HOLDOUT] {
            there.remove(own);
        }
        let mut wanted: BTreeSet<String> =
            ["run.json", "tasks.jsonl", "summary.json"].map(|f| format!("{RUN}/{f}")).into();
        wanted.insert(REPORT.to_owned());
        let mut allowed = wanted.clone();
        for task in self.manifest.replays.iter().take(REPLAYS) {
            let [trace, series] = trace_files(task).map(|f| format!("{RUN}/{f}"));
            wanted.insert(trace.clone());
            allowed.extend([trace, series]);
        }
        for name in wanted.iter().filter(|n| !there.contains_key(*n)) {
            found.push(Finding::new(Check::Files, name, MISSING));
        }
        for (name, size) in &there {
            let limit = files::limit(name);
            if !allowed.contains(name) {
                found.push(Finding::new(Check::Files, name, "does not belong to the submission"));
            } else if *size > limit {
                found.push(Finding::new(Check::Files, name, too_large(*size, limit)));
            } else if let Some(stated) = self.manifest.files.get(name) {
                let hash = files::sha256_file(&self.dir.join(name))?;
                if hash != *stated {
                    found.push(Finding::new(
                        Check::Files,
                        name,
                        format!("its SHA-256 is {hash}, not {stated}"),
                    ));
                }
            } else {
                found.push(Finding::new(Check::Files, name, "is not in the manifest"));
            }
        }
        for name in self.manifest.files.keys().filter(|n| !there.contains_key(*n) && !wanted.contains(*n)) {
            found.push(Finding::new(Check::Files, name, "is in the manifest, but missing"));
        }
        Ok(found)
    }
}

/// Everything that can be checked without loading the plugin, and the tasks.
pub(crate) fn check(
    submission: &Submission,
    expected: &Expected<'_>,
) -> Result<(Findings, Vec<TaskId>), SubmissionError> {
    let m = &submission.manifest;
    let mut found = submission.check_files()?;
    // What is missing can't be read, and what is too large isn't.
    if found.iter().any(|f| f.text == MISSING || f.text.starts_with(TOO_LARGE)) {
        return Ok((found, Vec::new()));
    }
    // Only now: later versions may write an older manifest with a field more.
    if files::pretty(Path::new(MANIFEST), m)? != submission.bytes {
        found.push(Finding::new(Check::Files, MANIFEST, UNLIKE_OURS));
    }
    check_run(submission, &mut found)?;
    check_suite(m, expected.suite, &mut found);
    same(
        &mut found,
        Check::Plugin,
        "run.plugin.sha256",
        m.run.plugin.sha256.as_str(),
        expected.plugin_sha256,
    );
    check_vehicle(m, expected, &mut found);
    let rules = m.rules();
    match &rules {
        Err(e) => found.push(Finding::new(Check::Rules, "run.rules", e)),
        Ok(rules) => {
            same(&mut found, Check::Rules, "run.rules.hash", &m.run.rules.hash, &rules.hash());
            same(&mut found, Check::Rules, "run.rules.name", &m.run.rules.name, &rules.name);
            for d in differences(&m.run.rules.profile, rules, DIFFERENCES) {
                let text = format!("{}, not {}", d.a, d.b);
                found.push(Finding::new(Check::Rules, format!("run.rules.profile.{}", d.path), text));
            }
        }
    }
    if let Err(e) = m.limits() {
        found.push(Finding::new(Check::Limits, "run.limits", e));
    }
    let records = check_tasks(submission, expected.suite, &mut found)?;
    if let Ok(rules) = &rules {
        let summary = Summary::new(&m.run, rules, &records, Vec::new());
        check_summary(submission, &summary, &mut found)?;
    }
    check_division(m, expected.shipped, &mut found);
    // The page is of records that were found to be records.
    if found.is_empty()
        && files::read(&submission.dir.join(REPORT), PAGE)? != report(&submission.dir)?.as_bytes()
    {
        found.push(Finding::new(Check::Report, REPORT, "differs from the report of the records"));
    }
    Ok((found, records.into_iter().map(|r| r.task).collect()))
}

/// Notes a field that is not what it should be.
fn same<T: PartialEq + std::fmt::Debug + ?Sized>(
    found: &mut Findings,
    check: Check,
    field: &str,
    is: &T,
    should: &T,
) {
    if is != should {
        found.push(Finding::new(check, format!("{MANIFEST}: {field}"), format!("is {is:?}, not {should:?}")));
    }
}

/// `run.json` and what of the header can be judged by itself.
fn check_run(submission: &Submission, found: &mut Findings) -> Result<(), SubmissionError> {
    let m = &submission.manifest;
    let path = submission.run_dir().join("run.json");
    let bytes = files::read(&path, SMALL)?;
    let place = |field: &str| format!("{RUN}/run.json: {field}");
    match serde_json::from_slice::<RunHeader>(&bytes) {
        Err(e) => found.push(Finding::new(Check::Run, format!("{RUN}/run.json"), e)),
        Ok(header) => {
            let differ = differences(&header, &m.run, DIFFERENCES);
            for d in &differ {
                found.push(Finding::new(
                    Check::Run,
                    place(&d.path),
                    format!("is {}, the manifest has {}", d.a, d.b),
                ));
            }
            if differ.is_empty() && files::pretty(&path, &header)? != bytes {
                found.push(Finding::new(Check::Run, format!("{RUN}/run.json"), UNLIKE_OURS));
            }
        }
    }
    same(found, Check::Run, "run.schema", &m.run.schema, &RUN_SCHEMA);
    same(found, Check::Run, "run.sample_period", &m.run.sample_period, &SAMPLE_PERIOD);
    let public = published(&m.run, &m.replays);
    same(found, Check::Run, "run.suite.path", &m.run.suite.path, &public.suite.path);
    same(found, Check::Run, "run.plugin.path", &m.run.plugin.path, &public.plugin.path);
    let ranges = [
        ("scale", m.run.scale, 0.01, 10.0),
        ("time_step", m.run.time_step, 1e-4, 5e-3),
        ("soil_resolution", m.run.soil_resolution, 0.01, 0.5),
    ];
    for (field, value, low, high) in ranges {
        if !(low..=high).contains(&value) {
            let text = format!("{value} is not between {low} and {high}");
            found.push(Finding::new(Check::Run, format!("{MANIFEST}: run.{field}"), text));
        }
    }
    let steps = SAMPLE_PERIOD / m.run.time_step;
    if (steps.round() * m.run.time_step - SAMPLE_PERIOD).abs() >= 1e-9 {
        let text = format!("{} s does not divide {SAMPLE_PERIOD} s", m.run.time_step);
        found.push(Finding::new(Check::Run, format!("{MANIFEST}: run.time_step"), text));
    }
    // Without traces their mode says nothing; with them, they must be of some.
    if m.replays.is_empty() != (m.run.trace == TraceMode::None) {
        let text = format!("{}, with {} replays", m.run.trace.name(), m.replays.len());
        found.push(Finding::new(Check::Run, format!("{MANIFEST}: run.trace"), text));
    }
    Ok(())
}

fn check_suite(m: &Manifest, suite: &Suite, found: &mut Findings) {
    same(found, Check::Suite, "run.suite.hash", &m.run.suite.hash, &suite.hash());
    same(found, Check::Suite, "run.suite.name", &m.run.suite.name, &suite.meta().name);
    same(found, Check::Suite, "run.suite.tasks", &m.run.suite.tasks, &(suite.task_count() as u64));
    same(found, Check::Suite, "suite_version", &m.suite_version, &suite.meta().version);
}

/// What the plugin says of itself.
pub(crate) fn check_plugin(m: &Manifest, plugin: &Plugin, perception: &Profile, found: &mut Findings) {
    let p = &m.run.plugin;
    same(found, Check::Plugin, "run.plugin.sha256", p.sha256.as_str(), plugin.sha256());
    same(found, Check::Plugin, "run.plugin.name", &p.name, &plugin.metadata().name);
    same(found, Check::Plugin, "run.plugin.version", &p.version, &plugin.metadata().version);
    same(found, Check::Plugin, "run.plugin.kind", p.kind.name(), plugin.kind().name());
    same(
        found,
        Check::Plugin,
        "run.plugin.control_period",
        &p.control_period,
        &plugin.metadata().control_period,
    );
    let eligible = plugin.kind().is_eligible();
    let sensors: Vec<_> = perception.sensors_of(plugin.metadata()).iter().map(ToString::to_string).collect();
    same(found, Check::Plugin, "run.plugin.sensors", &p.sensors.join(", "), &sensors.join(", "));
    same(found, Check::Plugin, "run.plugin.eligible_for_ranking", &p.eligible_for_ranking, &eligible);
    same(found, Check::Plugin, "run.plugin.sandbox", &p.sandbox.is_some(), &plugin.sandbox().is_some());
    same(found, Check::Plugin, "abi", m.abi.as_str(), plugin.abi().name());
    let params: Vec<_> = m.run.params.iter().map(|(k, v)| (k.clone(), v.clone())).collect();
    if let Err(e) = plugin.params(&params) {
        found.push(Finding::new(Check::Plugin, format!("{MANIFEST}: run.params"), e));
    }
}

fn check_vehicle(m: &Manifest, expected: &Expected<'_>, found: &mut Findings) {
    let (vehicle, soils) = (expected.vehicle, expected.soils);
    same(found, Check::Vehicle, "run.vehicle.hash", &m.run.vehicle.hash, &vehicle.hash);
    same(found, Check::Vehicle, "run.vehicle.name", &m.run.vehicle.name, &vehicle.spec.name);
    same(
        found,
        Check::Perception,
        "run.perception.hash",
        m.run.perception.hash.as_str(),
        expected.perception.sha256(),
    );
    same(
        found,
        Check::Perception,
        "run.perception.name",
        m.run.perception.name.as_str(),
        expected.perception.name(),
    );
    same(found, Check::Vehicle, "run.soils.hash", &m.run.soils.hash, &soils.hash);
    same(found, Check::Vehicle, "run.soils.name", &m.run.soils.name, &soils.set.name);
}

/// The records line by line: whole, of the suite's tasks, each once, as the manifest has them. Returns them without their
/// texts.
fn check_tasks(
    submission: &Submission,
    suite: &Suite,
    found: &mut Findings,
) -> Result<Vec<TaskRecord>, SubmissionError> {
    let m = &submission.manifest;
    let worlds: BTreeMap<&str, &WorldInfo> = suite.worlds().iter().map(|w| (w.id.as_str(), w)).collect();
    let mut wanted: BTreeSet<TaskId> = match &m.run.selector {
        None => suite.worlds().iter().flat_map(WorldInfo::task_ids).collect(),
        Some(text) => match Selector::parse(text).and_then(|s| s.select(suite)) {
            Ok(tasks) => tasks.into_iter().collect(),
            Err(e) => {
                found.push(Finding::new(Check::Tasks, format!("{MANIFEST}: run.selector"), e));
                BTreeSet::new()
            }
        },
    };
    same(found, Check::Tasks, "run.tasks", &m.run.tasks, &(wanted.len() as u64));
    let file = format!("{RUN}/tasks.jsonl");
    let mut records = Vec::new();
    let mut seen = BTreeSet::new();
    let lines = wanted.len().saturating_add(LINES_MORE);
    files::each_line(&submission.dir.join(&file), |number, line, ended| {
        let mut note = |place: String, text: String| found.push(Finding::new(Check::Tasks, place, text));
        if number > lines {
            note(file.clone(), format!("has more than {lines} lines; further lines are not read"));
            return Ok(ControlFlow::Break(()));
        }
        let record: TaskRecord = match serde_json::from_slice(line) {
            Ok(record) => record,
            Err(e) => {
                note(format!("{file}: line {number}"), e.to_string());
                return Ok(ControlFlow::Continue(()));
            }
        };
        let place = format!("{file}: {}", record.task);
        if !ended || serde_json::to_vec(&record).ok().as_deref() != Some(line) {
            note(place.clone(), format!("line {number} differs from the format of `submit`"));
        }
        if !seen.insert(record.task.clone()) {
            note(place, "is a duplicate".into());
            return Ok(ControlFlow::Continue(()));
        }
        if !wanted.remove(&record.task) {
            note(place, "is not a task of the run".into());
            return Ok(ControlFlow::Continue(()));
        }
        if let Some(w) = worlds.get(record.task.world()) {
            let labels = (w.id.as_str(), w.elevation, w.terrain, w.density);
            if (record.world.as_str(), record.elevation, record.terrain, record.density) != labels {
                note(place.clone(), "its world or labels differ from those of the suite".into());
            }
        }
        if record.flags != record.judged() {
            note(place.clone(), "its flags do not follow from its outcome, metrics and ride".into());
        }
        if record.outcome == Outcome::HostError {
            note(place.clone(), "failed because of the machine, so it is not a result".into());
        }
        let entry = TaskEntry::from(&record);
        match m.tasks.get(&record.task) {
            Some(stated) => {
                for d in differences(stated, &entry, DIFFERENCES) {
                    note(
                        format!("{MANIFEST}: tasks.{}.{}", record.task, d.path),
                        format!("is {}, the record has {}", d.a, d.b),
                    );
                }
            }
            None => note(format!("{MANIFEST}: tasks.{}", record.task), "is missing".into()),
        }
        records.push(slim(record));
        Ok(ControlFlow::Continue(()))
    })?;
    for task in &wanted {
        found.push(Finding::new(Check::Tasks, format!("{file}: {task}"), "is missing"));
    }
    for task in m.tasks.keys().filter(|t| !seen.contains(*t)) {
        found.push_with(|| Finding::new(Check::Tasks, format!("{MANIFEST}: tasks.{task}"), "has no record"));
    }
    if m.replays.len() > REPLAYS {
        let text = format!("are {}; at most {REPLAYS} are allowed", m.replays.len());
        found.push(Finding::new(Check::Tasks, format!("{MANIFEST}: replays"), text));
    }
    let mut last: Option<&TaskId> = None;
    for task in &m.replays {
        if !seen.contains(task) || last.is_some_and(|l| l >= task) {
            found.push_with(|| {
                let text = format!("{task} is not a task of the run, or is out of order");
                Finding::new(Check::Tasks, format!("{MANIFEST}: replays"), text)
            });
        }
        last = Some(task);
    }
    Ok(records)
}

fn check_summary(
    submission: &Submission,
    summary: &Summary,
    found: &mut Findings,
) -> Result<(), SubmissionError> {
    for d in differences(&submission.manifest.results, &summary.all, DIFFERENCES) {
        let text = format!("is {}; the records result in {}", d.a, d.b);
        found.push(Finding::new(Check::Summary, format!("{MANIFEST}: results.{}", d.path), text));
    }
    let path = submission.run_dir().join("summary.json");
    let bytes = files::read(&path, DOCUMENT)?;
    let ours = files::pretty(&path, summary)?;
    if bytes == ours {
        return Ok(());
    }
    let place = format!("{RUN}/summary.json");
    if bytes.len() as u64 > SMALL.saturating_add(2 * ours.len() as u64) {
        let text = format!("has {} bytes; the records result in {}", bytes.len(), ours.len());
        found.push(Finding::new(Check::Summary, place, text));
        return Ok(());
    }
    match serde_json::from_slice::<serde_json::Value>(&bytes) {
        Err(e) => found.push(Finding::new(Check::Summary, place, e)),
        Ok(stated) => {
            let differ = differences(&stated, summary, DIFFERENCES);
            for d in &differ {
                let text = format!("is {}; the records result in {}", d.a, d.b);
                found.push(Finding::new(Check::Summary, format!("{place}: {}", d.path), text));
            }
            if differ.is_empty() {
                found.push(Finding::new(Check::Summary, place, "differs from the format of `submit`"));
            }
        }
    }
    Ok(())
}

fn check_division(m: &Manifest, shipped: &Shipped, found: &mut Findings) {
    let reasons = open_reasons(&m.run, shipped);
    same(found, Check::Division, "division", m.division.name(), division(&m.run, &reasons).name());
    for d in differences(&m.open_because, &reasons, DIFFERENCES) {
        let text = format!("is {}; the rules result in {}", d.a, d.b);
        found.push(Finding::new(Check::Division, format!("{MANIFEST}: open_because.{}", d.path), text));
    }
}
