//! The planners with learned models, as their users run them.

use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

/// All of the first tasks fail alike.
const FAIL_FAST: i32 = 10;
const PLANNERS: [&str; 5] = ["wmvct", "mppi6", "tal", "tnt", "ibex"];

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
    for name in PLANNERS.into_iter().filter(|name| *name != "ibex") {
        let plugin = plugin(name, PluginKind::Wasm);
        let run = ["--plugin", text(&plugin), "--suite", "smoke", "--perception", "degraded", "--out", name];
        let error = bench.run(&run).error(FAIL_FAST);
        assert!(error.contains(name) && error.contains("omits the elevation map"), "{name}: {error}");
    }
}

#[test]
fn without_maps_of_the_world_ibex_drives_by_what_it_sees() {
    let bench = Bench::new();
    let drive = |profile: &str, kind: PluginKind| {
        let (plugin, out) = (plugin("ibex", kind), format!("{profile}-{kind:?}"));
        let run = ["--plugin", text(&plugin), "--suite", "smoke", "--tasks", "w001/t01"];
        bench.ok(&[&run[..], &["--perception", profile, "--out", &out]].concat());
        bench.records(&out).remove("w001/t01").expect("the task is recorded")
    };
    for profile in ["onboard", "degraded"] {
        let (wasm, native) = (drive(profile, PluginKind::Wasm), drive(profile, PluginKind::Native));
        assert_eq!(wasm["outcome"], "success", "{profile}: {wasm}");
        assert_eq!(wasm["state_hash"], native["state_hash"], "{profile}");
    }
}

#[test]
fn a_plugin_names_the_weights_that_it_has_and_what_they_were_learned_from() {
    let bench = Bench::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../plugins/hybrid/weights");
    let mut named: [Vec<String>; 2] = Default::default();
    for entry in std::fs::read_dir(&folder).expect("the weights") {
        let file = entry.expect("an entry").path();
        if file.extension().is_none_or(|e| e != "vbnn") {
            continue;
        }
        let hash = vb_files::sha256(&std::fs::read(&file).expect("weights"));
        let card = std::fs::read_to_string(file.with_extension("json")).expect("a card");
        let card: Value = serde_json::from_str(&card).expect("JSON");
        assert_eq!(card["weights_sha256"], hash.as_str(), "{}", file.display());
        let frames: Vec<&str> =
            card["frames_sha256"].as_array().expect("hashes").iter().filter_map(Value::as_str).collect();
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        let attends = card["sight"] == "attention";
        named[usize::from(attends)]
            .push(format!("{name} sha256 {hash}, learned from frames sha256 {}", frames.join(" ")));
    }
    for (name, attends) in
        [("wmvct", false), ("mppi6", false), ("tal", true), ("tnt", false), ("ibex", false)]
    {
        for kind in [PluginKind::Wasm, PluginKind::Native] {
            let file = plugin(name, kind);
            let told = bench.ok(&["inspect", "--plugin", text(&file), "--message-format", "json"]);
            let told: Value = serde_json::from_str(&told).expect("JSON");
            let models = told["models"][0].as_str().expect("its models");
            for own in &named[usize::from(attends)] {
                assert!(models.contains(own), "{name}: {own} in {models}");
            }
        }
    }
}
