//! Choosing tasks of a suite by a short text.
//!
//! A selector is a list of items separated by commas; a task is chosen if any item chooses it. An item is a list of
//! conditions separated by colons; all must hold. A condition is either worlds, optionally with tasks
//! (`w001`, `w001-w010`, `w*`, `*`, each with `/t03`, `/t00-t04`, `/*`), or `key=value` with the keys `elevation`
//! (low, medium, high), `terrain` (rigid, deformable, mixed) and `density` (sparse, medium, dense).

use crate::{Density, Elevation, Suite, Terrain, WorldInfo};
use std::fmt;

/// Names one task of a suite.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TaskRef {
    /// The world's id.
    pub world: String,
    /// The task's id within the world.
    pub task: String,
}

impl fmt::Display for TaskRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.world, self.task)
    }
}

/// The reason why a selector cannot be used. Each message names the item and what there is.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectorError {
    /// The text is not a selector.
    #[error("task selector: {item:?}: {problem}")]
    Syntax {
        /// The item of the selector.
        item: String,
        /// The problem with the item.
        problem: String,
    },
    /// An item names a world or task that the suite does not have.
    #[error("task selector: {item:?}: no {kind} {name:?} in suite {suite:?}; there are {known}")]
    Unknown {
        /// The item of the selector.
        item: String,
        /// The kind of what it names: `world` or `task`.
        kind: &'static str,
        /// The name that the suite does not have.
        name: String,
        /// The name of the suite.
        suite: String,
        /// The names that there are.
        known: String,
    },
    /// An item chooses no task.
    #[error("task selector: {item:?} matches none of the {tasks} tasks of suite {suite:?}; it has {known}")]
    NoMatch {
        /// The item of the selector.
        item: String,
        /// The number of tasks in the suite.
        tasks: usize,
        /// The name of the suite.
        suite: String,
        /// The levels, grounds and densities that there are.
        known: String,
    },
}

/// How conditions are joined, for messages.
const JOINED: &str = " (a colon joins conditions that must all hold, as in elevation=high:terrain=rigid, a comma alternatives)";

/// A parsed selector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selector {
    items: Vec<Item>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Item {
    text: String,
    conditions: Vec<Condition>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Condition {
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

impl Default for Selector {
    /// Every task.
    fn default() -> Self {
        let all = || Names::Prefix(String::new());
        let conditions = vec![Condition::Names { worlds: all(), tasks: all() }];
        Self { items: vec![Item { text: "*".into(), conditions }] }
    }
}

impl Selector {
    /// Parses a selector.
    ///
    /// # Errors
    /// Returns an error if an item is empty or has an unknown key or value.
    pub fn parse(text: &str) -> Result<Self, SelectorError> {
        let items = text.split(',').map(|item| Item::parse(item.trim())).collect::<Result<_, _>>()?;
        Ok(Self { items })
    }

    /// A sentence for users who may have meant both of two conditions where the selector takes either: it has items on different things,
    /// of which one is a level. `chosen` is the number of tasks that it chooses, of `all`.
    #[must_use]
    pub fn note(&self, chosen: usize, all: usize) -> Option<String> {
        let keys = |item: &Item| {
            item.conditions.iter().map(Condition::key).collect::<std::collections::BTreeSet<_>>()
        };
        let levels = |item: &Item| item.conditions.iter().any(|c| c.key() != "worlds");
        let (a, b) = self.items.iter().enumerate().find_map(|(k, a)| {
            let other =
                self.items[k + 1..].iter().find(|b| keys(b) != keys(a) && (levels(a) || levels(b)))?;
            Some((a, other))
        })?;
        let items: Vec<&str> = self.items.iter().map(|item| item.text.as_str()).collect();
        Some(format!(
            "{chosen} of {all} tasks (any of {}; for both write {}:{})",
            items.join(", "),
            a.text,
            b.text
        ))
    }

    /// The tasks that the selector chooses, in the order of the suite, none twice.
    ///
    /// # Errors
    /// Returns an error if an item names a world or task that the suite does not have, or chooses nothing.
    pub fn select(&self, suite: &Suite) -> Result<Vec<TaskRef>, SelectorError> {
        let mut chosen: Vec<Vec<bool>> = suite.worlds().iter().map(|w| vec![false; w.tasks.len()]).collect();
        for item in &self.items {
            let mut any = false;
            for (flags, tasks) in chosen.iter_mut().zip(item.matches(suite)?) {
                for t in tasks {
                    flags[t] = true;
                    any = true;
                }
            }
            if !any {
                return Err(item.no_match(suite));
            }
        }
        let worlds = suite.worlds().iter().zip(chosen);
        Ok(worlds
            .flat_map(|(w, flags)| {
                let tasks = w.tasks.iter().zip(flags).filter(|(_, chosen)| *chosen);
                tasks.map(|(t, _)| TaskRef { world: w.id.clone(), task: t.clone() })
            })
            .collect())
    }
}

impl Item {
    fn parse(text: &str) -> Result<Self, SelectorError> {
        let conditions =
            text.split(':').map(|c| Condition::parse(text, c.trim())).collect::<Result<_, _>>()?;
        Ok(Self { text: text.into(), conditions })
    }

    /// Indices of the chosen tasks of each world.
    fn matches(&self, suite: &Suite) -> Result<Vec<Vec<usize>>, SelectorError> {
        let mut sets: Vec<Vec<usize>> = suite.worlds().iter().map(|w| (0..w.tasks.len()).collect()).collect();
        for condition in &self.conditions {
            let keep = |w: &WorldInfo| match condition {
                Condition::Elevation(v) => w.elevation == *v,
                Condition::Terrain(v) => w.terrain == *v,
                Condition::Density(v) => w.density == *v,
                Condition::Names { .. } => true,
            };
            for (set, w) in sets.iter_mut().zip(suite.worlds()) {
                if !keep(w) {
                    set.clear();
                }
            }
            if let Condition::Names { worlds, tasks } = condition {
                self.keep_names(suite, worlds, tasks, &mut sets)?;
            }
        }
        Ok(sets)
    }

    fn keep_names(
        &self,
        suite: &Suite,
        worlds: &Names,
        tasks: &Names,
        sets: &mut [Vec<usize>],
    ) -> Result<(), SelectorError> {
        let ids: Vec<_> = suite.worlds().iter().map(|w| w.id.as_str()).collect();
        let unknown = |kind, name: String, known: &[&str]| SelectorError::Unknown {
            item: self.text.clone(),
            kind,
            name,
            suite: suite.meta().name.clone(),
            known: crate::format::list(known),
        };
        let named = worlds.find(&ids).map_err(|name| unknown("world", name, &ids))?;
        let mut missing = None;
        let mut found = false;
        for (k, (set, w)) in sets.iter_mut().zip(suite.worlds()).enumerate() {
            if !named.contains(&k) {
                set.clear();
                continue;
            }
            let ids: Vec<_> = w.tasks.iter().map(String::as_str).collect();
            // Of several worlds some may lack the task; it must exist in one.
            match tasks.find(&ids) {
                Ok(these) => {
                    set.retain(|t| these.contains(t));
                    found = true;
                }
                Err(name) => {
                    set.clear();
                    missing.get_or_insert_with(|| unknown("task", name, &ids));
                }
            }
        }
        match missing {
            Some(error) if !found => Err(error),
            _ => Ok(()),
        }
    }

    fn no_match(&self, suite: &Suite) -> SelectorError {
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
            item: self.text.clone(),
            tasks: suite.task_count(),
            suite: suite.meta().name.clone(),
            known: known.join(", "),
        }
    }
}

impl Condition {
    /// What it is about.
    fn key(&self) -> &'static str {
        match self {
            Self::Elevation(_) => "elevation",
            Self::Terrain(_) => "terrain",
            Self::Density(_) => "density",
            Self::Names { .. } => "worlds",
        }
    }

    fn parse(item: &str, text: &str) -> Result<Self, SelectorError> {
        let syntax = |problem: String| SelectorError::Syntax { item: item.into(), problem };
        let Some((key, value)) = text.split_once('=') else {
            let (worlds, tasks) = text.split_once('/').unwrap_or((text, "*"));
            let names = |text: &str| {
                Names::parse(text).ok_or_else(|| {
                    syntax(format!(
                        "{text:?} names nothing: write w001, w001-w010, w001/t03, w*/t00 or elevation=high{JOINED}"
                    ))
                })
            };
            return Ok(Self::Names { worlds: names(worlds)?, tasks: names(tasks)? });
        };
        let (key, value) = (key.trim(), value.trim());
        let unknown =
            |all: [&str; 3]| syntax(format!("{value:?} is no {key}: use {}{JOINED}", all.join(", ")));
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
            _ => Err(syntax(format!("{key:?} is no key: use elevation, terrain or density{JOINED}"))),
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
