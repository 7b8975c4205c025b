//! Whole tasks against Project Chrono.

use std::process::Command;

use crate::run::{Failure, cargo, remove, run, step};
use crate::{built, default_plugin_dir, plugins, root, target_dir};

/// Builds harness, planners and `vb-compare`, and lets it drive the recorded tasks: the few of which there are time
/// series, or `all` of which the end is known. Without the recorded runs it says so, and that is all.
pub(crate) fn compare_chrono(all: bool) -> Result<(), Failure> {
    let shared = vb_testing::shared_folder();
    let (option, name, folder) = if all {
        ("--all", "reference/chrono/all-tasks.csv", "compare-chrono-all")
    } else {
        ("--recorded", "reference/chrono/tasks", "compare-chrono")
    };
    let recorded = shared.join(name);
    if !recorded.exists() {
        step(&format!("skipped: no recorded runs at {} (set VB_SHARED)", recorded.display()));
        return Ok(());
    }
    step("building the harness and the comparison");
    cargo(&["build", "--release", "--package", "vb-harness", "--package", "vb-compare"])?;
    plugins::build(&default_plugin_dir())?;
    let out = target_dir().join(folder);
    remove(&out)?;
    let mut command = Command::new(built("vb-compare"));
    command.arg("--harness").arg(built("vb-harness")).arg("--plugins").arg(default_plugin_dir());
    command.arg("--vehicle").arg(root().join("tasks/vehicles/hmmwv.yaml"));
    command.arg("--recorded-vehicle").arg(root().join("tasks/vehicles/hmmwv-released.yaml"));
    command.arg("--soils").arg(root().join("tasks/soils/original.yaml"));
    command.arg(option).arg(recorded).arg("--original").arg(shared.join("verti-bench")).arg("--out").arg(out);
    run(&mut command)
}
