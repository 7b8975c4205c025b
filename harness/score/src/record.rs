//! One line of `tasks.jsonl`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::measures::measures;
use vb_world::{Density, Elevation, Terrain};

use crate::{Cause, Flag, Metrics, Outcome, Ride, TaskScore, ThreeWay};

measures! {
    /// What a planner used in one task. Fuel is in the host's units (WebAssembly instructions, roughly). Records of
    /// run layout 1 have `total` and `max_step` only.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct FuelUse {
        /// Fuel in the whole task.
        pub total: u64,
        /// Fuel for start-up and `init`.
        #[serde(default)]
        pub init: u64,
        /// Fuel for the median step.
        #[serde(default)]
        pub p50_step: u64,
        /// Fuel that 99 % of the steps stay within.
        #[serde(default)]
        pub p99_step: u64,
        /// Fuel for the most costly step.
        pub max_step: u64,
        /// `init` as a share of its limit.
        #[serde(default)]
        pub init_share: f64,
        /// `p99_step` as a share of the limit of a step.
        #[serde(default)]
        pub p99_share: f64,
        /// `max_step` as a share of the limit of a step.
        #[serde(default)]
        pub max_share: f64,
        /// The most linear memory, bytes.
        #[serde(default)]
        pub memory_bytes: u64,
    }
}

impl FuelUse {
    /// The use of a task whose start-up took `init` and whose steps took `steps`, within limits of `init_limit` and
    /// `step_limit`.
    #[must_use]
    pub fn new(init: u64, mut steps: Vec<u64>, init_limit: u64, step_limit: u64, memory_bytes: u64) -> Self {
        steps.sort_unstable();
        // Nearest rank: the least value that so many percent are not above.
        let percentile = |percent: usize| {
            steps.get((steps.len() * percent).div_ceil(100).saturating_sub(1)).copied().unwrap_or(0)
        };
        let fraction = |used: u64, limit: u64| if limit == 0 { 0.0 } else { used as f64 / limit as f64 };
        let (p99_step, max_step) = (percentile(99), percentile(100));
        Self {
            total: steps.iter().fold(init, |sum, &n| sum.saturating_add(n)),
            init,
            p50_step: percentile(50),
            p99_step,
            max_step,
            init_share: fraction(init, init_limit),
            p99_share: fraction(p99_step, step_limit),
            max_share: fraction(max_step, step_limit),
            memory_bytes,
        }
    }
}

/// The record of a finished task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskRecord {
    /// The name of the task in the suite, e.g. `w001/t03`.
    pub task: String,
    /// The name of the task's world.
    pub world: String,
    /// The elevation level of the world.
    pub elevation: Elevation,
    /// The kind of ground of the world.
    pub terrain: Terrain,
    /// The obstacle density of the world.
    pub density: Density,
    /// The outcome of the task.
    pub outcome: Outcome,
    /// The paper's class of the outcome.
    pub three_way: ThreeWay,
    /// What is true or false of the trial beside its outcome ([`TaskRecord::judge`]); what isn't known is left out.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub flags: BTreeMap<Flag, bool>,
    /// The reason for the outcome, in words.
    pub reason: String,
    /// What the vehicle was up against, if it rolled over or got stuck. Records before version 0.2 have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<Cause>,
    /// The figures that the cause was known by, in words; empty without a cause.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub evidence: String,
    /// The stable code of what happened, for errors, e.g. `planner/out-of-fuel`. Before version 0.2 it has no part
    /// before the slash.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// The simulated time at the end of the task, s.
    pub time_s: f64,
    /// The hash over the whole state of the simulation at every sample, as 16 hexadecimal digits.
    pub state_hash: String,
    /// The number of simulation steps.
    pub sim_steps: u64,
    /// The number of calls of the planner's step.
    pub planner_steps: u64,
    /// The number of these calls whose command was out of range and was clamped.
    pub clamped: u64,
    /// The resources that the planner used; `None` for native planners.
    pub fuel: Option<FuelUse>,
    /// The measures; `None` if the task ended before the first sample.
    pub metrics: Option<Metrics>,
    /// Shock and ride; `None` if the task ended before the first step, or was scored again with another end.
    #[serde(default, deserialize_with = "Ride::checked", skip_serializing_if = "Option::is_none")]
    pub ride: Option<Ride>,
    /// The last lines that the planner logged, if the run keeps them for such a task; otherwise, or if it logged none,
    /// the list is empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub log: Vec<String>,
    /// The innermost functions at a trap of the planner, the failing one first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub backtrace: Vec<String>,
}

impl TaskRecord {
    /// The reason with the cause and its evidence, in words: `moved 0.12 m in the last 10 s; high-centred: the hull bears 43 %
    /// of the weight`.
    #[must_use]
    pub fn explanation(&self) -> String {
        match self.cause {
            None => self.reason.clone(),
            Some(cause) if self.evidence.is_empty() => format!("{}; {}", self.reason, cause.title()),
            Some(cause) => format!("{}; {}: {}", self.reason, cause.title(), self.evidence),
        }
    }

    /// Sets the flags to what outcome, metrics and ride say.
    pub fn judge(&mut self) {
        self.flags = self.judged();
    }

    /// The flags that outcome, metrics and ride give.
    #[must_use]
    pub fn judged(&self) -> BTreeMap<Flag, bool> {
        Flag::ALL.into_iter().filter_map(|flag| Some((flag, flag.of(self)?))).collect()
    }

    /// Replaces what the rules decided by another score, as re-scoring does. What was counted over the whole simulation
    /// (state hash, steps, clamped commands, fuel, log) stays. So does the cause of a failure that is one of the same kind, and
    /// shock and ride where the trial ends at the same time: a trace doesn't hold what others could be known by.
    pub fn set_score(&mut self, score: TaskScore) {
        let TaskScore { outcome, three_way, reason, time_s, metrics } = score;
        if time_s != self.time_s {
            self.ride = None;
        }
        if outcome != self.outcome {
            (self.cause, self.evidence) = (None, String::new());
        }
        if !matches!(outcome, Outcome::PlannerError | Outcome::SimError | Outcome::HostError) {
            self.fault = None;
        }
        (self.outcome, self.three_way, self.reason) = (outcome, three_way, reason);
        (self.time_s, self.metrics) = (time_s, metrics);
        self.judge();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank() {
        // 1 to 200 in disorder: half are not above 100, 99 % not above 198.
        let steps = (0..200u64).map(|i| (i * 77) % 200 + 1).collect();
        let used = FuelUse::new(1000, steps, 4000, 400, 65536);
        assert_eq!((used.p50_step, used.p99_step, used.max_step), (100, 198, 200));
        assert_eq!(
            (used.total, used.init_share, used.p99_share, used.max_share),
            (1000 + 20_100, 0.25, 0.495, 0.5)
        );
        let none = FuelUse::new(7, Vec::new(), 4000, 400, 0);
        assert_eq!((none.total, none.p50_step, none.max_step), (7, 0, 0));
        assert_eq!(FuelUse::new(0, vec![5], 1, 1, 0).p50_step, 5);
    }

    #[test]
    fn a_record_of_the_first_version_is_read() {
        // As version 0.1.0 wrote it, cut down to its needs.
        let used: FuelUse = serde_json::from_str(r#"{"total":100,"max_step":20}"#).unwrap();
        assert_eq!((used.total, used.max_step, used.p99_step), (100, 20, 0));
        // Its measures had neither `reverse_s` nor the place of the end, and are written as they were read but for the former.
        let text = r#"{"samples":1,"roll_mean_deg":0.0,"roll_variance_deg2":0.0,"roll_max_deg":0.0,"roll_end_deg":0.0,
            "pitch_mean_deg":0.0,"pitch_variance_deg2":0.0,"pitch_max_deg":0.0,"distance_m":0.0,"speed_mean_m_per_s":0.0,
            "speed_max_m_per_s":0.0,"throttle_effort_s":0.0,"brake_effort_s":0.0,"steering_effort_s":0.0,
            "steering_rate_per_s":0.0,"goal_distance_min_m":5.0,"goal_distance_end_m":6.0}"#;
        let metrics: Metrics = serde_json::from_str(text).unwrap();
        assert_eq!((metrics.end(), metrics.goal_distance_end_m), (None, 6.0));
        let written = serde_json::to_string(&metrics).unwrap();
        assert!(!written.contains("end_x_m"), "{written}");
    }
}
