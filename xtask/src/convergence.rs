//! Whether the step and the soil's grid decide verdicts.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::records::records;
use crate::run::{Failure, remove, run, step};
use crate::{build_all, built, default_plugin_dir, target_dir};

/// Seed and number of worlds of the suite, of which two thirds are low or medium: 100 tasks of each kind of ground.
const SUITES: [&str; 2] = ["rigid", SOFT];
const SOFT: &str = "deformable";
const SEED: &str = "7";
const WORLDS: &str = "15";

/// Drives 100 low and medium tasks on rigid and on deformable ground with the shipped step and grid, with others, and
/// at another speed, and tells how many verdicts stay.
pub(crate) fn convergence() -> Result<(), Failure> {
    build_all()?;
    let dir = target_dir().join("convergence");
    remove(&dir)?;
    let mut table = vec![
        "| ground | change | same outcome of 100 | successes, before and after | mean change of time |"
            .to_owned(),
        "|---|---|---|---|---|".to_owned(),
    ];
    for ground in SUITES {
        let suite = dir.join(ground);
        generate(&suite, ground)?;
        let drive = |name: &str, options: &[&str]| {
            step(&format!("driving on {ground} ground: {name}"));
            drive(&suite, &dir.join(format!("{ground}-{}", name.replace(' ', "-"))), options)
        };
        let base = drive("as shipped", &[])?;
        let mut changes = vec![
            ("half the step", vec!["--time-step", "0.5ms"]),
            ("twice the step", vec!["--time-step", "2ms"]),
            // What chance alone does: another speed by a thousandth.
            ("5.005 m/s", vec!["--param", "speed=5.005"]),
        ];
        if ground == SOFT {
            changes.push(("half the grid", vec!["--soil-resolution", "0.05"]));
        }
        for (name, options) in changes {
            table.push(compare(ground, name, &base, &drive(name, &options)?));
        }
    }
    let file = dir.join("convergence.md");
    let text = table.join("\n") + "\n";
    std::fs::write(&file, &text).map_err(|e| Failure::new(format!("can't write {}: {e}", file.display())))?;
    step(&format!("{text}table: {}", file.display()));
    Ok(())
}

/// The generator's rules with nothing but this ground.
fn only(ground: &str, rules: &str) -> Option<String> {
    let order = rules.lines().find(|line| line.trim_start().starts_with("order: ["))?;
    Some(rules.replacen(order, &format!("  order: [{ground}]"), 1))
}

fn generate(suite: &Path, ground: &str) -> Result<(), Failure> {
    let params = crate::root().join("tasks/generator/default.yaml");
    let text = std::fs::read_to_string(&params)
        .map_err(|e| Failure::new(format!("can't read {}: {e}", params.display())))?;
    let text = only(ground, &text)
        .ok_or_else(|| Failure::new(format!("{} has no line `order: […]`", params.display())))?;
    let own = suite.with_extension("yaml");
    let written =
        std::fs::create_dir_all(suite.parent().unwrap_or(suite)).and_then(|()| std::fs::write(&own, text));
    written.map_err(|e| Failure::new(format!("can't write {}: {e}", own.display())))?;
    let mut command = Command::new(built("vb-harness"));
    command.args(["suite", "generate", "--seed", SEED, "--worlds", WORLDS, "--params"]).arg(&own);
    run(command.arg("--out").arg(suite).stdout(std::process::Stdio::null()))
}

/// Outcome and time of each task.
type Verdicts = BTreeMap<String, (String, f64)>;

fn drive(suite: &Path, out: &Path, options: &[&str]) -> Result<Verdicts, Failure> {
    let mut command = Command::new(built("vb-harness"));
    command.arg("--plugin").arg(default_plugin_dir().join("pid.wasm")).arg("--suite").arg(suite);
    command.args(["--tasks", "elevation=low,elevation=medium", "--trace", "none", "--out"]).arg(out);
    run(command.args(options).stdout(std::process::Stdio::null()))?;
    let of = |record: &Value| {
        let text = |name: &str| record[name].as_str().map(str::to_owned);
        Some((text("task")?, (text("outcome")?, record["time_s"].as_f64()?)))
    };
    let wrong = || Failure::new(format!("{}: a record without task, outcome or time", out.display()));
    records(out)?.iter().map(of).collect::<Option<_>>().ok_or_else(wrong)
}

fn compare(ground: &str, name: &str, base: &Verdicts, other: &Verdicts) -> String {
    let pairs: Vec<_> = base.iter().filter_map(|(task, a)| Some((a, other.get(task)?))).collect();
    let same = pairs.iter().filter(|(a, b)| a.0 == b.0).count();
    let successes = |v: &Verdicts| v.values().filter(|(outcome, _)| outcome == "success").count();
    let both: Vec<f64> = pairs
        .iter()
        .filter(|(a, b)| a.0 == "success" && b.0 == "success")
        .map(|(a, b)| (b.1 / a.1 - 1.0).abs())
        .collect();
    let mean = 100.0 * both.iter().sum::<f64>() / both.len().max(1) as f64;
    let (before, after) = (successes(base), successes(other));
    format!("| {ground} | {name} | {same} of {} | {before}, {after} | {mean:.2} % |", pairs.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generators_rules_can_be_had_with_one_ground_only() {
        let rules = include_str!("../../tasks/generator/default.yaml");
        let rigid = only("rigid", rules).expect("a line with the order of grounds");
        assert!(rigid.contains("  order: [rigid]\n") && rigid.lines().count() == rules.lines().count());
        assert_eq!(rigid.matches("order:").count(), 1);
    }

    #[test]
    fn verdicts_are_compared_task_by_task() {
        let v = |items: &[(&str, &str, f64)]| -> Verdicts {
            items.iter().map(|(t, o, s)| ((*t).to_owned(), ((*o).to_owned(), *s))).collect()
        };
        let a = v(&[("a", "success", 40.0), ("b", "stuck", 20.0), ("c", "success", 30.0)]);
        let b = v(&[("a", "success", 42.0), ("b", "stuck", 25.0), ("c", "rollover", 9.0)]);
        assert_eq!(compare("rigid", "x", &a, &b), "| rigid | x | 2 of 3 | 2, 1 | 5.00 % |");
    }
}
