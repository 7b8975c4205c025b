//! The built program, run as people run it.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Runs the program in a directory, on the data that comes with the checkout.
pub(crate) fn harness(dir: &TempDir, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vb-harness"))
        .args(args)
        .current_dir(dir.path())
        .env("VB_TASKS", Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks"))
        .output()
        .unwrap()
}

/// The standard output of a command that must succeed.
pub(crate) fn succeed(dir: &TempDir, args: &[&str]) -> String {
    let output = harness(dir, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}
