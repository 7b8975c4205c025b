//! `hygiene`: a task leaves nothing behind. Task B after task A in the same process gives the same bits as B alone.

use vb_score::TaskRecord;

use super::determinism::{difference, gave_nothing, unchecked};
use super::report::{Check, Verdict};

const NAME: &str = "hygiene";

/// `deterministic`: what became of that check, without which this one says nothing.
pub(super) fn check(
    alone: &TaskRecord,
    after: &TaskRecord,
    before: &TaskRecord,
    deterministic: Verdict,
) -> Check {
    if deterministic == Verdict::Fail {
        return Check::skip(NAME, "it is not deterministic, so state leaks between tasks cannot be detected");
    }
    match difference(alone, after) {
        None if gave_nothing(alone) => Check::skip(NAME, unchecked(alone)),
        None => Check::pass(NAME, format!("{}: equal results alone and after {}", alone.task, before.task)),
        Some(what) => Check::fail(
            NAME,
            format!("{} alone and after {}: {what}", alone.task, before.task),
            "keep nothing in statics, globals or threads: all state belongs to the planner that init makes",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tasks::tests::driven;
    use super::*;
    use vb_score::Outcome;

    #[test]
    fn a_trace_of_the_task_before_fails_unless_nothing_can_be_told() {
        let (a, b) = (driven("w001/t00", Outcome::Success), driven("w001/t01", Outcome::Success));
        let other = TaskRecord { state_hash: "f".repeat(16), ..b.clone() };
        assert_eq!(check(&b, &b, &a, Verdict::Pass).verdict, Verdict::Pass);
        let found = check(&b, &other, &a, Verdict::Pass);
        assert_eq!(found.verdict, Verdict::Fail);
        assert!(
            found.detail.starts_with("w001/t01 alone and after w001/t00: state hash"),
            "{}",
            found.detail
        );
        assert_eq!(check(&b, &other, &a, Verdict::Fail).verdict, Verdict::Skip);
    }
}
