//! Counts and averages over the tasks of a run: `summary.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vb_record::RunHeader;
use vb_world::{Density, Elevation, TaskId, Terrain};

use crate::stats::{Ratio, Running, success_interval};
use crate::{Cause, Conditions, Flag, FuelUse, Outcome, Pooled, Ride, Rules, TaskRecord, ThreeWay};

/// The version of the layout of a summary.
pub const SUMMARY_SCHEMA: u32 = 3;

/// The result of a run. It does not depend on the order in which tasks ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`SUMMARY_SCHEMA`].
    pub schema: u32,
    /// The version of the harness that ran the tasks.
    pub harness_version: String,
    /// The name of the suite.
    pub suite: String,
    /// The hash of the suite's content (hex).
    pub suite_hash: String,
    /// Name and version of the planner.
    pub planner: String,
    /// The planner's parameters as the user gave them; all others have its defaults.
    pub params: BTreeMap<String, String>,
    /// The SHA-256 of the planner's plugin file.
    pub plugin_sha256: String,
    /// The name of the vehicle.
    pub vehicle: String,
    /// The factor on every length of the world.
    pub scale: f64,
    /// The run's seed.
    pub seed: u64,
    /// The name of the rules applied.
    pub rules: String,
    /// The hash of the content of the rules applied (hex).
    pub rules_hash: String,
    /// The settings that aren't the benchmark's ([`Conditions::departures`]), as text, e.g. `time step 5 ms`; the
    /// result is not comparable with results without them.
    pub departures: Vec<String>,
    /// The selector that chose the tasks; `None` if all were chosen.
    pub selector: Option<String>,
    /// The number of tasks of the whole suite.
    pub suite_tasks: u64,
    /// The number of tasks that were to be run.
    pub planned: u64,
    /// The tasks whose trace ends before the rules determine an outcome. They are excluded from all figures below.
    pub undecided: Vec<TaskId>,
    /// The tasks with failures of the harness or the machine. They are excluded from all figures below; `--resume`
    /// re-runs them.
    pub host_errors: Vec<TaskId>,
    /// The figures over all tasks; `None` if there are none.
    pub all: Option<Group>,
    /// The figures by elevation level.
    pub elevation: BTreeMap<Elevation, Group>,
    /// The figures by terrain type.
    pub terrain: BTreeMap<Terrain, Group>,
    /// The figures by obstacle density.
    pub density: BTreeMap<Density, Group>,
    /// The figures by world.
    pub world: BTreeMap<String, Group>,
}

/// Figures over some tasks. Angles are absolute and in degrees; variances and standard deviations are of the
/// population.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// The number of tasks, at least 1.
    pub tasks: u64,
    /// The number of tasks by outcome, with every outcome except `host_error`, which isn't counted.
    pub outcomes: BTreeMap<Outcome, u64>,
    /// The number of tasks by the paper's class, with every class.
    pub three_way: BTreeMap<ThreeWay, u64>,
    /// The number of tasks for which each flag is true. Flags without data are omitted.
    pub flags: BTreeMap<Flag, u64>,
    /// The number of tasks that rolled over or got stuck by cause. Causes without tasks are omitted.
    pub causes: BTreeMap<Cause, u64>,
    /// The successes over the tasks. Errors of planner and simulation count as failures; excluding them would reward
    /// them.
    pub success_rate: f64,
    /// The lower end of the 95 % interval of the rate ([`success_interval`]); `None` for a single world.
    pub success_low: Option<f64>,
    /// The upper end of this interval.
    pub success_high: Option<f64>,
    /// The mean traversal time over successes, s; `None` without any.
    pub time_mean_s: Option<f64>,
    /// The standard deviation of the traversal time over successes, s.
    pub time_std_s: Option<f64>,
    /// The figures over the tasks' metrics.
    #[serde(flatten)]
    pub metrics: Pooled,
    /// The mean of each measure of [`Ride`] over the tasks that have it, by its name.
    pub ride: BTreeMap<String, f64>,
    /// The number of commands that were clamped.
    pub clamped: u64,
    /// The resources that the planner used: for `total` the sum over tasks, otherwise the maximum over tasks
    /// (`p99_step`: the maximum of the tasks' 99th percentiles). `None` for native planners.
    pub fuel: Option<FuelUse>,
}

impl Summary {
    /// The result of these tasks under these rules. Each task may occur once.
    #[must_use]
    pub fn new(
        header: &RunHeader,
        rules: &Rules,
        records: &[TaskRecord],
        mut undecided: Vec<TaskId>,
    ) -> Self {
        // Sums of floats depend on their order, so there is one: that of the tasks' names.
        let mut sorted: Vec<&TaskRecord> = records.iter().collect();
        sorted.sort_by(|a, b| a.task.cmp(&b.task));
        let (failed, sorted): (Vec<_>, Vec<_>) =
            sorted.into_iter().partition(|r| r.outcome == Outcome::HostError);
        undecided.sort();
        Self {
            schema: SUMMARY_SCHEMA,
            harness_version: header.harness_version.clone(),
            suite: header.suite.name.clone(),
            suite_hash: header.suite.hash.clone(),
            planner: format!("{} {}", header.plugin.name, header.plugin.version),
            params: header.params.clone(),
            plugin_sha256: header.plugin.sha256.clone(),
            vehicle: header.vehicle.name.clone(),
            scale: header.scale,
            seed: header.seed,
            rules: rules.name.clone(),
            rules_hash: rules.hash(),
            departures: Conditions::of(header).under(rules).departures(),
            selector: header.selector.clone(),
            suite_tasks: header.suite.tasks,
            planned: header.tasks,
            undecided,
            host_errors: failed.iter().map(|r| r.task.clone()).collect(),
            all: Group::new(&sorted),
            elevation: by(&sorted, |r| r.elevation),
            terrain: by(&sorted, |r| r.terrain),
            density: by(&sorted, |r| r.density),
            world: by(&sorted, |r| r.world.clone()),
        }
    }

    /// The number of tasks whose simulation failed.
    #[must_use]
    pub fn sim_errors(&self) -> u64 {
        self.all.as_ref().map_or(0, |all| all.outcomes.get(&Outcome::SimError).copied().unwrap_or(0))
    }

    /// The number of tasks that are neither finished, nor undecided, nor failed by the host.
    #[must_use]
    pub fn missing(&self) -> u64 {
        let done = self.all.as_ref().map_or(0, |all| all.tasks)
            + (self.undecided.len() + self.host_errors.len()) as u64;
        self.planned.saturating_sub(done)
    }
}

/// The figures of the tasks with each value of `key`.
fn by<K: Ord>(records: &[&TaskRecord], key: fn(&TaskRecord) -> K) -> BTreeMap<K, Group> {
    let mut groups: BTreeMap<K, Vec<&TaskRecord>> = BTreeMap::new();
    for record in records {
        groups.entry(key(record)).or_default().push(record);
    }
    groups.into_iter().filter_map(|(k, v)| Some((k, Group::new(&v)?))).collect()
}

impl Group {
    /// Figures over these tasks in the order given; none without tasks.
    fn new(records: &[&TaskRecord]) -> Option<Self> {
        let tasks = records.len() as u64;
        let mut outcomes: BTreeMap<Outcome, u64> =
            Outcome::ALL.into_iter().filter(|o| *o != Outcome::HostError).map(|o| (o, 0)).collect();
        let mut causes: BTreeMap<Cause, u64> = BTreeMap::new();
        let mut three_way: BTreeMap<ThreeWay, u64> = ThreeWay::ALL.map(|o| (o, 0)).into();
        let mut time = Running::default();
        let mut fuel: Option<FuelUse> = None;
        let mut clamped = 0;
        let mut flags: BTreeMap<Flag, u64> = BTreeMap::new();
        let mut ride = [Running::default(); Ride::MEASURES.len()];
        let mut worlds: BTreeMap<&str, Ratio> = BTreeMap::new();
        for r in records {
            let world = worlds.entry(&r.world).or_default();
            world.weight += 1.0;
            *outcomes.entry(r.outcome).or_default() += 1;
            *three_way.entry(r.three_way).or_default() += 1;
            r.flags.iter().for_each(|(flag, is)| *flags.entry(*flag).or_default() += u64::from(*is));
            for (mean, measure) in ride.iter_mut().zip(Ride::MEASURES) {
                let value = r.ride.as_ref().and_then(|ride| measure.number(ride));
                value.into_iter().for_each(|value| mean.push(value));
            }
            r.cause.into_iter().for_each(|cause| *causes.entry(cause).or_default() += 1);
            if r.outcome == Outcome::Success {
                world.sum += 1.0;
                time.push(r.time_s);
            }
            if let Some(used) = r.fuel {
                fuel.get_or_insert_default().pool(&used);
            }
            clamped += r.clamped;
        }
        if tasks == 0 {
            return None;
        }
        let worlds: Vec<Ratio> = worlds.into_values().collect();
        let success = success_interval(&worlds);
        let mean = |s: &Running| (s.count > 0).then_some(s.mean);
        Some(Self {
            tasks,
            outcomes,
            three_way,
            flags,
            causes,
            success_rate: time.count as f64 / tasks as f64,
            success_low: success.map(|i| i.low),
            success_high: success.map(|i| i.high),
            time_mean_s: mean(&time),
            time_std_s: mean(&time).map(|_| time.variance().sqrt()),
            metrics: Pooled::new(&records.iter().filter_map(|r| r.metrics.as_ref()).collect::<Vec<_>>()),
            ride: Ride::MEASURES
                .iter()
                .zip(&ride)
                .filter_map(|(measure, of)| Some((measure.name.to_owned(), mean(of)?)))
                .collect(),
            clamped,
            fuel,
        })
    }
}
