//! The tables of docs/performance.md, measured on this machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

use crate::blocks;
use crate::examples::python;
use crate::records::records;
use crate::run::{Failure, cargo_program, output, remove, run, step};
use crate::{build_all, built, default_plugin_dir, root, target_dir};

const PAGE: &str = "docs/performance.md";
/// Groups of `cargo bench -p vb-sim --bench step`, in which an iteration simulates a second.
const GROUPS: [&str; 3] =
    ["simulate 1 s at 1 ms", "hull on the ground, 1 s at 1 ms", "vehicles, 1 s at 1 ms"];
/// Planners whose tasks are timed, and the tasks: one of each world of a suite.
const PLANNERS: [&str; 7] = ["pid", "mppi", "wmvct", "tal", "tnt", "rl", "ibex"];
const SUITE: &str = "smoke";
const TASKS: &str = "*/t00";
/// The task of a run whose start is timed.
const FIRST: &str = "w001/t00";
/// A run of one task is started so often.
const STARTS: usize = 11;

/// Measures all and writes the tables; takes some 15 minutes, in which the machine should do nothing else.
pub(crate) fn performance() -> Result<(), Failure> {
    build_all()?;
    let mut tables = vec![
        ("machine", machine()),
        ("simulator", simulator()?),
        ("tasks", tasks()?),
        ("planners", bench("vb-host", "planners")?),
        ("languages", bench("vb-harness", "languages")?),
    ];
    match environments() {
        Some(table) => tables.push(("environments", table)),
        None => step("skipped: environments: this Python has no package vertibench (PYTHON names another)"),
    }
    let named = tables.into_iter().map(|(name, table)| (format!("{name} speed"), table));
    blocks::write(&root().join(PAGE), "performance", &named.collect::<Vec<_>>())
}

/// Processor, cores and compiler.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let compiler = output(Command::new("rustc").arg("--version")).unwrap_or_default();
    format!("Measured on: {model}, {cores} cores, {}, {compiler}.\n", std::env::consts::OS)
}

/// Runs a bench, and returns what it prints: a table.
fn bench(package: &str, name: &str) -> Result<String, Failure> {
    step(&format!("cargo bench -p {package} --bench {name}"));
    let mut command = Command::new(cargo_program());
    // With the features of the workspace, so that little is built anew.
    command.args(["bench", "--quiet", "--package", "vb-unify", "--package", package, "--bench", name]);
    let told = output(command.current_dir(root()).stderr(Stdio::inherit()));
    let told = told.ok_or_else(|| Failure::new(format!("the bench {name} of {package} failed")))?;
    Ok(told.lines().filter(|line| line.starts_with('|')).map(|line| format!("{line}\n")).collect())
}

/// How many times real time one core simulates.
fn simulator() -> Result<String, Failure> {
    let folder = target_dir().join("criterion");
    for group in GROUPS {
        remove(&folder.join(group))?;
    }
    step("cargo bench -p vb-sim --bench step");
    let mut command = Command::new(cargo_program());
    command.args([
        "bench",
        "--quiet",
        "--package",
        "vb-unify",
        "--package",
        "vb-sim",
        "--bench",
        "step",
        "--",
    ]);
    command.args(["1 s at 1 ms", "--noplot", "--warm-up-time", "1", "--measurement-time", "3"]);
    run(command.current_dir(root()).stdout(Stdio::null()).stderr(Stdio::null()))?;
    let mut text = "| vehicle, ground | × real time |\n|---|---|\n".to_owned();
    for group in GROUPS {
        let dir = folder.join(group);
        let entries = std::fs::read_dir(&dir).map_err(|e| Failure::new(format!("{}: {e}", dir.display())))?;
        let mut rows = Vec::new();
        for path in entries.flatten().map(|entry| entry.path().join("new")).filter(|path| path.is_dir()) {
            let name = json(&path.join("benchmark.json"))?["function_id"].as_str().unwrap_or("").to_owned();
            let nanoseconds = json(&path.join("estimates.json"))?["median"]["point_estimate"].as_f64();
            let speed = 1e9 / nanoseconds.unwrap_or(f64::NAN);
            let vehicle = if group.starts_with("vehicles") { "" } else { "hmmwv, " };
            rows.push(format!("| {vehicle}{name} | {speed:.0} |\n"));
        }
        rows.sort();
        text.extend(rows);
    }
    Ok(text)
}

fn json(file: &Path) -> Result<Value, Failure> {
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    serde_json::from_str(&std::fs::read_to_string(file).map_err(|e| wrong(&e))?).map_err(|e| wrong(&e))
}

/// Processor time of tasks by planner, and the time that a run of one task takes from the command to its end.
fn tasks() -> Result<String, Failure> {
    let out = target_dir().join("performance");
    let unknown = || Failure::new("this system doesn't tell the processor time of programs");
    let mut text = "| planner | processor time of a task, s | × real time |\n|---|---|---|\n".to_owned();
    for planner in PLANNERS {
        step(&format!("{planner} drives {TASKS} of {SUITE}"));
        // Once without measuring: the planner is compiled then.
        drive(planner, FIRST, &out)?;
        let before = vb_testing::processor_time_of_children().ok_or_else(unknown)?;
        drive(planner, TASKS, &out)?;
        let spent = vb_testing::processor_time_of_children().ok_or_else(unknown)? - before;
        let records = records(&out)?;
        let simulated: f64 = records.iter().filter_map(|r| r["time_s"].as_f64()).sum();
        let each = spent / records.len() as f64;
        text += &format!("| {planner} | {each:.2} | {:.0} |\n", simulated / spent);
    }
    let mut starts = (0..STARTS)
        .map(|_| {
            #[allow(clippy::disallowed_methods, reason = "it measures time; no score is near")]
            let begin = Instant::now();
            drive("pid", FIRST, &out).map(|()| begin.elapsed().as_secs_f64())
        })
        .collect::<Result<Vec<_>, _>>()?;
    starts.sort_by(f64::total_cmp);
    let simulated = records(&out)?.iter().filter_map(|r| r["time_s"].as_f64()).sum::<f64>();
    Ok(format!(
        "{text}\nA run of one task of {simulated:.0} s with PID takes {:.2} s from the command to its end (median of {STARTS}).\n",
        starts[STARTS / 2]
    ))
}

/// Lets a planner drive tasks on one core.
fn drive(planner: &str, tasks: &str, out: &PathBuf) -> Result<(), Failure> {
    remove(out)?;
    let mut command = Command::new(built("vb-harness"));
    command.arg("run").arg(default_plugin_dir().join(format!("{planner}.wasm")));
    command.args(["--suite", SUITE, "--tasks", tasks, "--trace", "none", "--jobs", "1", "--out"]).arg(out);
    command.env("VB_TASKS", root().join("tasks"));
    run(command.current_dir(root()).stdout(Stdio::null()).stderr(Stdio::null()))
}

/// Speed of the environments of the Python package; nothing where it isn't installed.
fn environments() -> Option<String> {
    let mut command = Command::new(python());
    command.args(["-m", "vertibench.envs.bench", "--seconds", "3", "--stretches", "3"]);
    let told = output(command.current_dir(target_dir()).stderr(Stdio::null()))?;
    let rows = told.lines().filter_map(row).collect::<String>();
    Some(format!("| environments | speed |\n|---|---|\n{rows}"))
}

/// A row of a table from a line in which what was measured and the figure are columns.
fn row(line: &str) -> Option<String> {
    let (what, figure) = line.split_once("  ")?;
    Some(format!("| {what} | {} |\n", figure.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_two_columns_is_a_row() {
        assert_eq!(
            row("rigid: one environment          1386 steps/s").unwrap(),
            "| rigid: one environment | 1386 steps/s |\n"
        );
        assert_eq!(row("no figure"), None);
    }

    #[test]
    fn every_table_of_the_page_is_one_of_these() {
        let text = std::fs::read_to_string(root().join(PAGE)).unwrap();
        for name in ["machine", "simulator", "tasks", "planners", "languages", "environments"] {
            let mark = format!("<!-- made: {name} speed (by cargo xtask performance) -->\n");
            assert_eq!(text.matches(&mark).count(), 1, "{name}");
        }
        assert_eq!(text.matches("(by cargo xtask performance) -->").count(), 6);
    }
}
