//! The planners with learned models, as their users run them.

use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

/// All of the first tasks fail alike.
const FAIL_FAST: i32 = 10;
const PLANNERS: [&str; 4] = ["wmvct", "mppi6", "tal", "tnt"];

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

#[test]
fn planners_with_learned_models_get_over_easy_ground_and_drive_alike_in_both_kinds() {
    let bench = Bench::new();
    for name in PLANNERS {
        let record = |kind: PluginKind| {
            let (plugin, out) = (plugin(name, kind), format!("{name}-{kind:?}"));
            let run = ["--plugin", text(&plugin), "--suite", "smoke", "--tasks", "w001/t00"];
            bench.ok(&[&run[..], &["--param", "samples=200", "--out", &out]].concat());
            bench.records(&out).remove("w001/t00").expect("the task is recorded")
        };
        let (wasm, native) = (record(PluginKind::Wasm), record(PluginKind::Native));
        assert_eq!(wasm["outcome"], "success", "{name}: {wasm}");
        assert_eq!(wasm["state_hash"], native["state_hash"], "{name}");
    }
}

#[test]
fn another_vehicle_than_the_models_is_driven_and_told() {
    let bench = Bench::new();
    let plugin = plugin("mppi6", PluginKind::Wasm);
    let run = ["--plugin", text(&plugin), "--suite", "smoke", "--tasks", "w001/t00", "--vehicle", "gator"];
    bench.ok(&[&run[..], &["--param", "samples=200", "--logs", "all", "--out", "r"]].concat());
    let record = &bench.records("r")["w001/t00"];
    assert_ne!(record["outcome"], "planner_error", "{record}");
    let log = record["log"].as_array().expect("a log");
    let warned = |line: &Value| {
        line.as_str().is_some_and(|l| l.starts_with("warn: ") && l.contains("hmmwv") && l.contains("gator"))
    };
    assert!(log.iter().any(warned), "{record}");
}

#[test]
fn without_maps_of_the_world_they_say_so_at_once() {
    let bench = Bench::new();
    for name in PLANNERS {
        let plugin = plugin(name, PluginKind::Wasm);
        let run = ["--plugin", text(&plugin), "--suite", "smoke", "--perception", "degraded", "--out", name];
        let error = bench.run(&run).error(FAIL_FAST);
        assert!(error.contains(name) && error.contains("gives no map of heights"), "{name}: {error}");
    }
}
