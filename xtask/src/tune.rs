//! Choosing the defaults of the reference planners: candidates drive training worlds, which are in no suite.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::run::{Failure, remove, run, step};
use crate::{built, default_plugin_dir, root, target_dir};

/// Seed and number of the training worlds, and the tasks of each that are driven.
const SEED: &str = "7001";
const WORLDS: &str = "30";
const TASKS: &str = "w*/t00-t02";

/// Candidates of each planner: each differs from its defaults in one or two parameters.
const CANDIDATES: &[(&str, &[&[&str]])] = &[
    (
        "eh",
        &[
            &[],
            &["terrain=0.1"],
            &["terrain=0.4"],
            &["region=3.2"],
            &["region=3.2", "terrain=0.4"],
            &["roughness=0"],
            &["roughness=3"],
            &["speed=3"],
        ],
    ),
    (
        "mppi",
        &[
            &[],
            &["pace=1"],
            &["pace=10"],
            &["lookahead=6"],
            &["dt=0.1"],
            &["steer_spread=0.2"],
            &["effective=0.03"],
            &["effort=0.02"],
            &["effort=0.5"],
            &["speed=3"],
        ],
    ),
    ("wmvct", &[&[], &["speed=3"], &["speed=5"], &["tilt=1"], &["tilt=4"]]),
    ("mppi6", &[&[], &["speed=3"], &["speed=5"], &["stuck=4"], &["stuck=20"], &["risk=0.8"], &["learned=0"]]),
    ("tal", &[&[], &["speed=3"], &["speed=5"], &["stuck=4"], &["stuck=20"], &["risk=0.8"], &["learned=0"]]),
    (
        "tnt",
        &[
            &[],
            &["speed=3"],
            &["speed=5"],
            &["guided=0"],
            &["price_stuck=10"],
            &["price_stuck=50"],
            &["tilt=2"],
            &["over=60"],
            &["risk=0.8"],
            &["learned=0"],
        ],
    ),
    (
        "ibex",
        &[
            &[],
            &["price_hull=0", "price_tilt=0"],
            &["price_hull=20", "price_tilt=10"],
            &["recover=0"],
            &["foresight=0"],
            &["foresight=64"],
            &["clearance=0"],
            &["hull=0"],
            &["price_again=0"],
            &["speed=3"],
            &["speed=5"],
            &["learned=0"],
        ],
    ),
];

/// Drives all candidates of a planner and prints what became of them.
pub(crate) fn tune(planner: &str) -> Result<(), Failure> {
    let (_, candidates) = CANDIDATES.iter().find(|(name, _)| *name == planner).ok_or_else(|| {
        let known: Vec<&str> = CANDIDATES.iter().map(|(name, _)| *name).collect();
        Failure::new(format!("{planner}: there is nothing to tune; want one of {}", known.join(", ")))
    })?;
    let folder = target_dir().join("tune");
    let worlds = folder.join("worlds");
    if !worlds.join("suite.yaml").is_file() {
        let mut generate = Command::new(built("vb-harness"));
        generate.args(["suite", "generate", "--training", "--seed", SEED]);
        generate.args(["--worlds", WORLDS, "--name", "training"]);
        run(generate.arg("--out").arg(&worlds).stderr(Stdio::null()))?;
    }
    apart(&worlds)?;
    step("| parameters | success % | low | medium | high | time s | rollover |");
    step("|---|---|---|---|---|---|---|");
    for params in *candidates {
        let out =
            folder.join(planner).join(if params.is_empty() { "defaults".into() } else { params.join("-") });
        remove(&out)?;
        let mut drive = Command::new(built("vb-harness"));
        drive.arg("--plugin").arg(default_plugin_dir().join(format!("{planner}.wasm")));
        drive.arg("--suite").arg(&worlds).args(["--tasks", TASKS, "--trace", "none"]).arg("--out").arg(&out);
        params.iter().for_each(|p| {
            drive.args(["--param", p]);
        });
        run(drive.stdout(Stdio::null()).stderr(Stdio::null()))?;
        step(&row(params, &out.join("summary.json"))?);
    }
    Ok(())
}

fn row(params: &[&str], file: &Path) -> Result<String, Failure> {
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|e| wrong(&e))?;
    let summary: Value = serde_json::from_str(&text).map_err(|e| wrong(&e))?;
    let percent =
        |group: &Value| group["success_rate"].as_f64().map_or("–".into(), |v| format!("{:.1}", 100.0 * v));
    let (all, level) = (&summary["all"], &summary["elevation"]);
    Ok(format!(
        "| {} | {} | {} | {} | {} | {:.1} | {} |",
        if params.is_empty() { "defaults".to_owned() } else { params.join(", ") },
        percent(all),
        percent(&level["low"]),
        percent(&level["medium"]),
        percent(&level["high"]),
        all["time_mean_s"].as_f64().unwrap_or(f64::NAN),
        all["outcomes"]["rollover"].as_u64().unwrap_or(0)
    ))
}

/// Fails if one of these worlds is one of a suite that comes with the harness.
fn apart(worlds: &Path) -> Result<(), Failure> {
    let suites: Vec<PathBuf> = std::fs::read_dir(root().join("tasks"))
        .map_err(|e| Failure::new(format!("tasks: {e}")))?
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.join("suite.yaml").is_file())
        .collect();
    let training = hashes(worlds)?;
    for suite in suites {
        if let Some(hash) = hashes(&suite)?.intersection(&training).next() {
            return Err(Failure::new(format!(
                "{}: the training world with hash {hash} is one of it: choose another seed",
                suite.display()
            )));
        }
    }
    step(&format!("{} training worlds, none of them in a suite", training.len()));
    Ok(())
}

/// Content hashes of a suite's worlds.
fn hashes(suite: &Path) -> Result<BTreeSet<String>, Failure> {
    let file = suite.join("suite.yaml");
    let text =
        std::fs::read_to_string(&file).map_err(|e| Failure::new(format!("{}: {e}", file.display())))?;
    Ok(text
        .lines()
        .filter_map(|l| l.trim().strip_prefix("sha256: "))
        .map(|h| h.trim_matches('"').to_owned())
        .collect())
}
