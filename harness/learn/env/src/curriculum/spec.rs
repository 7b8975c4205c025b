//! Curricula as data.

use serde::{Deserialize, Serialize};
use vb_files::document::{self, Document};
use vb_files::{Flaw, Schema};
use vb_world::Selector;

/// A curriculum as its file states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The name in lists and messages.
    pub name: String,
    /// The rule that selects the next task.
    pub method: Method,
}

/// A rule that samples tasks.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Uniform sampling of all tasks.
    Uniform,
    /// Manual stages; each environment changes its stage independently.
    Manual(ManualSpec),
    /// Probability proportional to p(1 − p) with the success rate p of a task.
    Learnability(LearnabilitySpec),
    /// Prioritised level replay.
    Replay(ReplaySpec),
}

/// Stages in a fixed order.
#[derive(Clone, Debug, PartialEq)]
pub struct ManualSpec {
    /// The tasks of each stage: the union of its selectors.
    pub stages: Vec<Vec<Selector>>,
    /// The conditions of a change of the stage.
    pub rule: StageRule,
}

/// The conditions under which an environment changes its stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRule {
    /// Episodes of an environment at its stage before it may change the stage.
    pub window: u32,
    /// The success rate at or above which it advances.
    pub promote: f64,
    /// The success rate at or below which it falls back.
    pub demote: f64,
    /// The fraction of episodes sampled from earlier stages.
    pub review: f64,
}

/// Sampling for learnability, p(1 − p).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnabilitySpec {
    /// The fraction of episodes sampled uniformly from all tasks.
    pub explore: f64,
    /// The decay of an outcome's weight with each later outcome of the task.
    pub keep: f64,
    /// The same for outcomes of all tasks of a level.
    pub keep_level: f64,
    /// The number of a task's outcomes that weigh as much as those of its level.
    pub prior: f64,
}

/// Prioritised level replay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplaySpec {
    /// The probability of selecting a task seen before.
    pub replay: f64,
    /// The fraction of all tasks that must have been seen before one is repeated.
    pub seen: f64,
    /// The weight of the previous score.
    pub keep: f64,
    /// The temperature of the ranks by score.
    pub temperature: f64,
    /// The fraction of the probability that depends on the time since a task was last run.
    pub staleness: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    name: String,
    #[serde(default)]
    #[allow(dead_code, reason = "for readers of the file")]
    description: String,
    /// The rule that selects the next task. Each other field belongs to one kind and is required there.
    kind: Kind,
    /// `manual`: the tasks of each stage, in order.
    stages: Option<Vec<Stage>>,
    /// `manual`: the episodes of an environment at a stage after which it may change the stage.
    window: Option<u32>,
    /// `manual`: the success rate in the window at or above which an environment advances.
    promote: Option<f64>,
    /// `manual`: the success rate in the window at or below which an environment falls back.
    demote: Option<f64>,
    /// `manual`: the fraction of episodes from earlier stages.
    review: Option<f64>,
    /// `learnability`: the fraction of episodes that are sampled uniformly from all tasks.
    explore: Option<f64>,
    /// `learnability`: the factor on the weight of a task's earlier outcomes with each new one. `replay`: the weight of
    /// the previous score.
    keep: Option<f64>,
    /// `learnability`: the same factor for outcomes of all tasks of a level.
    keep_level: Option<f64>,
    /// `learnability`: the number of a task's outcomes that weigh as much as those of its level.
    prior: Option<f64>,
    /// `replay`: the probability of selecting a task seen before.
    replay: Option<f64>,
    /// `replay`: the fraction of all tasks that must have been seen before one is repeated.
    seen: Option<f64>,
    /// `replay`: the temperature of the ranks by score.
    temperature: Option<f64>,
    /// `replay`: the fraction of the probability that depends on the time since a task was last run.
    staleness: Option<f64>,
}

/// A selector, or a list of selectors.
#[derive(Deserialize)]
#[serde(untagged, expecting = "want a selector, or a list of selectors")]
enum Stage {
    One(String),
    Several(Vec<String>),
}

impl Stage {
    fn parse(&self) -> Result<Vec<Selector>, String> {
        let texts = match self {
            Self::One(text) => std::slice::from_ref(text),
            Self::Several(texts) => texts,
        };
        if texts.is_empty() {
            return Err("at least one selector is required".into());
        }
        texts.iter().map(|text| Selector::parse(text).map_err(|e| e.to_string())).collect()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
/// A rule that selects tasks.
enum Kind {
    /// Uniform sampling of all tasks.
    Uniform,
    /// Manual stages; each environment changes its stage independently.
    Manual,
    /// Probability proportional to p(1 − p) with the success rate p of a task.
    Learnability,
    /// Prioritised level replay.
    Replay,
}

impl Document for Spec {
    type File = File;
    const KIND: &'static str = "curriculum";
    const FIELDS: &'static str = "docs/training.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("uniform", include_str!("../../../../../tasks/curricula/uniform.yaml")),
        ("manual", include_str!("../../../../../tasks/curricula/manual.yaml")),
        ("learnability", include_str!("../../../../../tasks/curricula/learnability.yaml")),
        ("replay", include_str!("../../../../../tasks/curricula/replay.yaml")),
    ];

    fn from_file(mut file: File) -> Result<Self, Flaw> {
        let method = file.method()?;
        if let Some(field) = file.rest() {
            let kind = format!("{:?}", file.kind).to_lowercase();
            return Err(Flaw::new(field, format!("a curriculum of kind {kind} has no such field")));
        }
        Ok(Self { name: file.name, method })
    }
}

vb_files::document!(Spec);

/// The value of a field, which must be there and lie within bounds.
fn within(value: &mut Option<f64>, field: &str, low: f64, high: f64) -> Result<f64, Flaw> {
    let value = value.take().ok_or_else(|| Flaw::new(field, "it is missing"))?;
    document::within(field, value, low, high)?;
    Ok(value)
}

impl File {
    /// Takes the fields of the kind.
    fn method(&mut self) -> Result<Method, Flaw> {
        Ok(match self.kind {
            Kind::Uniform => Method::Uniform,
            Kind::Manual => {
                let stages = self.stages.take().ok_or_else(|| Flaw::new("stages", "they are missing"))?;
                if stages.is_empty() {
                    return Err(Flaw::new("stages", "at least one stage is required"));
                }
                let parse = |(k, stage): (usize, &Stage)| {
                    stage.parse().map_err(|e| Flaw::new(format!("stages[{k}]"), e))
                };
                let window = self.window.take().ok_or_else(|| Flaw::new("window", "it is missing"))?;
                document::within("window", window, 1, 1000)?;
                let promote = within(&mut self.promote, "promote", 0.0, 1.0)?;
                let demote = within(&mut self.demote, "demote", -1.0, 1.0)?;
                if demote >= promote {
                    return Err(Flaw::must_be("demote", demote, &format!("less than promote, {promote}")));
                }
                let review = within(&mut self.review, "review", 0.0, 1.0)?;
                Method::Manual(ManualSpec {
                    stages: stages.iter().enumerate().map(parse).collect::<Result<_, _>>()?,
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
