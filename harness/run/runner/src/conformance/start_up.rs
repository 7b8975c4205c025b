//! `start-up`: how long users wait for the planner. By the wall clock, so it differs between machines and never fails.

use std::time::Instant;

use vb_host::{LogSink, Plugin};
use vb_sdk::Param;

use super::course::Course;
use super::report::Check;

const NAME: &str = "start-up";
/// Every task begins with this wait, s.
const LONG_START: f64 = 1.0;
/// The wait before a run when the plugin has been loaded before, s.
const LONG_LOAD: f64 = 5.0;

/// What `work` gives, and how long it took, s.
#[allow(clippy::disallowed_methods, reason = "told to people: nothing of it reaches a score")]
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = Instant::now();
    let result = work();
    (result, begin.elapsed().as_secs_f64())
}

/// `loads`: the times of the first and of a later load, s.
pub(super) fn check(course: &Course, plugin: &Plugin, params: &[Param], loads: [f64; 2]) -> Check {
    let brief = match course.brief(0, plugin, params) {
        Ok(brief) => brief,
        Err(e) => return Check::skip(NAME, e.to_string()),
    };
    let (session, start) = timed(|| plugin.start(&brief, LogSink::discard()));
    // Whether it starts is another check's matter.
    judge(loads, session.is_ok().then_some(start))
}

fn judge([first, again]: [f64; 2], start: Option<f64>) -> Check {
    let starts = start.map_or_else(String::new, |s| format!(", starts on a task in {}", time(s)));
    let detail = format!("loads in {}, again in {}{starts}", time(first), time(again));
    let check = if start.is_some_and(|s| s > LONG_START) {
        Check::warn(NAME, detail, "every task waits for init: do less there")
    } else if again > LONG_LOAD {
        Check::warn(NAME, detail, "every run waits for it: make the plugin smaller")
    } else {
        Check::pass(NAME, detail)
    };
    let check = check.figure("load_s", first).figure("load_again_s", again);
    match start {
        Some(seconds) => check.figure("start_s", seconds),
        None => check,
    }
}

fn time(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.1} ms", seconds * 1e3) } else { format!("{seconds:.1} s") }
}

#[cfg(test)]
mod tests {
    use super::super::report::Verdict;
    use super::*;

    #[test]
    fn long_waits_warn_and_the_first_load_may_take_its_time() {
        assert_eq!(judge([30.0, 0.01], Some(0.002)).verdict, Verdict::Pass);
        assert_eq!(judge([0.1, 0.01], Some(1.1)).verdict, Verdict::Warn);
        assert_eq!(judge([9.0, 6.0], Some(0.1)).verdict, Verdict::Warn);
        let check = judge([1.25, 0.01], None);
        assert_eq!(check.detail, "loads in 1.2 s, again in 10.0 ms");
        assert_eq!(check.figures.len(), 2);
    }
}
