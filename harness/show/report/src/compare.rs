//! Planners held against each other on the same tasks.
//!
//! A difference is always one run's value less another's, "second − first" in a [`Pair`]; whether that is good depends on the
//! measure ([`Measure::more_is_better`]), and a [`Verdict`] says it.

use crate::figures::{Measure, estimate};
use crate::runs::{Row, Run, Runs};
use crate::statistics::{Profile, Ratio, mcnemar, profiles, sign_flip, wilcoxon};
use crate::verdict::{Difference, decide};

use vb_score::BOOTSTRAP_SEED;

/// Two runs on their common tasks.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The first run, an index into [`Runs::runs`].
    pub a: usize,
    /// The second.
    pub b: usize,
    /// Number of tasks that both have done.
    pub common: u64,
    /// Tasks that both succeed in.
    pub both: u64,
    /// Tasks that the first alone succeeds in.
    pub only_a: u64,
    /// Tasks that the second alone succeeds in.
    pub only_b: u64,
    /// Differences, in the order of [`Measure::ALL`].
    pub differences: Vec<Difference>,
}

#[derive(Clone, Debug)]
pub struct Comparison {
    /// Pairs of runs, all with all.
    pub pairs: Vec<Pair>,
    /// Each run's performance profile by traversal time, over the tasks that all have done.
    pub profiles: Vec<Profile>,
    /// Number of those tasks.
    pub profile_tasks: usize,
}

impl Comparison {
    /// Compares runs; none if there is but one.
    #[must_use]
    pub fn new(runs: &Runs) -> Option<Self> {
        let n = runs.runs.len();
        if n < 2 {
            return None;
        }
        let mut pairs: Vec<Pair> =
            (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).map(|(a, b)| pair(runs, a, b)).collect();
        for measure in Measure::ALL {
            decide(pairs.iter_mut().filter_map(|p| p.differences.get_mut(measure as usize)).collect());
        }
        let costs = common_costs(runs);
        let profile_tasks = costs.first().map_or(0, Vec::len);
        Some(Self { pairs, profiles: profiles(&costs), profile_tasks })
    }

    /// The pair of two runs, whichever of them is its first.
    #[must_use]
    pub fn pair(&self, x: usize, y: usize) -> Option<&Pair> {
        self.pairs.iter().find(|p| (p.a, p.b) == (x.min(y), x.max(y)))
    }

    /// The difference of run `x` less run `y`.
    #[must_use]
    pub fn between(&self, x: usize, y: usize, measure: Measure) -> Option<Difference> {
        let d = self.pair(x, y)?.differences.get(measure as usize)?;
        Some(if x < y { d.reversed() } else { d.clone() })
    }
}

/// The rows of the tasks that two runs have both done and that count in both.
fn common<'a>(a: &'a Run, b: &'a Run) -> impl Iterator<Item = (&'a Row, &'a Row)> {
    let mut others = b.rows.iter().peekable();
    a.rows.iter().filter_map(move |row| {
        while others.next_if(|o| o.key() < row.key()).is_some() {}
        others.next_if(|o| o.key() == row.key()).map(|o| (row, o)).filter(|(r, o)| r.counts() && o.counts())
    })
}

pub(crate) fn common_worlds(runs: &Runs, a: usize, b: usize) -> usize {
    let worlds = common(&runs.runs[a], &runs.runs[b]).map(|(row, _)| row.world);
    worlds.collect::<std::collections::BTreeSet<u32>>().len()
}

/// A measure of one task in one run, if it has it there.
fn value(measure: Measure, row: &Row) -> Option<f64> {
    // Of angles a task's own mean: long tasks count no more than short ones.
    let r = measure.of(row);
    (r.weight > 0.0).then(|| r.sum / r.weight)
}

pub(crate) fn pair(runs: &Runs, a: usize, b: usize) -> Pair {
    let rows: Vec<(&Row, &Row)> = common(&runs.runs[a], &runs.runs[b]).collect();
    let count = |f: fn(bool, bool) -> bool| {
        rows.iter().filter(|(x, y)| f(x.succeeded(), y.succeeded())).count() as u64
    };
    let (only_a, only_b) = (count(|x, y| x && !y), count(|x, y| !x && y));
    let differences = Measure::ALL.map(|measure| {
        let mut worlds = vec![Ratio::default(); runs.worlds.len()];
        for (x, y) in &rows {
            if let Some((x_value, y_value)) = value(measure, x).zip(value(measure, y)) {
                let w = &mut worlds[x.world as usize];
                w.sum += y_value - x_value;
                w.weight += 1.0;
            }
        }
        let tasks = worlds.iter().map(|w| w.weight).sum::<f64>() as u64;
        let sums: Vec<f64> = worlds.iter().map(|w| w.sum).collect();
        let test = sign_flip(&sums, BOOTSTRAP_SEED, &["report", "sign flips", measure.name()]);
        let means: Vec<f64> = worlds.iter().filter(|w| w.weight > 0.0).map(|w| w.sum / w.weight).collect();
        let secondary = match measure {
            Measure::Success => mcnemar(only_a, only_b),
            // Equal everywhere: nothing speaks for a difference.
            _ => wilcoxon(&means).map_or(1.0, |r| r.p),
        };
        Difference {
            measure,
            tasks,
            worlds: test.worlds,
            difference: estimate(&worlds, &format!("difference of {}", measure.name())),
            p: (tasks > 0).then_some(test.p),
            adjusted: None,
            verdict: None,
            secondary: (tasks > 0).then_some(secondary),
        }
    });
    Pair {
        a,
        b,
        common: rows.len() as u64,
        both: count(|x, y| x && y),
        only_a,
        only_b,
        differences: differences.into(),
    }
}

/// Traversal times of each run over the tasks that all have done, none where it failed.
fn common_costs(runs: &Runs) -> Vec<Vec<Option<f64>>> {
    let n = runs.runs.len();
    let mut at = vec![0; n];
    let mut costs = vec![Vec::new(); n];
    for row in &runs.runs[0].rows {
        let found: Option<Vec<&Row>> = runs
            .runs
            .iter()
            .zip(&mut at)
            .map(|(run, k)| {
                while run.rows.get(*k).is_some_and(|r| r.key() < row.key()) {
                    *k += 1;
                }
                run.rows.get(*k).filter(|r| r.key() == row.key() && r.counts())
            })
            .collect();
        if let Some(found) = found {
            for (own, r) in costs.iter_mut().zip(found) {
                // A task that begins at its goal costs nothing for anybody.
                own.push(r.succeeded().then_some(r.time.max(1e-9)));
            }
        }
    }
    costs
}
