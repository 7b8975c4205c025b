//! One line of `tasks.jsonl`.

use serde::{Deserialize, Serialize};
use vb_world::{Density, Elevation, Terrain};

use crate::{Metrics, Outcome, TaskScore, ThreeWay};

/// Fuel that a planner used in one task, in the host's units (WebAssembly instructions, roughly).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FuelUse {
    /// In the whole task.
    pub total: u64,
    /// In the most costly step.
    pub max_step: u64,
}

/// What is known of a finished task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskRecord {
    /// Name of the task in the suite, e.g. `w001/t03`.
    pub task: String,
    /// Name of its world.
    pub world: String,
    /// Elevation level of the world.
    pub elevation: Elevation,
    /// Kind of ground of the world.
    pub terrain: Terrain,
    /// Obstacle density of the world.
    pub density: Density,
    /// How it ended.
    pub outcome: Outcome,
    /// The paper's class of that.
    pub three_way: ThreeWay,
    /// Why, in words.
    pub reason: String,
    /// For errors: the kind of fault, e.g. `out-of-fuel`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Simulated time at its end, s.
    pub time_s: f64,
    /// Hash over the whole state of the simulation at every sample (16 hexadecimal digits).
    pub state_hash: String,
    /// Number of simulation steps.
    pub sim_steps: u64,
    /// Number of calls of the planner's step.
    pub planner_steps: u64,
    /// Number of those whose command was out of range and clamped.
    pub clamped: u64,
    /// Fuel that the planner used; none for native planners.
    pub fuel: Option<FuelUse>,
    /// Measures; none if the task ended before the first sample.
    pub metrics: Option<Metrics>,
    /// The last lines that the planner logged, if it failed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub log: Vec<String>,
}

impl TaskRecord {
    /// Replaces what the rules decided by another score, as re-scoring does. What was counted over the whole
    /// simulation (state hash, steps, clamped commands, fuel, log) stays.
    pub fn set_score(&mut self, score: TaskScore) {
        let TaskScore { outcome, three_way, reason, time_s, metrics } = score;
        if !matches!(outcome, Outcome::PlannerError | Outcome::SimError) {
            self.fault = None;
        }
        (self.outcome, self.three_way, self.reason) = (outcome, three_way, reason);
        (self.time_s, self.metrics) = (time_s, metrics);
    }
}
