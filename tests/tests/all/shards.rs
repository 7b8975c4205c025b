//! Many machines drive the parts of a run, and together they leave what one leaves: docs/scale.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use vb_tests::{Bench, Done, pid};

/// Tasks of nine worlds.
const TASKS: &str = "w001-w009/t00-t01";

/// The command line of a run of these tasks.
fn args(out: &str, more: &[&str]) -> Vec<String> {
    let args = ["--plugin", pid().to_str().unwrap(), "--param", "speed=6", "--tasks", TASKS, "--out", out]
        .map(str::to_owned);
    args.into_iter().chain(more.iter().map(|a| (*a).to_owned())).collect()
}

/// Drives one of several parts, or what is left of it.
fn shard(bench: &Bench, shard: &str) {
    bench.ok(&args("parts", &["--shard", shard, "--resume"]));
}

/// The files of a run, but for the time of its start, which run.json has, and its checksum.
fn files(bench: &Bench, run: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = bench.files(run);
    let text = |bytes: Vec<u8>, no: &str| {
        let text = String::from_utf8(bytes).unwrap();
        text.lines().filter(|l| !l.contains(no)).collect::<Vec<_>>().join("\n").into_bytes()
    };
    for (name, no) in [("run.json", "started_at"), ("checksums.txt", "  run.json")] {
        let bytes = files.remove(Path::new(name)).unwrap();
        files.insert(name.into(), text(bytes, no));
    }
    files
}

#[test]
fn shards_joined_are_byte_for_byte_the_run_of_one_machine() {
    let bench = Bench::new();
    bench.ok(&args("one", &["--jobs", "2"]));
    let one = files(&bench, "one");
    assert_eq!(one.len(), 5 + 18);
    // More shards than worlds: one of them is empty.
    for of in [2, 10] {
        for k in 1..=of {
            shard(&bench, &format!("{k}/{of}"));
        }
        bench.ok(&["merge", "parts", "--out", "merged"]);
        let merged = files(&bench, "merged");
        let names = |f: &BTreeMap<PathBuf, Vec<u8>>| f.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&merged), names(&one));
        for (name, bytes) in &one {
            assert!(merged[name] == *bytes, "{}", name.display());
        }
        for dir in ["parts", "merged"] {
            fs::remove_dir_all(bench.path(dir)).unwrap();
        }
    }
}

#[test]
fn what_is_missing_is_named_and_driven_by_resume_and_what_was_driven_twice_is_told() {
    let bench = Bench::new();
    bench.ok(&args("one", &[]));
    for k in ["1/3", "3/3"] {
        shard(&bench, k);
    }
    // A machine that was killed in the midst of its tasks.
    let killed = bench.path("parts/shard-0003-of-0003/tasks.jsonl");
    let text = fs::read_to_string(&killed).unwrap();
    let kept = text.lines().next().unwrap();
    fs::write(&killed, format!("{kept}\n")).unwrap();

    let merge = ["merge", "parts", "--out", "merged"];
    let told = bench.run(&merge).error(11);
    assert!(
        told.contains("11 of 18 tasks are missing: ") && told.contains("--out merged --resume"),
        "{told}"
    );
    bench.ok(&args("merged", &["--resume"]));
    assert_eq!(files(&bench, "merged"), files(&bench, "one"));

    // Its job was begun again, and another took over what it had done.
    shard(&bench, "2/3");
    shard(&bench, "3/3");
    fs::rename(bench.path("parts"), bench.path("first")).unwrap();
    shard(&bench, "3/3");
    let again = ["merge", "first", "parts", "--out", "again", "--json"];
    let told: Value = serde_json::from_str(&bench.ok(&again)).unwrap();
    assert_eq!((told["shards"].as_u64(), told["missing"].as_array().map(Vec::len)), (Some(4), Some(0)));
    assert_eq!(told["twice"].as_array().map(Vec::len), Some(6));
    assert_eq!(files(&bench, "again"), files(&bench, "one"));
}

#[test]
fn a_trace_that_a_shard_has_lost_is_told() {
    let bench = Bench::new();
    for k in ["1/2", "2/2"] {
        shard(&bench, k);
    }
    let part = "parts/shard-0001-of-0002";
    let task = bench.records(part).into_keys().next().expect("a task");
    fs::remove_file(bench.path(part).join(format!("traces/{task}.parquet"))).unwrap();
    let merge = ["merge", "parts", "--out", "merged"];
    let told = bench.run(&merge).error(3);
    assert!(told.contains(&format!("traces/{task}.parquet")) && told.contains("is missing"), "{told}");
    assert!(!bench.path("merged").exists());
    // Who has removed it on purpose removes the checksums, and is told all the same.
    fs::remove_file(bench.path(part).join("checksums.txt")).unwrap();
    let told = bench.run(&merge);
    assert!(told.stderr.contains(&format!("1 tasks have no trace, because their shards lost it: {task}")));
    let _ = told.ok();
}

#[test]
fn resume_begins_a_shard_and_continues_it_and_is_done_at_once_after_its_end() {
    let bench = Bench::new();
    shard(&bench, "1/2");
    let whole = files(&bench, "parts/shard-0001-of-0002");
    let tasks = bench.path("parts/shard-0001-of-0002/tasks.jsonl");
    let text = fs::read_to_string(&tasks).unwrap();
    fs::write(&tasks, text.lines().next().unwrap().to_owned() + "\n").unwrap();
    for _ in 0..2 {
        shard(&bench, "1/2");
        assert_eq!(files(&bench, "parts/shard-0001-of-0002"), whole);
    }
    let e = bench.run(&args("parts", &["--shard", "1/2"])).error(4);
    assert!(e.contains("not empty") && e.contains("--resume"), "{e}");
}

#[test]
fn a_scheduler_says_which_shard_it_is() {
    let bench = Bench::new();
    let auto = |variables: &[(&str, &str)]| {
        let mut command = bench.command(&args("parts", &["--shard", "auto"]));
        command.envs(variables.iter().copied());
        Done::of(&mut command)
    };
    let done = auto(&[("JOB_COMPLETION_INDEX", "1"), ("VB_SHARDS", "2")]).ok();
    assert!(done.contains("pid"), "{done}");
    assert!(bench.path("parts/shard-0002-of-0002/summary.json").is_file());
    let told = auto(&[]).error(2);
    assert!(told.contains("no job of an array"), "{told}");
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let bench = Bench::new();
    shard(&bench, "1/2");
    let refused = |dirs: &[&str], why: &str| {
        let args = [&["merge"], dirs, &["--out", "merged"]].concat();
        let told = bench.run(&args).error(3);
        assert!(told.contains(why), "{told}");
        assert!(!bench.path("merged").exists());
    };
    bench.ok(&args("seed", &["--seed", "1", "--shard", "2/2"]));
    refused(&["parts", "seed"], "belong to different runs: seed differs: 0 and 1");
    bench.ok(&args("split", &["--shard", "2/3"]));
    refused(&["parts", "split"], "belong to different runs: shard.of differs: 2 and 3");
    bench.ok(&args("whole", &[]));
    refused(&["parts", "whole"], "is not a shard");
    refused(&["runs"], "cannot read directory");
    fs::create_dir(bench.path("empty")).unwrap();
    refused(&["empty"], "neither a run nor a shard");
    let told = bench.run(&["merge", "parts", "--suite", "smoke", "--out", "merged"]).error(3);
    assert!(told.contains("of the run (hash"), "{told}");

    // A machine that computes otherwise must not go unnoticed.
    bench.ok(&args("other", &["--shard", "1/2"]));
    for name in ["tasks.jsonl", "checksums.txt"] {
        let path = bench.path("other/shard-0001-of-0002").join(name);
        let text = fs::read_to_string(&path).unwrap();
        if name == "tasks.jsonl" {
            fs::write(&path, text.replacen("\"state_hash\":\"", "\"state_hash\":\"0", 1)).unwrap();
        } else {
            fs::remove_file(&path).unwrap();
        }
    }
    refused(&["parts", "other"], "have different records of w00");

    // Nobody takes a part for the whole.
    let plugin = pid();
    let part = "parts/shard-0001-of-0002";
    let submit = ["submit", "--run", part, "--plugin", plugin.to_str().unwrap(), "--out", "s"];
    let told = bench.run(&submit).error(3);
    assert!(told.contains("is shard 1 of 2 of a run (join the shards with merge first)"), "{told}");
}
