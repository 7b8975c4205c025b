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
    /// `tnt does most: 65.2 % of 1 000 tasks, which is 22.7 points more than mppi (p < 0.001); it can't be told from tal.` None if
    /// there is but one run. It holds names of planners as they are, on one line.
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

        let (does, it, which) =
            if best.len() == 1 { ("does", "it", "which is") } else { ("do", "they", "each") };
        let mut s = format!(
            "{} {does} most: {} % of {} {}",
            self.names(&best),
            number(100.0 * rate.mean, 1),
            grouped(all.tasks),
            if all.tasks == 1 { "task" } else { "tasks" }
        );
        if let Some((run, d)) = below.and_then(|run| Some((run, between(run)?))) {
            let more = d.difference.map_or(0.0, |e| 100.0 * e.mean);
            let p = d.adjusted.map_or_else(String::new, told_p);
            let _ = write!(s, ", {which} {} points more than {} ({p})", number(more, 1), self.names(&[run]));
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

    /// Names as in `a, b and c`.
    fn names(&self, runs: &[usize]) -> String {
        let mut names: Vec<String> =
            runs.iter().take(NAMES).map(|run| one_line(&self.runs.runs[*run].label, 80)).collect();
        if runs.len() > NAMES {
            names.push(format!("{} others", runs.len() - NAMES));
        }
        match names.pop() {
            Some(last) if !names.is_empty() => format!("{} and {last}", names.join(", ")),
            last => last.unwrap_or_default(),
        }
    }
}

/// A p-value in a sentence: `p < 0.001`, `p = 0.012`.
fn told_p(p: f64) -> String {
    let text = p_value(p);
    if text.starts_with('<') { format!("p {text}") } else { format!("p = {text}") }
}

/// Why runs can't be told from the first, if it is for the number of worlds with each of them.
fn too_few(c: &Comparison, first: usize, ties: &[usize]) -> String {
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
