//! The findings of the checks.

use std::collections::BTreeMap;

use serde::Serialize;
use vb_host::Metadata;

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The planner keeps the promise.
    Pass,
    /// The planner keeps the promise, but its author should look at something.
    Warn,
    /// The planner breaks the promise.
    Fail,
    /// It can't be told whether the planner keeps the promise, or the promise doesn't apply to it.
    Skip,
}

impl Verdict {
    /// The name of the verdict in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Warn => "warn",
            Self::Fail => "fail",
            Self::Skip => "skip",
        }
    }
}

/// One promise and whether the planner keeps it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The stable name of the check, e.g. `determinism`.
    pub name: &'static str,
    /// The verdict of the check.
    pub verdict: Verdict,
    /// A line on what was seen.
    pub detail: String,
    /// A line on what to do, unless the check passed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<&'static str>,
    /// The figures by name, e.g. `p99_fraction`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub figures: BTreeMap<&'static str, f64>,
}

impl Check {
    pub(super) fn new(name: &'static str, verdict: Verdict, detail: impl Into<String>) -> Self {
        Self { name, verdict, detail: detail.into(), hint: None, figures: BTreeMap::new() }
    }

    pub(super) fn pass(name: &'static str, detail: impl Into<String>) -> Self {
        Self::new(name, Verdict::Pass, detail)
    }

    pub(super) fn skip(name: &'static str, detail: impl Into<String>) -> Self {
        Self::new(name, Verdict::Skip, detail)
    }

    pub(super) fn fail(name: &'static str, detail: impl Into<String>, hint: &'static str) -> Self {
        Self::new(name, Verdict::Fail, detail).hint(hint)
    }

    pub(super) fn warn(name: &'static str, detail: impl Into<String>, hint: &'static str) -> Self {
        Self::new(name, Verdict::Warn, detail).hint(hint)
    }

    pub(super) fn hint(mut self, hint: &'static str) -> Self {
        self.hint = Some(hint);
        self
    }

    pub(super) fn figure(mut self, name: &'static str, value: f64) -> Self {
        self.figures.insert(name, value);
        self
    }
}

/// All checks of a planner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The planner's metadata; `None` if it can't be loaded.
    pub planner: Option<Metadata>,
    /// The checks in the order in which they were made.
    pub checks: Vec<Check>,
}

impl Report {
    /// Tells whether no check failed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.count(Verdict::Fail) == 0
    }

    /// The number of checks that ended with this verdict.
    #[must_use]
    pub fn count(&self, verdict: Verdict) -> usize {
        self.checks.iter().filter(|check| check.verdict == verdict).count()
    }
}
