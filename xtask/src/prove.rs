//! Proof that the tasks of a suite can be done: the expert drives them, one variant after the other, and then the planners that do
//! most in one drive, until all are done or nobody is left.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::run::{Failure, remove, run, step};
use crate::{built, default_plugin_dir, root, target_dir};

/// Who drives, with which parameters: the expert with its own, then faster, slower and more cautious, then on other ways; and the
/// planners that do most of all in one drive, each of which meets ledges on other lines.
const VARIANTS: [(&str, &[&str]); 18] = [
    ("expert", &[]),
    ("expert", &["speed=4.5"]),
    ("expert", &["speed=6", "caution=2"]),
    ("expert", &["variant=1", "speed=4"]),
    ("expert", &["variant=2", "speed=5", "caution=3"]),
    ("expert", &["variant=3", "speed=7"]),
    ("expert", &["speed=2"]),
    ("expert", &["variant=4", "speed=5", "lookahead=8"]),
    ("expert", &["caution=3"]),
    ("expert", &["variant=5"]),
    ("expert", &["variant=6", "speed=6", "caution=4"]),
    ("expert", &["variant=7", "speed=4", "lookahead=3"]),
    ("ibex", &[]),
    ("tnt", &[]),
    ("tal", &[]),
    ("mppi6", &[]),
    ("rl", &[]),
    ("acl", &[]),
];

/// Drives the tasks of a suite and writes its `proof.json`.
pub(crate) fn prove(suite: &Path) -> Result<(), Failure> {
    let suite = if suite.is_dir() { suite.to_owned() } else { root().join("tasks").join(suite) };
    let runs = target_dir().join("proof").join(suite.file_name().unwrap_or_default());
    remove(&runs)?;
    let mut left: Option<String> = None;
    let mut done = Vec::new();
    for (k, (planner, params)) in VARIANTS.iter().enumerate() {
        step(&format!(
            "{planner} {}",
            if params.is_empty() { "as it is".to_owned() } else { params.join(" ") }
        ));
        let out = runs.join(k.to_string());
        let mut drive = Command::new(built("vb-harness"));
        drive.arg("--plugin").arg(default_plugin_dir().join(format!("{planner}.wasm")));
        drive.arg("--suite").arg(&suite).arg("--out").arg(&out).args(["--trace", "none"]);
        // Of the tasks that are left, a planner may well find no way to any.
        drive.arg("--keep-going");
        for param in *params {
            drive.args(["--param", param]);
        }
        if let Some(tasks) = &left {
            drive.args(["--tasks", tasks]);
        }
        run(&mut drive)?;
        done.push(out);
        let unproven = collect(&suite, &done)?;
        step(&format!("{} tasks are left", unproven.len()));
        if unproven.is_empty() {
            break;
        }
        left = Some(unproven.join(","));
    }
    Ok(())
}

/// Writes the proof of these runs; the tasks that are left.
fn collect(suite: &Path, runs: &[std::path::PathBuf]) -> Result<Vec<String>, Failure> {
    let mut command = Command::new(built("vb-harness"));
    command.args(["suite", "prove", "--json"]).arg(suite).args(runs).stderr(Stdio::inherit());
    // By name, since what is driven anew may prove less than the old file.
    command.arg("--out").arg(suite.join("proof.json"));
    let output = command.output().map_err(|e| Failure::new(format!("can't run vb-harness: {e}")))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let last: Option<Value> = text.lines().last().and_then(|line| serde_json::from_str(line).ok());
    let unproven = last.as_ref().and_then(|message| message["unproven"].as_array());
    let names = |tasks: &Vec<Value>| tasks.iter().filter_map(Value::as_str).map(str::to_owned).collect();
    unproven.map(names).ok_or_else(|| Failure::new("`vb-harness suite prove` failed"))
}
