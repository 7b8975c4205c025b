//! Proof that tasks can be done is collected from runs, and anybody can do them again.

use std::path::Path;

use vb_tests::{Bench, PluginKind, plugin, root};

const BAD_INPUT: i32 = 3;

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

#[test]
fn a_proof_names_who_did_a_task_first_and_what_nobody_did() {
    let bench = Bench::new();
    let [pid, expert] = ["pid", "expert"].map(|name| plugin(name, PluginKind::Wasm));
    let run = |plugin: &Path, tasks: &str, out: &str| {
        bench.ok(&["--plugin", text(plugin), "--suite", "smoke", "--tasks", tasks, "--out", out]);
    };
    run(&pid, "w001/t00-t01", "a");
    run(&expert, "w001/t01-t02", "b");
    let told = bench.ok(&["suite", "prove", "smoke", "a", "b", "--out", "proof.json", "--json"]);
    let proof = bench.json("proof.json");
    let by = |task: &str| proof["tasks"][task]["prover"].as_u64();
    assert_eq!([by("w001/t00"), by("w001/t01"), by("w001/t02")], [Some(0), Some(0), Some(1)]);
    assert_eq!(proof["provers"][1]["planner"], "expert");
    assert_eq!(proof["tasks"]["w001/t02"]["state_hash"], bench.records("b")["w001/t02"]["state_hash"]);
    assert_eq!(proof["unproven"].as_array().map(Vec::len), Some(97));
    let last: serde_json::Value = serde_json::from_str(told.lines().last().expect("a line")).expect("JSON");
    assert_eq!((&last["event"], &last["proven"]), (&"proof".into(), &3.into()));

    // Runs that say nothing of this suite, or drove under other conditions, prove nothing.
    bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00", "--out", "other"]);
    let error = bench.run(&["suite", "prove", "smoke", "other", "--out", "p.json"]).error(BAD_INPUT);
    assert!(error.contains("belongs to a suite with hash"), "{error}");
    bench.ok(&[
        "--plugin",
        text(&pid),
        "--suite",
        "smoke",
        "--tasks",
        "w001/t00",
        "--rules",
        "dev",
        "--out",
        "dev",
    ]);
    let error = bench.run(&["suite", "prove", "smoke", "a", "dev", "--out", "p.json"]).error(BAD_INPUT);
    assert!(error.contains("differs from the first run"), "{error}");
    assert!(!bench.path("p.json").exists());
    // The proof that lies beside the suite isn't replaced by one of fewer tasks.
    let file = root().join("tasks/smoke/proof.json");
    let before = std::fs::read(&file).expect("the suite's proof");
    let error = bench.run(&["suite", "prove", "smoke", "a", "b", "--in-place"]).error(2);
    assert!(
        error.contains("proof.json has certificates of ") && error.contains("another file with --out"),
        "{error}"
    );
    // Nothing is written beside a suite unless the user says so.
    let error = bench.run(&["suite", "prove", "smoke", "a", "b"]).error(2);
    assert!(error.contains("--in-place") && error.contains("--out"), "{error}");
    assert!(std::fs::read(&file).expect("the suite's proof") == before);
}

/// A snapshot: the proof of the small suite is of today's physics. If it fails, re-run `cargo xtask prove smoke`, and say so in the
/// change log, since all results change.
#[test]
fn tasks_that_are_said_to_be_proven_are_done_again_with_the_same_states() {
    let bench = Bench::new();
    let suite = "smoke";
    let file = root().join("tasks").join(suite).join("proof.json");
    let proof: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(file).expect("a proof")).expect("JSON");
    let tasks = proof["tasks"].as_object().expect("tasks");
    // Seven in ten: what is left are soft and high worlds.
    assert!(tasks.len() * 10 >= 7 * (tasks.len() + proof["unproven"].as_array().map_or(0, Vec::len)));
    // The first task of the first two provers, and of the last.
    let last = proof["provers"].as_array().map_or(0, |all| all.len() - 1);
    for prover in [0, 1, last] {
        let (task, drive) = tasks.iter().find(|(_, d)| d["prover"] == prover).expect("it proved something");
        let params = proof["provers"][prover]["params"].as_object().expect("parameters");
        let params: Vec<String> =
            params.iter().map(|(k, v)| format!("{k}={}", v.as_str().unwrap_or_default())).collect();
        let out = format!("{suite}-{prover}");
        let planner = proof["provers"][prover]["planner"].as_str().expect("a planner");
        let planner = plugin(planner, PluginKind::Wasm);
        let mut args = vec!["--plugin", text(&planner), "--suite", suite, "--tasks", task, "--out", &out];
        params.iter().for_each(|p| args.extend(["--param", p.as_str()]));
        bench.ok(&args);
        let record = &bench.records(&out)[task];
        assert_eq!(
            (&record["outcome"], &record["state_hash"]),
            (&"success".into(), &drive["state_hash"]),
            "{task}"
        );
    }
}
