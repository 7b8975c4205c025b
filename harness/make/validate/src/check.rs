//! A figure held against an expectation.

use serde::Serialize;

/// Where an expectation comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Computed from the vehicle's data.
    Theory,
    /// A figure of the real vehicle.
    Published,
    /// A run of Project Chrono.
    Chrono,
    /// The simulation held against itself at another step or grid.
    Convergence,
}

impl Kind {
    /// All kinds, strongest first.
    pub const ALL: [Self; 4] = [Self::Theory, Self::Published, Self::Chrono, Self::Convergence];

    /// The name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["theory", "published", "chrono", "convergence"][self as usize]
    }

    /// The set-up of its references, for people: "throttle 0.3, in Chrono's set-up".
    #[must_use]
    pub fn setup(self) -> &'static str {
        ["theory's set-up", "the published set-up", "Chrono's set-up", "the convergence set-up"]
            [self as usize]
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// Within a distance of a value, both in the figure's unit.
    Within {
        value: f64,
        tolerance: f64,
    },
    AtLeast(f64),
    AtMost(f64),
    /// No less than the first and no more than the second.
    Between(f64, f64),
}

impl Expected {
    /// Within a share of a value, e.g. 0.05 for 5 %.
    #[must_use]
    pub fn fraction(value: f64, fraction: f64) -> Self {
        Self::Within { value, tolerance: fraction * value.abs() }
    }

    /// Whether a figure is as expected. A figure that is no number never is.
    #[must_use]
    pub fn admits(self, figure: f64) -> bool {
        match self {
            Self::Within { value, tolerance } => (figure - value).abs() <= tolerance,
            Self::AtLeast(low) => figure >= low,
            Self::AtMost(high) => figure <= high,
            Self::Between(low, high) => figure >= low && figure <= high,
        }
    }
}

/// What one figure of one event should be, and who says so.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expectation {
    pub figure: String,
    pub expected: Expected,
    pub kind: Kind,
    /// The formula, publication or run, so that it can be looked up.
    pub source: String,
    /// Why this reference decides nothing, where it is known to be unsound; it is shown beside the figure all the same.
    pub unsound: Option<String>,
}

impl Expectation {
    /// An expectation of theory, by its formula.
    #[must_use]
    pub fn theory(figure: impl Into<String>, expected: Expected, source: impl Into<String>) -> Self {
        Self { figure: figure.into(), expected, kind: Kind::Theory, source: source.into(), unsound: None }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Pass,
    Fail,
    /// The reference is unsound: shown, not judged.
    Shown,
}

/// A figure beside one expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    #[serde(flatten)]
    pub expectation: Expectation,
    /// What was measured; none if the event has no such figure or did not get so far.
    pub measured: Option<f64>,
    /// The references in whose set-up it was measured ([`crate::Setup`]); none for the vehicle as it is.
    pub setup: Option<Kind>,
    /// Unit of the expected and of the measured value.
    pub unit: String,
    pub verdict: Verdict,
}

impl Check {
    /// Of figures that were measured with the vehicle as it is.
    pub(crate) fn new(expectation: Expectation, figures: &[crate::Figure]) -> Self {
        let figure = figures.iter().find(|f| f.name == expectation.figure);
        let measured = figure.map(|f| f.value).filter(|v| v.is_finite());
        let verdict = match (&expectation.unsound, measured) {
            (Some(_), _) => Verdict::Shown,
            (None, Some(v)) if expectation.expected.admits(v) => Verdict::Pass,
            (None, _) => Verdict::Fail,
        };
        Self { expectation, measured, setup: None, unit: figure.map_or("", |f| f.unit).to_owned(), verdict }
    }

    /// Of figures that were measured in the set-up of the expectation's kind.
    pub(crate) fn in_setup(expectation: Expectation, figures: &[crate::Figure]) -> Self {
        let setup = Some(expectation.kind);
        Self { setup, ..Self::new(expectation, figures) }
    }

    /// What it is held against: its kind, and whether it was measured in that kind's set-up.
    #[must_use]
    pub fn against(&self) -> String {
        let kind = self.expectation.kind.name();
        if self.setup.is_some() { format!("{kind}, in its set-up") } else { kind.to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Figure;

    fn verdict(expected: Expected, value: f64) -> Verdict {
        let figures = [Figure { name: "a".to_owned(), value, unit: "m" }];
        Check::new(Expectation::theory("a", expected, ""), &figures).verdict
    }

    #[test]
    fn a_figure_passes_up_to_the_tolerance_and_fails_beyond() {
        let near = Expected::fraction(-2.0, 0.05);
        assert_eq!([verdict(near, -2.0999), verdict(near, -2.1001)], [Verdict::Pass, Verdict::Fail]);
        assert_eq!([verdict(near, -1.9001), verdict(near, -1.8999)], [Verdict::Pass, Verdict::Fail]);
        let between = Expected::Between(1.0, 2.0);
        assert_eq!(
            [1.0, 2.0, 0.99, 2.01].map(|v| verdict(between, v) == Verdict::Pass),
            [true, true, false, false]
        );
        assert_eq!(verdict(Expected::AtLeast(1.0), 0.9), Verdict::Fail);
        assert_eq!(verdict(Expected::AtMost(1.0), 1.1), Verdict::Fail);
    }

    #[test]
    fn what_was_not_measured_fails_and_what_is_unsound_never_judges() {
        assert_eq!(verdict(Expected::AtMost(1.0), f64::NAN), Verdict::Fail);
        assert_eq!(verdict(Expected::AtMost(1.0), f64::NEG_INFINITY), Verdict::Fail);
        let missing = Check::new(Expectation::theory("b", Expected::AtLeast(0.0), ""), &[]);
        assert_eq!((missing.verdict, missing.measured), (Verdict::Fail, None));
        let unsound = Some("creeps".to_owned());
        let shown = Expectation { unsound, ..Expectation::theory("a", Expected::AtLeast(9.0), "") };
        let figures = [Figure { name: "a".to_owned(), value: 1.0, unit: "m" }];
        assert_eq!(Check::new(shown, &figures).verdict, Verdict::Shown);
    }
}
