//! Checks whether a suite is fit to be driven: every finding is one line, with what to do.
//!
//! The format, its values and the hashes are errors, as is a start, a goal or a path on which no vehicle could be; what
//! can be driven but is odd – a path too near to an obstacle, a label that the relief belies – is a warning.

mod duplicates;
mod footprint;
mod labels;
mod released;
mod tasks;
#[cfg(test)]
mod tests;

pub use footprint::Vehicle;

use crate::clearance::Footprints;
use crate::generate::GeneratorParams;
use duplicates::Fingerprints;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use vb_world::{Part, Suite, SuiteMeta, World};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The suite cannot or must not be driven.
    Error,
    /// The suite can be driven, but something is odd.
    Warning,
}

impl Severity {
    /// The name of the severity, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rule {
    /// Files can be read, values make sense, and hashes and index agree with the files.
    Format,
    /// Worlds and tasks are there, once, and listed.
    Content,
    /// Starts and goals lie on ground where the vehicle can stand, clear of obstacles, within the world.
    Ends,
    /// Paths are clear of obstacles and edges, have close waypoints, and are not too steep.
    Path,
    /// Obstacles stand apart from each other and in the ground.
    Obstacles,
    /// Labels agree with the relief and the number of obstacles.
    Labels,
}

impl Rule {
    /// The name of the rule, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Format => "format",
            Self::Content => "content",
            Self::Ends => "ends",
            Self::Path => "path",
            Self::Obstacles => "obstacles",
            Self::Labels => "labels",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    pub severity: Severity,
    pub rule: Rule,
    /// The world that is meant; `None` where it is the suite as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world: Option<String>,
    /// One line: where, what, and what to do.
    pub text: String,
}

/// The limits of what is still fine.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// The vehicle that must have room.
    pub vehicle: Vehicle,
    /// The distance from a path to obstacles below which there is a warning, m.
    pub clearance: f64,
    /// The distance between two waypoints above which there is a warning, m.
    pub spacing: f64,
    /// The tilt of the ground under the vehicle at start and goal above which there is a warning, degrees.
    pub end_tilt: f64,
    /// The tilt of the ground under the vehicle above which there is a warning along the path, and an error at start
    /// and goal, degrees.
    pub tilt: f64,
    /// The rules of the generator, whose spread of heights and numbers of obstacles say what labels mean.
    pub rules: GeneratorParams,
}

impl Limits {
    /// The limits for a vehicle, with the clearance and the spacing of the generator's rules. The tilts are 31°, the 60
    /// % grade that the HMMWV is rated for, and 45°, beyond which no friction below 1 holds a vehicle.
    #[must_use]
    pub fn of(vehicle: Vehicle) -> Self {
        let rules = GeneratorParams::default();
        Self {
            vehicle,
            clearance: rules.path.clearance,
            spacing: rules.path.spacing,
            end_tilt: 31.0,
            tilt: 45.0,
            rules,
        }
    }
}

/// Findings of one rule in one world beyond which the rest are only counted.
const SHOWN: usize = 10;

/// Where checks of a world put what they find.
struct Findings<'a> {
    suite: &'a Suite,
    world: Option<&'a str>,
    all: Vec<Finding>,
    counts: BTreeMap<(Rule, Severity), usize>,
}

impl<'a> Findings<'a> {
    fn new(suite: &'a Suite, world: Option<&'a str>) -> Self {
        Self { suite, world, all: Vec::new(), counts: BTreeMap::new() }
    }

    /// A finding whose text says where.
    fn say(&mut self, severity: Severity, rule: Rule, text: String) {
        let count = self.counts.entry((rule, severity)).or_insert(0);
        *count += 1;
        if *count <= SHOWN {
            self.all.push(Finding { severity, rule, world: self.world.map(str::to_owned), text });
        }
    }

    /// A finding in a part of the world.
    fn at(&mut self, severity: Severity, rule: Rule, part: Part, field: &str, problem: &str) {
        let file = self.suite.world_dir(self.world.unwrap_or_default()).join(part.file_name());
        self.say(severity, rule, format!("{}: {field}: {problem}", file.display()));
    }

    fn error(&mut self, rule: Rule, part: Part, field: &str, problem: &str) {
        self.at(Severity::Error, rule, part, field, problem);
    }

    fn warn(&mut self, rule: Rule, part: Part, field: &str, problem: &str) {
        self.at(Severity::Warning, rule, part, field, problem);
    }

    fn finish(mut self) -> Vec<Finding> {
        for ((rule, severity), count) in std::mem::take(&mut self.counts) {
            if count > SHOWN {
                let (world, more) = (self.world.unwrap_or("the suite"), count - SHOWN);
                let s = if more == 1 { "" } else { "s" };
                let text = format!(
                    "{world}: {more} more finding{s} of the rule {}: fix those above first",
                    rule.name()
                );
                self.all.push(Finding { severity, rule, world: self.world.map(str::to_owned), text });
            }
        }
        self.all
    }
}

/// Checks a suite world by world. `told` hears of each world's findings, with the world's id, once it is checked, and
/// at last of those about the suite as a whole, without an id.
pub fn validate(
    suite: &Suite,
    limits: &Limits,
    mut told: impl FnMut(Option<&str>, &[Finding]),
) -> Vec<Finding> {
    let mut all = Vec::new();
    let mut fingerprints = Fingerprints::default();
    for info in suite.worlds() {
        let mut findings = Findings::new(suite, Some(&info.id));
        match suite.examine_world(&info.id) {
            Ok((world, errors)) => {
                for e in errors {
                    findings.say(Severity::Error, Rule::Format, vb_files::one_line(&e.to_string()));
                }
                if let Some(world) = world {
                    check(&world, limits, &mut findings);
                    fingerprints.add(&world, &mut findings);
                }
            }
            Err(e) => findings.say(Severity::Error, Rule::Format, vb_files::one_line(&e.to_string())),
        }
        let found = findings.finish();
        told(Some(&info.id), &found);
        all.extend(found);
    }
    let mut findings = Findings::new(suite, None);
    whole(suite, &mut findings);
    let found = findings.finish();
    told(None, &found);
    all.extend(found);
    all
}

fn check(world: &World, limits: &Limits, findings: &mut Findings<'_>) {
    let footprints = Footprints::new(&world.obstacles);
    tasks::check(world, &footprints, limits, findings);
    for [i, j] in footprints.overlaps() {
        let problem = format!("overlaps obstacles[{j}]: move one of them, or remove the inner one");
        findings.warn(Rule::Obstacles, Part::Obstacles, &format!("obstacles[{i}]"), &problem);
    }
    for (k, o) in world.obstacles.iter().enumerate() {
        let height = o.size()[2];
        let problem = if o.buried < 0.0 {
            format!("{} lets it hang {:.2} m above the terrain: use 0 or more", o.buried, -o.buried)
        } else if o.buried >= height {
            format!(
                "{} buries all of its {height} m at its centre: lower it, or remove the obstacle",
                o.buried
            )
        } else {
            continue;
        };
        findings.warn(Rule::Obstacles, Part::Obstacles, &format!("obstacles[{k}].buried"), &problem);
    }
    labels::check(world, &limits.rules, findings);
}

/// What only shows in the suite as a whole.
fn whole(suite: &Suite, findings: &mut Findings<'_>) {
    let index = suite.dir().join("suite.yaml");
    if suite.worlds().is_empty() {
        let text = format!("{}: worlds: is empty: add worlds", index.display());
        findings.say(Severity::Warning, Rule::Content, text);
    }
    match released::hash_of(suite.meta()) {
        Ok(Some(released)) if released != suite.hash() => {
            let SuiteMeta { name, version, .. } = suite.meta();
            let text = format!(
                "{}: version: {name} {version} was released with the hash {released}, not {}: give the changed suite another version or name",
                index.display(),
                suite.hash()
            );
            findings.say(Severity::Error, Rule::Content, text);
        }
        Ok(_) => {}
        Err(problem) => findings.say(Severity::Error, Rule::Content, vb_files::one_line(&problem)),
    }
    for folder in folders(&suite.dir().join("worlds")) {
        if suite.worlds().iter().all(|w| w.id != folder) {
            let text = format!(
                "{}: worlds: does not list the folder worlds/{folder}: list it or remove it",
                index.display()
            );
            findings.say(Severity::Warning, Rule::Content, text);
        }
    }
}

/// Names of the folders in a folder, in order; none if it cannot be read, which the worlds' own checks tell.
fn folders(dir: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    let folders = entries.filter(|e| e.path().is_dir());
    let mut names: Vec<_> = folders.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
