//! `vb-harness vehicle`: what a person gets who asks whether a vehicle can be believed.

use std::fs;

use serde_json::Value;
use vb_tests::{Bench, root};

/// Exit codes of docs/results.md.
const USAGE: i32 = 2;
const BAD_INPUT: i32 = 3;
const OUTPUT: i32 = 4;
const CHECKS_FAILED: i32 = 6;

fn hmmwv() -> String {
    fs::read_to_string(root().join("tasks/vehicles/hmmwv.yaml")).expect("the shipped vehicle")
}

#[test]
fn vehicles_are_listed_shown_and_checked() {
    let bench = Bench::new();
    assert!(bench.ok(&["list", "vehicles"]).lines().any(|l| l.starts_with("hmmwv ")));
    let shown = bench.ok(&["vehicle", "show", "hmmwv"]);
    // 2060.2 kg sprung and four wheels of 108.44 kg (tasks/vehicles/hmmwv.yaml).
    assert!(shown.contains("2494.0 kg") && shown.contains("axle front"), "{shown}");
    bench.write("mine.yaml", hmmwv());
    assert!(bench.ok(&["vehicle", "validate", "mine.yaml"]).contains("all valid"));
    bench.write("light.yaml", hmmwv().replacen("mass: 2060.2", "mass: -3", 1));
    let error = bench.run(&["vehicle", "validate", "light.yaml"]).error(BAD_INPUT);
    assert!(error.contains("light.yaml: chassis.mass: -3 must be a positive number"), "{error}");
    let error = bench.run(&["vehicle", "show", "tank"]).error(BAD_INPUT);
    assert!(error.contains("there is no vehicle tank") && error.contains("hmmwv"), "{error}");
}

/// The guide imports into a folder `original`, which is a soil set's name too.
#[test]
fn a_folder_of_the_same_name_does_not_hide_what_comes_with_the_harness() {
    let bench = Bench::new();
    for name in ["hmmwv", "original"] {
        fs::create_dir(bench.path(name)).expect("a folder");
    }
    assert!(bench.ok(&["vehicle", "show", "hmmwv"]).contains("axle front"));
    let pid = vb_tests::pid();
    let plugin = pid.to_str().expect("paths of tests are text");
    bench.ok(&[
        "--plugin", plugin, "--tasks", "w007/t00", "--soils", "original", "--trace", "none", "--out", "r",
    ]);
    assert_eq!(bench.json("r/run.json")["soils"]["name"], "original");
}

#[test]
fn a_test_writes_a_page_that_needs_nothing_else_and_results_and_series() {
    let bench = Bench::new();
    let text =
        bench.ok(&["vehicle", "test", "hmmwv", "--out", "r", "--event", "free-fall", "--event", "static"]);
    assert!(text.contains("free-fall") && !text.contains("FAIL"), "{text}");
    let page = fs::read_to_string(bench.path("r/report.html")).expect("a page");
    for outside in ["http://", "https://", "<script", "src=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside} in the page");
    }
    assert!(
        page.contains("<svg") && page.contains("prefers-color-scheme:dark") && page.contains("@media print")
    );
    assert!(!page.contains("NaN"));
    let results = bench.json("r/results.json");
    assert_eq!(results["checks"]["failed"], 0);
    let names: Vec<&Value> =
        results["events"].as_array().expect("events").iter().map(|e| &e["event"]).collect();
    assert_eq!(names, ["static", "free-fall"]);
    let series = fs::read_to_string(bench.path("r/series/free-fall-fall.csv")).expect("a series");
    assert!(
        series.starts_with("t [s],x [m],y [m],z [m],roll [°],") && series.lines().count() > 80,
        "{series}"
    );
}

#[test]
fn the_table_tells_which_checks_were_measured_in_the_set_up_of_their_reference() {
    let bench = Bench::new();
    let text = bench.ok(&[
        "vehicle",
        "test",
        "hmmwv-released",
        "--out",
        "r",
        "--event",
        "static",
        "--tyre",
        "brush",
    ]);
    let line = |of: &str| text.lines().find(|l| l.contains(of)).expect("a line").trim_end().to_owned();
    assert!(line("load front left").ends_with("chrono, in its set-up"), "{text}");
    assert!(line("sum of wheel loads").ends_with("theory"), "{text}");
    let results = bench.json("r/results.json");
    let event = &results["events"][0];
    assert_eq!(event["setups"][0]["setup"], "chrono");
    let in_setup = event["setups"][0]["figures"].as_array().expect("figures");
    let height = |figures: &[Value]| {
        let found = figures.iter().find(|f| f["name"] == "height of the reference point");
        found.expect("the figure")["value"].as_f64().expect("a number")
    };
    let own = height(event["figures"].as_array().expect("figures"));
    // The rigid tyre of the set-up yields 2.4 mm, the other 15 mm.
    assert!(height(in_setup) > own + 0.01, "{} m, as it is {own} m", height(in_setup));
    assert!(bench.files("r").keys().any(|f| f.to_string_lossy().ends_with("-chrono.csv")));
}

#[test]
fn the_whole_test_measures_every_figure_that_it_is_held_against() {
    let bench = Bench::new();
    let done = bench.run(&["vehicle", "test", "hmmwv", "--out", "r"]);
    assert!(matches!(done.status.code(), Some(0 | CHECKS_FAILED)), "{}", done.stderr);
    let results = bench.json("r/results.json");
    let events = results["events"].as_array().expect("events");
    assert!(events.len() > 20);
    for event in events {
        assert_eq!(event["failure"], Value::Null, "{event}");
        for check in event["checks"].as_array().expect("checks") {
            assert!(check["measured"].is_number(), "{}: {check}", event["event"]);
        }
    }
}

#[test]
fn the_number_of_jobs_changes_nothing() {
    let bench = Bench::new();
    for (out, jobs) in [("a", "1"), ("b", "3")] {
        let events = ["static", "drop", "rolling", "free-fall", "grains-bed"].map(|name| ["--event", name]);
        let args =
            [&["vehicle", "test", "hmmwv", "--jobs", jobs, "--out", out], events.as_flattened()].concat();
        let _ = bench.run(&args);
    }
    assert!(bench.files("a").len() > 5);
    assert!(bench.files("a") == bench.files("b"), "reports differ");
}

#[test]
fn a_vehicle_that_is_not_what_it_should_be_fails_with_its_own_exit_code() {
    let bench = Bench::new();
    let released = fs::read_to_string(root().join("tasks/vehicles/hmmwv-released.yaml")).expect("a vehicle");
    bench.write("heavy.yaml", released.replacen("mass: 2095.592", "mass: 2395.592", 1));
    let done = bench.run(&[
        "vehicle",
        "test",
        "heavy.yaml",
        "--event",
        "static",
        "--out",
        "r",
        "--message-format",
        "json",
    ]);
    let messages: Vec<Value> = done.stdout.lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let error = done.error(CHECKS_FAILED);
    assert!(
        error.contains("hmmwv-released: ") && error.contains("checks failed; see r/report.html"),
        "{error}"
    );
    assert_eq!(messages.len(), 2);
    assert_eq!((&messages[0]["event"], &messages[0]["passed"]), (&"vehicle_event".into(), &false.into()));
    // 300 kg on four wheels: 736 N a wheel, beyond 3 % of Chrono's 6339 N; theory goes by the vehicle's own mass.
    let verdict = |figure: &str, kind: &str| {
        let checks = messages[0]["checks"].as_array().expect("checks");
        let found = checks.iter().find(|c| c["figure"] == figure && c["kind"] == kind);
        found.expect("the check")["verdict"].clone()
    };
    assert_eq!(verdict("load front left", "chrono"), "fail");
    assert_eq!(verdict("sum of wheel loads", "theory"), "pass");
    assert_eq!(messages[1]["event"], "summary");
    assert_eq!(messages[1]["passed"], false);
}

#[test]
fn a_vehicle_without_references_is_held_against_theory_alone() {
    let bench = Bench::new();
    bench.write("mine.yaml", hmmwv().replacen("name: hmmwv", "name: mine", 1));
    bench.ok(&["vehicle", "test", "mine.yaml", "--event", "static", "--out", "r"]);
    let results = bench.json("r/results.json");
    let checks = results["events"][0]["checks"].as_array().expect("checks");
    assert!(!checks.is_empty() && checks.iter().all(|c| c["kind"] == "theory"), "{checks:?}");
}

#[test]
fn bad_input_to_a_test_is_one_line_that_says_what_to_do() {
    let bench = Bench::new();
    let refused = |args: &[&str], code: i32, says: &[&str]| {
        let error = bench.run(&[&["vehicle", "test"], args].concat()).error(code);
        for part in says {
            assert!(error.contains(part), "{args:?}: {part:?} is not in {error:?}");
        }
    };
    refused(&["hmmwv", "--event", "flying", "--out", "r"], USAGE, &["unknown event flying", "braking"]);
    refused(&["hmmwv", "--time-step", "50ms", "--out", "r"], USAGE, &["0.05", "between 0.01 and 10 ms"]);
    refused(&[], USAGE, &["NAME|FILE"]);
    bench.write(
        "r.yaml",
        "schema: 1\nvehicle: hmmwv\nevents:\n  braking:\n    - {figure: a, kind: chrono, source: s}\n",
    );
    let args = ["hmmwv", "--references", "r.yaml", "--out", "r"];
    refused(&args, BAD_INPUT, &["r.yaml: events.braking[0].value: give value with fraction or tolerance"]);
    let setup = "setups: {chrono: {about: a, tyre: square}}\nevents:\n  static:\n    - {figure: pitch, at_least: 0, kind: chrono, source: s}\n";
    bench.write("r.yaml", format!("schema: 1\nvehicle: hmmwv\n{setup}"));
    refused(&args, BAD_INPUT, &["r.yaml: setups.chrono.tyre: \"square\" is not among them", "rigid"]);
    bench.write("file", "");
    refused(&["hmmwv", "--event", "static", "--out", "file/r"], OUTPUT, &["file/r"]);
    assert!(bench.ok(&["vehicle", "test", "--list"]).lines().count() > 15);
}
