//! Whole tasks against Project Chrono.

use std::path::PathBuf;
use std::process::Command;

use crate::run::{Failure, cargo, run, step};
use crate::{built, default_plugin_dir, plugins, root, target_dir};

/// Where the reference data lie: `VB_SHARED`, or `shared` beside the repository.
fn shared() -> PathBuf {
    std::env::var_os("VB_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from)
}

/// Builds harness, planners and `vb-compare`, and lets it drive the recorded tasks. Without the recorded runs it says
/// so, and that is all.
pub(crate) fn compare_chrono() -> Result<(), Failure> {
    let shared = shared();
    let recorded = shared.join("reference/chrono/tasks");
    if !recorded.is_dir() {
        step(&format!("skipped: no recorded runs at {} (set VB_SHARED)", recorded.display()));
        return Ok(());
    }
    step("building the harness and the comparison");
    cargo(&["build", "--release", "--package", "vb-harness", "--package", "vb-compare"])?;
    plugins::build(&default_plugin_dir())?;
    let out = target_dir().join("compare-chrono");
    if out.exists() {
        std::fs::remove_dir_all(&out)
            .map_err(|e| Failure::new(format!("can't remove {}: {e}", out.display())))?;
    }
    let mut command = Command::new(built("vb-compare"));
    command.arg("--harness").arg(built("vb-harness")).arg("--plugins").arg(default_plugin_dir());
    command.arg("--vehicle").arg(root().join("tasks/vehicles/hmmwv.yaml"));
    command
        .arg("--recorded")
        .arg(recorded)
        .arg("--original")
        .arg(shared.join("verti-bench"))
        .arg("--out")
        .arg(out);
    run(&mut command)
}
