//! A soak of the simulator: commands that no planner would give, for all vehicles, over a whole suite.

use std::process::{Command, Stdio};

use crate::records::records;
use crate::run::{Failure, remove, step};
use crate::{built, default_plugin_dir, root, target_dir};

const SUITE: &str = "vb-100";
/// Ways of driving; without brakes a vehicle gets faster.
const WAYS: [&str; 2] = ["brakes=true", "brakes=false"];

/// Exit code of a run in which the simulation of some tasks failed (docs/results.md).
const SIM_ERRORS: i32 = 5;

/// Drives the tasks of the suite (those that `tasks` selects, or all) by the wild planner with every shipped vehicle. A single
/// simulation that failed is a failure of the soak.
pub(crate) fn soak(tasks: Option<&str>) -> Result<(), Failure> {
    let runs = target_dir().join("soak");
    remove(&runs)?;
    let (mut driven, mut hours, mut failed) = (0, 0.0, Vec::new());
    for vehicle in vehicles()? {
        for way in WAYS {
            let out = runs.join(format!("{vehicle}-{way}"));
            let mut drive = Command::new(built("vb-harness"));
            drive.arg("--plugin").arg(default_plugin_dir().join("wild.wasm")).args(["--param", way]);
            drive.args(["--suite", SUITE, "--vehicle", &vehicle, "--trace", "none", "--keep-going", "--out"]);
            drive.arg(&out).current_dir(root()).stdout(Stdio::null());
            if let Some(tasks) = tasks {
                drive.args(["--tasks", tasks]);
            }
            // That simulations failed is said below.
            let status = drive.status().map_err(|e| Failure::new(format!("can't run vb-harness: {e}")))?;
            if !status.success() && status.code() != Some(SIM_ERRORS) {
                return Err(Failure::new(format!("the drive of {vehicle} failed ({status})")));
            }
            let records = records(&out)?;
            let wrong = records.iter().filter(|r| r["outcome"] == "sim_error");
            failed.extend(wrong.map(|r| format!("{vehicle}, {way}, {}: {}", r["task"], r["reason"])));
            let seconds: f64 = records.iter().filter_map(|r| r["time_s"].as_f64()).sum();
            step(&format!("{vehicle}, {way}: {} tasks, {:.2} h", records.len(), seconds / 3600.0));
            driven += records.len();
            hours += seconds / 3600.0;
        }
    }
    step(&format!("{driven} tasks, {hours:.1} h of driving, {} simulations failed", failed.len()));
    if failed.is_empty() { Ok(()) } else { Err(Failure::new(failed.join("\n"))) }
}

/// Names of the shipped vehicles.
fn vehicles() -> Result<Vec<String>, Failure> {
    let folder = root().join("tasks/vehicles");
    let entries = std::fs::read_dir(&folder)
        .map_err(|e| Failure::new(format!("can't read {}: {e}", folder.display())))?;
    let name = |file: String| file.strip_suffix(".yaml").map(str::to_owned);
    let mut names: Vec<String> =
        entries.flatten().filter_map(|e| name(e.file_name().to_string_lossy().into_owned())).collect();
    names.sort();
    Ok(names)
}
