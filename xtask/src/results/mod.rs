//! The results of planners over the suites, as tables in README and docs.

mod hashes;
mod leaderboard;
mod published;
mod table;

pub(crate) use leaderboard::leaderboard;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::blocks;
use crate::run::{Failure, remove, run, step};
use crate::{built, default_plugin_dir, root, target_dir};

/// Planner class, as in the paper.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Class {
    Classical,
    Hybrid,
    EndToEnd,
    /// Not of the paper, and not ranked.
    Reference,
}

impl Class {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Classical => "classical",
            Self::Hybrid => "hybrid",
            Self::EndToEnd => "end-to-end",
            Self::Reference => "reference",
        }
    }
}

/// A planner with its parameters: a row of each table.
pub(super) struct Entry {
    /// The name of its plugin, by which published figures are found, too.
    pub(super) plugin: &'static str,
    pub(super) label: &'static str,
    pub(super) params: &'static [&'static str],
    pub(super) class: Class,
}

/// An entry with what it did on a course.
pub(super) struct Row<'a> {
    pub(super) entry: &'a Entry,
    /// The run's summary.json.
    pub(super) summary: Value,
    /// The first and the last place among the rows that the run may have: a difference that isn't significant is a tie.
    pub(super) rank: Option<[u64; 2]>,
    /// Success rate over the tasks proven solvable with the course's vehicle (the suite's `proof.json`).
    pub(super) of_solvable: Option<f64>,
}

impl Row<'_> {
    /// The figures over all tasks.
    pub(super) fn all(&self) -> &Value {
        &self.summary["all"]
    }
}

/// The rows, in their order.
const ENTRIES: &[Entry] = &[
    Entry { plugin: "pid", label: "PID", params: &[], class: Class::Classical },
    Entry { plugin: "pid", label: "PID, 3 m/s", params: &["speed=3"], class: Class::Classical },
    Entry { plugin: "eh", label: "EH", params: &[], class: Class::Classical },
    Entry { plugin: "eh", label: "EH, 3 m/s", params: &["speed=3"], class: Class::Classical },
    Entry { plugin: "mppi", label: "MPPI", params: &[], class: Class::Classical },
    Entry { plugin: "mppi", label: "MPPI, 3 m/s", params: &["speed=3"], class: Class::Classical },
    Entry { plugin: "wmvct", label: "WM-VCT", params: &[], class: Class::Hybrid },
    Entry { plugin: "mppi6", label: "MPPI-6", params: &[], class: Class::Hybrid },
    Entry { plugin: "tal", label: "TAL", params: &[], class: Class::Hybrid },
    Entry { plugin: "tnt", label: "TNT", params: &[], class: Class::Hybrid },
    Entry { plugin: "rl", label: "RL (SAC)", params: &[], class: Class::EndToEnd },
    Entry { plugin: "mcl", label: "MCL (SAC)", params: &[], class: Class::EndToEnd },
    Entry { plugin: "acl", label: "ACL (SAC)", params: &[], class: Class::EndToEnd },
    Entry { plugin: "ibex", label: "Ibex", params: &[], class: Class::Reference },
];

/// A suite that is driven with a vehicle: two tables, one of results and one of causes.
struct Course {
    /// The name of its tables in the documents, and of the folder of its runs.
    name: &'static str,
    suite: &'static str,
    vehicle: &'static str,
}

/// The worlds of the original, which don't come with the repository.
const ORIGINAL: &str = "original";

const COURSES: &[Course] = &[
    Course { name: "vb-100-hmmwv", suite: "vb-100", vehicle: "hmmwv" },
    Course { name: "vb-paper-hmmwv-released", suite: "vb-paper", vehicle: "hmmwv-released" },
    Course { name: "original-hmmwv-released", suite: ORIGINAL, vehicle: "hmmwv-released" },
];

/// Makes a table of the rows of a course.
type Make = fn(&[Row<'_>]) -> String;

/// The tables of a course: what their names end in, and what makes them.
const KINDS: [(&str, Make); 3] =
    [("summary", table::summary), ("results", table::results), ("causes", table::causes)];

/// The documents whose tables are made here.
const DOCUMENTS: [&str; 2] = ["README.md", "docs/benchmark-results.md"];

/// The selector of all tasks.
const ALL: &str = "*";

/// The tasks by which results are verified: a tenth of a whole suite.
const VERIFIED: &str = "w*/t00";

/// Drives every entry over every course, or over those that are named, and writes their tables into the documents, and the state
/// hashes of all tasks into `docs/results`. With `--resume`, earlier runs go on where they ended. With `--verify`, drives a tenth of
/// the tasks and compares their state hashes instead.
pub(crate) fn results(options: &[&str]) -> Result<(), Failure> {
    let (resume, verify) = (options.contains(&"--resume"), options.contains(&"--verify"));
    let names: Vec<&str> =
        options.iter().copied().filter(|o| !matches!(*o, "--resume" | "--verify")).collect();
    if let Some(unknown) = names.iter().find(|name| COURSES.iter().all(|c| c.name != **name)) {
        let known: Vec<&str> = COURSES.iter().map(|c| c.name).collect();
        return Err(Failure::new(format!(
            "results: no such course: `{unknown}`; there are {}",
            known.join(", ")
        )));
    }
    crate::build_harness()?;
    crate::plugins::build_as_wasm(&default_plugin_dir())?;
    let folder = target_dir().join("results");
    let courses = || COURSES.iter().filter(|c| names.is_empty() || names.contains(&c.name));
    if verify {
        return courses().try_for_each(|course| verified(course, &target_dir().join("results-verified")));
    }
    let mut tables = Vec::new();
    for course in courses() {
        if !resume {
            remove(&folder.join(course.name))?;
        }
        let suite = suite(course, &folder)?;
        let solvable = solvable(course)?;
        let (mut rows, mut states) = (Vec::new(), Vec::new());
        for entry in ENTRIES {
            let out = folder.join(course.name).join(run_name(entry));
            let summary = drive(entry, course, ALL, &suite, &out)?;
            states.push((run_name(entry), hashes::of_run(&out)?));
            let of_solvable =
                solvable.as_ref().map(|tasks| success_among(&out, tasks)).transpose()?.flatten();
            rows.push(Row { entry, summary, rank: None, of_solvable });
        }
        let ranked = || ENTRIES.iter().filter(|entry| entry.class != Class::Reference);
        let runs: Vec<PathBuf> = ranked().map(|e| folder.join(course.name).join(run_name(e))).collect();
        let rows_ranked = rows.iter_mut().filter(|row| row.entry.class != Class::Reference);
        for (row, rank) in rows_ranked.zip(ranking(&runs, &folder)?) {
            row.rank = rank;
        }
        hashes::write(course.name, &states)?;
        for (kind, make) in KINDS {
            tables.push((format!("{} {kind}", course.name), make(&rows)));
        }
    }
    for document in DOCUMENTS {
        blocks::write(&root().join(document), "results", &tables)?;
    }
    Ok(())
}

/// Drives a tenth of a course's tasks again and compares their states with those behind the tables.
///
/// # Errors
/// Returns an error that names the first task that ends in another state.
fn verified(course: &Course, folder: &Path) -> Result<(), Failure> {
    let Some(recorded) = hashes::read(course.name)? else {
        step(&format!("{}: no state hashes are recorded", course.name));
        return Ok(());
    };
    remove(&folder.join(course.name))?;
    let suite = suite(course, folder)?;
    for entry in ENTRIES {
        let Some(wanted) = recorded.get(&run_name(entry)) else { continue };
        let out = folder.join(course.name).join(run_name(entry));
        drive(entry, course, VERIFIED, &suite, &out)?;
        let found = hashes::of_run(&out)?;
        if let Some((task, hash)) = found.iter().find(|(task, hash)| wanted.get(*task) != Some(*hash)) {
            let recorded = wanted.get(task).map_or("none", String::as_str);
            return Err(Failure::new(format!(
                "{}: {}: {task} ends with the state hash {hash}, recorded is {recorded}",
                course.name, entry.label
            )));
        }
        step(&format!("{}: {}: {} state hashes are equal", course.name, entry.label, found.len()));
    }
    Ok(())
}

fn run_name(entry: &Entry) -> String {
    std::iter::once(entry.plugin).chain(entry.params.iter().copied()).collect::<Vec<_>>().join("-")
}

/// The suite of a course, by its name or its folder; the original's worlds are imported first.
fn suite(course: &Course, folder: &Path) -> Result<PathBuf, Failure> {
    if course.suite != ORIGINAL {
        return Ok(course.suite.into());
    }
    let imported = folder.join(ORIGINAL);
    if !imported.exists() {
        let from = vb_testing::shared_folder().join("verti-bench/BenchMaps");
        if !from.exists() {
            return Err(Failure::new(format!(
                "{}: the worlds of the original aren't there; set VB_SHARED to the folder that has verti-bench/BenchMaps",
                from.display()
            )));
        }
        let mut import = Command::new(built("vb-harness"));
        import.args(["suite", "import"]).arg(from).arg("--out").arg(&imported);
        run(import.stdout(Stdio::null()))?;
    }
    Ok(imported)
}

/// The summary of a run, which goes on where an interrupted one ended. The harness refuses one of another planner.
fn drive(entry: &Entry, course: &Course, tasks: &str, suite: &Path, out: &Path) -> Result<Value, Failure> {
    let file = out.join("summary.json");
    step(&format!("{} on {} in {}", entry.label, course.suite, course.vehicle));
    let mut drive = Command::new(built("vb-harness"));
    drive.arg("--plugin").arg(default_plugin_dir().join(format!("{}.wasm", entry.plugin)));
    drive.arg("--suite").arg(suite).args(["--vehicle", course.vehicle]).arg("--out").arg(out);
    drive.args(["--tasks", tasks, "--trace", "none", "--keep-going", "--resume"]);
    for param in entry.params {
        drive.args(["--param", param]);
    }
    let done =
        drive.current_dir(root()).output().map_err(|e| Failure::new(format!("can't run vb-harness: {e}")))?;
    // A run with simulations that failed, which count as failures, ends with a code of its own, and is complete.
    if !done.status.success() && !read(&file).is_ok_and(|summary| is_complete(&summary)) {
        let messages = String::from_utf8_lossy(&done.stderr);
        let last = messages.trim_end().lines().last().unwrap_or_default();
        return Err(Failure::new(format!("{}: vb-harness: {}: {last}", out.display(), done.status)));
    }
    read(&file)
}

/// The tasks proven solvable with the course's vehicle; `None` without a proof for that vehicle.
fn solvable(course: &Course) -> Result<Option<BTreeSet<String>>, Failure> {
    let file = root().join("tasks").join(course.suite).join("proof.json");
    if !file.exists() {
        return Ok(None);
    }
    let proof = read(&file)?;
    let tasks =
        proof["tasks"].as_object().filter(|_| proof["conditions"]["vehicle"]["name"] == course.vehicle);
    Ok(tasks.map(|tasks| tasks.keys().cloned().collect()))
}

/// The fraction of successes among those tasks of a run that are in `tasks`.
fn success_among(run: &Path, tasks: &BTreeSet<String>) -> Result<Option<f64>, Failure> {
    let file = run.join("tasks.jsonl");
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(&file).map_err(|e| wrong(&e))?;
    let (mut driven, mut done) = (0_u32, 0_u32);
    for line in text.lines() {
        let record: Value = serde_json::from_str(line).map_err(|e| wrong(&e))?;
        if record["task"].as_str().is_some_and(|task| tasks.contains(task)) {
            driven += 1;
            done += u32::from(record["outcome"] == "success");
        }
    }
    Ok((driven > 0).then(|| f64::from(done) / f64::from(driven)))
}

/// The first and the last place of each of several runs, as `vb-harness report` ranks them.
fn ranking(runs: &[PathBuf], folder: &Path) -> Result<Vec<Option<[u64; 2]>>, Failure> {
    let mut report = Command::new(built("vb-harness"));
    report.arg("report").args(runs).args(["--message-format", "json", "--force", "--markdown"]);
    let done = report
        .arg(folder.join("report.md"))
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| Failure::new(format!("can't run vb-harness: {e}")))?;
    let text = String::from_utf8_lossy(&done.stdout);
    let statistics = text
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .find(|message| message["event"] == "statistics")
        .ok_or_else(|| Failure::new(format!("vb-harness report: {}", done.status)))?;
    let places = statistics["ranking"].as_array().into_iter().flatten();
    let mut ranks = vec![None; runs.len()];
    for place in places {
        let [run, first, last] = ["run", "rank", "rank_last"].map(|key| place[key].as_u64());
        if let (Some(run), Some(first), Some(last)) = (run, first, last)
            && let Some(rank) = ranks.get_mut(run as usize)
        {
            *rank = Some([first, last]);
        }
    }
    Ok(ranks)
}

fn read(file: &Path) -> Result<Value, Failure> {
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|e| wrong(&e))?;
    serde_json::from_str(&text).map_err(|e| wrong(&e))
}

/// Whether a run has driven all that it was to drive; a run that was interrupted has a summary, too.
fn is_complete(summary: &Value) -> bool {
    summary["all"]["tasks"].is_u64() && summary["all"]["tasks"] == summary["planned"]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_was_interrupted_is_not_complete() {
        let summary = |tasks: u64| serde_json::json!({"planned": 1000, "all": {"tasks": tasks}});
        assert!(is_complete(&summary(1000)));
        assert!(!is_complete(&summary(316)) && !is_complete(&serde_json::json!({})));
    }

    #[test]
    fn every_mark_in_the_documents_is_of_a_table_and_every_table_has_a_place() {
        let marks = |document: &str| -> Vec<String> {
            let text = std::fs::read_to_string(root().join(document)).unwrap();
            let marks = text.lines().filter_map(|line| {
                line.strip_prefix("<!-- made: ")?.strip_suffix(" (by cargo xtask results) -->")
            });
            marks.map(str::to_owned).collect()
        };
        let names: Vec<String> =
            COURSES.iter().flat_map(|c| KINDS.map(|(kind, _)| format!("{} {kind}", c.name))).collect();
        for document in DOCUMENTS {
            for mark in marks(document) {
                assert!(names.contains(&mark), "{document}: {mark}");
            }
        }
        let placed = marks(DOCUMENTS[1]);
        let mut in_full = names.iter().filter(|name| !name.ends_with("summary"));
        assert!(in_full.all(|name| placed.contains(name)), "{placed:?}");
    }
}
