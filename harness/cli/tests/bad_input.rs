//! Bad input ends in one line on stderr – what, where, what to do – and the documented exit code.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a directory, on the built-in suites and vehicles of the checkout.
fn harness(dir: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vb-harness"))
        .args(args)
        .current_dir(dir)
        .env("VB_TASKS", Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks"))
        .env("VB_CACHE", dir.join("cache"))
        .output()
        .unwrap()
}

/// The one line of a command that must fail with this exit code.
fn failure(dir: &Path, code: i32, args: &[&str]) -> String {
    let output = harness(dir, args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    assert!(text.starts_with("error: ") && text.trim_end().lines().count() == 1, "{args:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

#[test]
fn a_command_line_without_a_plugin_is_a_usage_error_and_help_is_none() {
    let tmp = tempfile::tempdir().unwrap();
    assert_eq!(harness(tmp.path(), &[]).status.code(), Some(2));
    assert_eq!(harness(tmp.path(), &["--plugin", "a", "--jobs", "0"]).status.code(), Some(2));
    assert_eq!(harness(tmp.path(), &["--plugin", "a", "--trace", "5hz"]).status.code(), Some(2));
    let help = harness(tmp.path(), &["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let text = String::from_utf8(help.stdout).unwrap();
    for code in ["0", "1", "2", "3", "4", "5", "130"] {
        assert!(text.lines().any(|l| l.trim_start().starts_with(&format!("{code}  "))), "{code} in {text}");
    }
}

#[test]
fn a_plugin_that_is_missing_or_none_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "gone.wasm"]);
    assert!(e.contains("gone.wasm"), "{e}");
    fs::write(tmp.path().join("text.wasm"), "this is no plugin").unwrap();
    fs::write(tmp.path().join("empty.so"), "").unwrap();
    fs::write(tmp.path().join("torn.wasm"), b"\0asm\x0d\0\x01\0\x00\xff").unwrap();
    for name in ["text.wasm", "empty.so", "torn.wasm"] {
        let e = failure(tmp.path(), 3, &["--plugin", name]);
        assert!(e.contains(name), "{e}");
        let e = failure(tmp.path(), 3, &["inspect", "--plugin", name]);
        assert!(e.contains(name), "{e}");
    }
    assert!(!tmp.path().join("runs").exists(), "nothing is written for a run that can't start");
}

#[test]
fn a_suite_that_is_missing_or_damaged_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--suite", "./nowhere"]);
    assert!(e.contains("nowhere"), "{e}");
    let e = failure(tmp.path(), 3, &["suite", "show", "./nowhere"]);
    assert!(e.contains("nowhere"), "{e}");

    let copy = tmp.path().join("copy");
    copy_dir(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks/suites/vb-mini"), &copy);
    let elevation = copy.join("worlds/w001/elevation.png");
    let bytes = fs::read(&elevation).unwrap();
    fs::write(&elevation, &bytes[..bytes.len() / 2]).unwrap();
    let e = failure(tmp.path(), 3, &["suite", "validate", "copy/"]);
    assert!(e.contains("elevation.png"), "{e}");
    fs::write(copy.join("suite.yaml"), "schema: yes\n").unwrap();
    let e = failure(tmp.path(), 3, &["suite", "validate", "copy/"]);
    assert!(e.contains("suite.yaml"), "{e}");
}

fn copy_dir(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_dir(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

#[test]
fn an_unknown_task_world_or_condition_is_a_usage_error_that_names_it() {
    let tmp = tempfile::tempdir().unwrap();
    for selector in ["w999", "w001/t77", "elevation=steep", "colour=red", ",", ""] {
        let e = failure(tmp.path(), 2, &["--plugin", "x", "--tasks", selector]);
        assert!(e.contains(selector), "{e}");
    }
}

#[test]
fn rules_and_vehicles_that_do_not_exist_are_named_with_those_that_do() {
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--rules", "papper"]);
    assert!(e.contains("papper") && e.contains("paper, release, dev"), "{e}");
    fs::write(tmp.path().join("mine.yaml"), "schema: 1\nname: mine\ntime_limit_s: soon\n").unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--rules", "mine.yaml"]);
    assert!(e.contains("mine.yaml") && e.contains("time_limit_s") && e.contains("soon"), "{e}");
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--vehicle", "bicycle"]);
    assert!(e.contains("bicycle") && e.contains("hmmwv"), "{e}");
    fs::write(tmp.path().join("car.yaml"), "schema: 1\nname: [car]\n").unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--vehicle", "car.yaml"]);
    assert!(e.contains("car.yaml"), "{e}");
}

#[test]
fn scoring_what_is_no_run_says_so() {
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 3, &["score", "nothing"]);
    assert!(e.contains("nothing") && e.contains("run.json"), "{e}");
    fs::create_dir(tmp.path().join("torn")).unwrap();
    fs::write(tmp.path().join("torn/run.json"), "{\"schema\": 1, ").unwrap();
    let e = failure(tmp.path(), 3, &["score", "torn"]);
    assert!(e.contains("run.json"), "{e}");
}

#[test]
fn a_suite_is_not_written_over_what_is_there() {
    let tmp = tempfile::tempdir().unwrap();
    fs::write(tmp.path().join("file"), "x").unwrap();
    let e = failure(tmp.path(), 4, &["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "."]);
    assert!(e.contains("not empty"), "{e}");
    let e = failure(tmp.path(), 4, &["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "file/s"]);
    assert!(e.contains("file"), "{e}");
    let e = failure(tmp.path(), 3, &["suite", "import", ".", "--out", "s"]);
    assert!(e.contains("no world found"), "{e}");
    let e = failure(
        tmp.path(),
        3,
        &["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "s", "--params", "file"],
    );
    assert!(e.contains("file"), "{e}");
}

#[test]
fn an_unknown_suite_is_named_with_those_that_exist() {
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 3, &["--plugin", "x", "--suite", "vb-maxi"]);
    assert!(e.contains("vb-maxi") && e.contains("vb-mini"), "{e}");
}

#[test]
fn what_a_suite_holds_can_be_listed_and_checked() {
    let tmp = tempfile::tempdir().unwrap();
    let out = |args: &[&str]| {
        let output = harness(tmp.path(), args);
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(out(&["suite", "list"]).starts_with("vb-mini"));
    assert!(out(&["suite", "validate", "vb-mini"]).contains("all valid"));
    out(&["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "one"]);
    assert!(out(&["suite", "show", "./one"]).contains("w001"));
    assert_eq!(out(&["tasks", "list", "--suite", "./one"]).lines().count(), 10);
    let one = out(&["tasks", "list", "--tasks", "w001/t03", "--message-format", "json"]);
    assert!(
        one.starts_with("{\"event\":\"task\",\"task\":\"w001/t03\",") && one.lines().count() == 1,
        "{one}"
    );
}
