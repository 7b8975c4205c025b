//! What a dataset says of itself: `dataset.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use vb_record::{DataHeader, TIME_STEPS, differences};
use vb_vehicle::SCALES;

use crate::explore::Exploration;
use crate::feature::Layout;
use crate::formats::Format;
use crate::values::shown;

/// The version of the layout of `dataset.json` and of the columns.
pub const DATASET_SCHEMA: u32 = 1;

/// The licence of the datasets that the harness makes: the same as of the worlds.
pub const LICENCE: &str = "CC-BY-4.0";

/// The origin of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Random exploration.
    Explore,
    /// Planners that drive tasks.
    Drive,
    /// A person who drives.
    Teleop,
    /// The last seconds before failures.
    Failures,
    /// Datasets joined by `dataset merge`.
    Merged,
    /// A part of a dataset, by `dataset split`.
    Split,
}

impl Kind {
    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Explore => "explore",
            Self::Drive => "drive",
            Self::Teleop => "teleop",
            Self::Failures => "failures",
            Self::Merged => "merged",
            Self::Split => "split",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannerHeader {
    /// The name of the planner.
    pub name: String,
    /// The version of the planner.
    pub version: String,
    /// The SHA-256 of the plugin.
    pub sha256: String,
    /// The parameters that the user gave.
    pub params: BTreeMap<String, String>,
}

/// Everything that a dataset follows from. Two datasets with the same header have the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The version of the layout, [`DATASET_SCHEMA`].
    pub schema: u32,
    /// The format of the files with frames and episodes; the default is left out.
    #[serde(default, skip_serializing_if = "Format::is_default")]
    pub format: Format,
    /// The name of the dataset.
    pub name: String,
    /// The origin of the data.
    pub kind: Kind,
    /// The licence, as SPDX names it.
    pub licence: String,
    /// The version of the harness.
    pub harness_version: String,
    /// The commit of the harness.
    pub harness_commit: String,
    /// The arguments of `vb-harness` that make it again, `--out` left out.
    pub command: Vec<String>,
    /// The random seed.
    pub seed: u64,
    /// Frames a second.
    pub hz: u32,
    /// The columns that depend on the settings.
    pub layout: Layout,
    /// The vehicle, with the SHA-256 of its file.
    pub vehicle: DataHeader,
    /// The soil set, with the SHA-256 of its file.
    pub soils: DataHeader,
    /// The rules, with the SHA-256 of their file.
    pub rules: DataHeader,
    /// The perception profile, with the SHA-256 of its file.
    pub perception: DataHeader,
    /// The factor on every length of the worlds.
    pub scale: f64,
    /// The time step of the simulation, s.
    pub time_step: f64,
    /// The suite with the worlds, which lies in `suite`: name and hash.
    pub worlds: DataHeader,
    /// How the vehicle explored, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exploration: Option<Exploration>,
    /// The planners that drove, if any did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planners: Vec<PlannerHeader>,
    /// Whether the worlds belong to a suite: such a dataset is for inspection only, not for training.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_a_suite: bool,
    /// What else was asked for.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub options: BTreeMap<String, Value>,
}

/// The most wheels that a vehicle of a dataset may have.
const WHEELS: usize = 64;
/// The most rows of a crop.
const CROPS: usize = 128;
/// Frames a second at most.
const HZ: u32 = 100;

impl Header {
    /// The first value that no dataset can have: its field, its value, and what is allowed. `None` if there is none.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let real = |field: &str, value: f64, allowed: &std::ops::RangeInclusive<f64>| {
            let (low, high) = (allowed.start(), allowed.end());
            (!allowed.contains(&value))
                .then(|| format!("{field}: {} must lie in {low} to {high}", shown(value)))
        };
        let whole = |field: &str, value: usize, low: usize, high: usize| {
            (!(low..=high).contains(&value)).then(|| format!("{field}: {value} must lie in {low} to {high}"))
        };
        whole("layout.wheels", self.layout.wheels, 1, WHEELS)
            .or_else(|| whole("layout.crops", self.layout.crops, 0, CROPS))
            .or_else(|| whole("hz", self.hz as usize, 1, HZ as usize))
            .or_else(|| real("scale", self.scale, &SCALES))
            .or_else(|| real("time_step", self.time_step, &TIME_STEPS))
    }

    /// The first field (dotted path) in which another header differs, with both values as text; `None` if there is no such field.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let found = differences(self, other, usize::MAX);
        // Where the harness, a file or an option differs, the command may differ too; they say more.
        let first = found.into_iter().min_by_key(|d| d.path.split('.').next() == Some("command"))?;
        Some((first.path, first.a, first.b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn header(crops: usize, command: &str) -> Header {
        let file = json!({"name": "n", "hash": "aa"});
        let header = json!({
            "schema": DATASET_SCHEMA,
            "name": "d",
            "kind": "explore",
            "licence": LICENCE,
            "harness_version": "1.0.0",
            "harness_commit": "unknown",
            "command": ["dataset", command],
            "seed": 0,
            "hz": 10,
            "layout": {"wheels": 4, "speed": false, "goal": false, "truth": true, "crops": crops},
            "vehicle": file,
            "soils": file,
            "rules": file,
            "perception": file,
            "scale": 1.0,
            "time_step": 0.001,
            "worlds": file,
        });
        serde_json::from_value(header).unwrap()
    }

    #[test]
    fn the_difference_is_the_innermost_field_and_the_command_comes_last() {
        let difference = |a: &Header, b: &Header| {
            a.difference(b).map(|(field, before, now)| format!("{field}: {before}, {now}"))
        };
        let first = header(0, "explore");
        assert_eq!(difference(&first, &first), None);
        assert_eq!(difference(&first, &header(8, "drive")).unwrap(), "layout.crops: 0, 8");
        assert_eq!(difference(&first, &header(0, "drive")).unwrap(), "command.1: \"explore\", \"drive\"");
        let optioned = Header { options: BTreeMap::from([("jobs".to_owned(), json!(1))]), ..first.clone() };
        assert_eq!(difference(&first, &optioned).unwrap(), "options.jobs: nothing, 1");
    }
}
