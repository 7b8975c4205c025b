//! What all files of rules have in common, whatever is made by them: how they are read, and how their values are checked.
//!
//! The generator, sites and beds each have rules of their own. They are read here so that a flaw is told in the same words
//! in whichever of them it is: the field, its value, and what would be right.

use std::fmt::Display;

use serde::de::DeserializeOwned;
use vb_world::yaml;

/// Most nodes along a side of a world that is made.
pub(crate) const MOST_NODES: usize = 4097;

/// A flaw of a file of rules: the field, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {problem}")]
pub struct ParamsError {
    /// The field, e.g. `elevation.std.low`.
    pub field: String,
    /// The value, and what would be right.
    pub problem: String,
}

pub(crate) fn flaw(field: impl Into<String>, problem: impl Into<String>) -> ParamsError {
    ParamsError { field: field.into(), problem: problem.into() }
}

/// Rules that stand in a file.
pub(crate) trait Rules: DeserializeOwned {
    /// The version of the file's format that this build reads.
    const SCHEMA: u32;

    /// The version that the file says it has.
    fn schema(&self) -> u32;

    /// Whether the values make sense, which their types alone don't say; the first flaw if they don't.
    fn check(&self) -> Result<(), ParamsError>;
}

/// Reads rules from YAML and checks them; the first flaw if there is one.
pub(crate) fn parse<R: Rules>(text: &str) -> Result<R, ParamsError> {
    let rules: R = yaml::parse(text).map_err(|e| flaw(e.field, e.problem))?;
    let (schema, own) = (rules.schema(), R::SCHEMA);
    if schema != own {
        let problem = format!("version {schema} is not supported, this build reads version {own}");
        return Err(flaw("schema", problem));
    }
    rules.check()?;
    Ok(rules)
}

/// Rules whose text is part of the program. Tests parse them all, so they have no flaw.
pub(crate) fn built_in<R: Rules>(text: &str) -> R {
    parse(text).unwrap_or_else(|e| unreachable!("built-in rules: {e}"))
}

/// Whether a value lies between two others, both included. NaN doesn't.
pub(crate) fn within<T: PartialOrd + Display>(
    field: &str,
    value: T,
    low: T,
    high: T,
) -> Result<(), ParamsError> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(flaw(field, format!("{value} must lie in {low} to {high}")))
}

/// Whether a pair of values, the lower first, lies between two others.
pub(crate) fn range_within(
    field: &str,
    [lower, upper]: [f64; 2],
    low: f64,
    high: f64,
) -> Result<(), ParamsError> {
    within(&format!("{field}[0]"), lower, low, high)?;
    within(&format!("{field}[1]"), upper, lower, high)
}

/// A square of ground by its lengths, m: its side is so many patches, and the side of a patch so many distances between nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    /// Between nodes.
    pub(crate) resolution: f64,
    /// Side of a patch.
    pub(crate) patch: f64,
    /// Side of the square.
    pub(crate) side: f64,
}

impl Square {
    /// Whether each is a length and divides the next. Before their names in messages stands a prefix such as `bed.`.
    pub(crate) fn check(self, prefix: &str) -> Result<(), ParamsError> {
        let Self { resolution, patch, side } = self;
        let lengths = [("resolution", resolution), ("patch", patch), ("side", side)];
        for (name, length) in lengths {
            within(&format!("{prefix}{name}"), length, 1e-3, 1e5)?;
        }
        for ((below, small), (name, large)) in [(lengths[0], lengths[1]), (lengths[1], lengths[2])] {
            if whole(large / small).is_none() {
                let problem = format!("{large} must be a multiple of {prefix}{below}, {small}");
                return Err(flaw(format!("{prefix}{name}"), problem));
            }
        }
        Ok(())
    }

    /// Nodes along a side.
    pub(crate) fn nodes(self) -> usize {
        // Each ratio is a whole number but for rounding, and so their product may be farther from one than either.
        self.patches() * whole(self.patch / self.resolution).unwrap_or(1) + 1
    }

    /// Patches along a side.
    pub(crate) fn patches(self) -> usize {
        whole(self.side / self.patch).unwrap_or(1)
    }
}

/// A ratio that is a whole number but for rounding, at least 1.
fn whole(ratio: f64) -> Option<usize> {
    let n = ratio.round();
    (n >= 1.0 && (ratio - n).abs() < 1e-9 * n).then_some(n as usize)
}
