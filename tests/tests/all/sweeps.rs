//! Many runs as one plan: docs/scale.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, pid, plugin};

/// Three planners, two of them one with two speeds, under two profiles, with two seeds: twelve runs of a task of each of two worlds.
fn plan(bench: &Bench) {
    let (pid, mppi) = (pid(), plugin("mppi", PluginKind::Wasm));
    let text = format!(
        "schema: 1\nname: small\ntasks: w001/t00,w005/t02\nplanners:\n- plugin: {}\n  params: {{speed: [4, 6]}}\n- plugin: {}\n  \
         name: mine\nperceptions: [oracle, onboard]\nseeds: [0, 1]\n",
        pid.display(),
        mppi.display()
    );
    bench.write("sweep.yaml", text);
}

fn sweep<'a>(what: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["sweep", what, "sweep.yaml"], more].concat()
}

fn events(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The files of a run but for the time of its start.
fn files(bench: &Bench, run: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = bench.files(run);
    files.retain(|name, _| !["run.json", "checksums.txt"].iter().any(|n| name.ends_with(n)));
    files
}

#[test]
fn a_sweep_is_driven_told_of_and_compared() {
    let bench = Bench::new();
    plan(&bench);
    bench.ok(&sweep("run", &["--out", "one"]));
    let told = events(&bench.ok(&sweep("status", &["--out", "one", "--json"])));
    assert_eq!(told.len(), 13);
    let last = &told[12];
    let count = |name: &str| last[name].as_u64().unwrap();
    assert_eq!((count("runs"), count("runs_done"), count("tasks"), count("tasks_done")), (12, 12, 24, 24));

    // Each is the run that its own command makes.
    let name = "pid,speed=6--hmmwv--onboard--1";
    let pid = pid();
    let plugin = pid.to_str().unwrap();
    let tasks = "w001/t00,w005/t02";
    let own = [
        "--plugin",
        plugin,
        "--param",
        "speed=6",
        "--perception",
        "onboard",
        "--seed",
        "1",
        "--tasks",
        tasks,
        "--out",
        "own",
    ];
    bench.ok(&own);
    assert_eq!(files(&bench, &format!("one/runs/{name}")), files(&bench, "own"));

    let told = bench.ok(&sweep("report", &["--out", "one"]));
    // A table a setting, as `run` shows it, over the tasks of both seeds.
    for head in ["hmmwv, oracle ", "hmmwv, onboard "] {
        let line = told.lines().find(|line| line.starts_with(head)).unwrap();
        assert!(line.contains("tasks  success % (95 % CI)  time s"), "{told}");
    }
    let of_both = |line: &&str| line.split_whitespace().take(2).eq(["mine", "4"]);
    assert_eq!(told.lines().filter(of_both).count(), 2, "{told}");
    let csv = fs::read_to_string(bench.path("one/report/runs.csv")).unwrap();
    assert_eq!(csv.lines().count(), 13);
    let markdown = fs::read_to_string(bench.path("one/report/sweep.md")).unwrap();
    assert!(markdown.starts_with("| small | hmmwv, oracle | hmmwv, onboard |"), "{markdown}");
    assert!(markdown.contains("| pid,speed=4 |") && markdown.contains("| mine |"), "{markdown}");
    for setting in ["hmmwv--oracle", "hmmwv--onboard"] {
        let page = fs::read_to_string(bench.path(format!("one/report/{setting}/index.html"))).unwrap();
        assert!(page.contains("mppi") && page.contains("speed=6"), "{setting}");
    }

    // What is done is not driven again, and more may be wanted later.
    let e = bench.run(&sweep("run", &["--out", "one"])).error(4);
    assert!(e.contains("one is not empty") && e.contains("--resume"), "{e}");
    let again = events(&bench.ok(&sweep("run", &["--out", "one", "--resume", "--json"])));
    assert!(again.is_empty(), "{again:?}");
    let text = fs::read_to_string(bench.path("sweep.yaml")).unwrap();
    bench.write("sweep.yaml", text.replace("seeds: [0, 1]", "seeds: [0, 1, 2]"));
    let more = events(&bench.ok(&sweep("run", &["--out", "one", "--resume", "--json"])));
    assert_eq!(more.iter().filter(|e| e["event"] == "run_finished").count(), 6);
    assert_eq!(more.last().unwrap()["event"], "run_finished");
}

#[test]
fn shards_of_a_sweep_are_even_and_make_the_runs_of_one_machine() {
    let bench = Bench::new();
    plan(&bench);
    bench.ok(&sweep("run", &["--out", "one"]));
    // 24 worlds of all runs, and so eight in each shard, of a task each.
    for k in ["1/3", "2/3"] {
        let told = events(&bench.ok(&sweep("run", &["--out", "many", "--shard", k, "--json"])));
        assert_eq!(told.iter().filter(|e| e["event"] == "task").count(), 8);
    }
    let told = bench.run(&sweep("report", &["--out", "many"])).error(11);
    assert!(
        told.contains("runs are unfinished and omitted: ") && told.contains("sweep run --resume continues"),
        "{told}"
    );

    // A machine is killed in the midst of it; the same command with --resume continues.
    let args = sweep("run", &["--out", "many", "--shard", "3/3", "--jobs", "1"]);
    let mut watched = bench.watch(&args);
    watched.until("task");
    watched.kill();
    let e = bench.run(&args).error(4);
    assert!(e.contains("shard-0003-of-0003 is not empty") && e.contains("--resume"), "{e}");
    let rest = events(&bench.ok(&[&args[..], &["--resume", "--json"]].concat()));
    assert!(rest.iter().filter(|e| e["event"] == "task").count() < 8);
    bench.ok(&sweep("report", &["--out", "many"]));
    let (one, many) = (files(&bench, "one/runs"), files(&bench, "many/runs"));
    assert_eq!(one.keys().collect::<Vec<_>>(), many.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(many[name] == *bytes, "{}", name.display());
    }
    let told = events(&bench.ok(&sweep("status", &["--out", "many", "--json"])));
    assert_eq!(told[12]["runs_done"], 12);
}

#[test]
fn what_would_make_a_whole_run_fail_is_told_before_the_first_begins() {
    let bench = Bench::new();
    plan(&bench);
    let text = fs::read_to_string(bench.path("sweep.yaml")).unwrap();
    let refused = |from: &str, to: &str, code: i32, why: &str| {
        bench.write("sweep.yaml", text.replace(from, to));
        let told = bench.run(&sweep("run", &["--out", "out"])).error(code);
        assert!(told.contains(why), "{told}");
        assert!(!bench.path("out").exists());
    };
    refused("name: mine", "name: mine\n  params: {spede: 4}", 2, "mine,spede=4--hmmwv--oracle--0: ");
    refused("mppi.wasm", "nppi.wasm", 3, "nppi.wasm");
    refused("[oracle, onboard]", "[oracle, inboard]", 3, "inboard");
    refused("seeds", "vehicles: [hmmwv, tank]\nseeds", 3, "tank");
    refused("w005", "w905", 3, "sweep.yaml: tasks: task selector: ");
    refused("perceptions", "perception", 3, "perception");
}

#[test]
fn shards_of_another_plan_are_not_mixed_with_those_that_are_there() {
    let bench = Bench::new();
    plan(&bench);
    let shard = sweep("run", &["--out", "out", "--shard", "1/12", "--resume"]);
    bench.ok(&shard);
    let text = fs::read_to_string(bench.path("sweep.yaml")).unwrap();
    bench.write("sweep.yaml", text.replace("seeds: [0, 1]", "seeds: [0, 1, 2]"));
    for args in [shard, sweep("run", &["--out", "out", "--resume"])] {
        let told = bench.run(&args).error(4);
        assert!(told.contains("out was started with another plan"), "{told}");
    }
}

#[test]
fn a_planner_that_can_not_begin_is_told_of_and_the_others_are_driven() {
    let bench = Bench::new();
    let (pid, faulty) = (pid(), plugin("faulty", PluginKind::Wasm));
    bench.write(
        "sweep.yaml",
        format!(
            "schema: 1\nname: s\ntasks: w001,w002,w003\nplanners:\n- plugin: {}\n  params: {{fault: init-error}}\n- plugin: {}\n",
            faulty.display(),
            pid.display()
        ),
    );
    let told = bench.run(&sweep("run", &["--out", "out"])).error(10);
    assert!(
        told.contains(
            "1 of 2 runs have failures; faulty,fault=init-error--hmmwv--oracle--0: the planner failed in all"
        ),
        "{told}"
    );
    assert_eq!(bench.records("out/runs/pid--hmmwv--oracle--0").len(), 30);
}

#[test]
fn a_task_that_two_shards_have_done_counts_once() {
    let bench = Bench::new();
    let plan = "schema: 1\nname: one\ntasks: w001/t00,w005/t02\nplanners:\n- plugin: PID\n";
    bench.write("sweep.yaml", plan.replace("PID", pid().to_str().unwrap()));
    bench.ok(&sweep("run", &["--out", "s", "--shard", "1/2"]));
    let shards = fs::read_dir(bench.path("s/shards")).unwrap().next().unwrap().unwrap().path();
    vb_tests::copy_dir(&shards.join("shard-0001-of-0002"), &shards.join("shard-0001-of-0002-again"));
    let told = events(&bench.ok(&sweep("status", &["--out", "s", "--json"])));
    assert_eq!(told[1]["tasks_done"].as_u64(), Some(1), "{told:?}");
    // A run that lacks a task isn't joined as if it were done, so that the other shard still becomes a part of it.
    let e = bench.run(&sweep("report", &["--out", "s"])).error(11);
    assert!(e.contains("1 of 1 runs are unfinished"), "{e}");
    bench.ok(&sweep("run", &["--out", "s", "--shard", "2/2"]));
    bench.ok(&sweep("report", &["--out", "s"]));
}
