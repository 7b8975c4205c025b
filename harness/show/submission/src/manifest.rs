//! The manifest of a submission: `submission.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vb_host::Limits;
use vb_record::RunHeader;
use vb_score::{Group, Outcome, Rules, TaskRecord};
use vb_world::TaskId;

use crate::SubmissionError;
use crate::division::{Division, OpenReason};

pub const SUBMISSION_SCHEMA: u32 = 1;

/// The entrant's description of themselves. It is shown but not checked, and affects no result.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entrant {
    /// The name of the person, team or institute.
    pub name: String,
    /// The address of a web page; `https://` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// The address of the planner's source; `https://` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The address of a paper on it; `https://` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<String>,
    /// A short description of the planner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Entrant {
    /// Checks that all fields can be shown.
    ///
    /// # Errors
    /// Returns [`SubmissionError::Entrant`] with the first field that can't be shown.
    pub fn check(&self) -> Result<(), SubmissionError> {
        let field = |field, text: &str, most: usize| {
            let fail = |problem: String| Err(SubmissionError::Entrant { field, problem });
            if text.chars().count() > most {
                return fail(format!("longer than {most} characters"));
            }
            if text.chars().any(char::is_control) {
                return fail("contains a control character (give one line)".into());
            }
            // Two names that look alike, or one that turns the text around it, would mislead whoever reads a board.
            if vb_files::printable(text) != text {
                return fail(
                    "contains an invisible character, or one that changes the writing direction".into(),
                );
            }
            Ok(())
        };
        field("entrant", &self.name, 80)?;
        field("note", self.note.as_deref().unwrap_or_default(), 500)?;
        for (name, url) in [("url", &self.url), ("code", &self.code), ("paper", &self.paper)] {
            let Some(url) = url else { continue };
            field(name, url, 200)?;
            let odd = |b: u8| !b.is_ascii_graphic() || matches!(b, b'"' | b'\'' | b'<' | b'>' | b'\\');
            if url.bytes().any(odd) || !url.starts_with("https://") {
                return Err(SubmissionError::Entrant {
                    field: name,
                    problem: format!("{url:?} does not begin with https://"),
                });
            }
        }
        Ok(())
    }
}

/// A submission's entry for a task; the run's records contain the same data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskEntry {
    pub outcome: Outcome,
    /// The simulated time at the end of the task, s.
    pub time_s: f64,
    /// The hash over the trajectory (`docs/results.md`).
    pub state_hash: String,
}

impl From<&TaskRecord> for TaskEntry {
    fn from(r: &TaskRecord) -> Self {
        Self { outcome: r.outcome, time_s: r.time_s, state_hash: r.state_hash.clone() }
    }
}

/// The content of a submission. Every field but [`Manifest::INFORMATIONAL`] is checked by [`verify`](crate::verify).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The version of the layout, [`SUBMISSION_SCHEMA`].
    pub schema: u32,
    pub entrant: Entrant,
    pub division: Division,
    /// The reasons for the open division; empty for the others.
    pub open_because: Vec<OpenReason>,
    /// The version of the planner interface that the plugin uses.
    pub abi: String,
    /// The version of the suite, from its file.
    pub suite_version: String,
    /// The settings of the run: harness, suite, plugin, parameters, vehicle, soils, scale, seed, rules, limits. As in
    /// the run's `run.json`, but without paths, which are private; `trace` is `none` if no trace is included.
    pub run: RunHeader,
    /// The figures over all tasks: `all` of the summary.
    pub results: Option<Group>,
    /// The tasks whose traces are included for replays. The verification always re-runs them.
    pub replays: Vec<TaskId>,
    /// The result of each task.
    pub tasks: BTreeMap<TaskId, TaskEntry>,
    /// The SHA-256 (hexadecimal) of every other file, by its name.
    pub files: BTreeMap<String, String>,
}

impl Manifest {
    /// The fields (dotted paths, or beginnings of such that end in a dot) that inform people and decide nothing: they
    /// are not checked. The sandbox is that of the machine on which a native planner ran.
    pub const INFORMATIONAL: [&str; 4] =
        ["entrant.", "run.started_at", "run.harness_commit", "run.plugin.sandbox."];

    /// The rules of the run.
    ///
    /// # Errors
    /// Returns a text on what is wrong if they are not valid rules.
    pub fn rules(&self) -> Result<Rules, String> {
        // JSON is YAML; this way every value is checked.
        let text = self.run.rules.profile.to_string();
        Rules::parse(&text, "run.rules.profile").map_err(|e| e.to_string())
    }

    /// The limits of the run. Missing ones have their defaults.
    ///
    /// # Errors
    /// Returns a text on what is wrong if they are not valid limits.
    pub fn limits(&self) -> Result<Limits, String> {
        let value = |(name, value): (&String, &u64)| {
            let value = match (name.as_str(), value) {
                ("wasm_watchdog", 0) => false.into(),
                ("wasm_watchdog", 1) => true.into(),
                _ => serde_json::Value::from(*value),
            };
            (name.clone(), value)
        };
        let object: serde_json::Map<_, _> = self.run.limits.iter().map(value).collect();
        let limits: Limits =
            serde_json::from_value(object.into()).map_err(|e: serde_json::Error| e.to_string())?;
        limits.validate().map_err(|e| e.to_string())?;
        Ok(limits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_a_run_lacks_has_its_default_and_an_unknown_one_is_refused() {
        let text = include_str!("../../../../tests/fuzz/seeds/submission/submission.json");
        let mut manifest: Manifest = serde_json::from_str(text).unwrap();
        manifest.run.limits.insert("fuel_per_step".into(), 7);
        assert!(manifest.run.limits.remove("fuel_per_task").is_some());
        let limits = manifest.limits().unwrap();
        assert_eq!((limits.fuel_per_step, limits.fuel_per_task), (7, Limits::default().fuel_per_task));
        manifest.run.limits.insert("fuel_per_dream".into(), 7);
        assert!(manifest.limits().unwrap_err().contains("fuel_per_dream"));
    }

    #[test]
    fn only_addresses_that_run_nothing_are_shown() {
        let with = |url: &str| {
            let entrant = Entrant { name: "a".into(), ..Entrant::default() };
            let paper = Entrant { paper: Some(url.into()), ..entrant.clone() }.check();
            let code = Entrant { code: Some(url.into()), ..entrant.clone() }.check();
            let own = Entrant { url: Some(url.into()), ..entrant }.check();
            assert!(own.is_ok() == paper.is_ok() && own.is_ok() == code.is_ok(), "{url}");
            own
        };
        with("https://example.org/a?b=c#d").unwrap();
        for url in
            ["javascript:alert(1)", "http://a", "https://a\"onclick=b", "https://a b", "data:text/html,a", ""]
        {
            assert!(with(url).is_err(), "{url}");
        }
        let named = |name: &str| Entrant { name: name.into(), ..Entrant::default() }.check();
        named("Ünï <b> & Co.").unwrap();
        assert!(named("a\nb").is_err() && named(&"a".repeat(81)).is_err());
        // Zero-width space, right-to-left override, an isolate, a soft hyphen, a tag; U+FFFD itself hides nothing.
        for c in ['\u{200b}', '\u{202e}', '\u{2066}', '\u{ad}', '\u{e0041}'] {
            assert!(
                named(&format!("A team{c}")).unwrap_err().to_string().contains("invisible character"),
                "{c:?}"
            );
        }
        named("שלום \u{fffd}").unwrap();
    }
}
