//! Driving tasks again.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use vb_host::{Limits, LoadError, Plugin, PluginKind};
use vb_record::{TraceMode, differences};
use vb_runner::{Event, RunConfig};
use vb_score::{Outcome, Rules, TaskRecord};
use vb_world::TaskId;

use crate::SubmissionError;
use crate::check::{Expected, Submission, check, check_plugin, too_large};
use crate::division::{division, open_reasons};
use crate::files::{self, MANIFEST, RUN, SERIES, TRACE};
use crate::make::trace_files;
use crate::sample::draw;
use crate::verdict::{Check, DIFFERENCES, Finding, Findings, SampleTaken, VERIFICATION_SCHEMA, Verification};

/// The choice of the tasks that are driven again, and how they are.
#[derive(Clone, Debug)]
pub struct Sampling {
    /// The number of tasks and the seed that draws them; `None` means all tasks. The tasks with traces come on top.
    pub draw: Option<(usize, u64)>,
    /// The number of worker threads.
    pub jobs: usize,
}

/// Verifies a submission. It holds the submission against itself and `expected`; if nothing is found, it `load`s the
/// plugin with the submission's limits and holds it against what it says about itself; and if still nothing is found,
/// it drives a sample of the tasks again and compares every record, trajectory hash and trace. `ended` hears of each
/// task (done, of how many); setting `cancel` stops the verification.
///
/// # Errors
/// Returns an error if the submission can't be read, was made by another version of the harness, or the machine fails.
/// What isn't as it should be is not an error, but is in the verdict.
pub fn verify(
    submission: &Submission,
    expected: &Expected<'_>,
    load: &dyn Fn(&Limits) -> Result<Plugin, LoadError>,
    sampling: &Sampling,
    ended: &mut dyn FnMut(usize, usize, &TaskRecord),
    cancel: &AtomicBool,
) -> Result<Verification, SubmissionError> {
    let m = submission.manifest();
    if m.run.harness_version != expected.harness_version {
        return Err(SubmissionError::Version {
            path: submission.dir().to_owned(),
            made: m.run.harness_version.clone(),
            this: expected.harness_version.to_owned(),
        });
    }
    let (mut findings, mut tasks) = check(submission, expected)?;
    tasks.sort();
    let checks = Check::ALL.to_vec();
    let mut verdict = Verification {
        schema: VERIFICATION_SCHEMA,
        harness_version: expected.harness_version.to_owned(),
        verified: false,
        submission_sha256: submission.sha256(),
        plugin_sha256: expected.plugin_sha256.to_owned(),
        suite_hash: expected.suite.hash(),
        division: division(&m.run, &open_reasons(&m.run, expected.shipped)),
        checks,
        findings: Vec::new(),
        more_findings: 0,
        sample: None,
    };
    let plugin = match (findings.is_empty(), m.limits()) {
        (true, Ok(limits)) => Some(load(&limits)?),
        _ => None,
    };
    if let Some(plugin) = &plugin {
        // A file that was replaced between its hash and its loading is another plugin, too.
        if plugin.sha256() != expected.plugin_sha256 {
            findings.push(Finding::new(
                Check::Plugin,
                MANIFEST,
                "the plugin file changed during the verification",
            ));
        }
        check_plugin(m, plugin, expected.perception, &mut findings);
    }
    if let (true, Some(plugin), Ok(rules)) = (findings.is_empty(), &plugin, m.rules()) {
        let sample: BTreeSet<TaskId> = match sampling.draw {
            None => tasks.iter().cloned().collect(),
            Some((count, seed)) => draw(&tasks, count, seed, &m.replays),
        };
        let again = Again { submission, expected, plugin, rules, jobs: sampling.jobs };
        findings = again.drive(&sample, ended, cancel)?;
        verdict.sample = Some(SampleTaken {
            seed: sampling.draw.map(|(_, seed)| seed),
            of: tasks.len() as u64,
            tasks: sample.into_iter().collect(),
        });
    } else {
        verdict.checks.pop();
    }
    verdict.verified = findings.is_empty();
    (verdict.findings, verdict.more_findings) = findings.into_parts();
    Ok(verdict)
}

struct Again<'a> {
    submission: &'a Submission,
    expected: &'a Expected<'a>,
    plugin: &'a Plugin,
    rules: Rules,
    jobs: usize,
}

impl Again<'_> {
    fn drive(
        &self,
        sample: &BTreeSet<TaskId>,
        ended: &mut dyn FnMut(usize, usize, &TaskRecord),
        cancel: &AtomicBool,
    ) -> Result<Findings, SubmissionError> {
        let scratch = tempfile::tempdir().map_err(SubmissionError::write(&std::env::temp_dir()))?;
        let m = self.submission.manifest();
        let (shown, plain): (Vec<_>, Vec<_>) = sample.iter().cloned().partition(|t| m.replays.contains(t));
        let mut records = BTreeMap::new();
        // Of tasks that nobody sees no traces are needed.
        for (tasks, trace, name) in [(shown, m.run.trace, "shown"), (plain, TraceMode::None, "plain")] {
            if tasks.is_empty() {
                continue;
            }
            let config = self.config(tasks, trace, &scratch.path().join(name));
            let mut tell = |event| {
                if let Event::TaskEnded(record) = event {
                    records.insert(record.task.clone(), *record);
                    if let Some(record) = records.last_key_value().map(|(_, r)| r) {
                        ended(records.len(), sample.len(), record);
                    }
                }
            };
            let report = vb_runner::run(&config, &mut tell, cancel)?;
            if report.interrupted {
                return Err(SubmissionError::Interrupted);
            }
        }
        let failed: Vec<_> = records.values().filter(|r| r.outcome == Outcome::HostError).collect();
        if let Some(first) = failed.first() {
            return Err(SubmissionError::Machine { failed: failed.len(), example: first.task.clone() });
        }
        let mut found = Findings::default();
        self.compare_records(&records, &mut found)?;
        for task in &m.replays {
            self.compare_traces(&scratch.path().join("shown"), task, &mut found)?;
        }
        Ok(found)
    }

    fn config(&self, tasks: Vec<TaskId>, trace: TraceMode, out: &Path) -> RunConfig {
        let (m, e) = (self.submission.manifest(), self.expected);
        RunConfig {
            suite: e.suite.clone(),
            tasks,
            selector: m.run.selector.clone(),
            shard: None,
            plugin: self.plugin.clone(),
            plugin_path: Default::default(),
            params: m.run.params.iter().map(|(k, v)| (k.clone(), v.clone())).collect(),
            vehicle: e.vehicle.clone(),
            soils: e.soils.clone(),
            perception: e.perception.clone(),
            rules: self.rules.clone(),
            time_step: m.run.time_step,
            scale: m.run.scale,
            seed: m.run.seed,
            jobs: self.jobs,
            trace,
            logs: m.run.logs,
            out: out.to_owned(),
            resume: false,
            // What a submission says of its tasks is held against all of them.
            keep_going: true,
            started_at: String::new(),
            harness_version: e.harness_version.to_owned(),
            harness_commit: m.run.harness_commit.clone(),
        }
    }

    fn compare_records(
        &self,
        again: &BTreeMap<TaskId, TaskRecord>,
        found: &mut Findings,
    ) -> Result<(), SubmissionError> {
        let file = format!("{RUN}/tasks.jsonl");
        let path = self.submission.dir().join(&file);
        files::each_line(&path, |_, line, _| {
            let stated: TaskRecord =
                serde_json::from_slice(line).map_err(|e| SubmissionError::damaged(&path, e))?;
            let Some(driven) = again.get(&stated.task) else { return Ok(ControlFlow::Continue(())) };
            let (stated, driven) = (self.comparable(stated), self.comparable(driven.clone()));
            for d in differences(&stated, &driven, DIFFERENCES) {
                let place = format!("{file}: {}: {}", stated.task, d.path);
                found.push(Finding::new(
                    Check::Rerun,
                    place,
                    format!("is {}; the re-run results in {}", d.a, d.b),
                ));
            }
            Ok(ControlFlow::Continue(()))
        })
    }

    /// What of a record must come out again. The log of a native planner may tell the time, and the lines that it prints and
    /// those that it logs come in any order: where nothing but the rules ended the task, it is information.
    fn comparable(&self, mut record: TaskRecord) -> TaskRecord {
        if self.plugin.kind() == PluginKind::Native && record.fault.is_none() {
            record.log.clear();
        }
        record
    }

    fn compare_traces(
        &self,
        again: &Path,
        task: &TaskId,
        found: &mut Findings,
    ) -> Result<(), SubmissionError> {
        for (name, limit) in trace_files(task).into_iter().zip([TRACE, SERIES]) {
            let size = |path: &Path| match path.symlink_metadata() {
                Ok(meta) => Ok(Some(meta.len())),
                Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
                Err(e) => Err(SubmissionError::read(path)(e)),
            };
            let place = || format!("{RUN}/{name}");
            let theirs = self.submission.run_dir().join(&name);
            let stated = match size(&theirs)? {
                Some(size) if size > limit => {
                    found.push(Finding::new(Check::Rerun, place(), too_large(size, limit)));
                    continue;
                }
                Some(_) => Some(files::read(&theirs, limit)?),
                None => None,
            };
            // What is above the limit is left out of a submission.
            let driven = again.join(&name);
            let driven = match size(&driven)? {
                Some(size) if size <= limit => Some(files::read(&driven, limit)?),
                _ => None,
            };
            if stated != driven {
                let text = match driven {
                    Some(_) => "differs from the re-run of the task",
                    None => "exists, but the re-run of the task has none, or one that exceeds the size limit",
                };
                found.push(Finding::new(Check::Rerun, place(), text));
            }
        }
        Ok(())
    }
}
