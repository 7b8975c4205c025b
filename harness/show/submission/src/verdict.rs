//! The findings of a verification: `verification.json`.

use serde::{Deserialize, Serialize};
use vb_world::TaskId;

use crate::Division;

pub const VERIFICATION_SCHEMA: u32 = 1;

/// The number of leaves of two documents whose differences become findings.
pub(crate) const DIFFERENCES: usize = 20;

/// A part of a submission that is verified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Check {
    /// The files: names, sizes and SHA-256.
    Files,
    /// The description of the run.
    Run,
    /// The suite.
    Suite,
    /// The plugin's file and metadata.
    Plugin,
    /// The vehicle and the soils.
    Vehicle,
    /// The perception profile.
    Perception,
    /// The rules.
    Rules,
    /// The limits on the planner.
    Limits,
    /// The records of the tasks.
    Tasks,
    /// The figures that follow from the records.
    Summary,
    /// The HTML report.
    Report,
    /// The division by the rules.
    Division,
    /// The tasks that are re-run.
    Rerun,
}

impl Check {
    /// All checks, in the order in which they are made.
    pub const ALL: [Self; 13] = [
        Self::Files,
        Self::Run,
        Self::Suite,
        Self::Plugin,
        Self::Vehicle,
        Self::Perception,
        Self::Rules,
        Self::Limits,
        Self::Tasks,
        Self::Summary,
        Self::Report,
        Self::Division,
        Self::Rerun,
    ];

    /// The name of the check in files, messages and pages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Files => "files",
            Self::Run => "run",
            Self::Suite => "suite",
            Self::Plugin => "plugin",
            Self::Vehicle => "vehicle",
            Self::Perception => "perception",
            Self::Rules => "rules",
            Self::Limits => "limits",
            Self::Tasks => "tasks",
            Self::Summary => "summary",
            Self::Report => "report",
            Self::Division => "division",
            Self::Rerun => "rerun",
        }
    }
}

/// An incorrect statement of a submission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// The check that reported it.
    pub check: Check,
    /// The file, and the field or task in it.
    pub place: String,
    /// The value in the submission and the correct value, as text.
    pub text: String,
}

impl Finding {
    pub(crate) fn new(check: Check, place: impl Into<String>, text: impl std::fmt::Display) -> Self {
        // Texts of strangers end up here, and from here in comments and pages.
        let cut = |s: &str| vb_report::one_line(s, 300);
        Self { check, place: cut(&place.into()), text: cut(&text.to_string()) }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}: {}", self.check.name(), self.place, self.text)
    }
}

/// What was found, so far as it is kept: a stranger's file can be wrong in a million places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Findings {
    kept: Vec<Finding>,
    more: u64,
}

impl Findings {
    /// Findings that are kept at most.
    pub(crate) const MOST: usize = 100;

    pub(crate) fn push(&mut self, finding: Finding) {
        self.push_with(|| finding);
    }

    /// The same of a finding that is made only if it is kept.
    pub(crate) fn push_with(&mut self, finding: impl FnOnce() -> Finding) {
        if self.kept.len() < Self::MOST {
            self.kept.push(finding());
        } else {
            self.more += 1;
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Finding> {
        self.kept.iter()
    }

    /// Those that are kept, and the number of the others.
    pub(crate) fn into_parts(self) -> (Vec<Finding>, u64) {
        (self.kept, self.more)
    }
}

/// The sample of re-run tasks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleTaken {
    /// The seed of the sample; `None` if all tasks were re-run.
    pub seed: Option<u64>,
    /// The number of tasks of the submission.
    pub of: u64,
    /// The tasks of the sample, in order.
    pub tasks: Vec<TaskId>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verification {
    /// The version of the layout, [`VERIFICATION_SCHEMA`].
    pub schema: u32,
    /// The version of the harness that verified.
    pub harness_version: String,
    /// Whether there are no findings.
    pub verified: bool,
    /// The SHA-256 of `submission.json`, which states those of all other files.
    pub submission_sha256: String,
    /// The SHA-256 of the plugin that was run.
    pub plugin_sha256: String,
    /// The content hash of the suite.
    pub suite_hash: String,
    /// The division according to the conditions.
    pub division: Division,
    /// The checks that were made, in order.
    pub checks: Vec<Check>,
    /// The findings, at most a hundred.
    pub findings: Vec<Finding>,
    /// The number of further findings.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub more_findings: u64,
    /// The re-run tasks; `None` if there were findings before the re-run.
    pub sample: Option<SampleTaken>,
}

fn is_zero(n: &u64) -> bool {
    *n == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files_and_each_check_is_listed_once_in_order() {
        for check in Check::ALL {
            assert_eq!(serde_json::to_value(check).unwrap(), check.name());
        }
        assert!(Check::ALL.is_sorted_by(|a, b| a < b));
        assert!(serde_json::from_value::<Check>("file".into()).is_err());
    }
}
