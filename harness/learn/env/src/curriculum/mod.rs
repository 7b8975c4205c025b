//! Which task a learner drives next.
//!
//! A [`Curriculum`] draws tasks for the environments of a learner and hears how their episodes ended. What it is, is data
//! ([`Spec`], `tasks/curricula`): all tasks alike; stages by hand; tasks that can be learned from most; or prioritised level replay.
//! It knows tasks by their index in the list that it was made for, and nothing of simulation or learning, so any learner can use it.
//!
//! Everything that is random follows from the seed, the environment and how many tasks that environment has drawn; what is drawn also
//! depends on the outcomes that were reported before. Whoever reports them in a fixed order draws the same tasks again.
//! [`Curriculum::state`] is all that it remembers, so that training can be continued.

mod learnability;
mod manual;
mod replay;
mod spec;

use serde::{Deserialize, Serialize};
use vb_files::DocumentError;
use vb_math::rng::Stream;
use vb_world::{Suite, SuiteError, TaskId, WorldInfo};

use learnability::Learnability;
use manual::Manual;
use replay::Replay;
pub use spec::{LearnabilitySpec, ManualSpec, Method, ReplaySpec, Spec, StageRule};

/// The most tasks that are drawn, which counts never come near.
const MOST_DRAWN: u64 = 1 << 53;

/// Draws tasks for environments, and learns from how their episodes end.
#[derive(Clone, Debug)]
pub struct Curriculum {
    tasks: usize,
    seed: u64,
    memory: Memory,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Memory {
    /// The hash of the tasks that it is of, since what is remembered of a task is kept by its index.
    tasks: String,
    /// Of each environment, how many tasks it has drawn.
    drawn: Vec<u64>,
    method: Learned,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Learned {
    Uniform,
    Manual(Manual),
    Learnability(Learnability),
    Replay(Replay),
}

/// The end of an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// Index of the environment.
    pub environment: usize,
    /// Index of the task in the list that the curriculum was made for.
    pub task: usize,
    /// Whether the vehicle came to the goal.
    pub is_success: bool,
}

impl Curriculum {
    /// A curriculum over tasks of a suite, for so many environments.
    ///
    /// # Errors
    /// Returns an error if there is no task or environment, a task is not in the suite, or a stage has none of the tasks.
    pub fn new(
        spec: &Spec,
        suite: &Suite,
        tasks: &[TaskId],
        environments: usize,
        seed: u64,
    ) -> Result<Self, DocumentError> {
        let flaw = |field: String, problem: String| DocumentError {
            kind: "curriculum",
            file: spec.name.clone(),
            field,
            problem,
        };
        if tasks.is_empty() || environments == 0 {
            let problem = "at least one task and one environment are required".to_owned();
            return Err(flaw("tasks".to_owned(), problem));
        }
        let method = match &spec.method {
            Method::Uniform => Learned::Uniform,
            Method::Manual(method) => {
                let stages = method.stages.iter().enumerate().map(|(k, selectors)| {
                    let field = |e: String| flaw(format!("stages[{k}]"), e);
                    let mut chosen = Vec::new();
                    for selector in selectors {
                        chosen.extend(selector.select(suite).map_err(|e| field(e.to_string()))?);
                    }
                    let own: Vec<usize> = (0..tasks.len()).filter(|t| chosen.contains(&tasks[*t])).collect();
                    if own.is_empty() {
                        return Err(field("it contains no task of the environment".into()));
                    }
                    Ok(own)
                });
                let stages = stages.collect::<Result<Vec<_>, _>>()?;
                Learned::Manual(Manual::new(method.rule, stages, environments))
            }
            Method::Learnability(method) => {
                let levels = levels(suite, tasks);
                Learned::Learnability(Learnability::new(method, levels))
            }
            Method::Replay(method) => Learned::Replay(Replay::new(method, tasks.len())),
        };
        let hash = hash(suite, tasks).map_err(|e| flaw("tasks".to_owned(), e.to_string()))?;
        let memory = Memory { tasks: hash, drawn: vec![0; environments], method };
        Ok(Self { tasks: tasks.len(), seed, memory })
    }

    /// The number of environments.
    #[must_use]
    pub fn environments(&self) -> usize {
        self.memory.drawn.len()
    }

    /// The index of the task that an environment drives next.
    ///
    /// # Panics
    /// Panics if there is no such environment.
    pub fn draw(&mut self, environment: usize) -> usize {
        let drawn = &mut self.memory.drawn[environment];
        let labels = ["curriculum", &environment.to_string(), &drawn.to_string()];
        let mut stream = Stream::new(self.seed, &labels);
        *drawn += 1;
        match &mut self.memory.method {
            Learned::Uniform => stream.below(self.tasks as u64) as usize,
            Learned::Manual(method) => method.draw(environment, &mut stream),
            Learned::Learnability(method) => method.draw(&mut stream),
            Learned::Replay(method) => method.draw(&mut stream),
        }
    }

    /// Takes in how an episode ended.
    ///
    /// # Panics
    /// Panics if there is no such environment or task.
    pub fn report(&mut self, ending: &Ending) {
        assert!(
            ending.task < self.tasks && ending.environment < self.environments(),
            "no such task or environment"
        );
        match &mut self.memory.method {
            Learned::Uniform => {}
            Learned::Manual(method) => method.report(ending),
            Learned::Learnability(method) => method.report(ending),
            Learned::Replay(method) => method.report(ending),
        }
    }

    /// Takes in a learner's score of a task, which replay draws by: the mean size of what returns differed by from the expected
    /// values in an episode. Other methods pass it over, and all pass over what is not finite.
    ///
    /// # Panics
    /// Panics if there is no such task.
    pub fn score(&mut self, task: usize, score: f64) {
        assert!(task < self.tasks, "no such task");
        if let Learned::Replay(method) = &mut self.memory.method
            && score.is_finite()
        {
            method.score(task, score);
        }
    }

    /// The chance of each task to be drawn next, in the mean over the environments.
    #[must_use]
    pub fn chances(&self) -> Vec<f64> {
        match &self.memory.method {
            Learned::Uniform => vec![1.0 / self.tasks as f64; self.tasks],
            Learned::Manual(method) => method.chances(self.tasks),
            Learned::Learnability(method) => method.chances(),
            Learned::Replay(method) => method.chances(),
        }
    }

    /// Of each environment, the stage at which it is; none where there are no stages.
    #[must_use]
    pub fn stages(&self) -> Vec<usize> {
        match &self.memory.method {
            Learned::Manual(method) => method.at(),
            _ => Vec::new(),
        }
    }

    /// All that it remembers, as text.
    #[must_use]
    pub fn state(&self) -> String {
        // Numbers and lists of them can always be written.
        serde_json::to_string(&self.memory).expect("numbers and lists of them can be written")
    }

    /// Goes on from what another curriculum of the same kind over the same tasks remembered.
    ///
    /// # Errors
    /// Returns an error if the text isn't what such a curriculum remembers; nothing has changed then.
    pub fn restore(&mut self, state: &str) -> Result<(), DocumentError> {
        let flaw = |problem: &str| DocumentError {
            kind: "curriculum",
            file: "curriculum".into(),
            field: "state".into(),
            problem: problem.into(),
        };
        let memory: Memory =
            serde_json::from_str(state).map_err(|e| flaw(&format!("it can't be read: {e}")))?;
        let fits = match (&memory.method, &self.memory.method) {
            (Learned::Uniform, Learned::Uniform) => true,
            (Learned::Manual(a), Learned::Manual(b)) => a.is_like(b),
            (Learned::Learnability(a), Learned::Learnability(b)) => a.is_like(b),
            (Learned::Replay(a), Learned::Replay(b)) => a.is_like(b),
            _ => false,
        };
        let tasks_differ = memory.tasks != self.memory.tasks;
        let is_counted = memory.drawn.iter().all(|drawn| *drawn <= MOST_DRAWN);
        if !fits || tasks_differ || !is_counted || memory.drawn.len() != self.memory.drawn.len() {
            return Err(flaw("it belongs to another curriculum, or to other tasks or environments"));
        }
        self.memory = memory;
        Ok(())
    }
}

/// The hash of a list of tasks: of their names, and of what their worlds hold.
fn hash(suite: &Suite, tasks: &[TaskId]) -> Result<String, SuiteError> {
    let line = |t: &TaskId| Ok(format!("{t} {}", suite.world_info(t.world())?.sha256));
    let lines = tasks.iter().map(line).collect::<Result<Vec<_>, _>>()?;
    Ok(vb_files::sha256(lines.join("\n").as_bytes()))
}

/// Of each task, the number of its level: elevation, ground and density of its world.
fn levels(suite: &Suite, tasks: &[TaskId]) -> Vec<usize> {
    let mut known = Vec::new();
    let level = |w: &WorldInfo| (w.elevation, w.terrain, w.density);
    let of = |t: &TaskId| suite.worlds().iter().find(|w| w.id == t.world()).map(level);
    let mut number = |t: &TaskId| {
        let level = of(t);
        known.iter().position(|k| *k == level).unwrap_or_else(|| {
            known.push(level);
            known.len() - 1
        })
    };
    tasks.iter().map(&mut number).collect()
}

/// The index at which the running sum of weights passes a share of their sum. All alike where the sum is 0.
fn pick(weights: impl Iterator<Item = f64> + Clone, stream: &mut Stream) -> usize {
    let (sum, count) = weights.clone().fold((0.0, 0usize), |(sum, n), w| (sum + w, n + 1));
    if sum <= 0.0 {
        return stream.below(count as u64) as usize;
    }
    let mut left = stream.unit() * sum;
    for (k, weight) in weights.enumerate() {
        left -= weight;
        if left < 0.0 {
            return k;
        }
    }
    count - 1
}
