//! The planners that were trained end to end, as their users run them.

use std::path::Path;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin};

const PLANNERS: [&str; 4] = ["rl", "mcl", "acl", "rl-onboard"];

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

#[test]
fn policies_get_over_easy_ground_and_drive_alike_in_both_kinds() {
    let bench = Bench::new();
    for name in PLANNERS {
        // In held-out worlds of low elevation RL onboard completes 85 % with an interval from 70 %, and one task of ten is 10 %.
        let (profile, least) = if name == "rl-onboard" { ("onboard", 6) } else { ("oracle", 8) };
        let records = |kind: PluginKind| {
            let (plugin, out) = (plugin(name, kind), format!("{name}-{kind:?}"));
            let args = ["--plugin", text(&plugin), "--suite", "smoke", "--tasks", "w001", "--out", &out];
            bench.ok(&[&args[..], &["--perception", profile]].concat());
            bench.records(&out)
        };
        let (wasm, native) = (records(PluginKind::Wasm), records(PluginKind::Native));
        // A world of low elevation: in held-out ones they complete nine tasks in ten.
        let completed = wasm.values().filter(|record| record["outcome"] == "success").count();
        assert!(wasm.len() == 10 && completed >= least, "{name}: {completed} of {}", wasm.len());
        for (task, record) in &wasm {
            assert_eq!(record["state_hash"], native[task]["state_hash"], "{name}: {task}");
        }
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
