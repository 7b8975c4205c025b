//! `determinism`: the same task twice, each with a plugin loaded anew, gives the same bits.

use vb_score::{Outcome, TaskRecord};
use vb_sdk::fault::FaultCode;

use super::report::Check;

const NAME: &str = "determinism";

pub(super) fn check(once: &TaskRecord, again: &TaskRecord) -> Check {
    match difference(once, again) {
        None if gave_nothing(once) => Check::skip(NAME, unchecked(once)),
        None => Check::pass(NAME, format!("{} twice: the same state hash {}", once.task, once.state_hash)),
        Some(what) => Check::fail(
            NAME,
            format!("{} twice: {what}", once.task),
            "commands must not depend on clocks, addresses, threads or random numbers other than the task's seed",
        ),
    }
}

/// Whether the planner failed before its first command, so that two trials have nothing in which they could differ.
pub(super) fn gave_nothing(trial: &TaskRecord) -> bool {
    // The step in which it failed counts.
    trial.outcome == Outcome::PlannerError && trial.planner_steps <= 1
}

/// What is said in that case.
pub(super) fn unchecked(trial: &TaskRecord) -> String {
    format!("not checked: the planner failed on {} before its first command", trial.task)
}

/// The first thing in which two trials of a task differ, as `what: one and other`.
pub(super) fn difference(a: &TaskRecord, b: &TaskRecord) -> Option<String> {
    let text = |r: &TaskRecord| {
        let fuel = r.fuel.map_or_else(|| "none".to_owned(), |f| f.total.to_string());
        [
            ("outcome", r.outcome.name().to_owned()),
            ("fault", r.fault.map_or("none", FaultCode::name).to_owned()),
            ("planner steps", r.planner_steps.to_string()),
            ("clamped commands", r.clamped.to_string()),
            ("state hash", r.state_hash.clone()),
            ("fuel", fuel),
        ]
    };
    let mut pairs = text(a).into_iter().zip(text(b));
    pairs.find(|(a, b)| a != b).map(|((what, a), (_, b))| format!("{what} {a} and {b}"))
}

#[cfg(test)]
mod tests {
    use super::super::report::Verdict;
    use super::super::tasks::tests::driven;
    use super::*;

    #[test]
    fn a_planner_that_fails_before_its_first_command_is_not_said_to_be_deterministic() {
        let after = |planner_steps| TaskRecord { planner_steps, ..driven("w001/t00", Outcome::PlannerError) };
        // In the first of its steps, or before it had one.
        for once in [after(0), after(1)] {
            let found = check(&once, &once);
            assert_eq!(found.verdict, Verdict::Skip);
            assert!(found.detail.starts_with("not checked"), "{}", found.detail);
        }
        assert_eq!(check(&after(2), &after(2)).verdict, Verdict::Pass);
        let once = after(1);
        // Faults that differ are seen all the same.
        let other = TaskRecord { fault: Some(FaultCode::Panic), ..once.clone() };
        assert_eq!(check(&once, &other).verdict, Verdict::Fail);
    }

    #[test]
    fn the_first_difference_is_named_with_both_values() {
        let once = driven("w001/t00", Outcome::Success);
        assert_eq!(check(&once, &once).verdict, Verdict::Pass);
        let again = TaskRecord { state_hash: "f".repeat(16), planner_steps: 9, ..once.clone() };
        let found = check(&once, &again);
        assert_eq!(found.verdict, Verdict::Fail);
        assert_eq!(found.detail, "w001/t00 twice: planner steps 10 and 9");
        let more = vb_score::FuelUse { total: 7, ..vb_score::FuelUse::default() };
        let fuel = TaskRecord { fuel: Some(more), ..once.clone() };
        assert_eq!(difference(&once, &fuel).unwrap(), "fuel none and 7");
    }
}
