//! Granular beds, from rules to a replay: docs/granular.md.

use std::fs;

use vb_tests::{Bench, Browser, pid};

/// A world of 28 m with a small bed.
const RULES: &str = "schema: 1
name: small
ground: {side: 28.0, resolution: 1.0, patch: 1.0, class: dirt, friction: 0.8}
beds:
  - {material: gravel, length: 2.0, width: 4.0, depth: 0.2}
wall: {height: 1.5, thickness: 1.0}
tasks: {distance: 20.0, offset: 0.2}
path: {clearance: 1.5, grid: 0.5, spacing: 1.0}
";

fn generate(bench: &Bench, rules: &str, out: &str) -> vb_tests::Done {
    bench.write("rules.yaml", rules);
    bench.run(&["suite", "generate", "--granular", "--seed", "3", "--params", "rules.yaml", "--out", out])
}

fn drive<'a>(plugin: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = vec!["run", plugin, "--suite", "./beds", "--param", "speed=4", "--out", out];
    args.extend(more);
    args
}

#[test]
fn a_bed_is_generated_driven_over_alike_and_shown_with_its_grains() {
    let bench = Bench::new();
    assert!(generate(&bench, RULES, "beds").ok().contains("1 worlds, 2 tasks"));
    assert!(
        bench
            .ok(&["suite", "validate", "./beds", "--clearance", "1.5"])
            .contains("1 worlds, 2 tasks, all valid")
    );
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    bench.ok(&drive(pid, "one", &["--jobs", "1", "--trace", "full", "--tasks", "w001/t00"]));
    // The rest of it, and all of it at once by two workers.
    bench.ok(&drive(pid, "two", &["--jobs", "2", "--trace", "full"]));
    let (one, two) = (bench.records("one"), bench.records("two"));
    assert_eq!(one["w001/t00"], two["w001/t00"]);
    for record in two.values() {
        assert_eq!(record["outcome"], "success", "{record}");
        assert!(record["time_s"].as_f64().unwrap() > 2.0, "{record}");
    }
    // Half of a run is continued, with the same result.
    let (head, _) = fs::read_to_string(bench.path("two/tasks.jsonl"))
        .unwrap()
        .split_once('\n')
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .unwrap();
    vb_tests::copy_dir(&bench.path("two"), &bench.path("half"));
    bench.write("half/tasks.jsonl", head + "\n");
    bench.ok(&drive(pid, "half", &["--jobs", "2", "--trace", "full", "--resume"]));
    assert_eq!(bench.records("half"), two);
    // The drive is repeated bit for bit, with the grains.
    bench.ok(&[
        "replay",
        "two",
        "--task",
        "w001/t00",
        "--out",
        "page.html",
        "--png",
        "p.png",
        "--at",
        "2.5",
        "--mcap",
        "r.mcap",
    ]);
    let page = fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(page.len() < 60_000_000 && page.contains("\"exact\":true"));
    if let Some(mut browser) = Browser::start(600, 400) {
        browser.open_at(&bench.path("page.html"), "#t=0");
        let count = browser.eval("replay.grains().count").as_f64().unwrap();
        // 1.6 m³ of stones of 75 mm, without the deep ones.
        assert!((2000.0..9000.0).contains(&count), "{count}");
        // Once the car has passed, some lie elsewhere; back at the start all are where they were.
        let places =
            "JSON.stringify(Array.from({ length: replay.grains().count }, (_, k) => replay.grains(k).at))";
        let before = browser.eval(places);
        browser.eval("replay.seek(99)");
        assert_ne!(browser.eval(places), before);
        browser.eval("replay.seek(0)");
        assert_eq!(browser.eval(places), before);
        assert!(browser.errors().is_empty(), "{:?}", browser.errors());
    }
}

#[test]
fn beds_that_cannot_be_driven_on_end_in_one_message() {
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    let cases = [
        ("depth: 0.2", "depth: 20.0", "w001: beds.yaml: beds: about "),
        ("length: 2.0", "length: 30.0", "beds[0].length: 30 must lie in 0 to 28"),
        ("length: 2.0", "length: 0.0", "w001: beds.yaml: beds[0].length: 0 m must be at least 0.36 m"),
        ("material: gravel", "material: lava", "lava"),
        ("- {material", "- {mineral", "mineral"),
    ];
    for (k, (from, to, wanted)) in cases.into_iter().enumerate() {
        let message = generate(&bench, &RULES.replacen(from, to, 1), &format!("no-{k}")).error(3);
        assert!(message.contains(wanted) && message.lines().count() == 1, "{message}");
    }
    // Stones as large as wheels, which a vehicle that is larger could drive on.
    let stones = "schema: 1\nname: blocks\ndescription: Blocks\ngrains: {class: rock, radius: [0.48, 0.5], density: 2650, friction: 0.7, rolling_resistance: 0.3}\n";
    bench.write("blocks.yaml", stones);
    let large = RULES.replacen("material: gravel", "material: blocks.yaml", 1).replacen(
        "length: 2.0, width: 4.0, depth: 0.2",
        "length: 4.0, width: 4.0, depth: 2.0",
        1,
    );
    assert!(generate(&bench, &large, "beds").ok().contains("1 worlds, 2 tasks"));
    let message = bench.run(&drive(pid, "run", &[])).error(3);
    assert!(message.contains("world w001 has a granular bed with grains of radius 0.5 m"), "{message}");
    assert!(!bench.path("run/tasks.jsonl").exists(), "nothing was driven");
    // A file of beds that was changed.
    bench.write("beds/worlds/w001/beds.yaml", "materials: {}\nbeds: []\n");
    let message = bench.run(&["suite", "validate", "./beds"]).error(3);
    assert!(message.contains("beds.yaml"), "{message}");
}

#[test]
fn training_worlds_with_beds_give_datasets_of_drives_on_grains() {
    let bench = Bench::new();
    bench.write("rules.yaml", RULES);
    let generate = |seed: &'static str, more: &[&'static str]| {
        let args =
            ["suite", "generate", "--granular", "--seed", seed, "--params", "rules.yaml", "--out", "beds"];
        bench.run(&[&args[..], more].concat())
    };
    // Seeds of training worlds and those of suites are apart here, too.
    assert!(generate("7300", &[]).error(2).contains("are reserved for training worlds"));
    assert!(
        generate("3", &["--training"]).error(2).contains("training worlds need a seed from 7000 to 7999")
    );
    assert!(generate("7300", &["--training"]).ok().contains("1 worlds, 2 tasks"));
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    let drive = ["dataset", "drive", "--plugin", pid, "--suite", "./beds", "--out", "drives"];
    assert!(bench.ok(&drive).contains("2 episodes (2 success)"));
    assert!(bench.path("drives/suite/worlds/w001/beds.yaml").exists());
    bench.ok(&["dataset", "validate", "drives"]);
}
