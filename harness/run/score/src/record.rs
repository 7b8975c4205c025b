//! One line of `tasks.jsonl`.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use vb_sdk::fault::FaultCode;

use crate::measures::{MOST, measures, outside};
use vb_world::{Density, Elevation, TaskId, Terrain};

use crate::{Cause, Flag, Metrics, Outcome, Ride, TaskScore, ThreeWay};

measures! {
    /// Resources that a planner used in one task. Fuel is in the host's units (approximately WebAssembly instructions).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    "fuel": pub struct FuelUse {
        /// Fuel in the whole task.
        pub total: u64,
        /// Fuel for start-up and `init`.
        pub init: u64,
        /// Median fuel per step.
        pub p50_step: u64,
        /// 99th percentile of the fuel per step.
        pub p99_step: u64 => column("fuel 99 %"),
        /// Maximum fuel per step.
        pub max_step: u64,
        /// `init` as a fraction of its limit.
        pub init_fraction: f64,
        /// `p99_step` as a fraction of the limit of a step.
        pub p99_fraction: f64,
        /// `max_step` as a fraction of the limit of a step.
        pub max_fraction: f64,
        /// Maximum linear memory, bytes.
        pub memory_bytes: u64,
    }
}

/// Reads a time of a record, s.
fn time<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(from)?;
    outside("time_s", value, 0.0, MOST).map_or(Ok(value), |flaw| Err(serde::de::Error::custom(flaw)))
}

/// Reads a count of a record: counts are summed over tasks.
fn count<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    /// More than any simulation has steps.
    const MOST: u64 = 1 << 40;
    let value = u64::deserialize(from)?;
    if value > MOST {
        let text = format!("a count of {value} is more than {MOST}");
        return Err(serde::de::Error::custom(text));
    }
    Ok(value)
}

impl FuelUse {
    /// Adds the use of another task: the sum of the total fuel, and the maximum of all other values.
    pub(crate) fn pool(&mut self, other: &Self) {
        *self = Self {
            total: self.total.saturating_add(other.total),
            init: self.init.max(other.init),
            p50_step: self.p50_step.max(other.p50_step),
            p99_step: self.p99_step.max(other.p99_step),
            max_step: self.max_step.max(other.max_step),
            init_fraction: self.init_fraction.max(other.init_fraction),
            p99_fraction: self.p99_fraction.max(other.p99_fraction),
            max_fraction: self.max_fraction.max(other.max_fraction),
            memory_bytes: self.memory_bytes.max(other.memory_bytes),
        };
    }

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
            init_fraction: fraction(init, init_limit),
            p99_fraction: fraction(p99_step, step_limit),
            max_fraction: fraction(max_step, step_limit),
            memory_bytes,
        }
    }
}

/// The record of a finished task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskRecord {
    /// The name of the task in the suite, e.g. `w001/t03`.
    pub task: TaskId,
    /// The name of the task's world.
    pub world: String,
    /// The elevation level of the world.
    pub elevation: Elevation,
    /// The terrain of the world.
    pub terrain: Terrain,
    /// The obstacle density of the world.
    pub density: Density,
    /// The outcome of the task.
    pub outcome: Outcome,
    /// The paper's class of the outcome.
    pub three_way: ThreeWay,
    /// Properties of the trial in addition to its outcome ([`TaskRecord::judge`]); unknown ones are left out.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub flags: BTreeMap<Flag, bool>,
    /// The settings that aren't the benchmark's ([`crate::Conditions::departures`]), as text, e.g. `time step 5 ms`;
    /// the result is not comparable with results without them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub departures: Vec<String>,
    /// The reason for the outcome, as text.
    pub reason: String,
    /// The cause of a rollover or of getting stuck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<Cause>,
    /// The measured values on which the cause is based, as text; empty without a cause.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub evidence: String,
    /// The stable code of an error, e.g. `planner/out-of-fuel`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultCode>,
    /// The simulated time at the end of the task, s.
    #[serde(deserialize_with = "time")]
    pub time_s: f64,
    /// The hash over the whole state of the simulation at every sample, as 16 hexadecimal digits.
    pub state_hash: String,
    /// The number of simulation steps.
    #[serde(deserialize_with = "count")]
    pub sim_steps: u64,
    /// The number of calls of the planner's step.
    #[serde(deserialize_with = "count")]
    pub planner_steps: u64,
    /// The number of these calls whose command was out of range and was clamped.
    #[serde(deserialize_with = "count")]
    pub clamped: u64,
    /// The resources that the planner used; `None` for native planners.
    #[serde(default, deserialize_with = "FuelUse::checked")]
    pub fuel: Option<FuelUse>,
    /// The measures; `None` if the task ended before the first sample.
    #[serde(default, deserialize_with = "Metrics::checked")]
    pub metrics: Option<Metrics>,
    /// Shock and ride; `None` if the task ended before the first step, or was re-scored with a different end.
    #[serde(default, deserialize_with = "Ride::checked", skip_serializing_if = "Option::is_none")]
    pub ride: Option<Ride>,
    /// The last lines of the planner's log, if the run keeps them for such a task; otherwise empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub log: Vec<String>,
    /// The innermost stack frames at a trap of the planner, the failing function first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub backtrace: Vec<String>,
}

impl TaskRecord {
    /// The reason with the cause and its evidence:
    /// `moved 0.12 m in the last 10 s; high-centred: the hull bears 43 % of the weight`.
    #[must_use]
    pub fn explanation(&self) -> String {
        match self.cause {
            None => self.reason.clone(),
            Some(cause) if self.evidence.is_empty() => format!("{}; {}", self.reason, cause.title()),
            Some(cause) => format!("{}; {}: {}", self.reason, cause.title(), self.evidence),
        }
    }

    /// Sets the flags that follow from outcome, metrics and ride.
    pub fn judge(&mut self) {
        self.flags = self.judged();
    }

    /// The flags that follow from outcome, metrics and ride.
    #[must_use]
    pub fn judged(&self) -> BTreeMap<Flag, bool> {
        let (metrics, ride) = (self.metrics.as_ref(), self.ride.as_ref());
        let of = |flag: Flag| Some((flag, flag.of(self.outcome, metrics, ride)?));
        Flag::ALL.into_iter().filter_map(of).collect()
    }

    /// Replaces what the rules decided by another score, as re-scoring does. Values over the whole simulation (state
    /// hash, steps, clamped commands, fuel, log) are kept, as are the cause of a failure of the same class, and shock
    /// and ride where the trial ends at the same time: traces don't contain the data to determine others.
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
    use crate::{Measured, Reader};

    #[test]
    fn percentiles_are_by_nearest_rank() {
        // 1 to 200 in disorder: half are not above 100, 99 % not above 198.
        let steps = (0..200u64).map(|i| (i * 77) % 200 + 1).collect();
        let used = FuelUse::new(1000, steps, 4000, 400, 65536);
        assert_eq!((used.p50_step, used.p99_step, used.max_step), (100, 198, 200));
        assert_eq!(
            (used.total, used.init_fraction, used.p99_fraction, used.max_fraction),
            (1000 + 20_100, 0.25, 0.495, 0.5)
        );
        let none = FuelUse::new(7, Vec::new(), 4000, 400, 0);
        assert_eq!((none.total, none.p50_step, none.max_step), (7, 0, 0));
        assert_eq!(FuelUse::new(0, vec![5], 1, 1, 0).p50_step, 5);
    }

    #[test]
    fn fuel_is_given_as_fractions_of_its_limits_which_no_planner_exceeds() {
        let used = FuelUse::new(1000, vec![200], 4000, 400, 65536);
        assert_eq!([used.init_fraction, used.p99_fraction, used.max_fraction], [0.25, 0.5, 0.5]);
        let beyond = FuelUse { max_fraction: 1.5, ..used };
        assert_eq!(beyond.flaw().unwrap(), "max_fraction: 1.5 must lie in 0 to 1");
    }

    /// Whatever number a stranger writes, it is one that a trial can have, or the record is none.
    #[test]
    fn a_record_with_a_number_that_no_trial_has_is_refused_by_field_and_value() {
        let text = r#"{"task":"w001/t00","world":"w001","elevation":"low","terrain":"rigid","density":"sparse",
            "outcome":"success","three_way":"success","reason":"","time_s":1.0,"state_hash":"","sim_steps":1,"planner_steps":1,
            "clamped":0}"#;
        let mut good: serde_json::Value = serde_json::from_str(text).unwrap();
        good["fuel"] = serde_json::to_value(FuelUse::default()).unwrap();
        good["metrics"] = serde_json::to_value(Metrics::default()).unwrap();
        let ride = Ride { energy_surplus_j: Some(0.0), held_fraction: Some(0.0), ..Ride::default() };
        good["ride"] = serde_json::to_value(ride).unwrap();
        serde_json::from_value::<TaskRecord>(good.clone()).unwrap();
        let mut tried = 0;
        let mut attack = |place: &[&str], value: &serde_json::Value| {
            let mut bad = good.clone();
            let field = place.iter().fold(&mut bad, |v, name| &mut v[*name]);
            *field = value.clone();
            let e = serde_json::from_str::<TaskRecord>(&bad.to_string()).unwrap_err().to_string();
            assert!(e.len() < 200, "{place:?} = {value}: {e}");
            tried += 1;
            e
        };
        for group in ["metrics", "fuel", "ride"] {
            for (name, value) in good[group].as_object().unwrap() {
                if value.is_f64() {
                    for odd in [1e308, -1e308, 1e17] {
                        let e = attack(&[group, name], &odd.into());
                        assert!(e.contains(&format!("{group}.{name}: {odd:e} must lie in")), "{e}");
                    }
                }
            }
        }
        assert!(attack(&["time_s"], &1e308.into()).contains("time_s: 1e308 must lie in 0 to 1e9"));
        attack(&["time_s"], &(-1.0).into());
        for name in ["sim_steps", "planner_steps", "clamped"] {
            attack(&[name], &u64::MAX.into());
        }
        attack(&["metrics", "samples"], &u64::MAX.into());
        attack(&["metrics", "roll_max_deg"], &180.1.into());
        attack(&["metrics", "roll_mean_deg"], &(-0.1).into());
        fn numbers<T>(of: &[Measured<T>]) -> usize {
            of.iter().filter(|m| matches!(m.value, Reader::Number(_) | Reader::Optional(_))).count()
        }
        let numbers = numbers(Metrics::MEASURES) + numbers(FuelUse::MEASURES) + numbers(Ride::MEASURES);
        assert_eq!(tried, 3 * numbers + 8);
    }
}
