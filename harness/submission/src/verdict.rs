//! What a verification found: `verification.json`.

use serde::{Deserialize, Serialize};

use crate::Division;

/// Version of the layout of a verdict.
pub const VERIFICATION_SCHEMA: u32 = 1;

/// Something that isn't so.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// The check that found it, one of [`Verification::CHECKS`].
    pub check: String,
    /// File, and field or task.
    pub place: String,
    /// What it says, and what it should.
    pub text: String,
}

impl Finding {
    pub(crate) fn new(check: &str, place: impl Into<String>, text: impl std::fmt::Display) -> Self {
        // Texts of strangers end up here, and from here in comments and pages.
        let cut = |s: &str| vb_report::one_line(s, 300);
        Self { check: check.into(), place: cut(&place.into()), text: cut(&text.to_string()) }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}: {}", self.check, self.place, self.text)
    }
}

/// Which tasks were driven again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleTaken {
    /// Seed that drew them; none if all were.
    pub seed: Option<u64>,
    /// Number of tasks of the submission.
    pub of: u64,
    /// The tasks, by name.
    pub tasks: Vec<String>,
}

/// A verdict on a submission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verification {
    /// [`VERIFICATION_SCHEMA`].
    pub schema: u32,
    /// Version of the harness that verified.
    pub harness_version: String,
    /// Whether nothing was found.
    pub verified: bool,
    /// SHA-256 of `submission.json`, which states those of all other files.
    pub submission_sha256: String,
    /// SHA-256 of the plugin that was driven.
    pub plugin_sha256: String,
    /// Hash of the suite.
    pub suite_hash: String,
    /// The division by the rules.
    pub division: Division,
    /// The checks that were made, in order.
    pub checks: Vec<String>,
    /// What was found.
    pub findings: Vec<Finding>,
    /// What was driven again; none if that was not come to, since something was found before.
    pub sample: Option<SampleTaken>,
}

impl Verification {
    /// All checks, in the order in which they are made.
    pub const CHECKS: [&str; 12] = [
        "files", "run", "suite", "plugin", "vehicle", "rules", "limits", "tasks", "summary", "report",
        "division", "rerun",
    ];
}
