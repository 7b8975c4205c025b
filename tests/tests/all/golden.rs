//! Stored files of version 1.0 (`tests/golden`), which are never made again: planners drive like those built today, and a suite, a run and
//! a submission are read.

use std::path::{Path, PathBuf};

use serde_json::Value;
use vb_tests::{Bench, PluginKind, copy_dir, plugin, root};

/// The hash of the stored suite, a snapshot: results name suites by it, so it never changes.
const SUITE_HASH: &str = "a5de396787f3cb94a58e7249fa160700a74e800d44530fa0337ec97f028c73aa";

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

fn golden(name: &str) -> PathBuf {
    root().join("tests/golden/abi-1.0").join(name)
}

/// Both are the same planner on the same vehicle, so they come to the same verdict after as many steps. The last bits
/// may differ: the compiler and its library of functions are others. (That the golden one gives its own bits for ever is
/// tested beside the host.)
#[test]
fn a_golden_planner_drives_a_task_to_the_same_verdict_as_the_one_built_today() {
    let bench = Bench::new();
    let today = plugin("pursuit", PluginKind::Wasm);
    for file in [golden("pursuit.wasm"), today] {
        let out = if file.starts_with(root().join("tests/golden")) { "golden" } else { "today" };
        bench.ok(&["--plugin", text(&file), "--tasks", "w001/t00", "--out", out]);
    }
    let (golden, today) = (&bench.records("golden")["w001/t00"], &bench.records("today")["w001/t00"]);
    assert_ne!(golden["outcome"], "planner_error");
    for field in ["outcome", "three_way", "planner_steps", "clamped"] {
        assert_eq!(golden[field], today[field], "{field}");
    }
}

#[test]
fn golden_planners_pass_the_checks_of_today() {
    let bench = Bench::new();
    for name in ["pursuit.wasm", "pursuit-c.wasm"] {
        let told = bench.ok(&["check", "--plugin", text(&golden(name)), "--tasks", "w001/t00-t02"]);
        assert!(told.contains("0 failed"), "{name}: {told}");
    }
}

/// A bench with copies of the stored suite, run and submission.
fn formats() -> Bench {
    let bench = Bench::new();
    copy_dir(&root().join("tests/golden/formats-1.0"), &bench.path("."));
    bench
}

#[test]
fn the_suite_of_1_0_is_valid_and_has_its_hash() {
    let told = formats().ok(&["suite", "validate", "suite", "--message-format", "json"]);
    assert!(told.contains(SUITE_HASH), "{told}");
}

#[test]
fn the_run_of_1_0_is_scored_as_it_was_and_shown() {
    let bench = formats();
    let told = bench.ok(&["score", "run", "--message-format", "json"]);
    let of = |event: &str| {
        let messages = told.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
        messages.filter(|m| m["event"] == event).collect::<Vec<_>>()
    };
    let (summary, recorded) = (&of("summary")[0], bench.json("run/summary.json"));
    assert_eq!(summary["exact"], true);
    let records = bench.records("run");
    for message in of("task") {
        let record = &message["record"];
        let recorded = &records[record["task"].as_str().expect("a name")];
        for field in ["outcome", "cause", "time_s", "metrics"] {
            assert_eq!(record[field], recorded[field], "{field}");
        }
    }
    assert_eq!(of("task").len(), records.len());
    assert_eq!(summary["summary"]["all"]["success_rate"], recorded["all"]["success_rate"]);
    bench.ok(&["report", "run", "--out", "report"]);
    bench.ok(&["replay", "run", "--task", "w003/t00", "--out", "replay.html"]);
}

/// Its planner repeats its trajectories in the version that made it; trajectories of other versions may differ, so these refuse it.
#[test]
fn the_submission_of_1_0_is_read() {
    let bench = formats();
    let planner = golden("pursuit.wasm");
    let verify =
        ["verify", "submission", "--plugin", text(&planner), "--suite", "suite", "--out", "verdict.json"];
    let done = bench.run(&verify);
    let made = &bench.json("submission/submission.json")["run"]["harness_version"];
    if made == env!("CARGO_PKG_VERSION") {
        let _ = done.ok();
        assert_eq!(bench.json("verdict.json")["verified"], true);
    } else {
        let told = done.error(3);
        assert!(told.contains(made.as_str().expect("a version")), "{told}");
    }
}
