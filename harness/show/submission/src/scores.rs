//! All that an evaluation on a hidden suite tells.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vb_report::{Estimate, Measure, RunFigures, Runs};
use vb_score::{Flag, Outcome};

pub const SCORES_SCHEMA: u32 = 1;

/// The figures over all tasks of a suite that stays hidden. There is nothing in them of a single task or world, nothing
/// that the planner wrote, and neither path, seed nor hash of the suite. Means are rounded: their last digits could be
/// used to carry out what the planner saw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scores {
    /// The version of the layout, [`SCORES_SCHEMA`].
    pub schema: u32,
    pub harness_version: String,
    /// The name that the owner gives to the suite.
    pub suite: String,
    /// The name that the owner gives to this version of the suite.
    pub suite_version: String,
    pub planner: String,
    pub planner_version: String,
    /// The SHA-256 of the plugin.
    pub plugin_sha256: String,
    pub vehicle: String,
    pub rules: String,
    pub perception: String,
    pub tasks: u64,
    pub outcomes: BTreeMap<Outcome, u64>,
    /// The number of tasks of which each flag is true, whatever their outcome.
    pub flags: BTreeMap<Flag, u64>,
    /// The successes over the tasks, percent, to a tenth.
    pub success_percent: f64,
    /// The 95 % interval of the success rate by the bootstrap over worlds, percent; `None` for a single world.
    pub success_interval_percent: Option<[f64; 2]>,
    /// The mean traversal time of successes, s, to a tenth.
    pub time_mean_s: Option<f64>,
    /// The mean |roll|, degrees, to a tenth.
    pub roll_mean_deg: Option<f64>,
    /// The mean |pitch|, degrees, to a tenth.
    pub pitch_mean_deg: Option<f64>,
}

impl Scores {
    /// The scores of the first of `runs`.
    #[must_use]
    pub fn new(runs: &Runs, suite_version: &str) -> Self {
        let run = &runs.runs[0];
        let figures = RunFigures::new(runs, run).all;
        let tenth = |v: f64| (v * 10.0).round() / 10.0;
        let mean = |m| figures.mean(m).map(|e: Estimate| tenth(m.shown(e.mean)));
        let success = figures.mean(Measure::Success);
        let text = |t: &str| vb_report::one_line(t, 80);
        Self {
            schema: SCORES_SCHEMA,
            harness_version: run.header.harness_version.clone(),
            suite: text(&run.header.suite.name),
            suite_version: text(suite_version),
            planner: text(&run.header.plugin.name),
            planner_version: text(&run.header.plugin.version),
            plugin_sha256: run.header.plugin.sha256.clone(),
            vehicle: text(&run.header.vehicle.name),
            rules: text(&run.header.rules.name),
            perception: text(&run.header.perception.name),
            tasks: figures.tasks,
            outcomes: Outcome::ALL.into_iter().map(|o| (o, figures.count(o))).collect(),
            flags: Flag::ALL.into_iter().filter_map(|flag| Some((flag, figures.flagged(flag)?))).collect(),
            success_percent: mean(Measure::Success).unwrap_or(0.0),
            success_interval_percent: success
                .and_then(|e| e.interval)
                .map(|i| [tenth(100.0 * i.low), tenth(100.0 * i.high)]),
            time_mean_s: mean(Measure::Time),
            roll_mean_deg: mean(Measure::Roll),
            pitch_mean_deg: mean(Measure::Pitch),
        }
    }

    /// The scores as lines for people.
    #[must_use]
    pub fn text(&self) -> String {
        use std::fmt::Write as _;
        let mut s = format!(
            "{} {} on {} {}: {} tasks\n",
            self.planner, self.planner_version, self.suite, self.suite_version, self.tasks
        );
        let _ = write!(s, "rate     {:.1} %", self.success_percent);
        if let Some([low, high]) = self.success_interval_percent {
            let _ = write!(s, " (95 %: {low:.1} to {high:.1} %)");
        }
        s.push('\n');
        for (outcome, n) in self.outcomes.iter().filter(|(_, n)| **n > 0) {
            let _ = writeln!(s, "{:<8} {n}", outcome.name());
        }
        for (flag, n) in &self.flags {
            let _ = writeln!(s, "{:<8} {n}", flag.title());
        }
        let rows = [
            ("time", self.time_mean_s, "s"),
            ("|roll|", self.roll_mean_deg, "°"),
            ("|pitch|", self.pitch_mean_deg, "°"),
        ];
        for (name, value, unit) in rows {
            if let Some(v) = value {
                let _ = writeln!(s, "{name:<8} {v:.1} {unit}");
            }
        }
        s
    }
}
