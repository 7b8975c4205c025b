//! Who wins: ranks with ties.

use crate::compare::Comparison;
use crate::figures::{Measure, RunFigures};
use crate::verdict::Verdict;

/// Runs up to this number are shown all with all where each pair takes a line, more only with the first of the ranking.
const ALL_WITH_ALL: usize = 6;

/// A run's place in the ranking.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The run, an index into [`crate::Runs::runs`].
    pub run: usize,
    /// One more than the number of runs that are better for certain.
    pub rank: usize,
    /// The number of runs less those that are worse for certain: the last rank that it may truly have.
    pub last: usize,
    /// The runs that it can't be told from, in the order of the ranking.
    pub ties: Vec<usize>,
}

impl Place {
    /// The rank as it is printed: `2`, or with the last that is possible `2–4`.
    #[must_use]
    pub fn told(&self) -> String {
        if self.rank == self.last { self.rank.to_string() } else { format!("{}–{}", self.rank, self.last) }
    }
}

/// Runs by how much they succeed, with ties where the deciding test does not tell them apart.
///
/// The rank is one more than the number of runs that are better for certain, so runs that can't be told apart may share it.
/// `rank` to `last` is the set of ranks of Mogstad, Romano, Shaikh and Wilhelm (2024, Inference for ranks): as the verdicts
/// are corrected together, the true ranks of all runs lie in their sets in 19 of 20 reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ranking {
    /// The places: by rank, then by success rate, then in the order of the runs.
    pub places: Vec<Place>,
}

impl Ranking {
    #[must_use]
    pub fn new(figures: &[RunFigures], comparison: &Comparison) -> Self {
        let n = figures.len();
        let rate = |k: usize| figures[k].all.mean(Measure::Success).map_or(0.0, |e| e.mean);
        let verdict = |x, y| comparison.between(x, y, Measure::Success).and_then(|d| d.verdict);
        let mut places: Vec<Place> = (0..n)
            .map(|run| {
                let others = || (0..n).filter(|k| *k != run);
                let count = |v| others().filter(|k| verdict(run, *k) == Some(v)).count();
                let ties = others().filter(|k| !verdict(run, *k).is_some_and(Verdict::is_certain)).collect();
                Place { run, rank: 1 + count(Verdict::Worse), last: n - count(Verdict::Better), ties }
            })
            .collect();
        places.sort_by(|a, b| a.rank.cmp(&b.rank).then(rate(b.run).total_cmp(&rate(a.run))));
        let order: Vec<usize> = places.iter().map(|p| p.run).collect();
        let position = |run: &usize| order.iter().position(|o| o == run);
        places.iter_mut().for_each(|p| p.ties.sort_by_key(position));
        Self { places }
    }

    #[must_use]
    pub fn alone() -> Self {
        Self { places: vec![Place { run: 0, rank: 1, last: 1, ties: Vec::new() }] }
    }

    /// The pairs of runs of which each takes a line, as (`x`, `y`) of the difference `x` − `y`: all with all, later runs less
    /// earlier ones; of more than six runs, each less the first of the ranking.
    #[must_use]
    pub fn lines(&self) -> Vec<(usize, usize)> {
        let n = self.places.len();
        match &self.places[..] {
            [first, others @ ..] if n > ALL_WITH_ALL => others.iter().map(|p| (p.run, first.run)).collect(),
            _ => (0..n).flat_map(|y| (y + 1..n).map(move |x| (x, y))).collect(),
        }
    }
}
