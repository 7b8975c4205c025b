//! Locations and progress of a sweep's runs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use vb_record::{RunReader, StoreError};
use vb_score::Outcome;
use vb_world::TaskId;

/// The folder of a sweep: `sweep.yaml`, `runs/NAME` for each run, and `shards/NAME` for the shards of those that many machines
/// drive.
#[derive(Clone, Debug)]
pub struct Layout {
    root: PathBuf,
}

/// How far a run is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RunState {
    /// The tasks that are done, by their outcome. Those that the harness or the machine failed are not.
    pub done: BTreeMap<Outcome, u64>,
    /// The tasks that the harness or the machine failed.
    pub failed: u64,
    /// Whether it is there as a whole.
    pub is_whole: bool,
}

impl RunState {
    /// The number of tasks that are done.
    #[must_use]
    pub fn tasks(&self) -> u64 {
        self.done.values().sum()
    }
}

#[derive(Deserialize)]
struct Ended {
    task: TaskId,
    outcome: Outcome,
}

impl Layout {
    #[must_use]
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The plan, as it was when the first run began.
    #[must_use]
    pub fn plan(&self) -> PathBuf {
        self.root.join("sweep.yaml")
    }

    /// Where a run lies, whether or not it is there.
    #[must_use]
    pub fn run(&self, name: &str) -> PathBuf {
        self.root.join("runs").join(name)
    }

    #[must_use]
    pub fn shards(&self, name: &str) -> PathBuf {
        self.root.join("shards").join(name)
    }

    /// Whether any run is driven in shards.
    #[must_use]
    pub fn is_sharded(&self) -> bool {
        self.root.join("shards").is_dir()
    }

    /// How far the run or the shard in a folder is; nothing is done if there is none.
    pub fn state_of(&self, dir: &Path) -> Result<RunState, StoreError> {
        let mut state = RunState::default();
        if dir.join("run.json").is_file() {
            count(dir, &mut state, &mut BTreeSet::new())?;
        }
        Ok(state)
    }

    /// How far a run is, with what its shards have done if it isn't whole yet.
    pub fn state(&self, name: &str) -> Result<RunState, StoreError> {
        let whole = self.run(name);
        if whole.join("run.json").is_file() {
            return Ok(RunState { is_whole: true, ..self.state_of(&whole)? });
        }
        let mut state = RunState::default();
        let Ok(entries) = std::fs::read_dir(self.shards(name)) else { return Ok(state) };
        let mut shards: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
        shards.sort();
        let mut seen = BTreeSet::new();
        for shard in shards.iter().filter(|dir| dir.join("run.json").is_file()) {
            count(shard, &mut state, &mut seen)?;
        }
        Ok(state)
    }
}

/// Counts the tasks of a run, of which several shards may have `seen` some: each counts once.
fn count(run: &Path, state: &mut RunState, seen: &mut BTreeSet<TaskId>) -> Result<(), StoreError> {
    RunReader::open(run)?.each_record(|Ended { task, outcome }| match outcome {
        Outcome::HostError => state.failed += 1,
        outcome if seen.insert(task) => *state.done.entry(outcome).or_default() += 1,
        _ => {}
    })
}
