//! The vehicles that come with the harness, as a user meets them, and one of his own.

use std::fs;

use serde_json::Value;
use vb_tests::{Bench, pid, root};

/// The names of tasks/vehicles.
fn names() -> Vec<String> {
    let entries = fs::read_dir(root().join("tasks/vehicles")).expect("the shipped vehicles");
    let mut names: Vec<String> = entries
        .flatten()
        .filter_map(|e| e.file_name().to_string_lossy().strip_suffix(".yaml").map(str::to_owned))
        .collect();
    names.sort();
    names
}

/// One drive on rigid ground and one on soil.
const TASKS: &str = "w001/t00,w065/t00";

#[test]
fn every_vehicle_drives_the_same_bits_with_any_number_of_workers() {
    let bench = Bench::new();
    let plugin = pid();
    let plugin = plugin.to_str().expect("paths of tests are text");
    for name in names() {
        let runs = ["1", "2"].map(|jobs| {
            let out = format!("{name}-{jobs}");
            let args = ["--plugin", plugin, "--vehicle", &name, "--tasks", TASKS, "--jobs", jobs];
            bench.ok(&[&args[..], &["--trace", "none", "--out", &out]].concat());
            bench.records(&out)
        });
        assert_eq!(runs[0], runs[1], "{name}");
        for record in runs[0].values() {
            assert!(record["state_hash"].is_string() && record["outcome"] != "sim_error", "{name}: {record}");
        }
    }
}

#[test]
fn a_small_vehicle_runs_in_worlds_of_its_scale_unless_told_otherwise() {
    let bench = Bench::new();
    let plugin = pid();
    let plugin = plugin.to_str().expect("paths of tests are text");
    let scale = |more: &[&str], out: &str| {
        let args = ["--plugin", plugin, "--tasks", "w001/t00", "--trace", "none", "--out", out];
        bench.ok(&[&args[..], more].concat());
        bench.json(&format!("{out}/run.json"))["scale"].as_f64().expect("a number")
    };
    assert_eq!(scale(&["--vehicle", "artcar"], "a"), 1.0 / 6.0);
    assert_eq!(scale(&["--vehicle", "verti4wheeler"], "b"), 0.1);
    assert_eq!(scale(&["--vehicle", "hmmwv"], "c"), 1.0);
    assert_eq!(scale(&["--vehicle", "artcar", "--scale", "1/10"], "d"), 0.1);
}

#[test]
fn vehicles_are_listed_and_shown_to_programs_and_drawn() {
    let bench = Bench::new();
    let listed: Vec<Value> = bench
        .ok(&["list", "vehicles", "--json"])
        .lines()
        .map(|l| serde_json::from_str(l).expect("JSON"))
        .collect();
    let found: Vec<&str> = listed.iter().map(|v| v["name"].as_str().expect("a name")).collect();
    assert_eq!(found, names());
    for v in &listed {
        let name = v["name"].as_str().expect("a name");
        let shown: Value =
            serde_json::from_str(&bench.ok(&["vehicle", "show", name, "--json", "--svg", "v.svg"]))
                .expect("JSON");
        assert_eq!(shown["mass_kg"], v["mass_kg"], "{name}");
        let loads: f64 = shown["axles"]
            .as_array()
            .expect("axles")
            .iter()
            .map(|a| a["load_n"].as_f64().expect("a load"))
            .sum();
        let weight = 9.81 * v["mass_kg"].as_f64().expect("a mass");
        // Shown as soon as it has settled, when its springs still move by some hundredths of a millimetre, and the tyres of a robot
        // without springs by a fifth of a millimetre.
        assert!((loads / weight - 1.0).abs() < 0.03, "{name}: {loads} N of {weight} N");
        let svg = fs::read_to_string(bench.path("v.svg")).expect("a picture");
        // Side and top view have every wheel, and nothing comes from elsewhere.
        let wheels = svg.matches("class=\"wheel\"").count();
        assert_eq!(wheels as u64, 2 * v["wheels"].as_u64().expect("a number"), "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("href") && !svg.contains("inf"), "{name}");
    }
}

/// docs/vehicles.md shows for each vehicle what `vehicle show` says, and the picture that it draws.
#[test]
fn the_page_of_vehicles_says_what_the_command_says() {
    let bench = Bench::new();
    let page = fs::read_to_string(root().join("docs/vehicles.md")).expect("the page");
    for name in names() {
        let shown = bench.ok(&["vehicle", "show", &name, "--svg", "v.svg"]);
        assert!(page.contains(&shown), "docs/vehicles.md is not what vehicle show {name} says:\n{shown}");
        let file = root().join(format!("docs/vehicles/{name}.svg"));
        let kept = fs::read_to_string(&file).expect("a picture for each vehicle");
        let drawn = fs::read_to_string(bench.path("v.svg")).expect("a picture");
        assert!(kept == drawn, "{} is not what vehicle show --svg draws", file.display());
    }
}

/// The worked example of docs/custom-vehicle.md: its file is whole, its commands run, and its mistakes are told as shown.
#[test]
fn the_guide_to_a_vehicle_of_ones_own_works() {
    let bench = Bench::new();
    let guide = fs::read_to_string(root().join("docs/custom-vehicle.md")).expect("the guide");
    let yaml = guide.split("```yaml\n").nth(1).and_then(|t| t.split("```").next()).expect("the file");
    bench.write("buggy.yaml", yaml);
    assert!(bench.ok(&["vehicle", "validate", "buggy.yaml"]).contains("all valid"));
    bench.ok(&["vehicle", "show", "buggy.yaml", "--svg", "buggy.svg"]);
    let events = ["static", "suspension", "free-fall", "parked"];
    let mut args = vec!["vehicle", "test", "buggy.yaml", "--out", "report"];
    args.extend(events.iter().flat_map(|e| ["--event", e]));
    bench.ok(&args);
    let plugin = pid();
    let plugin = plugin.to_str().expect("paths of tests are text");
    bench.ok(&["--plugin", plugin, "--vehicle", "buggy.yaml", "--tasks", "w001/t00", "--out", "run"]);
    // A row of the table of mistakes: change, then what it says.
    let mut rows = 0;
    let mistakes = guide.split("| replace |").nth(1).and_then(|t| t.split("\n\n").next()).expect("the table");
    for row in mistakes.lines().filter(|l| l.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let code = |c: &str| c.trim_matches('`').to_owned();
        let (from, to, says) = (code(cells[1]), code(cells[2]), code(cells[3]));
        assert!(yaml.contains(&from), "{from} is not in the example");
        bench.write("broken.yaml", yaml.replace(&from, &to));
        let error = bench.run(&["vehicle", "validate", "broken.yaml"]).error(3);
        assert!(error.contains(&says), "{says:?} is not in {error:?}");
        rows += 1;
    }
    assert!(rows >= 4, "{rows}");
}

/// Some of what `cargo xtask soak` drives: two tasks each of low, medium and high worlds, and one in which a vehicle that
/// lay on its side was thrown about.
const SOAKED: &str = "w001/t00,w034/t03,w002/t02,w065/t01,w003/t05,w096/t07,w096/t02";

#[test]
fn no_simulation_fails_whatever_the_commands() {
    let bench = Bench::new();
    let plugin = vb_tests::plugin("wild", vb_tests::PluginKind::Wasm);
    let plugin = plugin.to_str().expect("paths of tests are text");
    for name in names() {
        let args = ["--plugin", plugin, "--vehicle", &name, "--suite", "vb-100", "--tasks", SOAKED];
        bench.ok(&[&args[..], &["--keep-going", "--trace", "none", "--out", &name]].concat());
        for (task, record) in bench.records(&name) {
            assert!(record["outcome"] != "sim_error", "{name}, {task}: {}", record["reason"]);
        }
    }
}
