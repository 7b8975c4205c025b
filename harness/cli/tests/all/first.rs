//! What is said before the work is done, and which suite is meant. No planner is needed for it.

use std::path::Path;

use crate::common::{harness, succeed};
use tempfile::TempDir;

/// Exit codes of docs/results.md.
const USAGE: i32 = 2;
const BAD_INPUT: i32 = 3;
const OUTPUT: i32 = 4;

/// What a command says that must fail with this code.
fn fail(dir: &TempDir, args: &[&str], code: i32) -> String {
    let output = harness(dir, args);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {told}");
    told
}

fn checkout() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The generator's rules with one text, which must be there, in place of another.
fn rules(dir: &TempDir, from: &str, to: &str) {
    let text = std::fs::read_to_string(checkout().join("tasks/generator/default.yaml")).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(dir.path().join("rules.yaml"), text.replacen(from, to, 1)).unwrap();
}

#[test]
fn the_name_of_a_suite_that_comes_with_the_harness_means_it_whatever_lies_here() {
    let dir = tempfile::tempdir().unwrap();
    // A folder of the same name that is no suite, such as that of a run, changes nothing.
    std::fs::create_dir(dir.path().join("smoke")).unwrap();
    let list = |suite: &str| harness(&dir, &["tasks", "list", "--suite", suite]);
    let plain = list("smoke");
    assert_eq!((plain.stdout.iter().filter(|b| **b == b'\n').count(), plain.stderr.len()), (100, 0));

    let made = harness(&dir, &["suite", "testbed", "--seed", "1", "--out", "smoke"]);
    assert!(String::from_utf8(made.stderr).unwrap().contains("--suite ./smoke"), "as it must be named");
    let (own, here) = (list("smoke"), list("./smoke"));
    assert_eq!(own.stdout, plain.stdout);
    let note = String::from_utf8(own.stderr).unwrap();
    assert!(note.contains("smoke is the built-in suite") && note.contains("./smoke"), "{note}");
    assert_eq!((here.stdout.iter().filter(|b| **b == b'\n').count(), here.stderr.len()), (10, 0));
    // Any other folder may be named without a path.
    std::fs::rename(dir.path().join("smoke"), dir.path().join("mine")).unwrap();
    assert_eq!(list("mine").stdout, here.stdout);
}

#[test]
fn a_directory_of_tasks_that_has_none_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let list = |args: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_vb-harness"));
        let output = command.args(args).env("VB_TASKS", dir.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(BAD_INPUT), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    for args in [
        &["list", "suites"][..],
        &["suite", "show", "smoke"],
        &["list", "vehicles"],
        &["vehicle", "show", "hmmwv"],
    ] {
        let told = list(args);
        assert!(told.contains(&dir.path().display().to_string()) && told.contains("VB_TASKS"), "{told}");
    }
}

#[test]
fn a_survey_with_room_for_too_many_worlds_is_refused_and_the_folder_is_looked_at_first() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("taken")).unwrap();
    std::fs::write(dir.path().join("taken/notes.txt"), "mine").unwrap();
    let told = fail(&dir, &["suite", "site", "nowhere.tif", "--out", "taken"], OUTPUT);
    assert!(told.contains("taken") && told.contains("not empty"), "{told}");
    let raster = checkout().join("examples/site/heights.tif");
    let raster = raster.to_str().unwrap();
    for resolution in ["1000", "1e300"] {
        let site = ["suite", "site", raster, "--out", "x", "--tiles", "--sample-resolution", resolution];
        let told = fail(&dir, &site, BAD_INPUT);
        assert!(told.contains("limit of 999") && told.contains("--at"), "{told}");
    }
    assert!(!dir.path().join("x").exists(), "nothing is written");
}

/// A ramp of 0.3 m on a course of 40 m by 4 m.
const COURSE: &str = "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 10.0\nLONG_SECTION_V_INCREMENT = 4.0\n$KD_DEFINITION\n#:LRFI\n\
                      D:long section 1,m\nD:long section 2,m\n$$$$\n 0.0000000 0.0000000\n 0.0000000 0.0000000\n \
                      0.3000000 0.3000000\n 0.3000000 0.3000000\n 0.0000000 0.0000000\n";

#[test]
fn a_course_becomes_a_world_with_a_task_along_it_and_is_refused_in_one_line() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("ramp.crg"), COURSE).unwrap();
    let made = harness(&dir, &["suite", "site", "ramp.crg", "--out", "ramp"]);
    let said = String::from_utf8(made.stderr).unwrap();
    assert!(made.status.success(), "{said}");
    assert!(
        said.starts_with("course of 40.00 m by 4.00 m, 5 cuts every 10 m with 2 sections, heights 0.000 to 0.300 m, straight\n"),
        "{said}"
    );
    // 40 m and 8 m at both ends, in patches of 8 m.
    assert!(said.contains("a world of 56 m with nodes every 1 m, and a task along the course"), "{said}");
    let valid = succeed(&dir, &["suite", "validate", "ramp"]);
    assert!(valid.contains("1 worlds, 1 tasks, all valid"), "{valid}");
    let told = fail(&dir, &["suite", "site", "ramp.crg", "--out", "x", "--unit", "0.01", "--tiles"], USAGE);
    assert!(told.contains("--unit, --tiles does not apply"), "{told}");
    std::fs::write(dir.path().join("bad.crg"), COURSE.replace("LRFI", "LHFI")).unwrap();
    for args in [
        &["suite", "site", "bad.crg", "--out", "x"][..],
        &["vehicle", "test", "gator", "--course", "bad.crg", "--out", "x"],
    ] {
        let told = fail(&dir, args, BAD_INPUT);
        assert!(told.contains("bad.crg: line 5: the data format LHFI is not supported"), "{told}");
    }
    assert!(!dir.path().join("x").exists(), "nothing is written");
}

#[test]
fn rules_of_the_generator_that_can_not_be_met_are_named_and_leave_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let generate =
        ["suite", "generate", "--seed", "1", "--worlds", "1", "--params", "rules.yaml", "--out", "x"];
    for (from, to, says) in [
        ("tilt: 20.0", "tilt: 0.0", "raise tasks.stand.tilt (100 % of the positions violate this rule)"),
        ("{rigid: [1, 7]", "{rigid: [7, 7]", "ground.centre_spread"),
        ("spacing: 10.0", "spacing: 50.0", "obstacles.spacing: 50 leaves room for"),
    ] {
        rules(&dir, from, to);
        if says == "ground.centre_spread" {
            // Seven clusters, all in the middle.
            let file = dir.path().join("rules.yaml");
            let text = std::fs::read_to_string(&file).unwrap();
            std::fs::write(file, text.replace("centre_spread: 0.288", "centre_spread: 0.001")).unwrap();
        }
        let told = fail(&dir, &generate, BAD_INPUT);
        assert!(told.contains(says), "{told}");
        assert!(!dir.path().join("x").exists(), "{told}");
    }
}

/// The run isn't there either: that the file can't be written is found before it is read.
#[test]
fn files_that_can_not_be_written_are_found_before_a_run_is_read() {
    let dir = tempfile::tempdir().unwrap();
    for (command, option, file) in [
        ("replay", "--video", "gone/x.gif"),
        ("replay", "--png", "gone/x.png"),
        ("replay", "--mcap", "gone/x.mcap"),
        ("replay", "--out", "gone/x.html"),
        ("report", "--csv", "gone/x.csv"),
        ("report", "--parquet", "gone/x.parquet"),
        ("report", "--markdown", "gone/x.md"),
    ] {
        let task = if command == "replay" { &["--task", "w001/t00"][..] } else { &[] };
        let told = fail(&dir, &[&[command, "nothing", option, file], task].concat(), OUTPUT);
        assert!(told.contains(&format!("cannot write {file}")), "{told}");
    }
}

#[test]
fn hints_name_options_that_the_command_has() {
    let dir = tempfile::tempdir().unwrap();
    let told = fail(&dir, &["suite", "show", "nowhere"], BAD_INPUT);
    assert!(!told.contains("--suite"), "it is an argument: {told}");
    let told = fail(&dir, &["dataset", "explore", "--world-seed", "5", "--out", "x"], USAGE);
    assert!(told.contains("--world-seed 5: ") && told.contains("7000 to 7999"), "{told}");
}
