//! Planners held against each other on the same tasks.

use crate::figures::{Estimate, Measure, estimate};
use crate::runs::{Row, Run, Runs};
use crate::statistics::{Profile, Ratio, holm, mcnemar, profiles, wilcoxon};

/// Runs up to this number are compared all with all, more with the first only.
const ALL_WITH_ALL: usize = 6;

/// A figure's difference between two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// What differs.
    pub measure: Measure,
    /// Number of tasks that have it in both runs.
    pub tasks: u64,
    /// Mean over tasks of the second run's value less the first's, with its interval; none without common tasks.
    pub difference: Option<Estimate>,
    /// Two-sided p-value: of McNemar's test over tasks for the success rate, else of Wilcoxon's over the means of worlds.
    pub p: Option<f64>,
    /// That p-value after Holm's correction over all tests of the report.
    pub adjusted: Option<f64>,
}

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

/// The comparison of two or more runs.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Pairs of runs.
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
        let first = if n <= ALL_WITH_ALL { n } else { 1 };
        let mut pairs: Vec<Pair> =
            (0..first).flat_map(|a| (a + 1..n).map(move |b| (a, b))).map(|(a, b)| pair(runs, a, b)).collect();
        // One family: whoever looks at the whole table sees a false difference in one of twenty tables at most.
        let tests: Vec<f64> = pairs.iter().flat_map(|p| &p.differences).filter_map(|d| d.p).collect();
        let mut adjusted = holm(&tests).into_iter();
        for d in pairs.iter_mut().flat_map(|p| &mut p.differences) {
            d.adjusted = d.p.and_then(|_| adjusted.next());
        }
        let costs = common_costs(runs);
        let profile_tasks = costs.first().map_or(0, Vec::len);
        Some(Self { pairs, profiles: profiles(&costs), profile_tasks })
    }
}

/// The rows of the tasks that two runs have both done and that count in both.
fn common<'a>(a: &'a Run, b: &'a Run) -> impl Iterator<Item = (&'a Row, &'a Row)> {
    let mut others = b.rows.iter().peekable();
    a.rows.iter().filter_map(move |row| {
        while others.next_if(|o| o.task < row.task).is_some() {}
        others.next_if(|o| o.task == row.task).map(|o| (row, o)).filter(|(r, o)| r.counts() && o.counts())
    })
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
        let means: Vec<f64> = worlds.iter().filter(|w| w.weight > 0.0).map(|w| w.sum / w.weight).collect();
        let p = match measure {
            Measure::Success => (tasks > 0).then(|| mcnemar(only_a, only_b)),
            // Equal everywhere: nothing speaks for a difference.
            _ => (!means.is_empty()).then(|| wilcoxon(&means).map_or(1.0, |r| r.p)),
        };
        Difference {
            measure,
            tasks,
            difference: estimate(&worlds, &format!("difference of {}", measure.name())),
            p,
            adjusted: None,
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
                while run.rows.get(*k).is_some_and(|r| r.task < row.task) {
                    *k += 1;
                }
                run.rows.get(*k).filter(|r| r.task == row.task && r.counts())
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
