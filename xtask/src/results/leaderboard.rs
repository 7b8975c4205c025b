//! The leaderboard of our own planners, from the runs behind the tables.

use std::path::Path;
use std::process::Command;

use super::{Class, ENTRIES, Entry, run_name};
use crate::run::{Failure, remove, run, step};
use crate::{built, default_plugin_dir, target_dir};

/// The course whose runs can be ranked: a whole shipped suite in the default vehicle.
const COURSE: &str = "vb-100-hmmwv";
/// Tasks that are re-run for the verdict of each entry, with a seed that anybody can repeat: our own entries need no surprise.
const SAMPLE: [&str; 4] = ["--sample", "10", "--seed", "0"];

/// Submits, verifies and ranks the runs of [`COURSE`] in `target/results`, and writes the site into `out`.
///
/// # Errors
/// Returns an error if a run is missing or not verified.
pub(crate) fn leaderboard(out: &Path) -> Result<(), Failure> {
    crate::build_harness()?;
    crate::plugins::build_as_wasm(&default_plugin_dir())?;
    let harness = || Command::new(built("vb-harness"));
    let accepted = target_dir().join("leaderboard-accepted");
    remove(&accepted)?;
    // Ranked are planners with their own parameters.
    let is_ranked = |entry: &&Entry| entry.class != Class::Reference && entry.params.is_empty();
    for entry in ENTRIES.iter().filter(is_ranked) {
        let driven = target_dir().join("results").join(COURSE).join(run_name(entry));
        if !driven.join("summary.json").exists() {
            return Err(Failure::new(format!(
                "{}: no run is here; `cargo xtask results {COURSE}` makes it",
                driven.display()
            )));
        }
        step(&format!("{}: submission and verification", entry.label));
        let plugin = default_plugin_dir().join(format!("{}.wasm", entry.plugin));
        let submission = accepted.join(entry.plugin);
        let mut submit = harness();
        submit.arg("submit").arg(&plugin).arg("--run").arg(&driven).arg("--out").arg(&submission);
        let note = format!("{}, a {} planner of the paper", entry.label, entry.class.name());
        run(submit.args(["--entrant", "Verti-Bench", "--note", &note, "--quiet"]))?;
        let mut verify = harness();
        verify.arg("verify").arg(&submission).arg("--plugin").arg(&plugin).args(["--ranked", "--quiet"]);
        run(verify.args(SAMPLE))?;
    }
    let mut build = harness();
    build.args(["leaderboard", "build", "--force"]).arg(&accepted).arg("--out").arg(out);
    run(build.args(["--title", "Verti-Bench reference planners"]))
}
