//! Curricula as data.

use serde::{Deserialize, Serialize};
use vb_world::Selector;

/// The version of the files.
const SCHEMA: u32 = 1;

/// A curriculum can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct CurriculumError {
    /// The file, or the name of the curriculum.
    pub file: String,
    /// The field, the value and what is wrong.
    pub problem: String,
}

/// What a curriculum is.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The name.
    pub name: String,
    /// How tasks are chosen.
    pub method: Method,
}

/// How tasks are chosen.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// All tasks alike.
    Uniform,
    /// By stages, on which each environment goes up and down on its own.
    Manual(ManualSpec),
    /// By p(1 − p), where p is the share of drives of a task that reach the goal.
    Learnability(LearnabilitySpec),
    /// By prioritised level replay.
    Replay(ReplaySpec),
}

/// Stages by hand.
#[derive(Clone, Debug, PartialEq)]
pub struct ManualSpec {
    /// The tasks of each stage.
    pub stages: Vec<Selector>,
    /// When an environment leaves its stage.
    pub rule: StageRule,
}

/// When an environment leaves its stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRule {
    /// Episodes of an environment at its stage after which it is decided whether it stays.
    pub window: u32,
    /// The share of successes from which it goes up.
    pub promote: f64,
    /// The share of successes up to which it goes down.
    pub demote: f64,
    /// The share of episodes that are drawn from earlier stages.
    pub review: f64,
}

/// Learnability.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnabilitySpec {
    /// The share of episodes that are drawn from all tasks alike.
    pub explore: f64,
    /// What an outcome of a task still counts when the next one is there.
    pub keep: f64,
    /// The same of outcomes of all tasks of a level.
    pub keep_level: f64,
    /// How many outcomes of a task weigh as much as those of its level.
    pub prior: f64,
}

/// Prioritised level replay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplaySpec {
    /// The chance of a task that was driven before.
    pub replay: f64,
    /// The share of all tasks that must have been driven before one is driven again.
    pub seen: f64,
    /// How much of the old score a new one leaves.
    pub keep: f64,
    /// The temperature of the ranks by score.
    pub temperature: f64,
    /// The part of the chance that goes by how long ago a task was driven.
    pub staleness: f64,
}

/// A file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: u32,
    name: String,
    #[serde(default)]
    #[allow(dead_code, reason = "for readers of the file")]
    description: String,
    kind: Kind,
    stages: Option<Vec<String>>,
    window: Option<u32>,
    promote: Option<f64>,
    demote: Option<f64>,
    review: Option<f64>,
    explore: Option<f64>,
    keep: Option<f64>,
    keep_level: Option<f64>,
    prior: Option<f64>,
    replay: Option<f64>,
    seen: Option<f64>,
    temperature: Option<f64>,
    staleness: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Uniform,
    Manual,
    Learnability,
    Replay,
}

impl Spec {
    /// Those that come with the harness, as names and the text of their files.
    pub const BUILTIN: [(&str, &str); 4] = [
        ("uniform", include_str!("../../../tasks/curricula/uniform.yaml")),
        ("manual", include_str!("../../../tasks/curricula/manual.yaml")),
        ("learnability", include_str!("../../../tasks/curricula/learnability.yaml")),
        ("replay", include_str!("../../../tasks/curricula/replay.yaml")),
    ];

    /// Finds a built-in one by its name, or else reads a file by its path.
    ///
    /// # Errors
    /// Returns an error that names the file, the field and the value.
    pub fn resolve(name_or_path: &str) -> Result<Self, CurriculumError> {
        let text = vb_files::named_text(name_or_path, &Self::BUILTIN).map_err(|e| {
            let names = Self::BUILTIN.map(|(name, _)| name).join(", ");
            let problem = format!("cannot read the curriculum: {e} (give a YAML file, or one of {names})");
            CurriculumError { file: name_or_path.to_owned(), problem }
        })?;
        Self::from_yaml(name_or_path, &text)
    }

    /// Reads one from YAML; `file` is what errors call it.
    ///
    /// # Errors
    /// Returns an error that names the field and the value.
    pub fn from_yaml(file: &str, text: &str) -> Result<Self, CurriculumError> {
        let flaw = |problem: String| CurriculumError { file: file.to_owned(), problem };
        let mut read: File = vb_world::yaml::parse(text).map_err(|e| flaw(e.to_string()))?;
        if read.schema != SCHEMA {
            return Err(flaw(format!("schema: {} must be {SCHEMA}", read.schema)));
        }
        let method = read.method().map_err(flaw)?;
        if let Some(field) = read.rest() {
            let kind = format!("{:?}", read.kind).to_lowercase();
            return Err(flaw(format!("{field}: a curriculum of kind {kind} has no such field")));
        }
        Ok(Self { name: read.name, method })
    }
}

/// The value of a field, which must be there and lie within bounds.
fn within(value: &mut Option<f64>, field: &str, low: f64, high: f64) -> Result<f64, String> {
    let value = value.take().ok_or_else(|| format!("{field}: it is missing"))?;
    if value >= low && value <= high {
        return Ok(value);
    }
    Err(format!("{field}: {value} must lie in {low} to {high}"))
}

impl File {
    /// Takes the fields of the kind.
    fn method(&mut self) -> Result<Method, String> {
        Ok(match self.kind {
            Kind::Uniform => Method::Uniform,
            Kind::Manual => {
                let texts = self.stages.take().ok_or("stages: they are missing")?;
                if texts.is_empty() {
                    return Err("stages: there must be one at least".into());
                }
                let parse =
                    |(k, t): (usize, &String)| Selector::parse(t).map_err(|e| format!("stages[{k}]: {e}"));
                let window = self.window.take().ok_or("window: it is missing")?;
                if !(1..=1000).contains(&window) {
                    return Err(format!("window: {window} must lie in 1 to 1000"));
                }
                let promote = within(&mut self.promote, "promote", 0.0, 1.0)?;
                let demote = within(&mut self.demote, "demote", -1.0, 1.0)?;
                if demote >= promote {
                    return Err(format!("demote: {demote} must be less than promote, {promote}"));
                }
                let review = within(&mut self.review, "review", 0.0, 1.0)?;
                Method::Manual(ManualSpec {
                    stages: texts.iter().enumerate().map(parse).collect::<Result<_, _>>()?,
                    rule: StageRule { window, promote, demote, review },
                })
            }
            Kind::Learnability => Method::Learnability(LearnabilitySpec {
                explore: within(&mut self.explore, "explore", 0.0, 1.0)?,
                keep: within(&mut self.keep, "keep", 0.0, 1.0)?,
                keep_level: within(&mut self.keep_level, "keep_level", 0.0, 1.0)?,
                prior: within(&mut self.prior, "prior", 1e-3, 1e3)?,
            }),
            Kind::Replay => Method::Replay(ReplaySpec {
                replay: within(&mut self.replay, "replay", 0.0, 1.0)?,
                seen: within(&mut self.seen, "seen", 0.0, 1.0)?,
                keep: within(&mut self.keep, "keep", 0.0, 1.0)?,
                temperature: within(&mut self.temperature, "temperature", 0.01, 100.0)?,
                staleness: within(&mut self.staleness, "staleness", 0.0, 1.0)?,
            }),
        })
    }

    /// A field that nothing has taken.
    fn rest(&self) -> Option<&'static str> {
        let numbers = [
            ("promote", self.promote),
            ("demote", self.demote),
            ("review", self.review),
            ("explore", self.explore),
            ("keep", self.keep),
            ("keep_level", self.keep_level),
            ("prior", self.prior),
            ("replay", self.replay),
            ("seen", self.seen),
            ("temperature", self.temperature),
            ("staleness", self.staleness),
        ];
        let number = numbers.iter().find(|(_, value)| value.is_some()).map(|(name, _)| *name);
        let stages = self.stages.as_ref().map(|_| "stages");
        number.or(stages).or(self.window.map(|_| "window"))
    }
}
