//! Tables for a paper or a pull request.

use std::fmt::Write as _;

use vb_score::Outcome;

use crate::Report;
use crate::figures::{Estimate, Measure};
use vb_page::{number, p_value};

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

fn mean(e: Option<Estimate>, measure: Measure) -> String {
    let v = |v: f64| number(measure.shown(v), 1);
    match e {
        None => "–".into(),
        Some(Estimate { mean, interval: Some(i) }) => format!("{} [{}, {}]", v(mean), v(i.low), v(i.high)),
        Some(Estimate { mean, interval: None }) => v(mean),
    }
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
            let difference = point.difference.as_ref().and_then(|d| d.difference);
            let _ = writeln!(
                s,
                "| {} | {} | {} | {} | {} | {} |",
                text(&line.label),
                text(&r.profiles[point.profile]),
                mean(all.mean(Measure::Success), Measure::Success),
                mean(difference, Measure::Success),
                percent(Outcome::Rollover),
                percent(Outcome::Stuck),
            );
        }
        s.push_str("\nDifferences are from the planner's first perception profile, paired by tasks.\n");
    }

    /// The results, and the comparison if there is one, as GitHub-flavoured Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let runs = &self.runs.runs;
        let mut s = format!(
            "| planner on {} | tasks | success % | time s | \\|roll\\| ° | \\|pitch\\| ° | rollover | stuck | timeout | out | errors |\n\
             |:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
            text(&self.runs.scope())
        );
        for (run, f) in runs.iter().zip(&self.figures) {
            let n = |o| f.all.count(o);
            let _ = writeln!(
                s,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
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
            );
        }
        s.push_str("\nIn brackets: 95 % intervals, bootstrap over worlds. Time: of successes; angles: over all samples.\n");
        for run in runs.iter().filter(|r| r.missing() > 0) {
            let _ = writeln!(
                s,
                "\n{}: {} of {} tasks are not done yet.",
                text(&run.label),
                run.missing(),
                run.header.tasks
            );
        }
        self.markdown_robustness(&mut s);
        let Some(c) = &self.comparison else { return s };
        s.push_str(
            "\n| second − first | success, points | only first / only second | p (McNemar) | time s | p (Wilcoxon) | \\|roll\\| ° | p | \
             \\|pitch\\| ° | p |\n|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
        );
        for p in &c.pairs {
            let _ = write!(s, "| {} − {}", text(&runs[p.b].label), text(&runs[p.a].label));
            for d in &p.differences {
                let _ = write!(s, " | {}", mean(d.difference, d.measure));
                if d.measure == Measure::Success {
                    let _ = write!(s, " | {} / {}", p.only_a, p.only_b);
                }
                let _ =
                    write!(s, " | {}", d.adjusted.map_or_else(|| "–".into(), p_value).replace('<', "&lt;"));
            }
            s.push_str(" |\n");
        }
        s.push_str("\nPaired, on common tasks; p-values after Holm's correction over the whole table.\n");
        s
    }
}
