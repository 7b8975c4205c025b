//! The description of a run: the content of `run.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{LogMode, PluginKind, TraceMode, differences, planner_with_params, suite_with_selection};

/// The version of the layout of a run directory, raised with every change that other readers can't read.
pub const RUN_SCHEMA: u32 = 3;

/// The suite of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuiteHeader {
    /// The name of the suite.
    pub name: String,
    /// The hash of the suite's content (hex), which is independent of the suite's location.
    pub hash: String,
    /// The path of the suite.
    pub path: String,
    /// The total number of tasks of the suite.
    pub tasks: u64,
}

/// The planner of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PluginHeader {
    /// The planner's name, as its metadata state it.
    pub name: String,
    /// The planner's version, as its metadata state it.
    pub version: String,
    /// The SHA-256 of the plugin file (hex).
    pub sha256: String,
    /// The kind of the planner.
    pub kind: PluginKind,
    /// The path of the file; for a command, the command itself.
    pub path: String,
    /// Whether the planner is a file that decides from observations and that others can run, too: `wasm` and `native`.
    /// Leaderboards rank `wasm` only.
    pub eligible_for_ranking: bool,
    /// The time between two of the planner's steps, s.
    pub control_period: f64,
    /// The planner's sensors, as named in its metadata, e.g. `lidar 10`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<String>,
    /// The confinement of the planner's process; `None` unless the planner is native.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sandbox: Option<SandboxHeader>,
}

/// The confinement of the process of a native planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SandboxHeader {
    /// The version of landlock in force; `None` where the kernel lacks it.
    pub landlock: Option<u32>,
    /// Whether system calls were filtered.
    pub seccomp: bool,
    /// Whether new privileges were disabled.
    pub no_new_privs: bool,
    /// Whether memory, files, processes and core dumps were limited.
    pub rlimits: bool,
}

/// A data file of a run: a vehicle, a set of soils, or a perception profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DataHeader {
    /// The name of what the file describes.
    pub name: String,
    /// The SHA-256 of the file (hex).
    pub hash: String,
}

/// A part of the selected tasks that one of several machines runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardHeader {
    /// The number of the part, from 1.
    pub index: u32,
    /// The number of parts.
    pub of: u32,
    /// The number of tasks of all parts.
    pub tasks: u64,
}

/// The rules of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RulesHeader {
    /// The name of the profile.
    pub name: String,
    /// The hash of the profile's content (hex).
    pub hash: String,
    /// The complete profile, so that results can be interpreted without the file.
    pub profile: Value,
}

/// All settings that determine a run's results, and their origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunHeader {
    /// The version of the layout, [`RUN_SCHEMA`].
    pub schema: u32,
    /// The version of the harness.
    pub harness_version: String,
    /// The Git commit of the harness, followed by `, modified` if its sources had been changed; `unknown` if it was not
    /// built in a checkout. It is informational and not part of any hash or score.
    pub harness_commit: String,
    /// The start time of the run, RFC 3339 in UTC. It is informational.
    pub started_at: String,
    /// The suite.
    pub suite: SuiteHeader,
    /// The selector of the tasks; `None` for all.
    pub selector: Option<String>,
    /// The number of selected tasks in this shard.
    pub tasks: u64,
    /// The shard of a larger run; `None` for a complete run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardHeader>,
    /// The planner.
    pub plugin: PluginHeader,
    /// The planner's parameters as the user gave them.
    pub params: BTreeMap<String, String>,
    /// The vehicle.
    pub vehicle: DataHeader,
    /// The soils of deformable ground.
    pub soils: DataHeader,
    /// The perception profile: prior maps, sensors and their errors.
    pub perception: DataHeader,
    /// The factor on every length of the world: 1, or less for smaller vehicles.
    pub scale: f64,
    /// The run's seed.
    pub seed: u64,
    /// The time step of the simulation, s.
    pub time_step: f64,
    /// The side of the soil's memory cells (ruts), at scale 1, m.
    pub soil_resolution: f64,
    /// The sampling period of rules and metrics, s.
    pub sample_period: f64,
    /// The rules.
    pub rules: RulesHeader,
    /// The limits on the planner by name, e.g. `fuel_per_step`, `memory_bytes`.
    pub limits: BTreeMap<String, u64>,
    /// The samples that are kept in traces.
    pub trace: TraceMode,
    /// The tasks whose records keep the planner's log.
    pub logs: LogMode,
}

/// Fields of run.json that may differ between a run and its resumption: they don't affect results.
const INFORMATION_ONLY: [&str; 7] = [
    "started_at",
    "suite.path",
    "plugin.path",
    "plugin.sandbox.landlock",
    "plugin.sandbox.seccomp",
    "plugin.sandbox.no_new_privs",
    "plugin.sandbox.rlimits",
];

impl RunHeader {
    /// The planner, with its parameters where the user gave any, as in [`planner_with_params`].
    #[must_use]
    pub fn planner(&self) -> String {
        planner_with_params(&format!("{} {}", self.plugin.name, self.plugin.version), &self.params)
    }

    /// The suite, with what was chosen of it where that is not all, as in [`suite_with_selection`].
    #[must_use]
    pub fn scope(&self) -> String {
        let chosen =
            suite_with_selection(&self.suite.name, self.tasks, self.suite.tasks, self.selector.as_deref());
        match self.shard {
            Some(shard) => format!("{chosen}, shard {}/{}", shard.index, shard.of),
            None => chosen,
        }
    }

    /// The same run with all of its shards.
    #[must_use]
    pub fn whole(&self) -> Self {
        let tasks = self.shard.map_or(self.tasks, |shard| shard.tasks);
        Self { tasks, shard: None, ..self.clone() }
    }

    /// The first field (dotted path) in which `other` would lead to other results, with both values as text; `None` if
    /// there is no such field.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let mut found = differences(self, other, usize::MAX);
        found.retain(|d| !INFORMATION_ONLY.contains(&d.path.as_str()));
        // A name says more than the hash, and the hash more than the fields of the profile that it covers.
        let first = found
            .into_iter()
            .min_by_key(|d| (d.path.starts_with("rules.profile"), d.path == "rules.hash"))?;
        Some((first.path, first.a, first.b))
    }
}
