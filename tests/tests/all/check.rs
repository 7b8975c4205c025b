//! `vb-harness check`: planners that keep their promises pass, and those that break one fail the check that is about it.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// The checks by name, and the last message.
fn messages(stdout: &str) -> (BTreeMap<String, Value>, Value) {
    let all: Vec<Value> = stdout.lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let (last, checks) = all.split_last().expect("messages");
    assert!(checks.iter().all(|m| m["event"] == "check"));
    assert_eq!(last["event"], "finished");
    let named = checks.iter().map(|m| (m["name"].as_str().expect("a name").to_owned(), m.clone()));
    (named.collect(), last.clone())
}

const JSON: [&str; 2] = ["--message-format", "json"];

#[test]
fn a_sound_planner_passes_as_wasm_and_as_a_native_library() {
    let bench = Bench::new();
    for plugin_kind in [PluginKind::Wasm, PluginKind::Native] {
        let file = plugin("pursuit", plugin_kind);
        let args = ["check", "--plugin", text(&file), "--tasks", "w001/t00-t02"];
        let (checks, finished) = messages(&bench.ok(&[&args[..], &JSON].concat()));
        let names: Vec<&str> = checks.keys().map(String::as_str).collect();
        let all =
            ["budget", "determinism", "hygiene", "imports", "loads", "probes", "stamp", "start-up", "tasks"];
        assert_eq!(names, all);
        for name in ["loads", "stamp", "tasks", "determinism", "hygiene"] {
            assert_eq!(checks[name]["verdict"], "pass", "{plugin_kind:?}: {}", checks[name]);
        }
        assert_eq!((&finished["passed"], &finished["planner"]), (&true.into(), &"pursuit".into()));
        // Only WASM is metered.
        let budget = &checks["budget"];
        if plugin_kind == PluginKind::Wasm {
            let fraction = budget["figures"]["p99_fraction"].as_f64().expect("a fraction");
            assert!(budget["verdict"] == "pass" && 0.0 < fraction && fraction < 0.01, "{budget}");
            let asked = checks["imports"]["detail"].as_str().expect("names");
            assert!(asked.contains("vertibench:planner/host@1.0.0"), "{asked}");
        } else {
            assert_eq!(budget["verdict"], "skip");
        }
    }
}

#[test]
fn a_planner_that_breaks_a_promise_fails_the_check_that_is_about_it() {
    let bench = Bench::new();
    let (wasm, native) = (PluginKind::Wasm, PluginKind::Native);
    for (plugin_kind, fault, failing, says) in [
        (wasm, "nan", "tasks", "steering is NaN"),
        (wasm, "panic", "tasks", "planner/panic"),
        (wasm, "clock", "tasks", "use the observation's `time`"),
        (native, "clock", "determinism", "w001/t00 twice: "),
        (native, "static", "hygiene", "alone and after w001/t00"),
    ] {
        let (file, fault) = (plugin("faulty", plugin_kind), format!("fault={fault}"));
        let args = ["check", "--plugin", text(&file), "--param", &fault, "--tasks", "w001/t00-t02"];
        let done = bench.run(&[&args[..], &JSON].concat());
        let (checks, finished) = messages(&done.stdout);
        let failed: Vec<_> = checks.values().filter(|c| c["verdict"] == "fail").collect();
        assert_eq!(failed.len(), 1, "{fault}: {failed:?}");
        assert_eq!(failed[0]["name"], failing, "{fault}");
        assert!(failed[0]["detail"].as_str().expect("a text").contains(says), "{fault}: {}", failed[0]);
        assert!(failed[0]["hint"].is_string());
        assert_eq!(finished["passed"], false);
        assert!(done.error(8).contains(failing));
    }
    // The same state in a static, but in WASM every planner has memory of its own.
    let file = plugin("faulty", wasm);
    let args = ["check", "--plugin", text(&file), "--param", "fault=static", "--tasks", "w001/t00-t01"];
    let (checks, _) = messages(&bench.ok(&[&args[..], &JSON].concat()));
    assert_eq!(checks["hygiene"]["verdict"], "pass");
}

/// The planner computes without end from the step on at which it is shown something extreme for the third time.
#[test]
fn a_planner_that_runs_away_from_an_extreme_observation_fails_the_probes() {
    let bench = Bench::new();
    bench.write("limits.yaml", "fuel_per_step: 1000000\n");
    let file = plugin("faulty", PluginKind::Wasm);
    let args = ["check", "--plugin", text(&file), "--param", "fault=endless", "--tasks", "w001/t00"];
    let done = bench.run(&[&args[..], &["--limits", "limits.yaml"], &JSON].concat());
    let (checks, _) = messages(&done.stdout);
    let failed: Vec<_> = checks.values().filter(|c| c["verdict"] == "fail").map(|c| &c["name"]).collect();
    assert_eq!(failed, ["probes", "tasks"]);
    let detail = checks["probes"]["detail"].as_str().expect("a text");
    assert!(detail.starts_with("planner/out-of-fuel after zeros, "), "{detail}");
    assert!(done.error(8).contains("tasks, probes"));
}

#[test]
fn little_head_room_is_a_warning_with_the_fraction() {
    let bench = Bench::new();
    let file = plugin("pursuit", PluginKind::Wasm);
    let args = ["check", "--plugin", text(&file), "--tasks", "w001/t00", "--message-format", "json"];
    let (checks, _) = messages(&bench.ok(&args));
    let figure = |name: &str| checks["budget"]["figures"][name].as_f64().expect("a fraction");
    // A limit of which the dearest step of this task takes 80 %.
    let limit = (2e9 * figure("max_fraction") / 0.8).ceil();
    bench.write("limits.yaml", format!("fuel_per_step: {limit}\n"));
    let (checks, finished) = messages(&bench.ok(&[&args[..], &["--limits", "limits.yaml"]].concat()));
    assert_eq!((&checks["budget"]["verdict"], &finished["passed"]), (&"warn".into(), &true.into()));
    let fraction = checks["budget"]["figures"]["max_fraction"].as_f64().expect("a fraction");
    assert!((fraction - 0.8).abs() < 1e-3, "{fraction}");
}

#[test]
fn a_file_that_cannot_be_loaded_fails_and_one_that_isnt_there_is_bad_input() {
    let bench = Bench::new();
    bench.write("empty.wasm", "");
    let done = bench.run(&["check", "--plugin", "empty.wasm"]);
    assert!(done.stdout.contains("fail  loads"), "{}", done.stdout);
    assert!(done.stdout.contains("skip  determinism"), "{}", done.stdout);
    assert!(done.error(8).contains("loads"));
    assert!(bench.run(&["check", "--plugin", "nowhere.wasm"]).error(3).contains("planner/not-found"));
    let file = plugin("pursuit", PluginKind::Wasm);
    let unknown = ["check", "--plugin", text(&file), "--param", "sped=3"];
    assert!(bench.run(&unknown).error(2).contains("--param sped"));
}
