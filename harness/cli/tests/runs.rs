//! Whole runs by the command line: output directories, messages, interruption, resumption, re-scoring.
//!
//! They drive the PID planner, which `cargo xtask plugins` builds to target/plugins; without it they are skipped.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn pid() -> Option<String> {
    let dir =
        std::env::var_os("VB_PLUGINS").map_or_else(|| Path::new(ROOT).join("target/plugins"), PathBuf::from);
    let file = dir.join("pid.wasm");
    if !file.is_file() {
        eprintln!("skipped: {} is missing (cargo xtask plugins)", file.display());
        return None;
    }
    // Tests run in another directory.
    Some(fs::canonicalize(file).unwrap().to_str().unwrap().to_owned())
}

fn command(dir: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vb-harness"));
    command.args(args).current_dir(dir).env("VB_TASKS", Path::new(ROOT).join("tasks"));
    command
}

fn harness(dir: &Path, args: &[&str]) -> Output {
    command(dir, args).output().unwrap()
}

fn succeed(dir: &Path, args: &[&str]) -> String {
    let output = harness(dir, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn failure(dir: &Path, code: i32, args: &[&str]) -> String {
    let output = harness(dir, args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    let errors: Vec<&str> = text.lines().filter(|l| l.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !text.contains("panicked"), "{text}");
    errors[0].to_owned()
}

/// The lines of tasks.jsonl in the order of their text.
fn lines(run: &Path) -> Vec<String> {
    let mut lines: Vec<String> =
        fs::read_to_string(run.join("tasks.jsonl")).unwrap().lines().map(str::to_owned).collect();
    lines.sort();
    lines
}

#[test]
fn a_run_tells_its_course_and_leaves_what_scoring_again_repeats() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    let args =
        ["--plugin", &pid, "--tasks", "w001/t00-t02", "--trace", "full", "--out", "r", "--param", "speed=5"];
    let out = succeed(tmp.path(), &[&args[..], &["--message-format", "json"]].concat());
    let messages: Vec<Value> = out.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let events: Vec<&str> = messages.iter().map(|m| m["event"].as_str().unwrap()).collect();
    assert_eq!(events, ["started", "task", "task", "task", "finished"]);
    assert_eq!((&messages[0]["total"], &messages[0]["resumed"]), (&3.into(), &0.into()));
    let read = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(tmp.path().join("r").join(name)).unwrap()).unwrap()
    };
    assert_eq!(messages[4]["summary"], read("summary.json"));
    assert_eq!(read("run.json")["params"]["speed"], "5");

    let again = succeed(tmp.path(), &["score", "r", "--message-format", "json"]);
    let again: Vec<Value> = again.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(again.last().unwrap()["summary"], read("summary.json"));
    let mut records: Vec<String> = again[..3].iter().map(|m| m["record"]["task"].to_string()).collect();
    records.dedup();
    assert_eq!(records.len(), 3);
    let table = succeed(tmp.path(), &["score", "r", "--rules", "release"]);
    assert!(table.contains("rules: release"), "{table}");
}

#[test]
fn a_run_is_resumed_to_the_same_result_and_only_with_its_own_settings() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    let args = ["--plugin", &pid, "--tasks", "w001/t00-t03", "--out"];
    succeed(tmp.path(), &[&args[..], &["whole"]].concat());
    succeed(tmp.path(), &[&args[..], &["torn", "--jobs", "1"]].concat());
    let (whole, torn) = (tmp.path().join("whole"), tmp.path().join("torn"));
    // As if killed while the third line was written.
    let bytes = fs::read(torn.join("tasks.jsonl")).unwrap();
    let ends: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i] == b'\n').collect();
    fs::write(torn.join("tasks.jsonl"), &bytes[..ends[1] + 40]).unwrap();
    fs::remove_file(torn.join("summary.json")).unwrap();

    let e = failure(tmp.path(), 4, &[&args[..], &["torn"]].concat());
    assert!(e.contains("--resume"), "{e}");
    let e = failure(tmp.path(), 4, &[&args[..], &["torn", "--resume", "--seed", "9"]].concat());
    assert!(e.contains("seed differs: the run has 0, this command has 9"), "{e}");
    succeed(tmp.path(), &[&args[..], &["torn", "--resume"]].concat());
    assert_eq!(lines(&torn), lines(&whole));
    let summary = |run: &Path| fs::read(run.join("summary.json")).unwrap();
    assert_eq!(summary(&torn), summary(&whole));
}

#[test]
fn an_output_directory_that_can_not_be_used_is_named() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    fs::write(tmp.path().join("file"), "x").unwrap();
    let e = failure(tmp.path(), 4, &["--plugin", &pid, "--out", "."]);
    assert!(e.contains("not empty"), "{e}");
    let e = failure(tmp.path(), 4, &["--plugin", &pid, "--out", "file/run"]);
    assert!(e.contains("file/run") && e.contains("--out"), "{e}");
    let e = failure(tmp.path(), 4, &["--plugin", &pid, "--out", "gone", "--resume"]);
    assert!(e.contains("gone"), "{e}");
    if Path::new("/dev/full").exists() {
        // A path that takes no directory, on any system with this device.
        failure(tmp.path(), 4, &["--plugin", &pid, "--out", "/dev/full/run"]);
    }
}

#[test]
fn a_parameter_that_the_planner_does_not_have_is_a_usage_error() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    let e = failure(tmp.path(), 2, &["--plugin", &pid, "--param", "sped=5"]);
    assert!(e.contains("sped") && e.contains("speed"), "{e}");
    assert!(!tmp.path().join("runs").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_run_cleanly_and_resuming_completes_it() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    // One at a time and ten of them: the first task's message comes long before the last task ends.
    let args = ["--plugin", &pid, "--tasks", "w001", "--jobs", "1", "--out", "r", "--message-format", "json"];
    let mut child = command(tmp.path(), &args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut told = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(told.any(|line| line.unwrap().contains("\"event\":\"task\"")));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let last = told.map(|l| l.unwrap()).last().unwrap();
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.lines().last().unwrap().contains("--resume"), "{text}");
    assert!(last.contains("\"event\":\"finished\"") && last.contains("\"interrupted\":true"), "{last}");
    let done = lines(&tmp.path().join("r")).len();
    assert!((1..10).contains(&done), "{done}");
    succeed(tmp.path(), &[&args[..], &["--resume"]].concat());
    assert_eq!(lines(&tmp.path().join("r")).len(), 10);
}

#[test]
fn plain_lines_tell_the_course_where_there_is_no_terminal() {
    let Some(pid) = pid() else { return };
    let tmp = tempfile::tempdir().unwrap();
    let output = harness(tmp.path(), &["--plugin", &pid, "--tasks", "w001/t00"]);
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(err.lines().any(|l| l.starts_with("[1/1] w001/t00 ")) && err.contains("real time"), "{err}");
    assert!(out.contains("success % (95 % CI)") && out.contains("rules: paper"), "{out}");
    assert!(tmp.path().join("runs/pid-1/summary.json").is_file());
    assert!(!err.contains('\u{1b}') && !out.contains('\u{1b}'));
}
