//! What a test of a difference says, as one of many.

use vb_page::signed;

use crate::figures::{Estimate, Measure};
use crate::statistics::{holm, least_p, worlds_needed};

/// The family-wise error rate: of twenty reports on planners that are all the same, one has a false difference in a family.
pub const LEVEL: f64 = 0.05;

/// What a difference says of the run that is named first in it (of "B − A", of B).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is better, for certain: its p-value holds after the correction.
    Better,
    /// It is worse, for certain.
    Worse,
    /// They are the same in every world.
    Equal,
    /// Nothing can be said, since the most extreme outcome in so few worlds could not be certain either.
    TooFewWorlds {
        /// How many worlds would have to differ.
        needed: usize,
    },
    /// The p-value would hold if this were the only pair, but not as one of many.
    Uncorrected { pairs: usize },
    /// They can't be told apart.
    Undecided,
}

impl Verdict {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
            Self::Equal => "equal",
            Self::TooFewWorlds { .. } => "too_few_worlds",
            Self::Uncorrected { .. } => "uncorrected",
            Self::Undecided => "undecided",
        }
    }

    /// Whether the runs are told apart.
    #[must_use]
    pub fn is_certain(self) -> bool {
        matches!(self, Self::Better | Self::Worse)
    }

    /// The same, seen from the other run.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Better => Self::Worse,
            Self::Worse => Self::Better,
            other => other,
        }
    }
}

/// A figure's difference between two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub measure: Measure,
    /// Number of tasks that have the measure in both runs.
    pub tasks: u64,
    /// Number of worlds in which the sum over those tasks differs: what the deciding test goes by.
    pub worlds: usize,
    /// Mean over tasks of the second run's value less the first's, with its interval; none without common tasks.
    pub difference: Option<Estimate>,
    /// Two-sided p-value of the deciding test, which flips the signs of whole worlds ([`crate::statistics::sign_flip`]); none without common tasks.
    pub p: Option<f64>,
    /// That p-value after Holm's correction over its family: this measure of all pairs.
    pub adjusted: Option<f64>,
    /// What the corrected p-value says of the second run; none without common tasks.
    pub verdict: Option<Verdict>,
    /// Two-sided p-value, without correction, of a test that assumes more and decides nothing: McNemar's exact test over tasks
    /// for the success rate, as if tasks were independent; else Wilcoxon's over the means of worlds, as if each world counted
    /// the same.
    pub secondary: Option<f64>,
}

impl Difference {
    /// The same, seen from the other run: the first less the second.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut other = self.clone();
        other.difference = self.difference.map(Estimate::negated);
        other.verdict = self.verdict.map(Verdict::reversed);
        other
    }

    /// The style class of what it says.
    pub(crate) fn class(&self) -> &'static str {
        match self.verdict {
            Some(Verdict::Better) => "better",
            Some(Verdict::Worse) => "worse",
            _ => "open",
        }
    }

    /// What is said of it, in two or three words.
    pub(crate) fn short(&self) -> String {
        match self.verdict {
            Some(Verdict::TooFewWorlds { .. }) => "too few worlds".into(),
            Some(Verdict::Uncorrected { .. }) => "not significant".into(),
            _ => self.told(),
        }
    }

    /// Its interval: `+3.0 to +12.0`.
    pub(crate) fn interval(&self) -> String {
        let v = |v: f64| signed(self.measure.shown(v), 2);
        let found = self.difference.and_then(|e| e.interval);
        found.map_or_else(|| "–".into(), |i| format!("{} to {}", v(i.low), v(i.high)))
    }

    /// Its verdict as people read it, with the reason where there is none for certain.
    #[must_use]
    pub fn told(&self) -> String {
        match self.verdict {
            None => "no common tasks".into(),
            Some(Verdict::Better) => "better".into(),
            Some(Verdict::Worse) => "worse".into(),
            Some(Verdict::Equal) => "equal".into(),
            Some(Verdict::TooFewWorlds { needed }) => {
                let differ = if self.worlds == 1 { "differs" } else { "differ" };
                format!("too few worlds ({} {differ}, {needed} needed)", self.worlds)
            }
            Some(Verdict::Uncorrected { pairs }) => {
                format!("not significant after correction for {pairs} pairs")
            }
            Some(Verdict::Undecided) => "not significant".into(),
        }
    }
}

/// Corrects the p-values of a family – one measure of all pairs – by Holm's method, and says what each means.
pub(crate) fn decide(family: Vec<&mut Difference>) {
    let mut family: Vec<(f64, &mut Difference)> =
        family.into_iter().filter_map(|d| Some((d.p?, d))).collect();
    let p: Vec<f64> = family.iter().map(|(p, _)| *p).collect();
    for (k, (adjusted, (own, d))) in holm(&p).into_iter().zip(&mut family).enumerate() {
        // What the correction would leave of the least p-value that this number of worlds can give.
        let least = || {
            let mut others = p.clone();
            others[k] = least_p(d.worlds);
            holm(&others)[k]
        };
        let more = d.difference.is_some_and(|e| e.mean > 0.0);
        d.adjusted = Some(adjusted);
        d.verdict = Some(if d.worlds == 0 {
            Verdict::Equal
        } else if adjusted < LEVEL {
            if more == d.measure.more_is_better() { Verdict::Better } else { Verdict::Worse }
        } else if least() >= LEVEL {
            Verdict::TooFewWorlds { needed: worlds_needed(LEVEL, p.len()) }
        } else if *own < LEVEL {
            Verdict::Uncorrected { pairs: p.len() }
        } else {
            Verdict::Undecided
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::{Estimate, Measure};

    fn difference(measure: Measure, worlds: usize, mean: f64, p: f64) -> Difference {
        Difference {
            measure,
            tasks: 100,
            worlds,
            difference: Some(Estimate { mean, interval: None }),
            p: Some(p),
            adjusted: None,
            verdict: None,
            secondary: None,
        }
    }

    fn verdicts(mut all: Vec<Difference>) -> Vec<Verdict> {
        decide(all.iter_mut().collect());
        all.iter().map(|d| d.verdict.unwrap()).collect()
    }

    #[test]
    fn better_is_more_success_and_less_time() {
        let of = |measure, mean| verdicts(vec![difference(measure, 10, mean, 0.002)])[0];
        assert_eq!(
            (of(Measure::Success, 0.1), of(Measure::Success, -0.1)),
            (Verdict::Better, Verdict::Worse)
        );
        for measure in [Measure::Time, Measure::Roll, Measure::Pitch] {
            assert_eq!(
                (of(measure, -1.0), of(measure, 1.0)),
                (Verdict::Better, Verdict::Worse),
                "{measure:?}"
            );
        }
        let mut one = [difference(Measure::Time, 10, 3.0, 0.002)];
        decide(one.iter_mut().collect());
        let other = one[0].reversed();
        assert_eq!((other.verdict, other.difference.unwrap().mean), (Some(Verdict::Better), -3.0));
    }

    #[test]
    fn what_is_not_certain_says_why() {
        let d = |worlds, p| difference(Measure::Success, worlds, 0.1, p);
        // Five worlds that all differ the same way have p = 0.0625: with one more it would be certain.
        assert_eq!(verdicts(vec![d(5, 0.0625)]), [Verdict::TooFewWorlds { needed: 6 }]);
        // By Holm 0.03 · 2 and 0.2; alone the first would hold.
        assert_eq!(
            verdicts(vec![d(40, 0.03), d(40, 0.2)]),
            [Verdict::Uncorrected { pairs: 2 }, Verdict::Undecided]
        );
        // Six worlds are enough behind a pair that is certain already (0.03125 · 1), and too few before it (· 2).
        assert_eq!(verdicts(vec![d(40, 1e-5), d(6, 0.5)]), [Verdict::Better, Verdict::Undecided]);
        assert_eq!(verdicts(vec![d(40, 0.9), d(6, 0.5)])[1], Verdict::TooFewWorlds { needed: 7 });
        assert_eq!(verdicts(vec![d(0, 1.0)]), [Verdict::Equal]);
        let mut none = difference(Measure::Time, 0, 0.0, 1.0);
        none.p = None;
        decide(vec![&mut none]);
        assert_eq!((none.verdict, none.told().as_str()), (None, "no common tasks"));
    }
}
