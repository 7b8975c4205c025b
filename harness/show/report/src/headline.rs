//! The result in one sentence, made from the figures.

use std::fmt::Write as _;

use vb_page::{grouped, number, p_value};

use crate::compare::common_worlds;
use crate::figures::Measure;
use crate::runs::one_line;
use crate::verdict::{Difference, Verdict};
use crate::{Comparison, Report};

/// Names that are told one by one.
const NAMES: usize = 4;
/// The suite with the most worlds that comes with the harness, and how many it has.
const LARGE_SUITE: (&str, usize) = ("vb-100", 100);
/// From so many worlds on, a difference that isn't significant is put down to chance, not to the number of worlds.
const MANY_WORLDS: usize = 50;

impl Report {
    /// Returns the planner with the highest success rate, its difference to the best significantly worse planner, and the planners over
    /// which its lead is not significant, with the reason and the remedy: `tnt has the highest success rate: 65.2 % of 1 000 tasks, 22.7
    /// points more than mppi (p < 0.001); its lead over tal is not significant: p = 0.31 after correction for 3 pairs.` If the runs
    /// contain different tasks, it names the tasks of each number. None for a single run. Names of planners are not escaped, and the text
    /// is one line.
    #[must_use]
    pub fn headline(&self) -> Option<String> {
        if let Some(why) = &self.unranked {
            return Some(format!(
                "Not ranked: the runs differ in {why}, so their results are not comparable (run all planners with the same settings)."
            ));
        }
        let (c, ranking) = (self.comparison.as_ref()?, self.ranking()?);
        let first = ranking.places.first()?.run;
        let all = &self.figures[first].all;
        let rate = all.mean(Measure::Success)?;
        if rate.mean == 0.0 {
            return Some("No planner solves any of the tasks.".into());
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
        let (has, its) = if best.len() == 1 { ("has", "its") } else { ("have", "their") };
        let mut s = format!(
            "{} {has} the highest success rate: {} % of {}",
            self.names(&best),
            number(100.0 * rate.mean, 1),
            if one_set { tasks(all.tasks) } else { self.own_tasks(&best) }
        );
        if let Some((run, d)) = below.and_then(|run| Some((run, between(run)?))) {
            let more = d.difference.map_or(0.0, |e| 100.0 * e.mean);
            let p = d.adjusted.map_or_else(String::new, told_p);
            let which = match best.len() {
                1 => String::new(),
                _ if one_set => "each".to_owned(),
                // On other tasks another would have another difference.
                _ => self.names(&[first]),
            };
            let which = if which.is_empty() { which } else { which + " " };
            let _ = write!(s, ", {which}{} points more than {}", number(more, 1), self.names(&[run]));
            if !shares_all(run) {
                let _ = write!(s, " on the {} that both have run", tasks(common(run)));
            }
            let _ = write!(s, " ({p})");
        }
        if !ties.is_empty() {
            let joint = if below.is_some() { ";" } else { ", but" };
            let _ = write!(
                s,
                "{joint} {its} lead over {} is not significant: {}",
                self.names(&ties),
                self.uncertain(c, first, &ties)
            );
        }
        s.push('.');
        Some(s)
    }

    /// The tasks of the rates, for runs with different tasks.
    fn own_tasks(&self, runs: &[usize]) -> String {
        let numbers: Vec<u64> = runs.iter().map(|run| self.figures[*run].all.tasks).collect();
        let who = if runs.len() == 1 { "it" } else { "each" };
        match numbers.iter().all(|n| *n == numbers[0]) {
            true => format!("the {} that {who} has run", tasks(numbers[0])),
            false => {
                let numbers = numbers.iter().take(NAMES).map(|n| grouped(*n)).collect();
                format!("the tasks that each has run ({})", listed(numbers, runs.len()))
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

fn tasks(n: u64) -> String {
    format!("{} {}", grouped(n), if n == 1 { "task" } else { "tasks" })
}

/// A p-value in a sentence: `p < 0.001`, `p = 0.012`.
fn told_p(p: f64) -> String {
    let text = p_value(p);
    if text.starts_with('<') { format!("p {text}") } else { format!("p = {text}") }
}

/// Numbers as a range: `5`, `5 to 7`.
fn range(numbers: impl Iterator<Item = usize> + Clone) -> String {
    let (least, most) = (numbers.clone().min().unwrap_or(0), numbers.max().unwrap_or(0));
    if least == most { least.to_string() } else { format!("{least} to {most}") }
}

impl Report {
    /// The reason why the lead over some runs is not significant: too few worlds, with a larger suite; or the p-value.
    fn uncertain(&self, c: &Comparison, first: usize, ties: &[usize]) -> String {
        let found: Vec<(usize, Difference)> =
            ties.iter().filter_map(|run| Some((*run, c.between(first, *run, Measure::Success)?))).collect();
        let found: Vec<(usize, Difference)> =
            found.into_iter().filter(|(_, d)| d.verdict.is_some()).collect();
        if found.is_empty() {
            return "no common tasks".to_owned();
        }
        let pairs = c.pairs.iter().filter(|p| p.common > 0).count();
        let corrected =
            if pairs > 1 { format!(" after correction for {pairs} pairs") } else { String::new() };
        let p = found.iter().filter_map(|(_, d)| d.adjusted).fold(1.0, f64::min);
        let p = match found.len() {
            1 => format!("{}{corrected}", told_p(p)),
            _ => format!("p ≥ {}{corrected}", p_value(p)),
        };
        let needed = found.iter().filter_map(|(_, d)| match d.verdict {
            Some(Verdict::TooFewWorlds { needed }) => Some(needed),
            _ => None,
        });
        let needed = needed.max();
        let worlds = found.iter().map(|(run, _)| common_worlds(&self.runs, first, *run)).min().unwrap_or(0);
        if needed.is_none() && worlds >= MANY_WORLDS {
            return p;
        }
        let are = if worlds == 1 { "world is" } else { "worlds are" };
        let differ = range(found.iter().map(|(_, d)| d.worlds));
        let why = match needed {
            Some(needed) => {
                format!("{differ} {}, {needed} needed", if differ == "1" { "differs" } else { "differ" })
            }
            None => p,
        };
        let remedy = match self.runs.runs[first].header.suite.name.as_str() {
            _ if worlds >= LARGE_SUITE.1 => String::new(),
            name if name == LARGE_SUITE.0 => format!("; run all {} worlds of {name}", LARGE_SUITE.1),
            _ => format!("; run the {} worlds of {}", LARGE_SUITE.1, LARGE_SUITE.0),
        };
        format!("{} {are} too few ({why}{remedy})", grouped(worlds as u64))
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
