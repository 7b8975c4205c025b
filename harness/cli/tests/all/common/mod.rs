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
