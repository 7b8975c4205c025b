//! Tables for a paper or a pull request.

use std::fmt::Write as _;

use vb_score::{Flag, Outcome};

use crate::failures::{Failure, failures};
use crate::figures::{Estimate, Measure};
use crate::ranking::{Place, Ranking};
use crate::verdict::Verdict;
use crate::{Comparison, Report};
use vb_page::{number, p_value, signed};

/// Text in a cell: nothing of it is markup.
pub(crate) fn text(t: &str) -> String {
    let mut out = String::with_capacity(t.len());
    for c in t.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '!' | '@' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// A mean with its interval, its values as `write` writes them.
fn cell(e: Option<Estimate>, measure: Measure, write: fn(f64, usize) -> String) -> String {
    let v = |v: f64| write(measure.shown(v), 1);
    match e {
        None => "–".into(),
        Some(Estimate { mean, interval: Some(i) }) => format!("{} [{}, {}]", v(mean), v(i.low), v(i.high)),
        Some(Estimate { mean, interval: None }) => v(mean),
    }
}

/// The same with the signs of values.
pub(crate) fn mean(e: Option<Estimate>, measure: Measure) -> String {
    cell(e, measure, number)
}

fn difference(e: Option<Estimate>, measure: Measure) -> String {
    cell(e, measure, signed)
}

impl Report {
    /// The planners that were run under several perception profiles, if there are any.
    fn markdown_robustness(&self, s: &mut String) {
        let Some(r) = &self.robustness else { return };
        s.push_str(
            "\n| planner | perception | success % | difference, points | rollover % | stuck % |\n|:--|:--|--:|--:|--:|--:|\n",
        );
        for (line, point) in r.lines.iter().flat_map(|line| line.points.iter().map(move |p| (line, p))) {
            let all = &self.figures[point.run].all;
            let percent = |o: Outcome| number(100.0 * all.count(o) as f64 / all.tasks.max(1) as f64, 1);
            let from_first = point.difference.as_ref().and_then(|d| d.difference);
            let _ = writeln!(
                s,
                "| {} | {} | {} | {} | {} | {} |",
                text(&line.label),
                text(&r.profiles[point.profile]),
                mean(all.mean(Measure::Success), Measure::Success),
                difference(from_first, Measure::Success),
                percent(Outcome::Rollover),
                percent(Outcome::Stuck),
            );
        }
        s.push_str("\nDifferences to the planner's first perception profile, paired by task.\n");
    }

    /// The results, and the comparison if there is one, as GitHub-flavoured Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut s = self.headline().map_or_else(String::new, |told| format!("{}\n\n", text(&told)));
        self.markdown_results(&mut s);
        s.push_str("\nIn brackets: 95 % intervals, bootstrap over worlds. Time: of successes; angles: over all samples.\n");
        for note in self.settings_notes() {
            let _ = writeln!(s, "\n{}", text(&note));
        }
        for run in self.runs.runs.iter().filter(|r| r.missing() > 0) {
            let _ = writeln!(
                s,
                "\n{}: {} of {} tasks are pending.",
                text(&run.label),
                run.missing(),
                run.header.tasks
            );
        }
        self.markdown_causes(&mut s);
        self.markdown_robustness(&mut s);
        if let (Some(c), Some(ranking)) = (&self.comparison, &self.order) {
            if self.runs.runs.len() > 2 {
                self.markdown_matrix(&mut s, c, ranking);
            }
            self.markdown_comparison(&mut s, c, ranking);
        }
        s
    }

    /// What stopped the vehicles, if the records say it.
    fn markdown_causes(&self, s: &mut String) {
        let mut found = failures(self);
        found.retain(|f| matches!(f, Failure::Cause(_)));
        if found.is_empty() {
            return;
        }
        let labels: Vec<String> = self.runs.runs.iter().map(|r| text(&r.label)).collect();
        let line = vec!["--:"; labels.len()].join("|");
        let _ = write!(s, "\n| cause of failure | {} |\n|:--|{line}|\n", labels.join(" | "));
        for failure in found {
            let counts: Vec<String> =
                self.figures.iter().map(|f| failure.count(&f.all).to_string()).collect();
            let _ = writeln!(s, "| {} | {} |", failure.title(), counts.join(" | "));
        }
    }

    /// A line for each run: by rank if there are several, with what ended its tasks.
    pub(crate) fn markdown_results(&self, s: &mut String) {
        let ranked = self.ranking().is_some();
        let (head, line) = if ranked { ("| rank ", "|--:") } else { ("", "") };
        let _ = write!(
            s,
            "{head}| planner on {} | tasks | success % | time s | \\|roll\\| ° | \\|pitch\\| ° | rollover | stuck | timeout | out | errors | {} |\n\
             {line}|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|{}\n",
            text(&self.runs.scope()),
            Flag::ALL.map(|flag| text(flag.title())).join(" | "),
            "--:|".repeat(Flag::ALL.len()),
        );
        let order: Vec<(usize, Option<&Place>)> = match self.ranking() {
            Some(ranking) => ranking.places.iter().map(|p| (p.run, Some(p))).collect(),
            None => (0..self.figures.len()).map(|run| (run, None)).collect(),
        };
        for (k, place) in order {
            let (run, f) = (&self.runs.runs[k], &self.figures[k]);
            let n = |o| f.all.count(o);
            if let Some(p) = place {
                let _ = write!(s, "| {} ", p.told());
            }
            let _ = writeln!(
                s,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                text(&run.label),
                f.all.tasks,
                mean(f.all.mean(Measure::Success), Measure::Success),
                mean(f.all.mean(Measure::Time), Measure::Time),
                mean(f.all.mean(Measure::Roll), Measure::Roll),
                mean(f.all.mean(Measure::Pitch), Measure::Pitch),
                n(Outcome::Rollover),
                n(Outcome::Stuck),
                n(Outcome::Timeout),
                n(Outcome::OutOfBounds),
                n(Outcome::PlannerError) + n(Outcome::SimError),
                f.all.flags.map(|n| n.map_or_else(|| "–".into(), |n| n.to_string())).join(" | "),
            );
        }
        if ranked {
            s.push_str(
                "\nRank: 1 + number of planners with a significantly higher success rate; \"1–3\": possible ranks.\n",
            );
        }
    }

    /// Differences of success, each planner with each.
    fn markdown_matrix(&self, s: &mut String, c: &Comparison, ranking: &Ranking) {
        s.push_str("\n| success, points: row − column |");
        let order: Vec<usize> = ranking.places.iter().map(|p| p.run).collect();
        for run in &order {
            let _ = write!(s, " {} |", text(&self.runs.runs[*run].label));
        }
        let _ = writeln!(s, "\n|:--|{}", "--:|".repeat(order.len()));
        for row in &order {
            let _ = write!(s, "| {} |", text(&self.runs.runs[*row].label));
            for column in &order {
                let found = c.between(*row, *column, Measure::Success);
                let cell = found.and_then(|d| Some((d.verdict?, d.difference?.mean)));
                let cell = cell.map_or_else(String::new, |(verdict, mean)| {
                    let value = signed(Measure::Success.shown(mean), 1);
                    if verdict.is_certain() { format!("**{value}**") } else { value }
                });
                let _ = write!(s, " {cell} |");
            }
            s.push('\n');
        }
        s.push_str("\nBold: significant after correction over all pairs.\n");
    }

    /// A line for each pair: the differences with what is said of them.
    fn markdown_comparison(&self, s: &mut String, c: &Comparison, ranking: &Ranking) {
        s.push_str(
            "\n| X − Y | success, points | only X / only Y | p | time s | p | \\|roll\\| ° | p | \\|pitch\\| ° | p |\n\
             |:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
        );
        let runs = &self.runs.runs;
        for (x, y) in ranking.lines() {
            let Some(p) = c.pair(x, y) else { continue };
            let _ = write!(s, "| {} − {}", text(&runs[x].label), text(&runs[y].label));
            for d in Measure::ALL.into_iter().filter_map(|m| c.between(x, y, m)) {
                let _ = write!(s, " | {}", difference(d.difference, d.measure));
                if d.measure == Measure::Success {
                    let only = if x == p.a { [p.only_a, p.only_b] } else { [p.only_b, p.only_a] };
                    let _ = write!(s, " | {} / {}", only[0], only[1]);
                }
                let p = d.adjusted.map_or_else(|| "–".into(), p_value).replace('<', "&lt;");
                let _ = match d.verdict {
                    Some(v) if v.is_certain() => write!(s, " | **{p}** {}", d.told()),
                    Some(Verdict::TooFewWorlds { .. }) => write!(s, " | {}", d.told()),
                    _ => write!(s, " | {p}"),
                };
            }
            s.push_str(" |\n");
        }
        s.push_str(
            "\nPaired, on common tasks. p: sign-flip test over worlds, after Holm's correction over all pairs, separately for each measure. \
             Better: more success, less time, less tilt; the verdict is for X.\n",
        );
    }
}
