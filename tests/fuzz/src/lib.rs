//! Fuzz targets: every reader of files and messages that somebody else may have made. A target hands its input to a
//! reader and ignores the answer; what counts is that there is one, without a panic and within memory and time.
//!
//! `cargo xtask fuzz` runs them under libFuzzer (`tests/fuzz/libfuzzer`); the tests of this crate run seeds and their
//! mutations with every test run, so that targets and readers stay in step.

mod bag;
mod dataset;
mod import;
mod limits;
mod manifest;
mod mutation;
mod plugin;
mod protocol;
mod raster;
mod records;
mod results;
mod site;
mod submission;
mod suite;
mod tables;
mod weights;

pub use mutation::{mutate, next};
use vb_score::Rules;
use vb_sim::SoilSet;
use vb_suite::generate::GeneratorParams;
use vb_suite::site::SiteParams;
use vb_vehicle::VehicleSpec;

/// A reader under test.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, which is that of the file in `libfuzzer/fuzz_targets`.
    pub name: &'static str,
    /// Hands an input to the reader.
    pub run: fn(&[u8]),
    /// Inputs to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

pub const TARGETS: &[Target] = &[
    Target { name: "plugin", run: plugin::run, seeds: plugin::seeds },
    Target { name: "suite", run: suite::run, seeds: suite::seeds },
    Target { name: "import", run: import::run, seeds: import::seeds },
    Target { name: "results", run: results::run, seeds: results::seeds },
    Target { name: "protocol", run: protocol::run, seeds: protocol::seeds },
    Target { name: "settings", run: settings, seeds: settings_seeds },
    Target { name: "limits", run: limits::run, seeds: limits::seeds },
    Target { name: "submission", run: submission::run, seeds: submission::seeds },
    Target { name: "raster", run: raster::run, seeds: raster::seeds },
    Target { name: "records", run: records::run, seeds: records::seeds },
    Target { name: "series", run: tables::series, seeds: tables::series_seeds },
    Target { name: "trace", run: tables::trace, seeds: tables::trace_seeds },
    Target { name: "recording", run: tables::recording, seeds: tables::recording_seeds },
    Target { name: "dataset", run: dataset::run, seeds: dataset::seeds },
    Target { name: "manifest", run: manifest::run, seeds: manifest::seeds },
    Target { name: "weights", run: weights::run, seeds: weights::seeds },
    Target { name: "bag", run: bag::run, seeds: bag::seeds },
];

/// The target of this name.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn target(name: &str) -> Target {
    *TARGETS.iter().find(|t| t.name == name).expect("a target of this name")
}

/// Files that users write by hand: rules, vehicles, soils, rules for worlds. The first byte chooses.
fn settings(data: &[u8]) {
    let Some((&kind, text)) = data.split_first() else { return };
    let Ok(text) = std::str::from_utf8(text) else { return };
    match kind % 5 {
        0 => drop(Rules::parse(text, "rules.yaml")),
        1 => drop(VehicleSpec::parse(text, "vehicle.yaml")),
        2 => drop(SoilSet::parse(text, "soils.yaml")),
        3 => drop(SiteParams::parse(text, "site.yaml")),
        _ => drop(GeneratorParams::parse(text, "rules.yaml")),
    }
}

fn settings_seeds() -> Vec<Vec<u8>> {
    let files = [
        (0, include_str!("../../../tasks/rules/paper.yaml")),
        (0, include_str!("../../../tasks/rules/release.yaml")),
        (1, include_str!("../../../tasks/vehicles/hmmwv.yaml")),
        (2, include_str!("../../../tasks/soils/default.yaml")),
        (2, include_str!("../../../tasks/soils/original.yaml")),
        (3, SiteParams::DEFAULT_YAML),
        (4, GeneratorParams::DEFAULT_YAML),
    ];
    files.iter().map(|(kind, text)| site::select(*kind, text.as_bytes())).collect()
}
