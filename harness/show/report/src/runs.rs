//! Runs as read for a report: of each task only what its figures need.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use vb_files::cut_line as one_line;
use vb_record::{RunHeader, RunReader};
use vb_score::{Cause, Conditions, Flag, FuelUse, Metrics, Outcome, Ride, TaskRecord};
use vb_world::{Density, Elevation, TaskId, Terrain};

use crate::ReportError;

/// Tasks of a run for which the reason of a failure is kept.
const NOTES: usize = 20_000;
/// Characters of a run's name at most, if the user gives it.
const LABEL_LENGTH: usize = 120;
/// Characters of a reason that are kept.
const NOTE_LENGTH: usize = 400;

/// A finished task: what figures need of its record, without texts that only records have. It takes less than half a kilobyte, so
/// that the rows of a million tasks fit into memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub task: TaskId,
    /// The seed of its run where runs with several seeds are one; otherwise empty.
    pub seed: Box<str>,
    /// Its world, an index into [`Runs::worlds`].
    pub world: u32,
    pub outcome: Outcome,
    /// What stopped the vehicle, if it rolled over or got stuck.
    pub cause: Option<Cause>,
    /// Simulated time at its end, s.
    pub time: f64,
    /// What is true or false of it beside its outcome, in the order of [`Flag::ALL`], where that is known.
    pub flags: [Option<bool>; Flag::ALL.len()],
    /// Measures, if it had samples.
    pub metrics: Option<Metrics>,
    /// Shock and ride, if they were measured.
    pub ride: Option<Ride>,
    /// Fuel, of metered planners.
    pub fuel: Option<FuelUse>,
    /// Number of clamped commands.
    pub clamped: u64,
    /// The reason of a failure, with its code in front, if it is kept.
    pub note: Box<str>,
}

impl Row {
    /// The task with its seed, by which rows are in order.
    pub(crate) fn key(&self) -> (&TaskId, &str) {
        (&self.task, &self.seed)
    }

    /// Whether the goal was reached in time.
    #[must_use]
    pub fn succeeded(&self) -> bool {
        self.outcome == Outcome::Success
    }

    /// Whether it counts: what the harness or the machine failed says nothing of a planner.
    #[must_use]
    pub fn counts(&self) -> bool {
        self.outcome != Outcome::HostError
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct WorldLabels {
    pub name: String,
    pub elevation: Elevation,
    pub terrain: Terrain,
    pub density: Density,
}

#[derive(Clone, Debug)]
pub struct Run {
    pub dir: PathBuf,
    pub header: RunHeader,
    /// What the run is called: the planner's name, with what it takes to tell it from the others.
    pub label: String,
    /// The finished tasks by name.
    pub rows: Vec<Row>,
}

impl Run {
    pub fn counted(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| r.counts())
    }

    /// Number of tasks that are not done yet.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.header.tasks.saturating_sub(self.rows.len() as u64)
    }

    /// Number of tasks that the harness or the machine failed.
    #[must_use]
    pub fn host_errors(&self) -> usize {
        self.rows.iter().filter(|r| !r.counts()).count()
    }
}

/// Runs of one suite, at least one.
#[derive(Clone, Debug)]
pub struct Runs {
    /// The runs in the order given.
    pub runs: Vec<Run>,
    /// The worlds of all their tasks, by name.
    pub worlds: Vec<WorldLabels>,
}

impl Runs {
    /// Reads runs, each directory line by line. A run that goes on is read as far as it got; a torn last line is left out.
    ///
    /// # Errors
    /// If a run can't be read, is of a newer version or without a finished task, or if the runs are not all of one suite.
    pub fn read(dirs: &[PathBuf]) -> Result<Self, ReportError> {
        let mut names: BTreeMap<String, u32> = BTreeMap::new();
        let mut worlds = Vec::new();
        let mut runs: Vec<Run> = Vec::with_capacity(dirs.len());
        for dir in dirs {
            let same = |other: &Run| {
                let real = |p: &Path| std::fs::canonicalize(p).unwrap_or_else(|_| p.to_owned());
                real(&other.dir) == real(dir)
            };
            if runs.iter().any(same) {
                return Err(ReportError::Twice(dir.clone()));
            }
            let reader = RunReader::open(dir)?;
            let header = reader.header().clone();
            if let Some(first) = runs.first()
                && first.header.suite.hash != header.suite.hash
            {
                let name = |h: &RunHeader| {
                    format!("{} ({})", h.suite.name, h.suite.hash.get(..12).unwrap_or(&h.suite.hash))
                };
                return Err(ReportError::Suites {
                    first: first.dir.clone(),
                    second: dir.clone(),
                    first_suite: name(&first.header),
                    second_suite: name(&header),
                });
            }
            let mut rows = Vec::new();
            reader.each_record(|record: TaskRecord| {
                let known = names.get(&record.world).copied();
                let world = known.unwrap_or_else(|| {
                    let index = u32::try_from(worlds.len()).unwrap_or(u32::MAX);
                    worlds.push(WorldLabels {
                        name: record.world.clone(),
                        elevation: record.elevation,
                        terrain: record.terrain,
                        density: record.density,
                    });
                    names.insert(record.world.clone(), index);
                    index
                });
                rows.push(row(&record, world, rows.len() < NOTES));
            })?;
            if rows.is_empty() {
                return Err(ReportError::Empty(dir.clone()));
            }
            rows.sort_by(|a: &Row, b: &Row| a.task.cmp(&b.task));
            runs.push(Run { dir: dir.clone(), header, label: String::new(), rows });
        }
        if runs.is_empty() {
            return Err(ReportError::NoRuns);
        }
        let mut all = Self { runs, worlds };
        all.sort_worlds(&names);
        all.name();
        Ok(all)
    }

    /// Puts the worlds in the order of their names.
    fn sort_worlds(&mut self, names: &BTreeMap<String, u32>) {
        let mut place = vec![0; self.worlds.len()];
        for (new, (_, &old)) in names.iter().enumerate() {
            place[old as usize] = new as u32;
        }
        self.worlds.sort_by(|a, b| a.name.cmp(&b.name));
        for row in self.runs.iter_mut().flat_map(|r| &mut r.rows) {
            row.world = place[row.world as usize];
        }
    }

    /// Gives each run a label that no other has: the planner's name, its version where versions differ, what differs in
    /// the settings, in the end the directory.
    fn name(&mut self) {
        let facts: Vec<_> =
            self.runs.iter().map(|r| (r.header.plugin.name.clone(), settings(&r.header))).collect();
        let labels: Vec<String> = facts
            .iter()
            .map(|(name, own)| {
                let namesakes: Vec<_> = facts.iter().filter(|(n, _)| n == name).map(|(_, s)| s).collect();
                let differ = |key: &str| namesakes.iter().any(|s| s.get(key) != own.get(key));
                let keys: std::collections::BTreeSet<&String> =
                    namesakes.iter().flat_map(|s| s.keys()).collect();
                let told: Vec<String> = keys
                    .into_iter()
                    .filter(|key| differ(key))
                    .map(|key| {
                        let value = own.get(key).map_or("default", String::as_str);
                        format!("{key} {value}")
                    })
                    .collect();
                let name = one_line(name, 60);
                if told.is_empty() { name } else { format!("{name} ({})", one_line(&told.join(", "), 80)) }
            })
            .collect();
        for (k, run) in self.runs.iter_mut().enumerate() {
            let unique = labels.iter().filter(|l| **l == labels[k]).count() == 1;
            run.label = if unique {
                labels[k].clone()
            } else {
                let dir = run.dir.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
                format!("{} [{}]", labels[k], one_line(&dir, 60))
            };
        }
        // Directories of one name in different places.
        for k in 0..self.runs.len() {
            if self.runs.iter().filter(|r| r.label == self.runs[k].label).count() > 1 {
                self.runs[k].label += &format!(" #{}", k + 1);
            }
        }
    }

    /// Calls runs by other names, each given as `RUN=TEXT`: `RUN` is the run's directory as it was given, or the last part of it.
    ///
    /// # Errors
    /// If there is no such run, or if a name is empty, is that of another run, or is one of two for the same run.
    pub fn relabel(&mut self, labels: &[String]) -> Result<(), ReportError> {
        let mut named: BTreeMap<usize, String> = BTreeMap::new();
        for given in labels {
            let taken = |reason: String| ReportError::LabelTaken { given: given.clone(), reason };
            let found = given.match_indices('=').find_map(|(at, _)| {
                Some((self.called(&given[..at])?, one_line(&given[at + 1..], LABEL_LENGTH)))
            });
            let Some((run, label)) = found else {
                let runs = self.runs.iter().map(|r| r.dir.display().to_string()).collect();
                return Err(ReportError::Label { given: given.clone(), runs });
            };
            if label.is_empty() {
                return Err(taken("its text is empty (write RUN=TEXT)".into()));
            }
            if let Some(other) = named.insert(run, label) {
                return Err(taken(format!("the run already has the label `{other}` (label it once)")));
            }
        }
        for (run, label) in &named {
            self.runs[*run].label.clone_from(label);
        }
        for run in named.keys() {
            let label = &self.runs[*run].label;
            if let Some(other) = self.runs.iter().enumerate().find(|(k, r)| k != run && r.label == *label) {
                let reason = format!("{} has the same label (choose another text)", other.1.dir.display());
                return Err(ReportError::LabelTaken { given: label.clone(), reason });
            }
        }
        Ok(())
    }

    /// The runs of each planner as one, in the order of the first of each: each task with each seed is a task of its own, and runs of
    /// one planner differ in the seed alone. `planners` says what the planner of each run is called.
    pub(crate) fn pooled(self, planners: &[&str]) -> Self {
        let mut pooled: Vec<Run> = Vec::new();
        for (mut run, planner) in self.runs.into_iter().zip(planners) {
            for row in &mut run.rows {
                row.seed = run.header.seed.to_string().into_boxed_str();
            }
            match pooled.iter_mut().find(|known| known.label == *planner) {
                Some(known) => known.rows.append(&mut run.rows),
                None => {
                    (*planner).clone_into(&mut run.label);
                    pooled.push(run);
                }
            }
        }
        for run in &mut pooled {
            run.rows.sort_by(|a, b| a.key().cmp(&b.key()));
        }
        Self { runs: pooled, worlds: self.worlds }
    }

    /// The run of this directory, or the only one whose directory has this name.
    fn called(&self, name: &str) -> Option<usize> {
        let whole = self.runs.iter().position(|r| r.dir == Path::new(name));
        let mut last =
            self.runs.iter().enumerate().filter(|(_, r)| r.dir.file_name().is_some_and(|n| n == name));
        whole.or_else(|| last.next().filter(|_| last.next().is_none()).map(|(k, _)| k))
    }

    /// The suite, with what was chosen of it where that is not all; if the runs differ in it, each says it by itself.
    #[must_use]
    pub fn scope(&self) -> String {
        let first = &self.runs[0].header;
        let alike = self.runs.iter().all(|r| r.header.scope() == first.scope());
        let scope = if alike { first.scope() } else { first.suite.name.clone() };
        one_line(&scope, 240)
    }

    /// Why the runs can't be ranked: the conditions in which they differ, with the value of each run. None if they can.
    #[must_use]
    pub fn unranked(&self) -> Option<String> {
        let all: Vec<Conditions> = self.runs.iter().map(|r| Conditions::of(&r.header)).collect();
        let told: Vec<String> = Conditions::differences(&all)
            .into_iter()
            .map(|(name, mut values)| {
                values.dedup();
                let values = values.iter().map(|v| one_line(v, 80)).collect::<Vec<_>>();
                format!("{name} ({})", one_line(&values.join(", "), 240))
            })
            .collect();
        (!told.is_empty()).then(|| told.join(" and in "))
    }

    /// Settings in which the runs differ, by name with each run's value: whoever compares them should know.
    #[must_use]
    pub fn differences(&self) -> Vec<(String, Vec<String>)> {
        let all: Vec<_> = self.runs.iter().map(|r| environment(&r.header)).collect();
        let mut found = Vec::new();
        for (k, (name, first)) in all[0].iter().enumerate() {
            if all.iter().any(|s| s[k].1 != *first) {
                found.push(((*name).to_owned(), all.iter().map(|s| s[k].1.clone()).collect()));
            }
        }
        found
    }
}

/// What the user chose of a planner and its surroundings, by name.
pub(crate) fn settings(h: &RunHeader) -> BTreeMap<String, String> {
    let mut s: BTreeMap<String, String> = h.params.clone();
    s.insert("version".into(), h.plugin.version.clone());
    s.insert("kind".into(), h.plugin.kind.to_string());
    s.extend(environment(h).into_iter().map(|(k, v)| (k.to_owned(), v)));
    s
}

/// What should be the same where planners are compared.
fn environment(h: &RunHeader) -> Vec<(&'static str, String)> {
    let data = |name: &str, hash: &str| format!("{name} ({})", hash.get(..8).unwrap_or(hash));
    vec![
        ("vehicle", data(&h.vehicle.name, &h.vehicle.hash)),
        ("rules", data(&h.rules.name, &h.rules.hash)),
        ("soils", data(&h.soils.name, &h.soils.hash)),
        ("perception", data(&h.perception.name, &h.perception.hash)),
        ("scale", h.scale.to_string()),
        ("seed", h.seed.to_string()),
        ("time step", h.time_step.to_string()),
        ("soil resolution", h.soil_resolution.to_string()),
        ("harness", format!("{} ({})", h.harness_version, h.harness_commit)),
        ("tasks", h.selector.clone().unwrap_or_else(|| "all".into())),
        ("limits", h.limits.iter().map(|(k, v)| format!("{k} {v}")).collect::<Vec<_>>().join(", ")),
    ]
}

fn row(r: &TaskRecord, world: u32, with_note: bool) -> Row {
    let note = match &r.fault {
        _ if !with_note || r.outcome == Outcome::Success => String::new(),
        Some(code) => one_line(&format!("{code}: {}", r.reason), NOTE_LENGTH),
        None => one_line(&r.explanation(), NOTE_LENGTH),
    };
    Row {
        task: r.task.clone(),
        seed: Box::default(),
        world,
        outcome: r.outcome,
        cause: r.cause,
        time: r.time_s,
        flags: Flag::ALL.map(|flag| r.flags.get(&flag).copied()),
        metrics: r.metrics,
        ride: r.ride,
        fuel: r.fuel,
        clamped: r.clamped,
        note: note.into_boxed_str(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_row_takes_less_than_half_a_kilobyte() {
        let size = size_of::<super::Row>();
        assert!(size < 512, "{size} bytes");
    }
}
