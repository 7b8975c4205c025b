//! `budget`: the planner has head-room within its limits, so that a harder task doesn't end it.

use vb_host::Limits;
use vb_score::TaskRecord;

use super::report::Check;

const NAME: &str = "budget";
/// Above this fraction of a limit, other tasks may well reach it.
const MUCH: f64 = 0.7;

pub(super) fn check(driven: &[TaskRecord], limits: &Limits) -> Check {
    let used: Vec<_> = driven.iter().filter_map(|r| r.fuel).collect();
    if used.is_empty() {
        return Check::skip(NAME, "no fuel was counted: only WASM planners that start are metered");
    }
    let most = |fraction: fn(&vb_score::FuelUse) -> f64| used.iter().map(fraction).fold(0.0, f64::max);
    let memory = most(|f| f.memory_bytes as f64) / limits.memory_bytes as f64;
    let fractions = [
        ("init_fraction", "of fuel_init", most(|f| f.init_fraction)),
        ("p99_fraction", "of fuel_per_step (p99)", most(|f| f.p99_fraction)),
        ("max_fraction", "of fuel_per_step (max)", most(|f| f.max_fraction)),
        ("memory_fraction", "of memory_bytes", memory),
    ];
    let text = |(_, what, fraction): &(_, &str, f64)| format!("{} {what}", percent(*fraction));
    let detail = fractions.iter().map(text).collect::<Vec<_>>().join(", ");
    let check = if fractions.iter().any(|(.., fraction)| *fraction > MUCH) {
        Check::warn(NAME, detail, "above 70 % of a limit: harder tasks may exceed it; use less")
    } else {
        Check::pass(NAME, detail)
    };
    fractions.into_iter().fold(check, |check, (name, _, fraction)| check.figure(name, fraction))
}

fn percent(fraction: f64) -> String {
    if fraction > 0.0 && fraction < 1e-4 {
        "under 0.01 %".into()
    } else {
        format!("{:.2} %", 100.0 * fraction)
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::Verdict;
    use super::*;

    #[test]
    fn a_fraction_is_told_in_percent_however_small() {
        assert_eq!([0.0, 3e-6, 0.0049, 0.7].map(percent), ["0.00 %", "under 0.01 %", "0.49 %", "70.00 %"]);
    }

    /// A task whose start-up and steps took so much of a limit of 1000 units, and as much memory of 1000 bytes.
    fn driven(init: u64, step: u64, memory: u64) -> TaskRecord {
        TaskRecord {
            fuel: Some(vb_score::FuelUse::new(init, vec![1, step], 1000, 1000, memory)),
            ..super::super::tasks::tests::driven("w001/t00", vb_score::Outcome::Success)
        }
    }

    #[test]
    fn above_seventy_percent_of_any_limit_in_any_task_is_a_warning() {
        let limits = Limits { fuel_init: 1000, fuel_per_step: 1000, memory_bytes: 1000, ..Limits::default() };
        let verdict = |of: [u64; 3]| {
            let [init, step, memory] = of;
            check(&[driven(1, 1, 1), driven(init, step, memory)], &limits).verdict
        };
        assert_eq!(verdict([700, 700, 700]), Verdict::Pass);
        for more in [[701, 1, 1], [1, 701, 1], [1, 1, 701]] {
            assert_eq!(verdict(more), Verdict::Warn, "{more:?}");
        }
    }

    #[test]
    fn planners_that_are_not_metered_have_no_budget() {
        let native = TaskRecord { fuel: None, ..driven(1, 1, 1) };
        assert_eq!(check(&[native], &Limits::default()).verdict, Verdict::Skip);
    }
}
