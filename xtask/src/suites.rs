//! The suites in `tasks/`: made by the generator, from seeds that stand here.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{Failure, output, run, step};
use crate::{built, root, target_dir};

/// Name, version, seed and number of worlds of each. A suite that has been released stays as it is: whatever changes
/// it makes a new version.
const SUITES: [(&str, &str, &str, &str); 2] = [("smoke", "1", "2025", "10"), ("vb-100", "1", "2026", "100")];

fn generate(name: &str, version: &str, seed: &str, worlds: &str, out: &Path) -> Result<(), Failure> {
    let _ = std::fs::remove_dir_all(out);
    let mut command = Command::new(built("vb-harness"));
    command.args(["suite", "generate", "--name", name, "--suite-version", version]);
    command.args(["--seed", seed, "--worlds", worlds]).arg("--out").arg(out);
    run(&mut command)
}

/// Writes all of them into `tasks/`.
pub(crate) fn write() -> Result<(), Failure> {
    SUITES.iter().try_for_each(|(name, version, seed, worlds)| {
        generate(name, version, seed, worlds, &root().join("tasks").join(name))
    })
}

/// Compares all of them with what the generator makes, byte by byte.
pub(crate) fn check() -> Result<(), Failure> {
    for (name, version, seed, worlds) in SUITES {
        let made: PathBuf = target_dir().join("suites").join(name);
        generate(name, version, seed, worlds, &made)?;
        let mut diff = Command::new("diff");
        diff.args(["--recursive", "--brief", "--exclude=proof.json"])
            .arg(root().join("tasks").join(name))
            .arg(&made);
        if output(&mut diff).is_none() {
            return Err(Failure::new(format!(
                "tasks/{name} is not what the generator makes (diff -r with {})",
                made.display()
            )));
        }
        step(&format!("tasks/{name} is what the generator makes"));
    }
    Ok(())
}
