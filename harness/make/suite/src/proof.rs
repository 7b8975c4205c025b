//! Proof that tasks can be done: for each, who has done it, how, and by which state hash one knows that it was so.
//!
//! A proof lies beside the suite's index as `proof.json`. It is no part of the suite: no hash covers it, and a suite
//! stays the same when more of its tasks are proven.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use vb_world::{Suite, TaskId, WorldInfo};

const SCHEMA: u32 = 1;
/// The file in a suite's folder.
const FILE: &str = "proof.json";

#[derive(Debug, thiserror::Error)]
pub enum ProofError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("{}: {problem}: re-create it with `vb-harness suite prove`", path.display())]
    Damaged { path: PathBuf, problem: String },
    #[error(
        "{}: contains certificates of a suite with hash {found}, not {expected}: re-create it with `vb-harness suite prove`", path.display()
    )]
    OtherSuite { path: PathBuf, found: String, expected: String },
}

/// A data file that decided what happened, by name and hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// The name of the file's content.
    pub name: String,
    /// The hash of the file's content (hex).
    pub hash: String,
}

/// The conditions that all drives of a proof have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// The version of the harness.
    pub harness_version: String,
    /// The vehicle.
    pub vehicle: Named,
    /// The soil set.
    pub soils: Named,
    /// The rules.
    pub rules: Named,
    /// The factor on every length of the worlds.
    pub scale: f64,
    /// The time step of the simulation, s.
    pub time_step: f64,
    /// The side of the cells in which soil remembers ruts, m.
    pub soil_resolution: f64,
}

/// A planner that proved tasks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prover {
    /// The name of the planner.
    pub planner: String,
    /// The version of the planner.
    pub version: String,
    /// The hash of the planner's file (hex).
    pub sha256: String,
    /// The parameters that differ from the planner's defaults.
    pub params: BTreeMap<String, String>,
    /// The seed of the run.
    pub seed: u64,
}

/// The way in which a task was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// The index of the prover.
    pub prover: usize,
    /// The time to the goal, s.
    pub time_s: f64,
    /// The hash over the simulation's states.
    pub state_hash: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proof {
    /// The version of the layout, 1.
    schema: u32,
    /// The hash of the suite.
    pub suite: String,
    /// The conditions of all runs.
    pub conditions: Conditions,
    /// The planners that solved tasks.
    pub provers: Vec<Prover>,
    /// The successful trial of each solved task.
    pub tasks: BTreeMap<TaskId, Drive>,
    /// The tasks that no planner has solved, which may be unsolvable.
    pub unproven: Vec<TaskId>,
}

impl Proof {
    /// A proof without a proven task.
    #[must_use]
    pub fn new(suite: &Suite, conditions: Conditions) -> Self {
        let unproven = suite.worlds().iter().flat_map(WorldInfo::task_ids).collect();
        Self {
            schema: SCHEMA,
            suite: suite.hash(),
            conditions,
            provers: Vec::new(),
            tasks: BTreeMap::new(),
            unproven,
        }
    }

    /// Adds what a planner has done: task, time (s) and state hash. Tasks that are proven already stay as they are, and
    /// a planner that proves nothing new is left out. It returns the number of tasks that the planner proved.
    pub fn add(&mut self, prover: Prover, done: impl IntoIterator<Item = (TaskId, f64, String)>) -> usize {
        let (before, index) = (self.tasks.len(), self.provers.len());
        for (task, time_s, state_hash) in done {
            if let Some(at) = self.unproven.iter().position(|t| *t == task) {
                self.unproven.remove(at);
                self.tasks.insert(task, Drive { prover: index, time_s, state_hash });
            }
        }
        if self.tasks.len() > before {
            self.provers.push(prover);
        }
        self.tasks.len() - before
    }

    #[must_use]
    pub fn path(suite: &Suite) -> PathBuf {
        suite.dir().join(FILE)
    }

    /// Reads the proof that lies beside a suite, if there is one.
    ///
    /// # Errors
    /// Returns an error if the file can't be read, is not a proof, or is another suite's.
    pub fn read(suite: &Suite) -> Result<Option<Self>, ProofError> {
        let path = Self::path(suite);
        let text = match vb_files::read_text(&path, vb_files::DATA) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(ProofError::File { path, source }),
        };
        let damaged = |problem: String| ProofError::Damaged { path: path.clone(), problem };
        let proof: Self = serde_json::from_str(&text).map_err(|e| damaged(e.to_string()))?;
        if proof.schema != SCHEMA {
            return Err(damaged(format!(
                "schema {} is not supported; this build reads {SCHEMA}",
                proof.schema
            )));
        }
        let expected = suite.hash();
        if proof.suite != expected {
            return Err(ProofError::OtherSuite { path, found: proof.suite, expected });
        }
        if let Some((task, drive)) = proof.tasks.iter().find(|(_, d)| d.prover >= proof.provers.len()) {
            return Err(damaged(format!("tasks.{task}.prover: prover {} does not exist", drive.prover)));
        }
        let fresh = Self::new(suite, proof.conditions.clone()).unproven;
        let mut all: Vec<&TaskId> = proof.tasks.keys().chain(&proof.unproven).collect();
        all.sort();
        if !all.iter().copied().eq(fresh.iter()) {
            return Err(damaged("does not contain every task of the suite exactly once".into()));
        }
        Ok(Some(proof))
    }

    /// Writes the proof, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), ProofError> {
        let failed = |source| ProofError::File { path: path.to_owned(), source };
        // One line a task, so that changes can be read.
        let value = serde_json::to_value(self).map_err(|e| failed(e.into()))?;
        vb_files::write(path, lines(&value).as_bytes()).map_err(failed)
    }
}

/// JSON with one line for each entry of the lists and tables at the first level.
fn lines(value: &serde_json::Value) -> String {
    use serde_json::Value;
    let entry = |key: &str, value: &Value| format!("{}: {value}", Value::from(key));
    let block = |open: char, close: char, rows: Vec<String>| {
        if rows.is_empty() {
            format!("{open}{close}")
        } else {
            format!("{open}\n    {}\n  {close}", rows.join(",\n    "))
        }
    };
    let field = |(key, value): (&String, &Value)| {
        let text = match value {
            Value::Array(items) => block('[', ']', items.iter().map(ToString::to_string).collect()),
            Value::Object(map) => block('{', '}', map.iter().map(|(k, v)| entry(k, v)).collect()),
            other => other.to_string(),
        };
        format!("{}: {text}", Value::from(key.as_str()))
    };
    let fields: Vec<String> = value.as_object().into_iter().flatten().map(field).collect();
    format!("{{\n  {}\n}}\n", fields.join(",\n  "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suite() -> (tempfile::TempDir, Suite) {
        let smoke = Suite::open(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/smoke")).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let suite = Suite::write(dir.path(), smoke.meta(), &[smoke.load_world("w001").unwrap()]).unwrap();
        (dir, suite)
    }

    fn conditions() -> Conditions {
        let named = |name: &str| Named { name: name.into(), hash: "00".into() };
        Conditions {
            harness_version: "0.1.0".into(),
            vehicle: named("hmmwv"),
            soils: named("default"),
            rules: named("paper"),
            scale: 1.0,
            time_step: 0.001,
            soil_resolution: 0.1,
        }
    }

    fn prover(speed: &str) -> Prover {
        let params = [("speed".to_owned(), speed.to_owned())].into();
        Prover { planner: "p".into(), version: "1".into(), sha256: "ab".into(), params, seed: 7 }
    }

    fn done(task: &str) -> (TaskId, f64, String) {
        (task.parse().unwrap(), 41.5, "0123".into())
    }

    #[test]
    fn the_first_who_does_a_task_proves_it_and_what_is_left_is_unproven() {
        let (_dir, suite) = suite();
        let mut proof = Proof::new(&suite, conditions());
        assert_eq!((proof.tasks.len(), proof.unproven.len()), (0, 10));
        assert_eq!(proof.add(prover("3"), [done("w001/t00"), done("w001/t04"), done("w009/t00")]), 2);
        assert_eq!(proof.add(prover("4"), [done("w001/t04")]), 0);
        assert_eq!(proof.add(prover("5"), [done("w001/t04"), done("w001/t05")]), 1);
        let who = |t: &str| proof.provers[proof.tasks[t].prover].params["speed"].clone();
        assert_eq!([who("w001/t00"), who("w001/t04"), who("w001/t05")], ["3", "3", "5"]);
        assert_eq!((proof.provers.len(), proof.unproven.len()), (2, 7));
    }

    #[test]
    fn a_proof_reads_back_as_it_was_written() {
        let (_dir, suite) = suite();
        assert_eq!(Proof::read(&suite).unwrap(), None);
        let mut proof = Proof::new(&suite, conditions());
        proof.add(prover("3"), [done("w001/t00")]);
        proof.write(&Proof::path(&suite)).unwrap();
        assert_eq!(Proof::read(&suite).unwrap(), Some(proof));
    }

    #[test]
    fn a_proof_of_another_suite_or_with_holes_is_refused() {
        let (_dir, suite) = suite();
        let proof = Proof::new(&suite, conditions());
        let refused = |change: &dyn Fn(&mut Proof)| {
            let mut other = proof.clone();
            change(&mut other);
            other.write(&Proof::path(&suite)).unwrap();
            Proof::read(&suite).unwrap_err().to_string()
        };
        assert!(refused(&|p| p.suite = "ff".into()).contains("a suite with hash ff"));
        assert!(refused(&|p| drop(p.unproven.pop())).contains("every task of the suite exactly once"));
        assert!(
            refused(&|p| p.unproven.push("w001/t00".parse().unwrap()))
                .contains("every task of the suite exactly once")
        );
        assert!(refused(&|p| p.schema = 9).contains("schema 9 is not supported"));
        let lost = refused(&|p| {
            p.add(prover("3"), [done("w001/t00")]);
            p.provers.clear();
        });
        assert!(lost.contains("tasks.w001/t00.prover: prover 0 does not exist"), "{lost}");
        std::fs::write(Proof::path(&suite), "{").unwrap();
        assert!(Proof::read(&suite).unwrap_err().to_string().contains("proof.json"));
    }
}
