//! The same inputs give the same bits, however a run is carried out: docs/determinism.md.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;
use vb_tests::{Bench, PluginKind, pid, plugin};

/// A few tasks of each elevation level, with and without success.
const TASKS: &str = "w001/t00,w002/t03,w003/t01,w005/t02,w006/t03,w009/t00";

/// The command line of a run of these tasks.
fn args<'a>(plugin: &'a Path, tasks: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let plugin = plugin.to_str().expect("paths of tests are text");
    let mut args = vec!["--plugin", plugin, "--param", "speed=5", "--tasks", tasks, "--out", out];
    args.extend(more);
    args
}

/// All that a run leaves but for the order of records, run.json and the lock.
#[derive(Debug, PartialEq)]
struct Results {
    records: BTreeMap<String, Value>,
    summary: Value,
    traces: BTreeMap<PathBuf, Vec<u8>>,
}

fn results(bench: &Bench, run: &str) -> Results {
    Results {
        records: bench.records(run),
        summary: bench.json(&format!("{run}/summary.json")),
        traces: bench.files(&format!("{run}/traces")),
    }
}

/// Bytes of traces make no readable message: records first, then the rest.
fn assert_same(a: &Results, b: &Results, what: &str) {
    assert_eq!(a.records, b.records, "{what}");
    assert_eq!(a.summary, b.summary, "{what}");
    let names = |r: &Results| r.traces.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(a), names(b), "{what}");
    assert!(a.traces == b.traces, "{what}: the bytes of traces differ");
}

/// A record without what a native planner has no measure of.
fn but_for_fuel(records: BTreeMap<String, Value>) -> BTreeMap<String, Value> {
    let strip = |(name, mut record): (String, Value)| {
        record.as_object_mut().expect("a record is an object").remove("fuel");
        (name, record)
    };
    records.into_iter().map(strip).collect()
}

#[test]
fn repeated_and_with_any_number_of_workers_a_run_leaves_the_same_bytes() {
    let bench = Bench::new();
    let runs = [("one", "1"), ("again", "1"), ("two", "2"), ("many", "7")];
    let all = runs.map(|(out, jobs)| {
        bench.ok(&args(&pid(), TASKS, out, &["--jobs", jobs]));
        results(&bench, out)
    });
    assert_eq!(all[0].records.len(), 6);
    assert_eq!(all[0].traces.len(), 6);
    for (other, (out, _)) in all.iter().zip(runs) {
        assert_same(&all[0], other, out);
    }
}

#[test]
fn a_task_ends_the_same_alone_and_among_others() {
    let bench = Bench::new();
    bench.ok(&args(&pid(), TASKS, "all", &[]));
    bench.ok(&args(&pid(), "w003/t01", "alone", &[]));
    let (all, alone) = (results(&bench, "all"), results(&bench, "alone"));
    assert_eq!(alone.records["w003/t01"], all.records["w003/t01"]);
    let trace = Path::new("w003/t01.parquet");
    assert!(alone.traces[trace] == all.traces[trace]);
}

/// Without this, a hash that never changes would pass all the other tests.
#[test]
fn another_parameter_gives_another_hash_for_every_task() {
    let bench = Bench::new();
    let plugin = pid();
    bench.ok(&args(&plugin, "w001", "five", &[]));
    // The least that a parameter can differ by.
    let more = "speed=5.000000000000001";
    let plugin = plugin.to_str().expect("paths of tests are text");
    bench.ok(&["--plugin", plugin, "--param", more, "--tasks", "w001", "--out", "more"]);
    let (five, more) = (bench.records("five"), bench.records("more"));
    let mut seen = std::collections::BTreeSet::new();
    for (task, record) in &five {
        assert_ne!(record["state_hash"], more[task]["state_hash"], "{task}");
        assert!(seen.insert(record["state_hash"].as_str()), "{task} has the hash of another task");
    }
}

#[test]
fn a_run_killed_again_and_again_ends_as_the_unbroken_one() {
    let bench = Bench::new();
    let (plugin, tasks) = (pid(), "w001,w003");
    bench.ok(&args(&plugin, tasks, "whole", &[]));
    for kill in 1..=3 {
        let more: &[&str] = if kill == 1 { &["--jobs", "1"] } else { &["--jobs", "1", "--resume"] };
        let mut run = bench.watch(&args(&plugin, tasks, "broken", more));
        let resumed = run.until("started")["resumed"].as_u64();
        // Each task that was told as done has survived the kill.
        assert!(resumed >= Some(2 * (kill - 1)), "{resumed:?} after {} kills", kill - 1);
        run.until("task");
        run.until("task");
        run.kill();
        assert!(!bench.path("broken/summary.json").exists(), "the kill came too late to test anything");
    }
    bench.ok(&args(&plugin, tasks, "broken", &["--jobs", "2", "--resume"]));
    assert_same(&results(&bench, "whole"), &results(&bench, "broken"), "killed");
}

#[cfg(unix)]
#[test]
fn a_run_is_stopped_in_the_midst_of_a_long_step_and_its_task_is_not_recorded() {
    let bench = Bench::new();
    // A step of minutes.
    bench.write("limits.yaml", "fuel_per_step: 1000000000000\n");
    let faulty = plugin("faulty", PluginKind::Wasm);
    let mut args = vec!["--plugin", faulty.to_str().expect("paths of tests are text")];
    args.extend([
        "--param",
        "fault=endless",
        "--limits",
        "limits.yaml",
        "--tasks",
        "w001/t00",
        "--out",
        "long",
    ]);
    let mut run = bench.watch(&args);
    run.until("started");
    std::thread::sleep(std::time::Duration::from_secs(1));
    #[allow(clippy::disallowed_methods, reason = "it is the time that is promised")]
    let now = std::time::Instant::now;
    let asked = now();
    let done = run.interrupt();
    // A second, and what a machine with other work takes to notice.
    assert!(now() - asked < std::time::Duration::from_secs(10));
    assert!(done.error(130).contains("1 tasks left"));
    assert!(bench.records("long").is_empty());
}

#[cfg(unix)]
#[test]
fn a_run_stopped_by_ctrl_c_ends_with_130_and_resumed_as_the_unbroken_one() {
    let bench = Bench::new();
    let (plugin, tasks) = (pid(), "w001,w003");
    bench.ok(&args(&plugin, tasks, "whole", &[]));
    let mut run = bench.watch(&args(&plugin, tasks, "stopped", &["--jobs", "1"]));
    run.until("task");
    let done = run.interrupt();
    let last: Value = done.stdout.lines().last().expect("a last message").parse().expect("JSON");
    assert_eq!((&last["event"], &last["interrupted"]), (&"finished".into(), &true.into()));
    // The summary of what is done is there, and says how much that is.
    assert_eq!(last["summary"], bench.json("stopped/summary.json"));
    assert_eq!(last["summary"]["planned"], 20);
    let e = done.error(130);
    let finished = bench.records("stopped").len();
    assert!((1..20).contains(&finished), "{finished}");
    assert!(
        e.contains(&format!("{} tasks left", 20 - finished)) && e.contains("--out stopped --resume"),
        "{e}"
    );
    bench.ok(&args(&plugin, tasks, "stopped", &["--resume"]));
    assert_same(&results(&bench, "whole"), &results(&bench, "stopped"), "interrupted");
}

#[test]
fn wasm_and_native_planners_leave_the_same_records_but_for_fuel() {
    let bench = Bench::new();
    for name in ["pid", "pursuit"] {
        let (wasm, native) = (format!("{name}-wasm"), format!("{name}-native"));
        bench.ok(&args(&plugin(name, PluginKind::Wasm), TASKS, &wasm, &[]));
        bench.ok(&args(&plugin(name, PluginKind::Native), TASKS, &native, &[]));
        let (wasm, native) = (results(&bench, &wasm), results(&bench, &native));
        for (task, record) in &wasm.records {
            assert!(record["fuel"]["total"].as_u64() > Some(0), "{task}");
            assert!(native.records[task]["fuel"].is_null(), "{task}");
        }
        assert!(wasm.traces == native.traces, "{name}: the bytes of traces differ");
        assert_eq!(but_for_fuel(wasm.records), but_for_fuel(native.records), "{name}");
    }
}
