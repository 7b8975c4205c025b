//! Tables for LaTeX.

use std::fmt::Write as _;

use vb_page::{number, p_value, signed};
use vb_score::{Flag, Outcome};

use crate::Report;
use crate::failures::{failures, groups};
use crate::figures::{Estimate, Measure};
use crate::runs::one_line;
use crate::verdict::Verdict;

/// Foreign text in a table: nothing of it is a command, a comment or an argument.
fn text(t: &str) -> String {
    let mut out = String::with_capacity(t.len());
    for c in one_line(t, 120).chars() {
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '`' => out.push_str("\\textasciigrave{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '|' => out.push_str("\\textbar{}"),
            '−' => out.push_str("$-$"),
            '…' => out.push_str("\\dots{}"),
            '\u{2009}' => out.push_str("\\,"),
            '\u{a0}' => out.push('~'),
            // In the place of what isn't printable; LaTeX's fonts lack it.
            '\u{fffd}' => {}
            // Behind the end of a row `[` and `*` would belong to it, and `--` would be one dash.
            '[' | ']' | '*' | '-' | '"' | '\'' => {
                out.push('{');
                out.push(c);
                out.push('}');
            }
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// A number with the minus sign of mathematics.
fn maths(number: &str) -> String {
    number.replace('−', "$-$")
}

/// A mean with its interval; the mean bold if it is the best for certain.
fn mean(e: Option<Estimate>, measure: Measure, best: bool) -> String {
    let Some(e) = e else { return "--".into() };
    let v = |v: f64| maths(&number(measure.shown(v), 1));
    let shown = if best { format!("\\textbf{{{}}}", v(e.mean)) } else { v(e.mean) };
    e.interval.map_or_else(|| shown.clone(), |i| format!("{shown} [{}, {}]", v(i.low), v(i.high)))
}

fn head(measure: Measure) -> &'static str {
    match measure {
        Measure::Success => "success, \\%",
        Measure::Time => "time, s",
        Measure::Roll => "$|$roll$|$, $^\\circ$",
        Measure::Pitch => "$|$pitch$|$, $^\\circ$",
    }
}

fn difference_unit(measure: Measure) -> &'static str {
    match measure {
        Measure::Success => "points",
        Measure::Time => "s",
        Measure::Roll | Measure::Pitch => "$^\\circ$",
    }
}

impl Report {
    /// The tables by the names of their files without ending: `results`, `comparison` of several runs, and `causes` if tasks
    /// failed. Each is a `tabular` with the rules of the package booktabs, to be put into a `table` with its caption.
    #[must_use]
    pub fn latex(&self) -> Vec<(&'static str, String)> {
        let tables = [
            ("results", Some(self.latex_results())),
            ("comparison", self.latex_comparison()),
            ("causes", self.latex_causes()),
        ];
        tables.into_iter().filter_map(|(name, table)| Some((name, table?))).collect()
    }

    /// What stands before a table, for those who read the file.
    fn latex_notes(&self, notes: &[&str]) -> String {
        let mut s = String::new();
        // A comment ends with its line, and no foreign text has another.
        for title in self.title.iter().map(|t| one_line(t, 200)) {
            let _ = writeln!(s, "% {title}");
        }
        let _ = writeln!(
            s,
            "% Verti-Bench in Rust, {}. Needs \\usepackage{{booktabs}}.",
            one_line(&self.runs.scope(), 200)
        );
        for note in self.settings_notes() {
            let _ = writeln!(s, "% {note}");
        }
        notes.iter().for_each(|note| {
            let _ = writeln!(s, "% {note}");
        });
        s
    }

    /// Whether a run has the best mean of all and is better than each other for certain, by the deciding test.
    fn is_best(&self, run: usize, measure: Measure) -> bool {
        let Some(c) = self.comparison.as_ref().filter(|_| self.unranked.is_none()) else { return false };
        let mean = |k: usize| self.figures[k].all.mean(measure).map(|e| e.mean);
        let Some(own) = mean(run) else { return false };
        (0..self.figures.len()).filter(|k| *k != run).all(|other| {
            let verdict = c.between(run, other, measure).and_then(|d| d.verdict);
            let ahead = mean(other).is_none_or(|m| if measure.more_is_better() { own > m } else { own < m });
            verdict == Some(Verdict::Better) && ahead
        })
    }

    fn latex_results(&self) -> String {
        let mut s = self.latex_notes(&[
            "In brackets: 95 % intervals, bias-corrected and accelerated bootstrap over worlds.",
            "Time: of successful tasks; angles: over all samples of all tasks.",
            "Rollover: outcome according to the rules of the run; tilt: maximum |roll| or |pitch| in all tasks; strict: docs/scoring.md.",
        ]);
        let rows: Vec<(usize, Option<String>)> = match self.ranking() {
            Some(r) => r.places.iter().map(|p| (p.run, Some(p.told().replace('–', "--")))).collect(),
            None => (0..self.figures.len()).map(|run| (run, None)).collect(),
        };
        let ranked = self.ranking().is_some();
        if ranked {
            s.push_str(
                "% Rank: 1 + number of planners with a significantly higher success rate; a range contains the possible ranks.\n\
                 % Bold: best, and significantly better than each other planner (sign-flip test over worlds, Holm's correction, 5 %).\n",
            );
        }
        let (columns, first) = if ranked { ("rl", "rank & planner") } else { ("l", "planner") };
        let _ = write!(s, "\\begin{{tabular}}{{@{{}}{columns}rrrrrrrr@{{}}}}\n\\toprule\n{first} & tasks");
        for measure in Measure::ALL {
            let _ = write!(s, " & {}", head(measure));
        }
        // Rollover by both rules, and success by the strict rules.
        s.push_str(" & rollover, \\% & tilt $>$ 30$^\\circ$, \\% & strict, \\%");
        s.push_str(" \\\\\n\\midrule\n");
        for (run, rank) in rows {
            let all = &self.figures[run].all;
            if let Some(rank) = rank {
                let _ = write!(s, "{rank} & ");
            }
            let _ = write!(s, "{} & {}", text(&self.runs.runs[run].label), all.tasks);
            for measure in Measure::ALL {
                let _ = write!(s, " & {}", mean(all.mean(measure), measure, self.is_best(run, measure)));
            }
            let rollover = 100.0 * all.count(Outcome::Rollover) as f64 / all.tasks.max(1) as f64;
            let flagged = [Flag::Tilted, Flag::Strict].map(|flag| all.flagged_percent(flag));
            for percent in std::iter::once(Some(rollover)).chain(flagged) {
                let _ = write!(s, " & {}", percent.map_or_else(|| "--".into(), |v| number(v, 1)));
            }
            s.push_str(" \\\\\n");
        }
        s.push_str("\\bottomrule\n\\end{tabular}\n");
        s
    }

    fn latex_comparison(&self) -> Option<String> {
        let (c, ranking) = self.comparison.as_ref().zip(self.order.as_ref())?;
        let mut s = self.latex_notes(&[
            "Differences X - Y on common tasks; of time, on tasks that both complete. In brackets: 95 % intervals, bootstrap",
            "over worlds. p: sign-flip test over worlds with Holm's correction over all pairs, separately for each measure.",
            "Bold: significant at 5 %. Better: more success, less time, less tilt; the verdict is for X.",
        ]);
        s.push_str(
            "\\begin{tabular}{@{}llrrrl@{}}\n\\toprule\nX $-$ Y & measure & difference & 95\\,\\% interval & $p$ & X is \\\\\n",
        );
        for (x, y) in ranking.lines() {
            s.push_str("\\midrule\n");
            let name = |run: usize| text(&self.runs.runs[run].label);
            for d in Measure::ALL.into_iter().filter_map(|m| c.between(x, y, m)) {
                let pair = if d.measure == Measure::Success {
                    format!("{} $-$ {}", name(x), name(y))
                } else {
                    String::new()
                };
                let v = |v: f64| maths(&signed(d.measure.shown(v), 2));
                let certain = d.verdict.is_some_and(Verdict::is_certain);
                let bold = |t: String| if certain { format!("\\textbf{{{t}}}") } else { t };
                let interval = d.difference.and_then(|e| e.interval);
                let few = matches!(d.verdict, Some(Verdict::TooFewWorlds { .. }));
                let p = d.adjusted.filter(|_| !few).map_or_else(
                    || "--".into(),
                    |p| if p < 0.001 { "$<$ 0.001".to_owned() } else { p_value(p) },
                );
                let measure = match d.measure {
                    Measure::Success => "success",
                    Measure::Time => "time",
                    Measure::Roll => "$|$roll$|$",
                    Measure::Pitch => "$|$pitch$|$",
                };
                let _ = writeln!(
                    s,
                    "{pair} & {measure}, {} & {} & {} & {p} & {} \\\\",
                    difference_unit(d.measure),
                    d.difference.map_or_else(|| "--".into(), |e| bold(v(e.mean))),
                    interval.map_or_else(|| "--".into(), |i| format!("[{}, {}]", v(i.low), v(i.high))),
                    d.short(),
                );
            }
        }
        s.push_str("\\bottomrule\n\\end{tabular}\n");
        Some(s)
    }

    fn latex_causes(&self) -> Option<String> {
        let (groups, failures) = (groups(self), failures(self));
        if failures.is_empty() {
            return None;
        }
        let mut s = self.latex_notes(&["Number of tasks, and percentage of all tasks of the column."]);
        let _ = write!(s, "\\begin{{tabular}}{{@{{}}l{}@{{}}}}\n\\toprule\ncause", "r".repeat(groups.len()));
        for g in &groups {
            let split = g.split.map_or_else(String::new, |split| format!("{}: ", split.name()));
            let _ = write!(s, " & {}", text(&(split + &g.name)));
        }
        s.push_str(" \\\\\n\\midrule\n");
        let cell = |n: u64, tasks: u64| match n {
            0 => "--".to_owned(),
            n => format!("{n} ({}\\,\\%)", number(100.0 * n as f64 / tasks.max(1) as f64, 1)),
        };
        for failure in &failures {
            s.push_str(&text(&failure.title()));
            for g in &groups {
                let _ = write!(s, " & {}", cell(failure.count(g.figures), g.figures.tasks));
            }
            s.push_str(" \\\\\n");
        }
        s.push_str("\\midrule\nall failures");
        for g in &groups {
            let n = failures.iter().map(|f| f.count(g.figures)).sum();
            let _ = write!(s, " & {}", cell(n, g.figures.tasks));
        }
        s.push_str(" \\\\\ntasks");
        for g in &groups {
            let _ = write!(s, " & {}", g.figures.tasks);
        }
        s.push_str(" \\\\\n\\bottomrule\n\\end{tabular}\n");
        Some(s)
    }
}

#[cfg(test)]
mod tests {
    use super::text;

    #[test]
    fn nothing_of_a_foreign_text_is_a_command() {
        assert_eq!(text(r"\input{x}"), r"\textbackslash{}input\{x\}");
        assert_eq!(
            text("a_b & 50 % #1 $x$ ~^"),
            r"a\_b \& 50 \% \#1 \$x\$ \textasciitilde{}\textasciicircum{}"
        );
        assert_eq!(text("[*] a--b <c>\n\u{202e}%d"), r"{[}{*}{]} a{-}{-}b \textless{}c\textgreater{} \%d");
    }
}
