//! The suites in `tasks/`: made by the harness, from seeds that stand here.

use std::path::Path;
use std::process::Command;

use crate::run::{Failure, output, run, step};
use crate::{built, root, target_dir};

/// How a suite is made.
struct Made {
    name: &'static str,
    version: &'static str,
    /// What of `vb-harness suite` makes it, with its seed and whatever else it takes.
    by: &'static [&'static str],
}

/// A suite that has been released stays as it is: whatever changes it makes a new version.
const SUITES: [Made; 5] = [
    Made { name: "granular", version: "1", by: &["generate", "--granular", "--seed", "2029"] },
    Made { name: "smoke", version: "3", by: &["generate", "--seed", "2025", "--worlds", "10"] },
    Made { name: "testbed", version: "2", by: &["testbed", "--seed", "2027"] },
    Made { name: "vb-100", version: "3", by: &["generate", "--seed", "2026", "--worlds", "100"] },
    Made {
        name: "vb-paper",
        version: "1",
        by: &["generate", "--seed", "2028", "--worlds", "100", "--params", "tasks/generator/paper.yaml"],
    },
];

fn make(suite: &Made, out: &Path) -> Result<(), Failure> {
    let _ = std::fs::remove_dir_all(out);
    let mut command = Command::new(built("vb-harness"));
    command.current_dir(root()).arg("suite").args(suite.by).args([
        "--name",
        suite.name,
        "--suite-version",
        suite.version,
    ]);
    command.arg("--out").arg(out);
    run(&mut command)
}

/// Writes all of them into `tasks/`.
pub(crate) fn write() -> Result<(), Failure> {
    SUITES.iter().try_for_each(|suite| make(suite, &root().join("tasks").join(suite.name)))
}

/// Compares all of them with what is made now, byte by byte.
pub(crate) fn check() -> Result<(), Failure> {
    for suite in SUITES {
        let (name, made) = (suite.name, target_dir().join("suites").join(suite.name));
        make(&suite, &made)?;
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
