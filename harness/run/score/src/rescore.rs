//! Scoring a finished run again from its traces.

use std::path::{Path, PathBuf};

use vb_record::{RunReader, StoreError, TraceMode};

use crate::scorer::{TIPPED, judged_again};
use crate::{
    Conditions, Fault, Outcome, RollTime, Rules, Scorer, Summary, TaskGeometry, TaskRecord, TaskScore,
    Verdict,
};

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
    #[error("run {} has no traces, because it used --trace none (re-run with --trace full)", .0.display())]
    NoTraces(PathBuf),
}

/// Scores the run in `dir` again under `rules`, without simulating.
///
/// Rules that differ from the run's own in the rollover rule alone end each trial where it ended and only classify its failure anew. The
/// records suffice for that, so traces are read only if they are full, or if the angle that counts is in no record (the pitch at the
/// end).
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
    let same_rules = rules.hash() == header.rules.hash;
    let mut records: Vec<TaskRecord> = run.records()?;
    records.sort_by(|a, b| a.task.cmp(&b.task));
    if !(header.trace == TraceMode::Full || same_rules && header.trace != TraceMode::None)
        && let Some(own) = Rules::recorded(header).ok().filter(|own| own.end_alike(rules))
        && let Some(records) = classified(&records, &own, rules, &Conditions::of(header).under(rules))
    {
        return Ok(Rescored {
            summary: Summary::new(header, rules, &records, Vec::new()),
            records,
            resolution_s: header.sample_period,
            exact: true,
        });
    }
    let Some(stride) = header.trace.stride() else { return Err(RescoreError::NoTraces(dir.to_owned())) };
    let mut decided = Vec::with_capacity(records.len());
    let mut undecided = Vec::new();
    let departures = Conditions::of(header).under(rules).departures();
    for mut record in records {
        record.departures.clone_from(&departures);
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

/// The records with their failures classified by the rollover rule of `rules`, under which the trials end as they did under `own`. None
/// if a record lacks an angle that counts.
fn classified(
    records: &[TaskRecord],
    own: &Rules,
    rules: &Rules,
    conditions: &Conditions,
) -> Option<Vec<TaskRecord>> {
    let departures = conditions.departures();
    // The pitch at the end is in no record.
    if rules.rollover.is_some_and(|r| r.when == RollTime::End && r.pitch_limit_deg.is_some()) {
        return None;
    }
    let one = |record: &TaskRecord| {
        let mut record = record.clone();
        record.departures.clone_from(&departures);
        let angles = match (rules.rollover, record.metrics) {
            (Some(rule), Some(m)) => match rule.when {
                RollTime::End => rule.exceeded(m.roll_end_deg, 0.0),
                RollTime::AnyTime => rule.exceeded(m.roll_max_deg, m.pitch_max_deg),
            },
            _ => None,
        };
        let rolled_over = angles.is_some();
        let verdict = match record.outcome {
            // Whoever tips over does so under both.
            Outcome::Rollover if own.overturned.is_some() && record.reason.starts_with(TIPPED) => None,
            Outcome::Stuck | Outcome::Rollover => Some(judged_again(record.outcome, &record.reason, angles)),
            _ => None,
        };
        let Verdict { outcome, reason } =
            verdict.unwrap_or_else(|| Verdict { outcome: record.outcome, reason: record.reason.clone() });
        let (three_way, time_s, metrics) = (outcome.three_way(rolled_over), record.time_s, record.metrics);
        record.set_score(TaskScore { outcome, three_way, reason, time_s, metrics });
        record
    };
    Some(records.iter().map(one).collect())
}
