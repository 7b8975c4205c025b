//! Fuzzing of every reader, by libFuzzer.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::root;
use crate::run::{Failure, cargo, output, run, step};

/// Seconds that one input may take.
const TIMEOUT_S: u32 = 20;
/// Memory that a reader may take, MiB.
const MEMORY_MIB: u32 = 2048;

/// Runs every target, or the one named, for some minutes. A finding ends it: the input is then under `artifacts`.
pub(crate) fn fuzz(target: Option<&str>, minutes: u32) -> Result<(), Failure> {
    if output(Command::new("cargo").args(["+nightly", "fuzz", "--version"])).is_none() {
        let hint = "fuzzing needs a nightly Rust (`rustup toolchain install nightly`) and cargo-fuzz (`cargo install \
                    cargo-fuzz`)";
        return Err(Failure::new(hint));
    }
    let folder = root().join("tests/fuzz/libfuzzer");
    let corpus = folder.join("corpus");
    let text = corpus.to_string_lossy().into_owned();
    cargo(&["run", "--release", "--package", "vb-fuzz", "--example", "write-seeds", "--", &text])?;
    let targets = targets(&folder)?;
    let chosen: Vec<&String> = targets.iter().filter(|t| target.is_none_or(|name| name == *t)).collect();
    if chosen.is_empty() {
        let name = target.unwrap_or_default();
        return Err(Failure::new(format!("no such target: {name}; there are {}", targets.join(", "))));
    }
    for target in chosen {
        step(&format!("fuzzing {target} for {minutes} minutes"));
        let limits = [
            format!("-max_total_time={}", 60 * minutes),
            format!("-timeout={TIMEOUT_S}"),
            format!("-rss_limit_mb={MEMORY_MIB}"),
            "-print_final_stats=1".to_owned(),
        ];
        let mut command = Command::new("cargo");
        // Not the cargo that runs this task: a nightly one.
        command.env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO_TARGET_DIR");
        run(command
            .args(["+nightly", "fuzz", "run", "--fuzz-dir"])
            .arg(&folder)
            .arg(target)
            .arg("--")
            .args(limits))?;
    }
    Ok(())
}

/// The names of the programs.
fn targets(folder: &Path) -> Result<Vec<String>, Failure> {
    let programs = folder.join("fuzz_targets");
    let unreadable = |e| Failure::new(format!("can't read {}: {e}", programs.display()));
    let mut names: Vec<String> = std::fs::read_dir(&programs)
        .map_err(unreadable)?
        .filter_map(|entry| PathBuf::from(entry.ok()?.file_name()).file_stem()?.to_str().map(str::to_owned))
        .collect();
    names.sort();
    Ok(names)
}
