//! The divisions of results, and the reasons for the open one.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vb_host::Limits;
use vb_record::{PluginKind, RunHeader};
use vb_score::Rules;
use vb_sense::Profile;
use vb_sense::profile::ORACLE;

/// The list of the leaderboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Division {
    /// WASM planners under the benchmark's conditions: every result is bit-for-bit reproducible, and all planners have
    /// the same resources.
    Ranked,
    /// The same conditions, but with the perception profile `onboard`.
    Onboard,
    /// The same conditions, but with the perception profile `degraded`.
    Degraded,
    /// All other results.
    Open,
}

impl Division {
    /// All, in the order of the site.
    pub const ALL: [Self; 4] = [Self::Ranked, Self::Onboard, Self::Degraded, Self::Open];

    /// The name of the division in files and on pages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ranked => "ranked",
            Self::Onboard => "onboard",
            Self::Degraded => "degraded",
            Self::Open => "open",
        }
    }

    /// The perception profile under which its results are made; `None` for the open division, which has any.
    #[must_use]
    pub fn profile(self) -> Option<&'static str> {
        match self {
            Self::Ranked => Some(ORACLE),
            Self::Onboard | Self::Degraded => Some(self.name()),
            Self::Open => None,
        }
    }
}

/// A condition that a run doesn't meet and that is required in all divisions except the open one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenReason {
    /// The field of the run, e.g. `limits.fuel_per_step`.
    pub field: String,
    /// The field's value and the required value, as text.
    pub text: String,
}

/// A suite that comes with the harness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShippedSuite {
    pub name: String,
    pub hash: String,
    pub tasks: u64,
}

/// A vehicle that comes with the harness.
#[derive(Clone, Debug, PartialEq)]
pub struct ShippedVehicle {
    /// The SHA-256 of the vehicle's file.
    pub hash: String,
    /// The scale that the vehicle is made for.
    pub scale: f64,
}

/// The suites, vehicles and soils that come with the harness and may be ranked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shipped {
    pub suites: Vec<ShippedSuite>,
    pub vehicles: BTreeMap<String, ShippedVehicle>,
    /// The SHA-256 of the default soils.
    pub soils: String,
}

/// Step of the simulation at which results are ranked, s.
const TIME_STEP: f64 = 0.001;
/// Side of the soil's cells at which results are ranked, m.
const SOIL_RESOLUTION: f64 = 0.1;
/// The seed with which results are ranked: one seed, so that nobody can enter the best of many.
const SEED: u64 = 0;

/// The least control period at which results are ranked, s. Fuel bounds a step, so the time that a task can take grows
/// with the number of its steps. The planners that come with the harness act every 0.1 s; 50 steps a second leave room for
/// faster ones. Only `pid-release` acts more often, every 5 ms as the released code does; it is there to be compared.
const LEAST_CONTROL_PERIOD: f64 = 0.02;

/// The conditions that a run doesn't meet and that are required in all divisions except the open one.
pub(crate) fn open_reasons(run: &RunHeader, shipped: &Shipped) -> Vec<OpenReason> {
    let mut reasons = Vec::new();
    let mut unless = |good: bool, field: &str, text: String| {
        if !good {
            reasons.push(OpenReason { field: field.into(), text });
        }
    };
    let short = |hash: &str| vb_report::one_line(hash.get(..12).unwrap_or(hash), 12);
    unless(
        run.plugin.kind == PluginKind::Wasm,
        "plugin.kind",
        format!("{}: only WASM is metered and bit-identical on all machines", run.plugin.kind),
    );
    unless(
        run.plugin.control_period >= LEAST_CONTROL_PERIOD,
        "plugin.control_period",
        format!("{} s, less than the minimum of {LEAST_CONTROL_PERIOD} s", run.plugin.control_period),
    );
    unless(
        run.params.is_empty(),
        "params",
        format!("{}: ranked planners run without parameters", vb_report::one_line(&run.planner(), 160)),
    );
    for (name, default) in Limits::default().named() {
        let value = run.limits.get(name).copied();
        let text = value.map_or_else(|| "missing".to_owned(), |value| value.to_string());
        unless(
            value == Some(default),
            &format!("limits.{name}"),
            format!("{text}, not the default {default}"),
        );
    }
    let paper = Rules::paper();
    unless(
        run.rules.hash == paper.hash(),
        "rules",
        format!("{} ({}), not {}", run.rules.name, short(&run.rules.hash), paper.name),
    );
    let suite = shipped.suites.iter().find(|s| s.hash == run.suite.hash);
    unless(
        suite.is_some(),
        "suite",
        format!("{} ({}) is not included with the harness", run.suite.name, short(&run.suite.hash)),
    );
    unless(
        run.selector.is_none() && suite.is_none_or(|s| s.tasks == run.tasks),
        "selector",
        format!("{}: not the whole suite", vb_report::one_line(&run.scope(), 160)),
    );
    let vehicle = shipped.vehicles.get(&run.vehicle.name).filter(|v| v.hash == run.vehicle.hash);
    unless(
        vehicle.is_some(),
        "vehicle",
        format!("{} ({}) is not included with the harness", run.vehicle.name, short(&run.vehicle.hash)),
    );
    let scale = vehicle.map_or(run.scale, |v| v.scale);
    unless(run.scale == scale, "scale", format!("{}, not {scale}, the scale of the vehicle", run.scale));
    unless(
        run.soils.hash == shipped.soils,
        "soils",
        format!("{} ({}), not the default", run.soils.name, short(&run.soils.hash)),
    );
    let perception = &run.perception;
    let shipped = Profile::built_in(&perception.name);
    unless(
        shipped.is_some_and(|p| p.sha256() == perception.hash),
        "perception",
        format!("{} ({}) is not included with the harness", perception.name, short(&perception.hash)),
    );
    unless(run.time_step == TIME_STEP, "time_step", format!("{} s, not {TIME_STEP} s", run.time_step));
    unless(
        run.soil_resolution == SOIL_RESOLUTION,
        "soil_resolution",
        format!("{} m, not {SOIL_RESOLUTION} m", run.soil_resolution),
    );
    unless(run.seed == SEED, "seed", format!("{}, not {SEED}", run.seed));
    reasons
}

/// The division of a run with these reasons.
pub(crate) fn division(run: &RunHeader, reasons: &[OpenReason]) -> Division {
    let of = |division: &Division| division.profile() == Some(run.perception.name.as_str());
    let own = Division::ALL.into_iter().find(of).filter(|_| reasons.is_empty());
    own.unwrap_or(Division::Open)
}
