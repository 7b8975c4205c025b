//! The report of a run: a page, a file of results and tables of the time series.

mod page;
mod svg;
mod text;

use crate::check::{Check, Kind, Verdict};
use crate::error::ValidateError;
use crate::event::Figure;
use crate::result::{EventResult, InSetup};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
pub use text::expected;
use vb_vehicle::VehicleSpec;

/// What a run of events gave.
#[derive(Clone, Debug)]
pub struct Report {
    pub vehicle: VehicleSpec,
    /// The step, s.
    pub step: f64,
    /// What the set-ups are in which references were held against the vehicle, by their kind.
    pub setups: BTreeMap<Kind, String>,
    /// In the order of [`crate::events`].
    pub results: Vec<EventResult>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub passed: usize,
    pub failed: usize,
    /// Shown beside an unsound reference, not judged.
    pub shown: usize,
}

#[derive(Serialize)]
struct ResultsFile<'a> {
    schema: u32,
    vehicle: &'a str,
    step_s: f64,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    setups: &'a BTreeMap<Kind, String>,
    checks: Counts,
    events: Vec<EventEntry<'a>>,
}

#[derive(Serialize)]
struct EventEntry<'a> {
    event: &'a str,
    title: &'a str,
    passed: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a str>,
    figures: &'a [Figure],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    setups: Vec<SetupEntry<'a>>,
    checks: &'a [Check],
}

/// The event in the set-up of a reference.
#[derive(Serialize)]
struct SetupEntry<'a> {
    setup: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a str>,
    figures: &'a [Figure],
}

impl<'a> SetupEntry<'a> {
    fn new(driven: &'a InSetup) -> Self {
        Self { setup: driven.kind, failure: driven.failure.as_deref(), figures: &driven.outcome.figures }
    }
}

impl Report {
    /// All checks, or those of one kind.
    #[must_use]
    pub fn counts(&self, kind: Option<Kind>) -> Counts {
        let mut counts = Counts::default();
        for check in self.results.iter().flat_map(|r| &r.checks) {
            if kind.is_some_and(|k| k != check.expectation.kind) {
                continue;
            }
            match check.verdict {
                Verdict::Pass => counts.passed += 1,
                Verdict::Fail => counts.failed += 1,
                Verdict::Shown => counts.shown += 1,
            }
        }
        counts
    }

    /// Whether every event was driven to its end and no check failed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.results.iter().all(EventResult::passed)
    }

    /// The page: one HTML file that needs nothing else.
    #[must_use]
    pub fn page(&self) -> String {
        page::page(self)
    }

    /// The results as JSON: figures and checks, without time series.
    #[must_use]
    pub fn json(&self) -> String {
        let events = self.results.iter().map(|r| EventEntry {
            event: r.event.name,
            title: r.event.title,
            passed: r.passed(),
            failure: r.failure.as_deref(),
            figures: &r.outcome.figures,
            setups: r.setups.iter().map(SetupEntry::new).collect(),
            checks: &r.checks,
        });
        let file = ResultsFile {
            schema: 1,
            vehicle: &self.vehicle.name,
            step_s: self.step,
            setups: &self.setups,
            checks: self.counts(None),
            events: events.collect(),
        };
        serde_json::to_string_pretty(&file).map_or_else(|e| format!("{{\"error\":\"{e}\"}}"), |t| t + "\n")
    }

    /// Writes `report.html`, `results.json`, `series/EVENT-CASE.csv` and, of drives in a set-up, `series/EVENT-CASE-KIND.csv`
    /// to a directory, which is made if it isn't there.
    pub fn write(&self, dir: &Path) -> Result<(), ValidateError> {
        let series = dir.join("series");
        let failed = |path: &Path, e: std::io::Error| ValidateError::Write {
            path: path.to_owned(),
            reason: e.to_string(),
        };
        std::fs::create_dir_all(&series).map_err(|e| failed(&series, e))?;
        let write =
            |path: &Path, text: &str| vb_files::write(path, text.as_bytes()).map_err(|e| failed(path, e));
        for r in &self.results {
            for s in &r.outcome.series {
                write(&series.join(format!("{}-{}.csv", r.event.name, file_name(&s.name))), &s.csv())?;
            }
            for (setup, s) in
                r.setups.iter().flat_map(|d| d.outcome.series.iter().map(|s| (d.kind.name(), s)))
            {
                let name = format!("{}-{}-{setup}.csv", r.event.name, file_name(&s.name));
                write(&series.join(name), &s.csv())?;
            }
        }
        write(&dir.join("results.json"), &self.json())?;
        write(&dir.join("report.html"), &self.page())
    }
}

/// A case's name as part of a file's name: μ and the like become plain letters.
fn file_name(case: &str) -> String {
    case.chars().map(|c| if c.is_ascii_alphanumeric() || "-._".contains(c) { c } else { '_' }).collect()
}
