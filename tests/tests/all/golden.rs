//! Stored plugins, which are never rebuilt within a version of the planner interface, drive like those built today.

use std::path::{Path, PathBuf};

use vb_tests::{Bench, PluginKind, plugin, root};

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
