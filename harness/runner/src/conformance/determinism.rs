//! `determinism`: the same task twice, each with a plugin loaded anew, gives the same bits.

use vb_score::TaskRecord;

use super::report::Check;

const NAME: &str = "determinism";

pub(super) fn check(once: &TaskRecord, again: &TaskRecord) -> Check {
    match difference(once, again) {
        None => Check::pass(NAME, format!("{} twice: the same state hash {}", once.task, once.state_hash)),
        Some(what) => Check::fail(
            NAME,
            format!("{} twice: {what}", once.task),
            "take no clock, address, thread or randomness but the task's seed into a command",
        ),
    }
}

/// The first thing in which two trials of a task differ, as `what: one and other`.
pub(super) fn difference(a: &TaskRecord, b: &TaskRecord) -> Option<String> {
    let text = |r: &TaskRecord| {
        let fuel = r.fuel.map_or_else(|| "none".to_owned(), |f| f.total.to_string());
        [
            ("outcome", r.outcome.name().to_owned()),
            ("fault", r.fault.clone().unwrap_or_else(|| "none".into())),
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
    use vb_score::Outcome;

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
