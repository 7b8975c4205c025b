//! Whether longer steps of the simulation are equivalent to the benchmark's step: paired tests of equivalence.
//!
//! Two one-sided tests (D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987, 657): success rates are equivalent at a level of 5 % if
//! the 90 % confidence interval of their difference lies within the margin. The tasks of a world are not independent, so the interval
//! is over the mean differences of worlds, by Student's t.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::records::records;
use crate::run::{Failure, run, step};
use crate::{build_all, built, default_plugin_dir, target_dir};

/// Seed and number of worlds of the suite, which no other suite has.
const SEED: &str = "21";
const WORLDS: usize = 100;
/// Vehicles. Each drives the same number of consecutive worlds, in which all levels occur.
const VEHICLES: [&str; 10] =
    ["artcar", "feda", "gator", "hmmwv", "husky", "jackal", "m113", "man10t", "man5t", "verti4wheeler"];
const PLANNERS: [&str; 3] = ["pid", "eh", "mppi"];
/// What is compared with a run with the benchmark's settings. The speed tells what an irrelevant change does.
const CHANGES: [(&str, &[&str]); 3] = [
    ("2 ms", &["--time-step", "2ms"]),
    ("5 ms", &["--time-step", "5ms"]),
    ("1 ms, 5.005 m/s", &["--param", "speed=5.005"]),
];
/// Difference of success rates up to which they are equivalent, percentage points.
const MARGIN: f64 = 2.0;
/// Exit code of a run in which the simulations of some tasks failed.
const SIM_ERRORS: i32 = 5;
/// The 95 % quantile of Student's t with [`WORLDS`] - 1 degrees of freedom.
const QUANTILE: f64 = 1.660;

/// Outcome of each task, by planner and task.
type Ends = BTreeMap<(&'static str, String), String>;

/// Drives the suite with each setting and prints the differences of success rates with their intervals. Runs that an earlier call
/// left are continued.
pub(crate) fn equivalence() -> Result<(), Failure> {
    build_all()?;
    let dir = target_dir().join("equivalence");
    let suite = dir.join("suite");
    if !suite.join("suite.yaml").is_file() {
        let mut command = Command::new(built("vb-harness"));
        command.args(["suite", "generate", "--seed", SEED, "--worlds", &WORLDS.to_string(), "--out"]);
        run(command.arg(&suite).stdout(Stdio::null()))?;
    }
    let drive =
        |name: &str, options: &[&str]| drive(&suite, &dir.join(name.replace([' ', ','], "-")), options);
    let base = drive("1 ms", &[])?;
    step(
        "| compared with 1 ms | planner | success %, before and after | difference, points (90 %) | equivalent | same end, % |",
    );
    step("|---|---|---|---|---|---|");
    for (name, options) in CHANGES {
        let other = drive(name, options)?;
        for planner in PLANNERS.into_iter().map(Some).chain([None]) {
            step(&Comparison::new(&base, &other, planner)?.row(name, planner.unwrap_or("all")));
        }
    }
    Ok(())
}

/// Lets each planner drive with each vehicle, and returns the ends of all tasks.
fn drive(suite: &Path, out: &Path, options: &[&str]) -> Result<Ends, Failure> {
    let mut ends = Ends::new();
    let share = WORLDS / VEHICLES.len();
    for (k, vehicle) in VEHICLES.into_iter().enumerate() {
        for planner in PLANNERS {
            let run_dir = out.join(format!("{planner}-{vehicle}"));
            let worlds = format!("w{:03}-w{:03}", k * share + 1, (k + 1) * share);
            let mut command = Command::new(built("vb-harness"));
            command.arg("run").arg(default_plugin_dir().join(format!("{planner}.wasm")));
            command.arg("--suite").arg(suite).args(["--tasks", &worlds, "--vehicle", vehicle]);
            command.args(["--trace", "none", "--resume", "--out"]).arg(&run_dir).args(options);
            // A run in which simulations failed, which count as failures, ends with a code of its own.
            let code =
                command.stdout(Stdio::null()).stderr(Stdio::null()).status().ok().and_then(|s| s.code());
            if !code.is_some_and(|code| [0, SIM_ERRORS].contains(&code)) {
                return Err(Failure::new(format!(
                    "{}: vb-harness run failed (see tasks.jsonl)",
                    run_dir.display()
                )));
            }
            for record in records(&run_dir)? {
                let field = |name: &str| record[name].as_str().unwrap_or_default().to_owned();
                ends.insert((planner, field("task")), field("outcome"));
            }
        }
    }
    Ok(ends)
}

/// Two settings, compared task by task.
struct Comparison {
    /// Success rates, %.
    rates: [f64; 2],
    /// Difference of the rates, percentage points.
    difference: f64,
    /// Half the width of its 90 % confidence interval, percentage points.
    margin: f64,
    /// Tasks with the same end, %.
    same: f64,
}

impl Comparison {
    /// Compares the tasks of a planner, or of all.
    fn new(base: &Ends, other: &Ends, planner: Option<&str>) -> Result<Self, Failure> {
        let mut worlds: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        let (mut tasks, mut successes, mut same) = (0.0, [0.0, 0.0], 0.0);
        for (key @ (of, task), before) in base.iter().filter(|((of, _), _)| planner.is_none_or(|p| p == *of))
        {
            let after = other.get(key).ok_or_else(|| Failure::new(format!("{of} has not driven {task}")))?;
            let [a, b] = [before, after].map(|outcome| f64::from(u8::from(outcome == "success")));
            let world = task.split_once('/').map_or(task.as_str(), |(world, _)| world);
            worlds.entry(world).or_default().push(b - a);
            tasks += 1.0;
            successes = [successes[0] + a, successes[1] + b];
            same += f64::from(u8::from(before == after));
        }
        let means: Vec<f64> =
            worlds.values().map(|d| 100.0 * d.iter().sum::<f64>() / d.len() as f64).collect();
        let n = means.len() as f64;
        let difference = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|d| (d - difference) * (d - difference)).sum::<f64>() / (n - 1.0);
        Ok(Self {
            rates: successes.map(|s| 100.0 * s / tasks),
            difference,
            margin: QUANTILE * (variance / n).sqrt(),
            same: 100.0 * same / tasks,
        })
    }

    fn is_equivalent(&self) -> bool {
        self.difference.abs() + self.margin < MARGIN
    }

    fn row(&self, change: &str, planner: &str) -> String {
        let ([before, after], difference) = (self.rates, self.difference);
        let [low, high] = [difference - self.margin, difference + self.margin];
        let verdict = if self.is_equivalent() { "yes" } else { "no" };
        format!(
            "| {change} | {planner} | {before:.1}, {after:.1} | {difference:+.1} ({low:+.1} to {high:+.1}) | {verdict} | {:.1} |",
            self.same
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(successes: impl Fn(usize, usize) -> bool) -> Ends {
        let task = |w: usize, t: usize| {
            let outcome = if successes(w, t) { "success" } else { "stuck" };
            (("pid", format!("w{w:03}/t{t:02}")), outcome.to_owned())
        };
        (0..WORLDS).flat_map(|w| (0..10).map(move |t| task(w, t))).collect()
    }

    #[test]
    fn the_same_ends_are_equivalent_and_five_points_are_not() {
        let base = ends(|w, _| w % 2 == 0);
        let same = Comparison::new(&base, &base, None).unwrap();
        assert!(same.is_equivalent());
        assert_eq!((same.rates, same.difference, same.margin, same.same), ([50.0; 2], 0.0, 0.0, 100.0));
        let fewer = Comparison::new(&base, &ends(|w, t| w % 2 == 0 && t > 0), Some("pid")).unwrap();
        assert!(!fewer.is_equivalent());
        assert_eq!((fewer.rates[1], fewer.difference, fewer.same), (45.0, -5.0, 95.0));
        // Worlds differ by 0 or 10 points, half of them each: 1.66 · 5.0252 / 10.
        assert!((fewer.margin - 0.834).abs() < 1e-3, "{}", fewer.margin);
    }

    #[test]
    fn a_task_that_was_driven_once_only_is_told() {
        let base = ends(|_, _| true);
        let mut other = base.clone();
        other.pop_last();
        let told = Comparison::new(&base, &other, None).err().unwrap().to_string();
        assert_eq!(told, "pid has not driven w099/t09");
    }
}
