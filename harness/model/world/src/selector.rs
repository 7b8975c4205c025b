//! Choosing tasks of a suite by a short text.
//!
//! A selector is a list of conditions separated by commas. A condition is either `key=value` with the keys `elevation`
//! (low, medium, high), `terrain` (rigid, deformable, mixed) and `density` (sparse, medium, dense), or names worlds,
//! optionally with tasks (`w001`, `w001-w010`, `w*`, `*`, each with `/t03`, `/t00-t04`, `/*`). All names together count as
//! one key. A task is chosen if, of each key that occurs, any condition holds: conditions of one key are alternatives,
//! different keys must hold together.

use crate::{Density, Elevation, Suite, TaskId, Terrain, WorldInfo};

/// The reason why a selector cannot be used. Each message names the condition and what there is.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectorError {
    /// The text is not a selector.
    #[error("task selector: {condition:?}: {problem}")]
    Syntax {
        /// The condition in the selector.
        condition: String,
        /// The problem with the condition.
        problem: String,
    },
    /// A condition names a world or task that the suite does not have.
    #[error("task selector: {condition:?}: no {kind} {name:?} in suite {suite:?}; there are {known}")]
    Unknown {
        /// The condition in the selector.
        condition: String,
        /// The kind of what it names: `world` or `task`.
        kind: &'static str,
        /// The name that the suite does not have.
        name: String,
        /// The name of the suite.
        suite: String,
        /// The names that there are.
        known: String,
    },
    /// A condition, or the whole selector, chooses no task.
    #[error("task selector: {text:?} matches none of the {tasks} tasks of suite {suite:?}; it has {known}")]
    NoMatch {
        /// The condition, or the selector if each of its conditions chooses a task.
        text: String,
        /// The number of tasks in the suite.
        tasks: usize,
        /// The name of the suite.
        suite: String,
        /// The levels, grounds and densities that there are.
        known: String,
    },
}

/// How conditions are joined, for messages.
const JOINED: &str = " (commas separate conditions: different keys must hold together, as in elevation=high,terrain=rigid; \
                      values of one key are alternatives, as in elevation=low,elevation=medium)";

/// A parsed selector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selector {
    text: String,
    conditions: Vec<Condition>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Condition {
    text: String,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind {
    Elevation(Elevation),
    Terrain(Terrain),
    Density(Density),
    Names { worlds: Names, tasks: Names },
}

/// A set of ids, in the order of the suite.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Names {
    /// All that begin so.
    Prefix(String),
    One(String),
    /// From one to another, both included.
    Range(String, String),
}

/// Whether each task of each world of a suite is chosen.
type Chosen = Vec<Vec<bool>>;

impl Default for Selector {
    /// Every task.
    fn default() -> Self {
        let all = || Names::Prefix(String::new());
        let kind = Kind::Names { worlds: all(), tasks: all() };
        Self { text: "*".into(), conditions: vec![Condition { text: "*".into(), kind }] }
    }
}

impl Selector {
    /// Parses a selector.
    ///
    /// # Errors
    /// Returns an error if a condition is empty or has an unknown key or value.
    pub fn parse(text: &str) -> Result<Self, SelectorError> {
        let conditions = text.split(',').map(|c| Condition::parse(c.trim())).collect::<Result<_, _>>()?;
        Ok(Self { text: text.into(), conditions })
    }

    /// The tasks that the selector chooses, in the order of the suite, none twice.
    ///
    /// # Errors
    /// Returns an error if a condition names a world or task that the suite does not have, and if a condition alone or all together
    /// choose nothing.
    pub fn select(&self, suite: &Suite) -> Result<Vec<TaskId>, SelectorError> {
        let mut by_key: [Option<Chosen>; Kind::KEYS] = [const { None }; Kind::KEYS];
        for condition in &self.conditions {
            let own = condition.matches(suite)?;
            match &mut by_key[condition.kind.key()] {
                None => by_key[condition.kind.key()] = Some(own),
                Some(chosen) => combine(chosen, &own, |a, b| a || b),
            }
        }
        let keys = by_key.into_iter().flatten();
        let chosen = keys.reduce(|mut all, key| {
            combine(&mut all, &key, |a, b| a && b);
            all
        });
        let worlds = suite.worlds().iter().zip(chosen.unwrap_or_default());
        let tasks: Vec<TaskId> = worlds
            .flat_map(|(w, flags)| {
                w.task_ids().zip(flags).filter(|(_, chosen)| *chosen).map(|(task, _)| task)
            })
            .collect();
        if tasks.is_empty() { Err(no_match(&self.text, suite)) } else { Ok(tasks) }
    }
}

/// Combines two choices task by task.
fn combine(chosen: &mut Chosen, other: &Chosen, how: impl Fn(bool, bool) -> bool) {
    for (a, b) in chosen.iter_mut().flatten().zip(other.iter().flatten()) {
        *a = how(*a, *b);
    }
}

fn no_match(text: &str, suite: &Suite) -> SelectorError {
    let w = suite.worlds();
    let part = |key: &str, all: [&'static str; 3], has: &dyn Fn(&str) -> bool| {
        let present: Vec<_> = all.into_iter().filter(|v| has(v)).collect();
        format!("{key}={}", present.join("|"))
    };
    let known = [
        part("elevation", Elevation::ALL.map(Elevation::name), &|v| {
            w.iter().any(|i| i.elevation.name() == v)
        }),
        part("terrain", Terrain::ALL.map(Terrain::name), &|v| w.iter().any(|i| i.terrain.name() == v)),
        part("density", Density::ALL.map(Density::name), &|v| w.iter().any(|i| i.density.name() == v)),
    ];
    SelectorError::NoMatch {
        text: text.into(),
        tasks: suite.task_count(),
        suite: suite.meta().name.clone(),
        known: known.join(", "),
    }
}

impl Condition {
    fn parse(text: &str) -> Result<Self, SelectorError> {
        let syntax = |problem: String| SelectorError::Syntax { condition: text.into(), problem };
        if text.contains(':') {
            return Err(syntax(format!(
                "write {:?}, with commas instead of colons{JOINED}",
                text.replace(':', ",")
            )));
        }
        Ok(Self { text: text.into(), kind: Kind::parse(text).map_err(syntax)? })
    }

    /// The tasks for which the condition holds.
    fn matches(&self, suite: &Suite) -> Result<Chosen, SelectorError> {
        let all = |keep: &dyn Fn(&WorldInfo) -> bool| {
            suite.worlds().iter().map(|w| vec![keep(w); w.tasks.len()]).collect::<Chosen>()
        };
        let chosen = match &self.kind {
            Kind::Elevation(v) => all(&|w| w.elevation == *v),
            Kind::Terrain(v) => all(&|w| w.terrain == *v),
            Kind::Density(v) => all(&|w| w.density == *v),
            Kind::Names { worlds, tasks } => self.named(suite, worlds, tasks)?,
        };
        if chosen.iter().flatten().any(|c| *c) { Ok(chosen) } else { Err(no_match(&self.text, suite)) }
    }

    /// The tasks of these names in the worlds of these names.
    fn named(&self, suite: &Suite, worlds: &Names, tasks: &Names) -> Result<Chosen, SelectorError> {
        let ids: Vec<_> = suite.worlds().iter().map(|w| w.id.as_str()).collect();
        let unknown = |kind, name: String, known: &[&str]| SelectorError::Unknown {
            condition: self.text.clone(),
            kind,
            name,
            suite: suite.meta().name.clone(),
            known: crate::format::list(known),
        };
        let named = worlds.find(&ids).map_err(|name| unknown("world", name, &ids))?;
        let mut chosen: Chosen = suite.worlds().iter().map(|w| vec![false; w.tasks.len()]).collect();
        let mut missing = None;
        let mut found = false;
        for k in named {
            let ids: Vec<_> = suite.worlds()[k].tasks.iter().map(String::as_str).collect();
            // Of several worlds some may lack the task; it must exist in one.
            match tasks.find(&ids) {
                Ok(these) => {
                    these.into_iter().for_each(|t| chosen[k][t] = true);
                    found = true;
                }
                Err(name) => {
                    missing.get_or_insert_with(|| unknown("task", name, &ids));
                }
            }
        }
        match missing {
            Some(error) if !found => Err(error),
            _ => Ok(chosen),
        }
    }
}

impl Kind {
    /// The number of keys.
    const KEYS: usize = 4;

    /// The index of the key; all names are of one key.
    fn key(&self) -> usize {
        match self {
            Self::Elevation(_) => 0,
            Self::Terrain(_) => 1,
            Self::Density(_) => 2,
            Self::Names { .. } => 3,
        }
    }

    /// Parses a condition; an error is the problem with it.
    fn parse(text: &str) -> Result<Self, String> {
        let Some((key, value)) = text.split_once('=') else {
            let (worlds, tasks) = text.split_once('/').unwrap_or((text, "*"));
            let names = |text: &str| {
                Names::parse(text).ok_or_else(|| {
                    format!("{text:?} names nothing: write w001, w001-w010, w001/t03, w*/t00 or elevation=high{JOINED}")
                })
            };
            return Ok(Self::Names { worlds: names(worlds)?, tasks: names(tasks)? });
        };
        let (key, value) = (key.trim(), value.trim());
        let unknown = |all: [&str; 3]| format!("{value:?} is no {key}: use {}{JOINED}", all.join(", "));
        match key {
            "elevation" => Elevation::ALL
                .into_iter()
                .find(|v| v.name() == value)
                .map(Self::Elevation)
                .ok_or_else(|| unknown(Elevation::ALL.map(Elevation::name))),
            "terrain" => Terrain::ALL
                .into_iter()
                .find(|v| v.name() == value)
                .map(Self::Terrain)
                .ok_or_else(|| unknown(Terrain::ALL.map(Terrain::name))),
            "density" => Density::ALL
                .into_iter()
                .find(|v| v.name() == value)
                .map(Self::Density)
                .ok_or_else(|| unknown(Density::ALL.map(Density::name))),
            _ => Err(format!("{key:?} is no key: use elevation, terrain or density{JOINED}")),
        }
    }
}

impl Names {
    /// None if the text cannot name anything.
    fn parse(text: &str) -> Option<Self> {
        let is_id = |s: &str| crate::check::check_id(s).is_ok();
        if let Some(prefix) = text.strip_suffix('*') {
            return (prefix.is_empty() || is_id(prefix)).then(|| Self::Prefix(prefix.into()));
        }
        if let Some((first, last)) = text.split_once('-') {
            return (is_id(first) && is_id(last)).then(|| Self::Range(first.into(), last.into()));
        }
        is_id(text).then(|| Self::One(text.into()))
    }

    /// Indices of the ids it names; an error is a name that does not exist.
    fn find(&self, ids: &[&str]) -> Result<Vec<usize>, String> {
        let position = |name: &str| ids.iter().position(|id| *id == name).ok_or_else(|| name.to_owned());
        match self {
            Self::One(name) => Ok(vec![position(name)?]),
            Self::Range(first, last) => {
                let (a, b) = (position(first)?, position(last)?);
                Ok((a.min(b)..=a.max(b)).collect())
            }
            Self::Prefix(prefix) => {
                let found: Vec<_> = (0..ids.len()).filter(|&k| ids[k].starts_with(prefix.as_str())).collect();
                if found.is_empty() && !prefix.is_empty() { Err(format!("{prefix}*")) } else { Ok(found) }
            }
        }
    }
}
