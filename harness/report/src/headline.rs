//! The result in one sentence, made from the figures.

use std::fmt::Write as _;

use vb_page::{grouped, number, p_value};

use crate::compare::Difference;
use crate::figures::Measure;
use crate::runs::one_line;
use crate::verdict::Verdict;
use crate::{Comparison, Report};

/// Names that are told one by one.
const NAMES: usize = 4;

impl Report {
    /// Who does most tasks, how much more than the best of those that are worse for certain, and from whom it can't be told:
    /// `tnt does most: 65.2 % of 1 000 tasks, which is 22.7 points more than mppi (p < 0.001); it can't be told from tal.` Where the
    /// runs have not all done the same tasks, it says of which tasks a figure is. None if there is but one run. It holds names of
    /// planners as they are, on one line.
    #[must_use]
    pub fn headline(&self) -> Option<String> {
        let (c, ranking) = (self.comparison.as_ref()?, self.ranking.as_ref()?);
        let first = ranking.places.first()?.run;
        let all = &self.figures[first].all;
        let rate = all.mean(Measure::Success)?;
        if rate.mean == 0.0 {
            return Some("No planner does any of the tasks.".into());
        }
        let between = |run: usize| c.between(first, run, Measure::Success);
        let is = |run: usize, v: Verdict| between(run).and_then(|d| d.verdict) == Some(v);
        let others = || ranking.places[1..].iter().map(|p| p.run);
        // Equals on the same tasks stand together.
        let equal = |run: usize| {
            let other = self.figures[run].all.mean(Measure::Success);
            !is(run, Verdict::Better) && other.is_some_and(|e| e.mean == rate.mean)
        };
        let mut best = vec![first];
        best.extend(others().filter(|run| equal(*run)));
        let ties: Vec<usize> = others()
            .filter(|run| !equal(*run) && !is(*run, Verdict::Better) && !is(*run, Verdict::Worse))
            .collect();
        let below = others().find(|run| is(*run, Verdict::Better));

        let common = |run: usize| c.pair(first, run).map_or(0, |pair| pair.common);
        let shares_all = |run: usize| self.figures[run].all.tasks == all.tasks && common(run) == all.tasks;
        let one_set = others().all(shares_all);
        let (does, it) = if best.len() == 1 { ("does", "it") } else { ("do", "they") };
        let mut s = format!(
            "{} {does} most: {} % of {}",
            self.names(&best),
            number(100.0 * rate.mean, 1),
            if one_set { tasks(all.tasks) } else { self.own_tasks(&best) }
        );
        if let Some((run, d)) = below.and_then(|run| Some((run, between(run)?))) {
            let more = d.difference.map_or(0.0, |e| 100.0 * e.mean);
            let p = d.adjusted.map_or_else(String::new, told_p);
            let which = match best.len() {
                1 => "which is".to_owned(),
                _ if one_set => "each".to_owned(),
                // On other tasks another would have another difference.
                _ => self.names(&[first]),
            };
            let _ = write!(s, ", {which} {} points more than {}", number(more, 1), self.names(&[run]));
            if !shares_all(run) {
                let _ = write!(s, " on the {} that both have done", tasks(common(run)));
            }
            let _ = write!(s, " ({p})");
        }
        if !ties.is_empty() {
            let joint = if below.is_some() { ";" } else { ", but" };
            let _ = write!(
                s,
                "{joint} {it} can't be told from {}{}",
                self.names(&ties),
                too_few(c, first, &ties)
            );
        }
        s.push('.');
        Some(s)
    }

    /// The tasks of which the rates of runs are that have not all done the same.
    fn own_tasks(&self, runs: &[usize]) -> String {
        let numbers: Vec<u64> = runs.iter().map(|run| self.figures[*run].all.tasks).collect();
        let who = if runs.len() == 1 { "it" } else { "each" };
        match numbers.iter().all(|n| *n == numbers[0]) {
            true => format!("the {} that {who} has done", tasks(numbers[0])),
            false => {
                let numbers = numbers.iter().take(NAMES).map(|n| grouped(*n)).collect();
                format!("the tasks that each has done ({})", listed(numbers, runs.len()))
            }
        }
    }

    /// Names as in `a, b and c`.
    fn names(&self, runs: &[usize]) -> String {
        let names = runs.iter().take(NAMES).map(|run| one_line(&self.runs.runs[*run].label, 80)).collect();
        listed(names, runs.len())
    }
}

/// The first of so many texts as in `a, b and c`, with the number of the others.
fn listed(mut first: Vec<String>, all: usize) -> String {
    if all > first.len() {
        first.push(format!("{} others", all - first.len()));
    }
    match first.pop() {
        Some(last) if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        last => last.unwrap_or_default(),
    }
}

/// A number of tasks.
fn tasks(n: u64) -> String {
    format!("{} {}", grouped(n), if n == 1 { "task" } else { "tasks" })
}

/// A p-value in a sentence: `p < 0.001`, `p = 0.012`.
fn told_p(p: f64) -> String {
    let text = p_value(p);
    if text.starts_with('<') { format!("p {text}") } else { format!("p = {text}") }
}

/// Why runs can't be told from the first, if it is for the number of worlds with each of them, or for want of common tasks.
fn too_few(c: &Comparison, first: usize, ties: &[usize]) -> String {
    if ties.iter().all(|run| c.pair(first, *run).is_some_and(|pair| pair.common == 0)) {
        return ": they have no common tasks".to_owned();
    }
    let found: Option<Vec<(usize, Difference)>> = ties
        .iter()
        .map(|run| {
            let d = c.between(first, *run, Measure::Success)?;
            let Some(Verdict::TooFewWorlds { needed }) = d.verdict else { return None };
            Some((needed, d))
        })
        .collect();
    match found.as_deref() {
        Some([(_, d)]) => format!(": {}", d.told()),
        Some([(needed, _), ..]) => format!(": too few worlds differ ({needed} needed)"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::told_p;

    #[test]
    fn p_values_are_told_with_their_sign() {
        assert_eq!((told_p(1e-5).as_str(), told_p(0.0123).as_str()), ("p < 0.001", "p = 0.012"));
    }
}
