//! What planners may do, what becomes of those that fail, and what the harness tells of them.

use std::path::Path;

use serde_json::{Value, json};
use vb_tests::{Bench, PluginKind, pid, plugin};

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// How a planner fails, and what is to be told of it.
struct Failure {
    plugin_kind: PluginKind,
    fault: &'static str,
    kind: &'static str,
    /// Part of the reason.
    says: &'static str,
    /// Steps that the planner was asked for.
    steps: u64,
}

/// A planner's failure costs one task, whatever it is. An endless loop of a native planner takes the watchdog's time, so
/// that it is left to the tests of the host.
#[test]
fn each_kind_of_failure_ends_its_own_task_with_its_kind_and_reason_and_no_other() {
    let wasm = |fault, kind, says, steps| Failure { plugin_kind: PluginKind::Wasm, fault, kind, says, steps };
    let native =
        |fault, kind, says, steps| Failure { plugin_kind: PluginKind::Native, fault, kind, says, steps };
    let failures = [
        wasm("error", "planner/error", "step 3 (t = 0.30 s): returned an error: instructed to give up", 4),
        wasm("panic", "planner/panic", "step 3 (t = 0.30 s): panicked at examples/faulty/src/lib.rs", 4),
        wasm("nan", "planner/invalid-output", "step 3 (t = 0.30 s): steering is NaN", 4),
        wasm(
            "endless",
            "planner/out-of-fuel",
            "step 3 (t = 0.30 s): exceeded its limit of 50000000 units of fuel",
            4,
        ),
        wasm("memory", "planner/out-of-memory", "bytes of memory; the limit is 33554432", 4),
        wasm("stack", "planner/stack-overflow", "step 3 (t = 0.30 s): overflowed its stack", 4),
        wasm("init-error", "planner/init-failed", "init: returned an error: instructed to give up", 0),
        wasm("init-panic", "planner/panic", "init: panicked at examples/faulty/src/lib.rs", 0),
        wasm("init-memory", "planner/out-of-memory", "init: requested", 0),
        native("error", "planner/error", "step 3 (t = 0.30 s): returned an error: instructed to give up", 4),
        native("panic", "planner/panic", "step 3 (t = 0.30 s): panicked at examples/faulty/src/lib.rs", 4),
        native("nan", "planner/invalid-output", "step 3 (t = 0.30 s): steering is NaN", 4),
        native("memory", "planner/out-of-memory", "exceeded its memory limit of 33554432 bytes", 4),
        native("stack", "planner/stack-overflow", "step 3 (t = 0.30 s): overflowed its stack", 4),
        native("init-error", "planner/init-failed", "init: returned an error: instructed to give up", 0),
        native("init-panic", "planner/panic", "init: panicked at examples/faulty/src/lib.rs", 0),
    ];
    let bench = Bench::new();
    let run = |plugin_kind, fault: &str, out: &str| {
        let (plugin, fault) = (plugin("faulty", plugin_kind), format!("fault={fault}"));
        let args = ["--plugin", text(&plugin), "--tasks", "w001/t00-t02", "--param", &fault];
        // The fuel is what growing to the limit of memory needs, and ends the endless loop soon.
        let more =
            ["--param", "only=w001/t01", "--out", out, "--fuel-per-step", "50000000", "--memory", "32M"];
        bench.ok(&[&args[..], &more].concat());
        bench.records(out)
    };
    for plugin_kind in [PluginKind::Wasm, PluginKind::Native] {
        let whole = run(plugin_kind, "none", &format!("none-{plugin_kind:?}"));
        for f in failures.iter().filter(|f| f.plugin_kind == plugin_kind) {
            let what = format!("{plugin_kind:?} {}", f.fault);
            let mut records = run(plugin_kind, f.fault, &what.replace(' ', "-"));
            let failed = records.remove("w001/t01").expect("the task is recorded");
            assert_eq!(failed["outcome"], "planner_error", "{what}");
            assert_eq!(failed["three_way"], "stuck", "{what}");
            assert_eq!(failed["fault"], f.kind, "{what}");
            let reason = failed["reason"].as_str().expect("a reason");
            // Who, where, what.
            assert!(reason.starts_with("planner faulty 1.0.0-rc.1 on w001/t01, "), "{what}: {reason}");
            assert!(reason.contains(f.says) && reason.lines().count() == 1, "{what}: {reason}");
            assert_eq!(failed["planner_steps"], f.steps, "{what}");
            assert_eq!(failed["metrics"].is_null(), f.steps == 0, "{what}");
            assert_eq!(records.len(), 2, "{what}");
            for (task, record) in records {
                assert_eq!(record["state_hash"], whole[&task]["state_hash"], "{what}: {task}");
                assert_eq!(record["outcome"], "stuck", "{what}: {task}");
            }
        }
    }
}

/// The watchdog by the wall clock only fires for what fuel doesn't explain, so it is the host's fault.
#[test]
fn what_the_host_failed_counts_for_nobody_and_is_run_again() {
    let bench = Bench::new();
    bench.write("limits.yaml", "fuel_per_step: 9000000000000000000\nwatchdog_ms: 300\nwasm_watchdog: true\n");
    let plugin = plugin("faulty", PluginKind::Wasm);
    let args = ["--plugin", text(&plugin), "--tasks", "w001/t00-t01", "--param", "fault=endless"];
    let more = ["--param", "only=w001/t01", "--limits", "limits.yaml", "--out", "r"];
    let args = [&args[..], &more].concat();
    let message = bench.run(&args).error(7);
    assert!(message.contains("--resume re-runs them"), "{message}");
    let record = &bench.records("r")["w001/t01"];
    assert_eq!((&record["outcome"], &record["fault"]), (&"host_error".into(), &"host/watchdog".into()));
    let summary = bench.json("r/summary.json");
    assert_eq!(summary["host_errors"], Value::from(vec!["w001/t01"]));
    assert_eq!((&summary["all"]["tasks"], &summary["all"]["outcomes"]["stuck"]), (&1.into(), &1.into()));
    // Resumed, the task is run again, and its line replaced.
    let again = bench.run(&[&args[..], &["--resume"]].concat()).error(7);
    assert!(again.contains("1 tasks failed"), "{again}");
    assert_eq!(bench.records("r").len(), 2);
}

#[test]
fn limits_come_from_a_file_and_lie_in_the_results_with_what_was_used() {
    let bench = Bench::new();
    bench.write(
        "limits.yaml",
        "# All others keep their defaults.\nfuel_per_step: 1000000\nstack_bytes: 262144\n",
    );
    let pid = pid();
    let args = ["--plugin", text(&pid), "--tasks", "w001/t00", "--limits", "limits.yaml", "--out", "r"];
    bench.ok(&[&args[..], &["--memory", "32M"]].concat());
    let limits = &bench.json("r/run.json")["limits"];
    assert_eq!((&limits["fuel_per_step"], &limits["stack_bytes"]), (&1_000_000.into(), &262_144.into()));
    assert_eq!((&limits["memory_bytes"], &limits["table_elements"]), (&(32 << 20).into(), &(1 << 20).into()));
    assert_eq!(limits.as_object().expect("limits").len(), 13);
    let fuel = &bench.records("r")["w001/t00"]["fuel"];
    let n = |name: &str| fuel[name].as_f64().expect(name);
    assert!(
        0.0 < n("p50_step") && n("p50_step") <= n("p99_step") && n("p99_step") <= n("max_step"),
        "{fuel}"
    );
    assert_eq!(n("max_fraction"), n("max_step") / 1e6);
    assert!(n("memory_bytes") > 0.0 && n("init") > 0.0, "{fuel}");
    assert_eq!(bench.json("r/summary.json")["all"]["fuel"], *fuel);
    for (content, words) in [
        ("fuel: 3\n", &["limits.yaml", "fuel"][..]),
        ("fuel_per_step: many\n", &["limits.yaml", "fuel_per_step", "many"]),
        ("stack_bytes: 1\n", &["limits.yaml", "stack_bytes", "65536"]),
    ] {
        bench.write("limits.yaml", content);
        let message = bench.run(&args).error(3);
        assert!(words.iter().all(|w| message.contains(w)), "{message}");
    }
}

#[test]
fn a_failing_planner_is_told_with_its_log_and_with_details_with_its_functions() {
    let bench = Bench::new();
    let plugin = plugin("faulty", PluginKind::Wasm);
    let args = ["--plugin", text(&plugin), "--tasks", "w001/t00", "--param", "fault=stack"];
    let (plain, debug) = (
        bench.run(&[&args[..], &["--out", "a"]].concat()).stderr,
        bench.run(&[&args[..], &["--out", "b", "--verbose"]].concat()).stderr,
    );
    assert!(plain.contains("    log | info: failing at 0.3 s: stack"), "{plain}");
    assert!(plain.contains("1 of 1000 tasks selected"), "{plain}");
    // Without progress and hints only the place of the results is left.
    let quiet = bench.run(&[&args[..], &["--out", "c", "--quiet"]].concat()).stderr;
    assert_eq!(quiet, "results: c\n");
    // Colours are those of outcomes alone; what a planner says can't have any.
    let coloured = bench.run(&[&args[..], &["--out", "d", "--color", "always"]].concat()).stderr;
    assert!(coloured.contains("\u{1b}[35m") && !plain.contains('\u{1b}'), "{coloured}");
    assert!(!plain.contains("      0 | ") && debug.contains("      0 | faulty::recurse\n"), "{debug}");
}

#[test]
fn the_log_of_a_planner_that_fails_is_kept() {
    let bench = Bench::new();
    for plugin_kind in [PluginKind::Wasm, PluginKind::Native] {
        let (plugin, out) = (plugin("faulty", plugin_kind), format!("{plugin_kind:?}"));
        let args = ["--plugin", text(&plugin), "--tasks", "w001/t00", "--param", "fault=error"];
        bench.ok(&[&args[..], &["--param", "at=5", "--out", &out]].concat());
        let log = &bench.records(&out)["w001/t00"]["log"];
        assert_eq!(*log, Value::from(vec!["info: failing at 0.5 s: error"]), "{plugin_kind:?}");
    }
}

/// A vehicle that stands still is no error of its planner's, but its log may tell why it does.
#[test]
fn the_log_of_a_vehicle_that_got_stuck_is_kept_unless_none_is_wanted() {
    let bench = Bench::new();
    let plugin = plugin("faulty", PluginKind::Wasm);
    let args = ["--plugin", text(&plugin), "--tasks", "w001/t00", "--param", "fault=range"];
    let run = |out: &str, more: &[&str]| {
        let done = bench.run(&[&args[..], &["--out", out], more].concat());
        assert!(done.status.success(), "{}", done.stderr);
        let record = bench.records(out).remove("w001/t00").expect("the task is recorded");
        assert_eq!(record["outcome"], "stuck");
        (record, done.stderr)
    };
    // It logs a line a step, every 0.1 s until 9.9 s; the last 20 are kept.
    let lines: Vec<String> =
        (80..100).map(|k| format!("info: failing at {} s: range", f64::from(k) / 10.0)).collect();
    let (usual, told) = run("usual", &[]);
    let kept = usual["log"].as_array().expect("a log");
    assert_eq!((kept.len(), &kept[0]), (20, &Value::from(lines[0].clone())));
    assert!(!told.contains("log | "), "{told}");
    assert_eq!(bench.json("usual/run.json")["logs"], "failed");
    let (all, told) = run("all", &["--logs", "all", "-v"]);
    assert_eq!(all, usual, "the lines are the same whenever the task is driven");
    assert!(told.contains("    log | info: failing at 9.9 s: range"), "{told}");
    let (none, _) = run("none", &["--logs", "none"]);
    assert!(none["log"].is_null(), "{none}");
    assert_eq!(none["state_hash"], usual["state_hash"]);
    // Scoring again leaves it as it is.
    let told = bench.ok(&["score", "usual", "--message-format", "json"]);
    let first: Value = serde_json::from_str(told.lines().next().expect("a line")).expect("JSON");
    assert_eq!(first["record"]["log"], usual["log"]);
    // Records hold it, so a run goes on with the same.
    let error = bench.run(&[&args[..], &["--out", "usual", "--resume", "--logs", "all"]].concat()).error(4);
    assert!(error.contains("logs"), "{error}");
}

#[test]
fn commands_out_of_range_are_clamped_and_counted() {
    let bench = Bench::new();
    let plugin = plugin("faulty", PluginKind::Wasm);
    let args =
        ["--plugin", text(&plugin), "--tasks", "w001/t00", "--param", "fault=range", "--trace", "full"];
    bench.ok(&[&args[..], &["--out", "r"]].concat());
    let record = &bench.records("r")["w001/t00"];
    // It stands still, so that the rule of the paper ends the task after 10 s and 100 steps. It asks for steering 7
    // from step 3 on.
    assert_eq!(record["outcome"], "stuck");
    assert_eq!((&record["planner_steps"], &record["clamped"]), (&100.into(), &97.into()));
    assert_eq!(bench.json("r/summary.json")["all"]["clamped"], 97);
    let rows = bench.parquet("r/traces/w001/t00.parquet");
    assert_eq!(rows.len(), 1001);
    for row in &rows {
        let time = row["time"].as_f64().expect("time");
        // The command of the step at 0.3 s is what was applied up to 0.31 s and later.
        let wanted = if time < 0.305 { 0.0 } else { 1.0 };
        assert_eq!(row["steering"], wanted, "at {time} s");
        assert_eq!(row["brake"], if time == 0.0 { 0.0 } else { 1.0 }, "at {time} s");
    }
}

#[test]
fn series_of_a_planner_lie_beside_the_trajectory() {
    let bench = Bench::new();
    let mut files = Vec::new();
    for plugin_kind in [PluginKind::Wasm, PluginKind::Native] {
        let (plugin, out) = (plugin("faulty", plugin_kind), format!("{plugin_kind:?}"));
        bench.ok(&["--plugin", text(&plugin), "--tasks", "w001/t00", "--out", &out]);
        let rows = bench.parquet(&format!("{out}/traces/w001/t00.debug.parquet"));
        // Number and time of each of the 100 steps.
        assert_eq!(rows.len(), 200, "{plugin_kind:?}");
        for (i, row) in rows.iter().enumerate() {
            let step = (i / 2) as f64;
            assert_eq!((&row["name"], &row["index"]), (&"step".into(), &(i % 2).into()));
            let (time, value) = (row["time"].as_f64().expect("time"), row["value"].as_f64().expect("value"));
            assert!((time - 0.1 * step).abs() < 1e-9, "{row}");
            // Values are single precision.
            let wanted = if i % 2 == 0 { step } else { 0.1 * step };
            assert!((value - wanted).abs() <= 1e-6 * wanted, "{row}");
        }
        files.push(bench.files(&format!("{out}/traces")));
    }
    assert!(files[0] == files[1], "both kinds of plugin hand over the same");
    // What keeps no trajectory keeps no series.
    let plugin = plugin("faulty", PluginKind::Wasm);
    bench.ok(&["--plugin", text(&plugin), "--tasks", "w001/t00", "--out", "bare", "--trace", "none"]);
    assert!(!bench.path("bare/traces").exists());
    assert_eq!(bench.records("bare"), bench.records("Wasm"));
}

#[test]
fn parameters_reach_the_planner() {
    let bench = Bench::new();
    let pid = pid();
    // The second is the default as `inspect` prints it.
    for speed in ["3", "5.0"] {
        let param = format!("speed={speed}");
        bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00-t02", "--param", &param, "--out", speed]);
        assert_eq!(bench.json(&format!("{speed}/run.json"))["params"]["speed"], speed);
    }
    let (slow, fast) = (bench.records("3"), bench.records("5.0"));
    for (task, slow) in &slow {
        let fast = &fast[task];
        assert_eq!((&slow["outcome"], &fast["outcome"]), (&"success".into(), &"success".into()), "{task}");
        // A proportional controller stays below its target on average; 3/5 of the time is what the target asks for.
        let ratio = fast["time_s"].as_f64().expect("time") / slow["time_s"].as_f64().expect("time");
        assert!((0.5..0.75).contains(&ratio), "{task}: {ratio}");
    }
    bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00-t02", "--out", "default"]);
    assert_eq!(bench.records("default"), fast);
}

#[test]
fn a_value_that_the_planner_refuses_is_told_in_the_planners_words() {
    let bench = Bench::new();
    let pid = pid();
    bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00", "--param", "speed=-1", "--out", "r"]);
    let record = &bench.records("r")["w001/t00"];
    assert_eq!(
        (&record["outcome"], &record["fault"]),
        (&"planner_error".into(), &"planner/init-failed".into())
    );
    let reason = record["reason"].as_str().expect("a reason");
    assert!(reason.contains("init: returned an error: parameter `speed`: -1 is not above 0"), "{reason}");
}

#[test]
fn inspect_tells_the_same_of_both_kinds() {
    let bench = Bench::new();
    for name in ["pid", "pursuit", "faulty"] {
        let told = [PluginKind::Wasm, PluginKind::Native].map(|plugin_kind| {
            let plugin = plugin(name, plugin_kind);
            let json = bench.ok(&["inspect", "--plugin", text(&plugin), "--message-format", "json"]);
            assert_eq!(json.lines().count(), 1);
            let message: Value = serde_json::from_str(&json).expect("JSON");
            (message, bench.ok(&["inspect", "--plugin", text(&plugin)]))
        });
        assert_eq!(told[0], told[1]);
        let (message, table) = &told[0];
        assert_eq!((&message["event"], &message["name"]), (&"plugin".into(), &name.into()));
        assert_eq!((&message["abi"], &message["control_period_s"]), (&"1.0".into(), &0.1.into()));
        for param in message["params"].as_array().expect("parameters") {
            let (key, default) = (param["key"].as_str(), param["default"].as_str());
            let option = format!("--param {}={}", key.expect("a key"), default.expect("a default"));
            assert!(table.contains(&option), "{option} in {table}");
        }
    }
    // The speed that the paper's traversal times imply (docs/planners.md).
    let pid = pid();
    assert!(bench.ok(&["inspect", "--plugin", text(&pid)]).contains("--param speed=5.0"));
}

#[test]
fn inspect_tells_the_sensors_that_a_planner_asks_for() {
    let bench = Bench::new();
    let told = |name: &str| {
        let file = plugin(name, PluginKind::Wasm);
        let json = bench.ok(&["inspect", "--plugin", text(&file), "--message-format", "json"]);
        let message: Value = serde_json::from_str(&json).expect("JSON");
        let table = bench.ok(&["inspect", "--plugin", text(&file)]);
        (message["needs"].clone(), message["needs_without_maps"].clone(), table)
    };
    // What a planner gets that declares nothing.
    let default = json!([{"sensor": "pose", "rate_hz": null}, {"sensor": "wheel-odometry", "rate_hz": null}]);
    let (needs, without_maps, table) = told("pid");
    assert_eq!((&needs, &without_maps), (&default, &json!([])));
    assert!(table.contains("pose, wheel-odometry") && !table.contains("without maps"), "{table}");
    let (needs, without_maps, table) = told("mppi");
    assert_eq!(needs, default);
    assert_eq!(without_maps[0]["sensor"], "local-map");
    assert!(table.contains("without maps") && table.contains("local-map"), "{table}");
}
