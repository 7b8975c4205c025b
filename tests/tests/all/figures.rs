//! Figures for papers, as the program writes them.

use std::fs;
use std::process::Command;

use vb_tests::{Bench, pid};

/// Exit codes, as in docs/results.md.
const USAGE: i32 = 2;
const OUTPUT: i32 = 4;

fn run(bench: &Bench, out: &str, speed: &str) {
    let pid = pid();
    let plugin = pid.to_str().expect("paths of tests are text");
    let tasks = "w001/t00-t01,w002/t00,w002/t06,w004/t08";
    bench.ok(&["--plugin", plugin, "--suite", "smoke", "--param", speed, "--tasks", tasks, "--out", out]);
}

#[test]
fn maps_are_figures_too() {
    let bench = Bench::new();
    run(&bench, "fast", "speed=5");
    run(&bench, "slow", "speed=3");
    bench.ok(&[
        "report",
        "fast",
        "slow",
        "--figures",
        "f",
        "--maps",
        "w001/t00,w004",
        "--label",
        "fast=Swift",
    ]);
    for world in ["w001", "w004"] {
        let file = |ending: &str| fs::read(bench.path(format!("f/map-{world}.{ending}"))).expect("a map");
        let svg = String::from_utf8(file("svg")).expect("text");
        // The ground is in the file, and each run has its legend; w001 has ways of two tasks of two runs.
        assert!(svg.contains("href=\"data:image/png;base64,") && svg.contains(">Swift</text>"));
        let ways = svg.matches("way\" d=\"").count();
        assert_eq!(ways, if world == "w001" { 4 } else { 2 }, "{world}");
        let pdf = file("pdf");
        let has = |what: &str| pdf.windows(what.len()).any(|w| w == what.as_bytes());
        assert!(
            has("/Subtype/Image") && has("/FontFile2"),
            "the ground as a picture, the texts with their font"
        );
        assert_eq!(file("png")[1..4], *b"PNG");
    }
    assert!(!bench.path("f/map-w002.svg").exists(), "its tasks were not selected");
    let told = bench.run(&["report", "fast", "--csv", "t.csv", "--maps", "w001"]).error(USAGE);
    assert!(
        told.contains("--maps: maps are HTML files or figures (add --out DIR or --figures DIR)"),
        "{told}"
    );
}

/// What a PDF says, where poppler is installed.
fn read(program: &str, args: &[&str]) -> Option<String> {
    let done = Command::new(program).args(args).output().ok()?;
    Some(String::from_utf8_lossy(&done.stdout).into_owned())
}

#[test]
fn figures_and_tables_are_written_and_named() {
    let bench = Bench::new();
    run(&bench, "fast", "speed=5");
    run(&bench, "slow", "speed=3");
    let report =
        ["report", "fast", "slow", "--figures", "f", "--label", "fast=PID & co", "--title", "Two speeds"];
    let told = bench.run(&report);
    let mut names: Vec<String> = Vec::new();
    for figure in ["results", "comparison", "profiles", "distributions", "causes"] {
        names.extend(["svg", "pdf", "png"].map(|ending| format!("{figure}.{ending}")));
    }
    names.extend(["results", "comparison", "causes"].map(|table| format!("{table}.tex")));
    for name in &names {
        let path = bench.path("f").join(name);
        assert!(fs::metadata(&path).is_ok_and(|m| m.len() > 300), "{name}");
        let path = std::path::Path::new("f").join(name);
        assert!(told.stderr.contains(&format!("wrote {}", path.display())), "{name}: {}", told.stderr);
    }
    assert_eq!(bench.files("f").len(), names.len());
    let table = fs::read_to_string(bench.path("f/results.tex")).expect("a table");
    assert!(table.contains("& PID \\& co & 5 & 80.0 ") && table.starts_with("% Two speeds\n"), "{table}");

    // Programs read the files' names, in the same order, and the files are the same again.
    let events = bench.ok(&[&report[..3], &["--figures", "g", "--json"], &report[5..]].concat());
    let last: serde_json::Value =
        serde_json::from_str(events.lines().last().expect("events")).expect("an event");
    let files: Vec<&str> =
        last["files"].as_array().expect("a list").iter().filter_map(|f| f.as_str()).collect();
    let wanted: Vec<String> =
        names.iter().map(|n| std::path::Path::new("g").join(n).display().to_string()).collect();
    assert_eq!((&last["event"], files), (&"report".into(), wanted.iter().map(String::as_str).collect()));
    assert_eq!(last["runs"][0], "PID & co");
    assert_eq!(bench.files("f"), bench.files("g"));

    // As any reader of PDFs has it.
    let pdf = bench.path("f/results.pdf");
    let pdf = pdf.to_str().expect("paths of tests are text");
    if let Some(fonts) = read("pdffonts", &[pdf]) {
        let rows: Vec<&str> = fonts.lines().skip(2).collect();
        assert!(
            !rows.is_empty()
                && rows.iter().all(|r| r.contains("+LiberationSans") && r.contains("yes yes yes")),
            "{fonts}"
        );
    }
    if let Some(text) = read("pdftotext", &[pdf, "-"]) {
        for said in ["PID & co", "Two speeds", "By elevation", "success rate, %"] {
            assert!(text.contains(said), "{said}: {text}");
        }
    }
}

#[test]
fn what_cannot_be_drawn_or_written_is_said() {
    let bench = Bench::new();
    run(&bench, "r", "speed=5");
    bench.write("taken", "a file");
    let refused = |args: &[&str], code: i32| bench.run(&[&["report", "r"], args].concat()).error(code);
    let told = refused(&["--figures", "-"], USAGE);
    assert!(told.contains("several files (give a directory"), "{told}");
    let told = refused(&["--figures", "taken"], OUTPUT);
    assert!(told.contains("cannot make the directory taken"), "{told}");
    let told = refused(&["--figures", "f", "--figure-width", "2"], USAGE);
    assert!(told.contains("too narrow") && told.contains("2.41 in"), "{told}");
    let told = refused(&["--figures", "f", "--figure-width", "wide"], USAGE);
    assert!(told.contains("3.5,7.16"), "{told}");
    let told = refused(&["--figures", "f", "--label", "q=x"], USAGE);
    assert!(told.contains("no run of that name") && told.contains("one of r"), "{told}");
    bench.write("f/results.pdf/in-the-way", "a file");
    let told = refused(&["--figures", "f"], OUTPUT);
    assert!(told.contains("f is not empty") && told.contains("--force"), "{told}");
    let told = refused(&["--figures", "f", "--force"], OUTPUT);
    assert!(told.contains("cannot write f/results.pdf"), "{told}");
}
