//! Commands that need no planner. Whole runs, and everything that can be wrong with what they are given, are tested in
//! `tests/` with the built binary and real planners.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Runs the program in a directory, on the built-in suites of the checkout.
fn harness(dir: &TempDir, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vb-harness"))
        .args(args)
        .current_dir(dir.path())
        .env("VB_TASKS", Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks"))
        .output()
        .unwrap()
}

fn succeed(dir: &TempDir, args: &[&str]) -> String {
    let output = harness(dir, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn help_lists_the_documented_exit_codes() {
    let help = succeed(&tempfile::tempdir().unwrap(), &["--help"]);
    let documented = include_str!("../../../docs/results.md");
    let codes = documented.lines().skip_while(|l| !l.starts_with("| exit code")).skip(2);
    let codes: Vec<&str> =
        codes.map_while(|l| l.strip_prefix("| ")?.split(" |").next()).map(str::trim).collect();
    assert_eq!(codes.len(), 10, "{codes:?}");
    for code in codes {
        assert!(help.lines().any(|l| l.trim_start().starts_with(&format!("{code}  "))), "{code} in {help}");
    }
}

#[test]
fn an_error_of_the_command_line_is_one_line() {
    let dir = tempfile::tempdir().unwrap();
    for (args, line) in [
        (
            &["run"][..],
            "error: the following required arguments were not provided: --plugin <FILE|COMMAND> (see --help)\n",
        ),
        (&["--plugin", "x", "--bogus"], "error: unexpected argument '--bogus' found (see --help)\n"),
    ] {
        let output = harness(&dir, args);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), line);
    }
}

#[test]
fn the_built_in_suites_are_listed_shown_and_valid() {
    let dir = tempfile::tempdir().unwrap();
    assert!(succeed(&dir, &["suite", "list"]).starts_with("vb-mini"));
    assert!(succeed(&dir, &["suite", "validate", "vb-mini"]).contains("10 worlds, 100 tasks, all valid"));
    let shown = succeed(&dir, &["suite", "show", "vb-mini"]);
    assert!(shown.contains("w001") && shown.contains("w010"), "{shown}");
    assert_eq!(succeed(&dir, &["tasks", "list"]).lines().count(), 100);
}

#[test]
fn a_suite_can_be_generated_and_its_tasks_chosen() {
    let dir = tempfile::tempdir().unwrap();
    succeed(&dir, &["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "one"]);
    assert_eq!(succeed(&dir, &["tasks", "list", "--suite", "./one"]).lines().count(), 10);
    let one = ["tasks", "list", "--suite", "./one", "--tasks", "w001/t03", "--message-format", "json"];
    let one = succeed(&dir, &one);
    assert!(one.starts_with("{\"event\":\"task\",\"task\":\"w001/t03\","), "{one}");
    assert_eq!(one.lines().count(), 1);
}
