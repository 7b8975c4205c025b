//! Rewards as data: `tasks/rewards/*.yaml`.

use std::collections::BTreeMap;

use serde::Deserialize;
use vb_files::document::within;
use vb_files::{Document, Flaw, Schema};
use vb_score::Outcome;

/// The maximum weight.
const HEAVIEST: f64 = 1e6;

/// A term of a reward: a measurement of a step, multiplied by a weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// The name in reward files.
    pub name: &'static str,
    /// The unit; empty for dimensionless terms.
    pub unit: &'static str,
    /// The meaning, in words.
    pub about: &'static str,
    kind: Kind,
}

impl Term {
    /// Whether the term applies to episodes with this outcome.
    pub(crate) fn is_of_end(self, outcome: Outcome) -> bool {
        self.kind == Kind::End(outcome)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Progress,
    Approach,
    Time,
    Roll,
    Pitch,
    Steering,
    End(Outcome),
}

const fn term(name: &'static str, unit: &'static str, kind: Kind, about: &'static str) -> Term {
    Term { name, unit, about, kind }
}

/// All terms. Lengths and times are at full scale (Froude scaling).
pub const TERMS: [Term; 12] = [
    term("progress", "m", Kind::Progress, "progress along the global path; each metre counts once"),
    term(
        "approach",
        "m",
        Kind::Approach,
        "decrease of the horizontal distance to the goal; negative for an increase",
    ),
    term("time", "s", Kind::Time, "duration of the step"),
    term("roll", "rad s", Kind::Roll, "absolute roll after the step, times the duration"),
    term("pitch", "rad s", Kind::Pitch, "absolute pitch after the step, times the duration"),
    term("steering", "", Kind::Steering, "absolute change of the steering command"),
    term("success", "", Kind::End(Outcome::Success), "1 if the episode ends at the goal"),
    term("rollover", "", Kind::End(Outcome::Rollover), "1 if the episode ends with a rollover"),
    term("stuck", "", Kind::End(Outcome::Stuck), "1 if the episode ends because the vehicle is stuck"),
    term("timeout", "", Kind::End(Outcome::Timeout), "1 if the episode ends at the time limit"),
    term("out_of_bounds", "", Kind::End(Outcome::OutOfBounds), "1 if the episode ends outside the world"),
    term("sim_error", "", Kind::End(Outcome::SimError), "1 if the episode ends with a simulation error"),
];

/// A number for each of [`TERMS`].
pub type Terms = [f64; TERMS.len()];

/// The measurements of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measured {
    /// m, of the full-size world.
    pub(crate) progress: f64,
    /// m, of the full-size world.
    pub(crate) approach: f64,
    /// s, of a full-size vehicle.
    pub(crate) time: f64,
    /// rad, with its sign.
    pub(crate) roll: f64,
    /// rad, with its sign.
    pub(crate) pitch: f64,
    /// The change of the steering command.
    pub(crate) steering: f64,
    pub(crate) end: Option<Outcome>,
}

/// The weights of the terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Reward {
    /// The name.
    pub name: String,
    /// The weight of each of [`TERMS`].
    pub weights: Terms,
}

/// A reward file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    name: String,
    #[serde(default)]
    #[allow(dead_code, reason = "for readers of the file")]
    description: String,
    /// The weight of each term by its name ([terms](environments.md#rewards-and-episode-ends)); 0 if absent.
    weights: BTreeMap<String, f64>,
}

impl Default for Reward {
    fn default() -> Self {
        Self { name: "none".into(), weights: [0.0; TERMS.len()] }
    }
}

impl Reward {
    /// A reward of named weights; the others are 0.
    ///
    /// # Errors
    /// Returns an error for an unknown term, or a weight that is not a number within ±1e6.
    pub fn new(name: &str, weights: impl IntoIterator<Item = (String, f64)>) -> Result<Self, Flaw> {
        let mut own = Self { name: name.to_owned(), ..Self::default() };
        for (name, weight) in weights {
            let Some(k) = TERMS.iter().position(|t| t.name == name) else {
                let known = TERMS.map(|t| t.name).join(", ");
                return Err(Flaw::new("weights", format!("unknown term {name} (terms: {known})")));
            };
            within(&format!("weights.{name}"), weight, -HEAVIEST, HEAVIEST)?;
            own.weights[k] = weight;
        }
        Ok(own)
    }

    /// What each term is worth; the reward is their sum, in this order.
    pub(crate) fn terms(&self, m: &Measured) -> Terms {
        let mut worth = self.weights;
        for (worth, term) in worth.iter_mut().zip(TERMS) {
            let measured = match term.kind {
                Kind::Progress => m.progress,
                Kind::Approach => m.approach,
                Kind::Time => m.time,
                Kind::Roll => m.roll.abs() * m.time,
                Kind::Pitch => m.pitch.abs() * m.time,
                Kind::Steering => m.steering.abs(),
                Kind::End(outcome) => f64::from(u8::from(m.end == Some(outcome))),
            };
            *worth *= measured;
        }
        worth
    }
}

impl Document for Reward {
    type File = File;
    const KIND: &'static str = "reward";
    const FIELDS: &'static str = "docs/environments.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("default", include_str!("../../../../tasks/rewards/default.yaml")),
        ("sparse", include_str!("../../../../tasks/rewards/sparse.yaml")),
    ];

    fn from_file(file: File) -> Result<Self, Flaw> {
        Self::new(&file.name, file.weights)
    }
}

vb_files::document!(Reward);

#[cfg(test)]
mod tests {
    use super::*;

    fn worth(reward: &Reward, name: &str, m: &Measured) -> f64 {
        reward.terms(m)[TERMS.iter().position(|t| t.name == name).unwrap()]
    }

    #[test]
    fn those_that_come_with_the_harness_are_valid() {
        for (name, _) in Reward::BUILTIN {
            assert_eq!(Reward::resolve(name).unwrap().name, *name);
        }
    }

    #[test]
    fn a_term_is_its_weight_times_what_was_measured() {
        let reward = Reward::new("mine", TERMS.map(|t| (t.name.to_owned(), 2.0))).unwrap();
        let m = Measured {
            progress: 0.5,
            approach: -0.25,
            time: 0.1,
            roll: -0.3,
            pitch: 0.2,
            steering: -0.4,
            end: Some(Outcome::Stuck),
        };
        let expected = [
            ("progress", 1.0),
            ("approach", -0.5),
            ("time", 0.2),
            ("roll", 0.06),
            ("pitch", 0.04),
            ("steering", 0.8),
            ("success", 0.0),
            ("stuck", 2.0),
        ];
        for (name, value) in expected {
            assert!((worth(&reward, name, &m) - value).abs() < 1e-12, "{name}");
        }
    }

    #[test]
    fn flaws_are_told_with_file_field_and_value() {
        let told = |text: &str| Reward::parse(text, "mine.yaml").unwrap_err().to_string();
        let of = |weights: &str| told(&format!("schema: 1\nname: mine\nweights: {weights}\n"));
        assert!(of("{succes: 1}").starts_with("mine.yaml: weights: unknown term succes (terms: progress,"));
        assert!(of("{success: .nan}").contains("weights.success: NaN must lie in"));
        assert!(of("{success: 1e9}").contains("weights.success: 1000000000 must lie in"));
        assert!(of("{success: much}").contains("much"));
        assert!(told("schema: 2\nname: x\nweights: {}\n").contains("version 2 is not supported"));
        let missing = Reward::resolve("nowhere.yaml").unwrap_err().to_string();
        assert!(
            missing.starts_with("cannot read reward nowhere.yaml: ") && missing.contains("default, sparse")
        );
    }
}
