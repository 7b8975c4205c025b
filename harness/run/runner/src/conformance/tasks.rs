//! `tasks`: the planner drives every task to a verdict. How well is not judged.

use vb_score::{Outcome, TaskRecord};
use vb_sdk::fault::FaultCode;

use super::report::Check;

const NAME: &str = "tasks";

pub(super) fn check(driven: &[TaskRecord]) -> Check {
    let of = |r: &TaskRecord| format!("{} {}", r.task, r.outcome.name());
    if let Some(r) = driven.iter().find(|r| r.outcome == Outcome::PlannerError) {
        let code = r.fault.map_or("no code", FaultCode::name);
        return Check::fail(
            NAME,
            format!("{}: {} ({code})", r.task, r.reason),
            "a task fails if its planner fails; run the task alone with --tasks and --verbose",
        );
    }
    let outcomes = driven.iter().map(of).collect::<Vec<_>>().join(", ");
    if driven.iter().any(|r| r.outcome == Outcome::SimError) {
        return Check::warn(
            NAME,
            outcomes,
            "the simulation failed, which is not the planner's fault; report it",
        );
    }
    let (clamped, steps) = driven.iter().fold((0, 0), |(c, s), r| (c + r.clamped, s + r.planner_steps));
    if clamped > 0 {
        return Check::warn(
            NAME,
            format!("{outcomes}; {clamped} of {steps} commands were out of range and clamped"),
            "keep steering within [-1, 1], throttle and brake within [0, 1]",
        );
    }
    Check::pass(NAME, outcomes)
}

#[cfg(test)]
pub(super) mod tests {
    use vb_score::ThreeWay;
    use vb_world::{Density, Elevation, Terrain};

    use super::super::report::Verdict;
    use super::*;

    /// A task that ended so.
    pub(in super::super) fn driven(task: &str, outcome: Outcome) -> TaskRecord {
        TaskRecord {
            task: task.parse().unwrap(),
            world: "w001".into(),
            elevation: Elevation::Low,
            terrain: Terrain::Rigid,
            density: Density::Sparse,
            outcome,
            three_way: ThreeWay::Stuck,
            flags: std::collections::BTreeMap::new(),
            departures: Vec::new(),
            reason: "because".into(),
            cause: None,
            evidence: String::new(),
            fault: None,
            time_s: 1.0,
            state_hash: "0123456789abcdef".into(),
            sim_steps: 1000,
            planner_steps: 10,
            clamped: 0,
            fuel: None,
            metrics: None,
            ride: None,
            log: Vec::new(),
            backtrace: Vec::new(),
        }
    }

    #[test]
    fn bad_driving_passes_and_a_fault_of_the_planner_fails() {
        let good = driven("w001/t00", Outcome::Success);
        for (outcome, verdict) in [
            (Outcome::Rollover, Verdict::Pass),
            (Outcome::Timeout, Verdict::Pass),
            (Outcome::SimError, Verdict::Warn),
            (Outcome::PlannerError, Verdict::Fail),
        ] {
            assert_eq!(check(&[good.clone(), driven("w001/t01", outcome)]).verdict, verdict, "{outcome:?}");
        }
    }

    #[test]
    fn commands_out_of_range_are_counted() {
        let wild = TaskRecord { clamped: 3, ..driven("w001/t00", Outcome::Success) };
        let check = check(&[wild.clone(), TaskRecord { clamped: 1, ..wild }]);
        assert_eq!(check.verdict, Verdict::Warn);
        assert!(check.detail.contains("4 of 20 commands"), "{}", check.detail);
    }
}
