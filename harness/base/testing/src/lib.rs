//! What tests and tools share: where the reference data lie, how a test says that it was skipped, and what programs cost.
//!
//! The test harness of Rust knows no test that finds only while it runs that something is missing, and a test that
//! returns early counts as passed. So it says so by [`skip`], and `cargo xtask test` prints at its end which tests were
//! skipped and why.

mod cost;

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};

pub use cost::processor_time_of_children;

/// Variable with the file to which skipped tests are appended, a line each: name, tab, reason. `cargo xtask test` sets it.
pub const SKIPPED: &str = "VB_SKIPPED";

/// Says that the running test is skipped, and why; the test returns then.
pub fn skip(reason: impl Display) {
    let thread = std::thread::current();
    // Tests run in threads of their names.
    let test = thread.name().unwrap_or("a test");
    eprintln!("skipped: {test}: {reason}");
    if let Some(file) = std::env::var_os(SKIPPED)
        && let Ok(mut file) = std::fs::OpenOptions::new().append(true).create(true).open(file)
    {
        // One write, so that lines of several programs don't mix. A list that can't be written fails no test.
        let _ = file.write_all(format!("{test}\t{reason}\n").as_bytes());
    }
}

/// Folder of the reference data (the original's worlds, runs of Chrono), whether it is there or not: `shared` beside the
/// repository, or where the environment variable `VB_SHARED` says.
#[must_use]
pub fn shared_folder() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../shared");
    let dir = std::env::var_os("VB_SHARED").map_or(beside, PathBuf::from);
    std::path::absolute(&dir).unwrap_or(dir)
}

/// A file or folder of the reference data; skips the test where it is missing.
#[must_use]
pub fn shared(path: &str) -> Option<PathBuf> {
    let path = shared_folder().join(path);
    if path.exists() {
        return Some(path);
    }
    skip(format_args!("no reference data at {} (set VB_SHARED)", path.display()));
    None
}
