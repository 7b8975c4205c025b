//! Ending a run early whose planner can't even begin, or whose simulation always fails.

use std::fmt;

use serde::Serialize;
use vb_score::{Outcome, TaskRecord};
use vb_sdk::fault::{Blame, FaultCode};

/// The number of first tasks after which a run stops if the planner fails alike in all of them, before its first
/// command, or the simulation fails in all of them. In the suites that come with the harness they are of two worlds with
/// different ground: a planner that refuses one world, or one kind of ground, isn't stopped.
pub const FAILED_STARTS: usize = 20;

/// The same number for a planner that doesn't answer in time: each of these tasks costs the whole time-out.
pub const HUNG_STARTS: usize = 3;

/// The reason why a run was ended early: the planner failed alike in all of the run's first tasks, before its first
/// command, or the simulation failed in all of them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailedStart {
    /// The number of those tasks.
    pub tasks: usize,
    /// The code of the fault of the first of them, e.g. `planner/init-failed`.
    pub fault: FaultCode,
    /// The reason in the record of the first of them, with the planner's own words.
    pub reason: String,
}

impl fmt::Display for FailedStart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tasks, fault, reason } = self;
        match fault.blame() {
            Blame::Planner => write!(
                f,
                "the planner failed in all of the first {tasks} tasks before its first command ({fault}), in the first with: \
                 {reason}"
            ),
            Blame::Simulation | Blame::Host => write!(
                f,
                "the simulation failed in all of the first {tasks} tasks ({fault}), in the first with: {reason}"
            ),
        }
    }
}

/// Watches the first tasks of a run.
///
/// It judges them by the order in which they were to be run, not by that in which they end: with several workers, those
/// that fail at once end before all that are driven well.
#[derive(Debug, Default)]
pub(crate) struct FailFast {
    /// The faults of the first tasks, as far as they have ended: code and reason.
    faults: Vec<Option<(FaultCode, String)>>,
    /// Whether a task has ended otherwise, so that there is nothing to watch for any more.
    started: bool,
    found: Option<FailedStart>,
}

impl FailFast {
    /// Takes the record of the task with this place in the run's order, from 0; true if the run is to be ended.
    pub(crate) fn ended(&mut self, place: usize, record: &TaskRecord) -> bool {
        if self.found.is_some() {
            return true;
        }
        if self.started || place >= FAILED_STARTS {
            return false;
        }
        let Some(fault) = hopeless_fault(record) else {
            self.started = true;
            return false;
        };
        if self.faults.len() <= place {
            self.faults.resize(place + 1, None);
        }
        self.faults[place] = Some((fault, record.reason.clone()));
        self.found = self.failed_start();
        self.found.is_some()
    }

    /// The verdict on the tasks so far.
    fn failed_start(&self) -> Option<FailedStart> {
        let (fault, reason) = self.faults.first()?.as_ref()?;
        let simulation = |code: FaultCode| code.blame() == Blame::Simulation;
        // In whichever way the simulation fails: no planner can mend it.
        let same = |code: FaultCode| code == *fault || (simulation(code) && simulation(*fault));
        let alike = |f: &&Option<(FaultCode, String)>| f.as_ref().is_some_and(|(code, _)| same(*code));
        let tasks = self.faults.iter().take_while(alike).count();
        let enough = if *fault == FaultCode::Hung { HUNG_STARTS } else { FAILED_STARTS };
        (tasks >= enough).then(|| FailedStart { tasks, fault: *fault, reason: reason.clone() })
    }

    pub(crate) fn found(self) -> Option<FailedStart> {
        self.found
    }
}

/// The code of a fault that leaves no hope for the next tasks if each of the first has it: of the planner in `init` or in the
/// first step, or of the simulation at any time.
fn hopeless_fault(record: &TaskRecord) -> Option<FaultCode> {
    let hopeless = match record.outcome {
        Outcome::PlannerError => record.planner_steps <= 1,
        Outcome::SimError => true,
        _ => false,
    };
    record.fault.filter(|_| hopeless)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_score::ThreeWay;
    use vb_world::{Density, Elevation, Terrain};

    fn failed(fault: FaultCode, planner_steps: u64) -> TaskRecord {
        TaskRecord {
            task: "w/t".parse().unwrap(),
            world: "w".into(),
            elevation: Elevation::Low,
            terrain: Terrain::Rigid,
            density: Density::Sparse,
            outcome: Outcome::PlannerError,
            three_way: ThreeWay::Stuck,
            flags: std::collections::BTreeMap::new(),
            departures: Vec::new(),
            reason: "its own words".into(),
            cause: None,
            evidence: String::new(),
            fault: Some(fault),
            time_s: 0.0,
            state_hash: String::new(),
            sim_steps: 0,
            planner_steps,
            clamped: 0,
            fuel: None,
            metrics: None,
            ride: None,
            log: Vec::new(),
            backtrace: Vec::new(),
        }
    }

    fn stuck() -> TaskRecord {
        TaskRecord { outcome: Outcome::Stuck, fault: None, ..failed(FaultCode::Error, 100) }
    }

    /// The number of tasks after which a run of these is ended.
    fn ended_after(tasks: impl IntoIterator<Item = (usize, TaskRecord)>) -> Option<usize> {
        let mut watch = FailFast::default();
        tasks.into_iter().position(|(place, record)| watch.ended(place, &record)).map(|k| k + 1)
    }

    #[test]
    fn a_planner_that_fails_alike_in_all_of_the_first_tasks_is_ended() {
        let init = || (0..100).map(|k| (k, failed(FaultCode::InitFailed, 0)));
        assert_eq!(ended_after(init()), Some(FAILED_STARTS));
        assert_eq!(ended_after(init().take(FAILED_STARTS - 1)), None);
        let mut watch = FailFast::default();
        init().for_each(|(place, record)| {
            watch.ended(place, &record);
        });
        let reason = "its own words".into();
        let fault = FaultCode::InitFailed;
        assert_eq!(watch.found(), Some(FailedStart { tasks: FAILED_STARTS, fault, reason }));
    }

    #[test]
    fn one_that_does_not_answer_is_ended_sooner() {
        // In `init` or in the first step: it is the same planner, which takes too long.
        assert_eq!(ended_after((0..100).map(|k| (k, failed(FaultCode::Hung, 0)))), Some(HUNG_STARTS));
        assert_eq!(
            ended_after((0..100).map(|k| (k, failed(FaultCode::Hung, k as u64 % 2)))),
            Some(HUNG_STARTS)
        );
    }

    #[test]
    fn one_that_gave_a_command_or_fails_in_several_ways_is_not_ended() {
        assert_eq!(ended_after((0..100).map(|k| (k, failed(FaultCode::Error, 2)))), None);
        let other = |k| if k == 19 { FaultCode::Panic } else { FaultCode::InitFailed };
        assert_eq!(ended_after((0..100).map(|k| (k, failed(other(k), 0)))), None);
        let host = || TaskRecord { outcome: Outcome::HostError, ..failed(FaultCode::Machine, 0) };
        assert_eq!(ended_after((0..100).map(|k| (k, host()))), None);
    }

    fn unsimulated(fault: FaultCode, planner_steps: u64) -> TaskRecord {
        TaskRecord { outcome: Outcome::SimError, ..failed(fault, planner_steps) }
    }

    #[test]
    fn a_run_whose_simulation_fails_in_all_of_the_first_tasks_is_ended() {
        // Whenever and in whichever way it fails.
        let fault = |k: usize| if k.is_multiple_of(3) { FaultCode::Diverged } else { FaultCode::Simulation };
        let all = || (0..100).map(|k| (k, unsimulated(fault(k), 7 * k as u64)));
        assert_eq!(ended_after(all()), Some(FAILED_STARTS));
        assert_eq!(ended_after(all().take(FAILED_STARTS - 1)), None);
        let mut watch = FailFast::default();
        all().for_each(|(place, record)| {
            watch.ended(place, &record);
        });
        let told = watch.found().map(|found| found.to_string());
        let wanted = "the simulation failed in all of the first 20 tasks (host/diverged), in the first with: its own words";
        assert_eq!(told.as_deref(), Some(wanted));
        // One task that could be simulated is hope, and so is a planner that fails instead.
        let but_one = |other: fn() -> TaskRecord| {
            (0..100).map(move |k| (k, if k == 19 { other() } else { unsimulated(FaultCode::Diverged, 5) }))
        };
        assert_eq!(ended_after(but_one(stuck)), None);
        assert_eq!(ended_after(but_one(|| failed(FaultCode::InitFailed, 0))), None);
    }

    /// The first task is driven for long by one worker, while the other ends one failure after the other.
    #[test]
    fn tasks_that_end_early_do_not_speak_for_those_before_them() {
        let rest = || (1..100).map(|k| (k, failed(FaultCode::InitFailed, 0)));
        assert_eq!(ended_after(rest().chain([(0, stuck())])), None);
        assert_eq!(ended_after([(0, stuck())].into_iter().chain(rest())), None);
        let last = [(0, failed(FaultCode::InitFailed, 0))];
        assert_eq!(ended_after(rest().take(40).chain(last)), Some(41));
    }
}
