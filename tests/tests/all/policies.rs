//! The planners that were trained end to end, as their users run them.

use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

const PLANNERS: [&str; 3] = ["rl", "mcl", "acl"];

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

#[test]
fn policies_get_over_easy_ground_and_drive_alike_in_both_kinds() {
    let bench = Bench::new();
    for name in PLANNERS {
        let record = |kind: PluginKind| {
            let (plugin, out) = (plugin(name, kind), format!("{name}-{kind:?}"));
            bench.ok(&["--plugin", text(&plugin), "--suite", "smoke", "--tasks", "w001/t00", "--out", &out]);
            bench.records(&out).remove("w001/t00").expect("the task is recorded")
        };
        let (wasm, native) = (record(PluginKind::Wasm), record(PluginKind::Native));
        assert_eq!(wasm["outcome"], "success", "{name}: {wasm}");
        assert_eq!(wasm["state_hash"], native["state_hash"], "{name}");
    }
}

#[test]
fn a_policy_names_its_weights_which_have_a_card() {
    let bench = Bench::new();
    for name in PLANNERS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../plugins").join(name);
        let hash = vb_files::sha256(&std::fs::read(folder.join("policy.vbnn")).expect("weights"));
        let card = std::fs::read_to_string(folder.join("policy.json")).expect("a card");
        let card: Value = serde_json::from_str(&card).expect("JSON");
        assert_eq!((&card["planner"], &card["weights_sha256"]), (&name.into(), &hash.as_str().into()));
        // It is what success in held-out worlds was measured with, and better than what it must beat.
        let success = |of: &str| card["held_out"][of]["all"]["success"].as_f64().expect("a number");
        assert!(success("policy") > success("pid"), "{name}: {} {}", success("policy"), success("pid"));
        let told = bench.ok(&[
            "inspect",
            "--plugin",
            text(&plugin(name, PluginKind::Wasm)),
            "--message-format",
            "json",
        ]);
        let told: Value = serde_json::from_str(&told).expect("JSON");
        let model = told["models"][0].as_str().expect("its weights");
        assert!(model.contains(&format!("policy.vbnn sha256 {hash}")), "{name}: {model}");
    }
}
