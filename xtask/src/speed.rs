//! How fast this version simulates beside another one: both drive the same tasks in turn, so that what else the machine does
//! falls on both.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::records::records;
use crate::run::{Failure, cargo_program, output, remove, run, step};
use crate::{built, default_plugin_dir, root, target_dir};

/// What is driven: a name for it, the planner, and the tasks of [`SUITE`].
const DRIVES: [(&str, &str, &str); 4] = [
    ("PID, rigid", "pid.wasm", "w*/t00,terrain=rigid"),
    ("PID, deformable", "pid.wasm", "w*/t00,terrain=deformable"),
    ("PID, mixed", "pid.wasm", "w*/t00,terrain=mixed"),
    ("MPPI, rigid", "mppi.wasm", "w*/t01,terrain=rigid,elevation=medium"),
];
const SUITE: &str = "vb-100";
/// How often each version drives if nothing is said.
pub(crate) const ROUNDS: u32 = 5;

/// A version of the harness.
struct Version {
    name: String,
    program: PathBuf,
}

/// What one drive took.
struct Drive {
    /// Processor time, s.
    processor: f64,
    /// Simulated time, s.
    simulated: f64,
    /// Task and state hash.
    hashes: Vec<(String, String)>,
}

/// Lets the `other` version, which is a program or a commit to be built, and this one drive `rounds` times, and prints how many
/// times real time each simulates on one core, and the ratio.
pub(crate) fn speed(other: &str, rounds: u32) -> Result<(), Failure> {
    let versions = [
        Version { name: other.to_owned(), program: program_of(other)? },
        Version { name: "this".to_owned(), program: built("vb-harness") },
    ];
    let runs = target_dir().join("speed").join("runs");
    step("| drive | simulated s | before, × real time | now | ratio (least to greatest) | state hashes |");
    step("|---|---|---|---|---|---|");
    for (name, planner, tasks) in DRIVES {
        let tasks = names(tasks)?;
        let (mut took, mut simulated, mut changed) = ([Vec::new(), Vec::new()], 0.0, 0);
        for round in 0..rounds {
            let by = |k: usize| drive(&versions[k], planner, &tasks, &runs);
            // In turn, since what comes second may find a warmer machine.
            let (before, now) = if round % 2 == 0 {
                let before = by(0)?;
                (before, by(1)?)
            } else {
                let now = by(1)?;
                (by(0)?, now)
            };
            took[0].push(before.processor / before.simulated);
            took[1].push(now.processor / now.simulated);
            simulated = now.simulated;
            changed = before.hashes.iter().zip(&now.hashes).filter(|(a, b)| a != b).count();
        }
        let ratios: Vec<f64> = took[0].iter().zip(&took[1]).map(|(before, now)| before / now).collect();
        let [before, now] = took.map(|costs| 1.0 / median(costs));
        let hashes = if changed == 0 { "the same".to_owned() } else { format!("{changed} differ") };
        let (least, most) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), r| (l.min(*r), m.max(*r)));
        step(&format!(
            "| {name} | {simulated:.0} | {before:.0} | {now:.0} | {:.2} ({least:.2} to {most:.2}) | {hashes} |",
            median(ratios)
        ));
    }
    step(&format!(
        "before: {}; medians of {rounds} rounds, processor time of the whole program",
        versions[0].name
    ));
    Ok(())
}

/// The names of the tasks that a selector chooses, which is a selector that older versions read, too.
fn names(selector: &str) -> Result<String, Failure> {
    let mut list = Command::new(built("vb-harness"));
    list.args(["tasks", "list", "--suite", SUITE, "--tasks", selector]).current_dir(root());
    let listed =
        output(&mut list).ok_or_else(|| Failure::new(format!("{selector}: selects no tasks of {SUITE}")))?;
    let names: Vec<&str> = listed.lines().filter_map(|line| line.split_whitespace().next()).collect();
    Ok(names.join(","))
}

/// The program that a file is, or that a commit becomes.
fn program_of(other: &str) -> Result<PathBuf, Failure> {
    let file = Path::new(other);
    if file.is_file() {
        return std::path::absolute(file).map_err(|e| Failure::new(format!("{other}: {e}")));
    }
    let git = |args: &[&str]| output(Command::new("git").arg("-C").arg(root()).args(args));
    let commit = git(&["rev-parse", "--verify", "--quiet", &format!("{other}^{{commit}}")])
        .ok_or_else(|| Failure::new(format!("{other}: neither a program nor a commit of this repository")))?;
    let folder = target_dir().join("speed");
    let (checkout, target) = (folder.join("checkout"), folder.join("target"));
    let (checkout_name, at) = (checkout.to_string_lossy(), commit.as_str());
    if !checkout.is_dir() && git(&["worktree", "add", "--detach", &checkout_name, at]).is_none() {
        return Err(Failure::new(format!("git can't check {other} out at {}", checkout.display())));
    }
    run(Command::new("git").arg("-C").arg(&checkout).args(["checkout", "--quiet", "--detach", at]))?;
    step(&format!("building {other} in {}", checkout.display()));
    let mut build = Command::new(cargo_program());
    build.args(["build", "--release", "--quiet", "--package", "vb-harness"]);
    run(build.env("CARGO_TARGET_DIR", &target).current_dir(&checkout))?;
    Ok(target.join("release").join(format!("vb-harness{}", std::env::consts::EXE_SUFFIX)))
}

/// Lets a version drive on one core.
fn drive(version: &Version, planner: &str, tasks: &str, runs: &Path) -> Result<Drive, Failure> {
    remove(runs)?;
    let mut command = Command::new(&version.program);
    command
        .arg("--plugin")
        .arg(default_plugin_dir().join(planner))
        .args(["--suite", SUITE, "--tasks", tasks]);
    command.args(["--trace", "none", "--jobs", "1", "--out"]).arg(runs).current_dir(root());
    // Both with the tasks of this version.
    command.env("VB_TASKS", root().join("tasks")).stdout(Stdio::null()).stderr(Stdio::null());
    let unknown = || Failure::new("this system doesn't tell the processor time of programs");
    let before = vb_testing::processor_time_of_children().ok_or_else(unknown)?;
    run(&mut command)?;
    let processor = vb_testing::processor_time_of_children().ok_or_else(unknown)? - before;
    let records = records(runs)?;
    let simulated = records.iter().filter_map(|r| r["time_s"].as_f64()).sum();
    let hashes = records.iter().map(|r| (r["task"].to_string(), r["state_hash"].to_string())).collect();
    Ok(Drive { processor, simulated, hashes })
}

/// The middle one of some numbers, or the mean of the middle two.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let n = numbers.len();
    if n == 0 { f64::NAN } else { 0.5 * (numbers[(n - 1) / 2] + numbers[n / 2]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }

    #[test]
    fn what_is_neither_a_program_nor_a_commit_is_refused_by_its_name() {
        let failure = program_of("no-such-version").unwrap_err().to_string();
        assert!(failure.starts_with("no-such-version: neither a program nor a commit"), "{failure}");
    }
}
