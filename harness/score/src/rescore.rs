//! Scoring a finished run again from its traces.

use std::path::{Path, PathBuf};

use vb_record::{RunReader, StoreError, TraceMode};

use crate::{Fault, Outcome, Rules, Scorer, Summary, TaskGeometry, TaskRecord};

/// The result of a run under other rules, or under its own again.
#[derive(Clone, Debug, PartialEq)]
pub struct Rescored {
    /// The summary of the run under these rules.
    pub summary: Summary,
    /// The tasks that could be decided, by name.
    pub records: Vec<TaskRecord>,
    /// The time between the samples that were looked at, s.
    pub resolution_s: f64,
    /// Whether these are all samples that the rules saw when the run was made. If not, verdicts and measures are only
    /// as good as the resolution.
    pub exact: bool,
}

/// The reason why a run can't be scored again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RescoreError {
    /// The run can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The run kept no traces.
    #[error("run {} has no traces: it was made with --trace none (run it again with --trace full)", .0.display())]
    NoTraces(PathBuf),
}

/// Scores the run in `dir` again under `rules`, without simulating.
///
/// With full traces and the run's own rules, verdicts and measures come out as they were, bit for bit. A trace ends
/// where the run's own rules decided; where that is too early for `rules` to decide, the task is undecided. Trials
/// that ended by a fault of planner or simulation, and were not decided before, keep that outcome. All measures are of
/// the samples in the traces, so that every task weighs in the pooled means as it does in the run.
///
/// # Errors
/// Returns [`RescoreError`], which says what is wrong.
pub fn rescore(dir: &Path, rules: &Rules) -> Result<Rescored, RescoreError> {
    let run = RunReader::open(dir)?;
    let header = run.header();
    let Some(stride) = header.trace.stride() else { return Err(RescoreError::NoTraces(dir.to_owned())) };
    let same_rules = rules.hash() == header.rules.hash;
    let mut records: Vec<TaskRecord> = run.records()?;
    records.sort_by(|a, b| a.task.cmp(&b.task));
    let mut decided = Vec::with_capacity(records.len());
    let mut undecided = Vec::new();
    for mut record in records {
        // Whatever the trace holds, the trial didn't take place as it should have.
        if record.outcome == Outcome::HostError {
            decided.push(record);
            continue;
        }
        let fault = match record.outcome {
            Outcome::PlannerError => Some(Fault::Planner),
            Outcome::SimError => Some(Fault::Simulation),
            _ => None,
        };
        // A planner that failed before the first sample left nothing to judge.
        if fault.is_some() && record.metrics.is_none() && !run.has_trace(&record.task)? {
            decided.push(record);
            continue;
        }
        let trace = run.trace(&record.task)?;
        let mut scorer = Scorer::new(rules, &TaskGeometry::from(&trace.meta));
        let found = trace.samples.iter().any(|sample| scorer.push(sample).is_some());
        let metrics = scorer.metrics();
        let score = match fault {
            Some(fault) if !found => Some(scorer.fail(fault, record.reason.clone())),
            _ => scorer.finish(),
        };
        match score {
            Some(score) => {
                record.set_score(score);
                decided.push(record);
            }
            // Thinned samples may miss by a hair what the same rules saw at full resolution, so the verdict stands. The
            // measures don't: they are of ten times the samples, and would weigh ten times as much in the pooled means.
            None if same_rules && header.trace == TraceMode::TenHz => {
                record.metrics = metrics;
                record.judge();
                decided.push(record);
            }
            None => undecided.push(record.task),
        }
    }
    Ok(Rescored {
        summary: Summary::new(header, rules, &decided, undecided),
        records: decided,
        resolution_s: header.sample_period * stride as f64,
        exact: header.trace == TraceMode::Full,
    })
}
