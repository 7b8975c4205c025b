//! What a dataset says of itself: `dataset.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use vb_record::{DataHeader, TIME_STEPS};
use vb_vehicle::SCALES;

use crate::explore::Exploration;
use crate::feature::Layout;
use crate::formats::Format;
use crate::values::shown;

/// The version of the layout of `dataset.json` and of the columns.
pub const DATASET_SCHEMA: u32 = 1;

/// The licence of the datasets that the harness makes: the same as of the worlds.
pub const LICENCE: &str = "CC-BY-4.0";

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
    Merged,
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
    pub name: String,
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
    pub name: String,
    pub kind: Kind,
    /// The licence, as SPDX names it.
    pub licence: String,
    pub harness_version: String,
    pub harness_commit: String,
    /// The arguments of `vb-harness` that make it again, `--out` left out.
    pub command: Vec<String>,
    pub seed: u64,
    /// Frames a second.
    pub hz: u32,
    /// The columns that depend on the settings.
    pub layout: Layout,
    /// The vehicle, with the SHA-256 of its file.
    pub vehicle: DataHeader,
    pub soils: DataHeader,
    pub rules: DataHeader,
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
    /// Whether the worlds belong to a suite: such a dataset is for looking at, and nothing may be trained on it.
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

    /// The first field in which another header differs: its name, and both values.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let (a, b) = (serde_json::to_value(self).ok()?, serde_json::to_value(other).ok()?);
        let (a, b) = (a.as_object()?, b.as_object()?);
        let names = a.keys().chain(b.keys());
        // Where the harness, a file or an option differs, the command may differ too; they say more.
        let named = names.clone().filter(|n| *n != "command").chain(names.filter(|n| *n == "command"));
        let show = |v: Option<&Value>| v.map_or_else(|| "absent".to_owned(), Value::to_string);
        named
            .into_iter()
            .find(|n| a.get(*n) != b.get(*n))
            .map(|n| (n.clone(), show(a.get(n)), show(b.get(n))))
    }
}
