//! A run whose planner can't even begin is ended early.

use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// Exit code of a run that was ended.
const FAILED_START: i32 = 10;

#[test]
fn a_planner_that_fails_alike_in_the_first_tasks_is_ended_and_resume_goes_on() {
    let bench = Bench::new();
    let faulty = plugin("faulty", PluginKind::Wasm);
    let args = ["--plugin", text(&faulty), "--param", "fault=init-error", "--tasks", "w001-w003"];
    let alone = [&args[..], &["--jobs", "1", "--out", "r"]].concat();
    let error = bench.run(&alone).error(FAILED_START);
    // Who, where, the planner's own words, how many, and what to do.
    for part in [
        "first 20 tasks",
        "(planner/init-failed)",
        "planner faulty 1.0.0-rc.1 on w001/t00, init: returned an error: instructed to give up",
        "10 tasks left",
        "--out r --resume",
        "--keep-going",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert_eq!(bench.records("r").len(), 20);
    assert_eq!(bench.json("r/summary.json")["all"]["outcomes"]["planner_error"], 20);
    // What was recorded stays, and the run goes on from there; it is for the user to say that it is meant so.
    let before = bench.records("r");
    bench.ok(&[&alone[..], &["--resume", "--keep-going"]].concat());
    let after = bench.records("r");
    assert_eq!(after.len(), 30);
    assert!(before.iter().all(|(task, record)| after[task] == *record));

    // With several workers, tasks that had begun are ended, and programs are told as people are.
    let several = ["--jobs", "3", "--out", "several", "--message-format", "json"];
    let done = bench.run(&[&args[..], &several].concat());
    assert_eq!(done.status.code(), Some(FAILED_START), "{}", done.stderr);
    // How many those are depends on how long the first task takes beside the others.
    let recorded = bench.records("several").len();
    assert!(recorded >= 20, "{recorded}");
    let finished: Value = serde_json::from_str(done.stdout.lines().last().expect("a line")).expect("JSON");
    assert_eq!((&finished["event"], &finished["interrupted"]), (&"finished".into(), &false.into()));
    let start = &finished["failed_start"];
    assert_eq!((&start["tasks"], &start["fault"]), (&20.into(), &"planner/init-failed".into()));
    assert!(start["reason"].as_str().is_some_and(|r| r.contains("instructed to give up")), "{start}");
}

#[test]
fn a_planner_that_does_not_answer_is_ended_after_three_tasks() {
    let bench = Bench::new();
    bench.write("limits.yaml", "watchdog_ms: 1000\n");
    let faulty = plugin("faulty", PluginKind::Native);
    for (fault, place) in
        [("fault=init-endless", "init: did not respond"), ("fault=endless", "step 0 (t = 0.00 s)")]
    {
        let out = fault.replace('=', "-");
        let args =
            ["--plugin", text(&faulty), "--param", fault, "--param", "at=0", "--limits", "limits.yaml"];
        let more = ["--tasks", "w001", "--jobs", "1", "--out", &out];
        let error = bench.run(&[&args[..], &more].concat()).error(FAILED_START);
        for part in ["first 3 tasks", "(planner/hung)", place, "within 1000 ms", "watchdog_ms"] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert_eq!(bench.records(&out).len(), 3);
    }
}

#[test]
fn a_planner_that_drives_some_way_or_fails_on_few_tasks_is_not_ended() {
    let bench = Bench::new();
    let faulty = plugin("faulty", PluginKind::Wasm);
    // After 0.3 s of each task; and in `init`, but of one task alone.
    for (out, fault, more) in
        [("late", "fault=error", "only="), ("once", "fault=init-error", "only=w001/t00")]
    {
        let args = ["--plugin", text(&faulty), "--param", fault, "--param", more, "--out", out];
        bench.ok(&[&args[..], &["--tasks", "w001-w002,w003/t00"]].concat());
        assert_eq!(bench.records(out).len(), 21);
    }
}
