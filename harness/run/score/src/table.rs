//! Results as text for the terminal.

use std::fmt::Write as _;
use std::ops::Range;

use vb_record::{planner_with_params, suite_with_selection};

use crate::{Cause, Flag, Group, Outcome, Summary};

/// The heads of the columns of figures.
const COLUMNS: [&str; 10] = [
    "tasks",
    "success % (95 % CI)",
    "time s",
    "|roll| °",
    "|pitch| °",
    "rollover",
    "stuck",
    "timeout",
    "out",
    "errors",
];

/// The heads of all columns: those of the figures, and those of the flags, which count tasks whatever their outcome.
fn heads() -> Vec<String> {
    COLUMNS.iter().copied().chain(Flag::ALL.map(Flag::title)).map(str::to_owned).collect()
}

impl Summary {
    /// The result as a table of plain text, without escape sequences: a row for all tasks and one for each level. Where it is wider
    /// than `width` columns, it is parted into tables below each other, and texts are wrapped.
    #[must_use]
    pub fn table(&self, width: Option<usize>) -> String {
        let mut rows = Vec::new();
        if let Some(all) = &self.all {
            rows.push(TableRow::new("all".to_owned(), all));
        }
        let row = |split: &str, level: &str, g| TableRow::new(format!("{split} {level}"), g);
        rows.extend(self.elevation.iter().map(|(level, g)| row("elevation", level.name(), g)));
        rows.extend(self.terrain.iter().map(|(level, g)| row("terrain", level.name(), g)));
        rows.extend(self.density.iter().map(|(level, g)| row("density", level.name(), g)));
        table("", &rows, width) + &wrapped(&self.notes(), width)
    }

    /// What is told below the table, line by line.
    fn notes(&self) -> String {
        let mut out = String::new();
        // Writing to a string can't fail.
        let planner = planner_with_params(&self.planner, &self.params);
        let suite =
            suite_with_selection(&self.suite, self.planned, self.suite_tasks, self.selector.as_deref());
        let _ = writeln!(out, "{planner} on {suite}; rules: {}", self.rules);
        if !self.departures.is_empty() {
            let _ = writeln!(
                out,
                "not the benchmark's settings: {}; comparable only with runs of the same settings",
                self.departures.join(", ")
            );
        }
        if !self.undecided.is_empty() {
            // What could be decided is a biased choice, failures first: without the bounds it would mislead.
            let n = self.undecided.len() as u64;
            let (tasks, successes) = self
                .all
                .as_ref()
                .map_or((0, 0), |all| (all.tasks, all.outcomes.get(&Outcome::Success).copied().unwrap_or(0)));
            let percent = |successes: u64| 100.0 * successes as f64 / (tasks + n) as f64;
            let _ = writeln!(
                out,
                "{n} undecided, not counted above: their traces end before a decision of these rules. Success over all {} \
                 tasks is between {:.1} % and {:.1} %",
                tasks + n,
                percent(successes),
                percent(successes + n)
            );
        }
        if let Some(all) = self.all.as_ref().filter(|all| !all.causes.is_empty()) {
            let _ = writeln!(out, "failures: {}", by_cause(all).join(", "));
        }
        if let Some(used) = self.all.as_ref().and_then(|all| all.fuel) {
            let percent = |fraction: f64| 100.0 * fraction;
            let _ = writeln!(
                out,
                "maximum fuel: {} units for init ({:.3} % of the limit) and {} per step ({:.3} %; 99th percentile: {:.3} %); {:.1} \
                 MiB of memory",
                used.init,
                percent(used.init_fraction),
                used.max_step,
                percent(used.max_fraction),
                percent(used.p99_fraction),
                used.memory_bytes as f64 / f64::from(1 << 20)
            );
        }
        if !self.host_errors.is_empty() {
            let _ = writeln!(
                out,
                "{} failed because of the harness or the machine, not counted above (run --resume re-runs them): {}",
                self.host_errors.len(),
                self.host_errors.join(", ")
            );
        }
        if self.missing() > 0 {
            let _ = writeln!(out, "{} of {} tasks pending", self.missing(), self.planned);
        }
        out
    }
}

/// The columns of figures in as many parts as it takes to have each, with the names, within a width.
fn parts(widths: &[usize], width: Option<usize>) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let (mut begin, mut used) = (1, widths[0]);
    for (c, own) in widths.iter().enumerate().skip(1) {
        if c > begin && width.is_some_and(|width| used + 2 + own > width) {
            parts.push(begin..c);
            (begin, used) = (c, widths[0]);
        }
        used += 2 + own;
    }
    parts.push(begin..widths.len());
    parts
}

/// Lines of text, broken between words where they are longer than a width.
fn wrapped(text: &str, width: Option<usize>) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let mut column = 0;
        for word in line.split(' ') {
            let length = word.chars().count();
            if column > 0 && width.is_some_and(|width| column + 1 + length > width) {
                out.push_str("\n  ");
                column = 2;
            } else if column > 0 {
                out.push(' ');
                column += 1;
            }
            out.push_str(word);
            column += length;
        }
        out.push('\n');
    }
    out
}

/// How often each cause stopped the vehicle, the most frequent first.
fn by_cause(g: &Group) -> Vec<String> {
    let causes = Cause::by_frequency(|cause| g.causes.get(&cause).copied().unwrap_or(0));
    causes.iter().map(|(cause, n)| format!("{n} {}", cause.title())).collect()
}

/// A row of [`table`]: figures over some tasks.
#[derive(Clone, Debug, PartialEq)]
pub struct TableRow {
    /// What stands in front.
    pub name: String,
    /// The number of tasks.
    pub tasks: u64,
    /// The success rate, in [0, 1].
    pub success: f64,
    /// The 95 % interval of the rate, if there is one.
    pub interval: Option<[f64; 2]>,
    /// The means of the traversal time of successes, s, and of |roll| and |pitch| over all samples, degrees.
    pub means: [Option<f64>; 3],
    /// The number of tasks by outcome, in the order of [`Outcome::ALL`].
    pub outcomes: [u64; Outcome::ALL.len()],
    /// The number of tasks of which each flag is true, in the order of [`Flag::ALL`]; `None` where no task says it.
    pub flags: [Option<u64>; Flag::ALL.len()],
}

impl TableRow {
    fn new(name: String, g: &Group) -> Self {
        Self {
            name,
            tasks: g.tasks,
            success: g.success_rate,
            interval: g.success_low.zip(g.success_high).map(|(low, high)| [low, high]),
            means: [g.time_mean_s, g.metrics.roll_mean_deg, g.metrics.pitch_mean_deg],
            outcomes: Outcome::ALL.map(|outcome| g.outcomes.get(&outcome).copied().unwrap_or(0)),
            flags: Flag::ALL.map(|flag| g.flags.get(&flag).copied()),
        }
    }

    /// The figures as they are shown.
    fn cells(&self) -> Vec<String> {
        let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.1}"));
        let count = |outcome: Outcome| self.outcomes[outcome.index()];
        let percent = |rate: f64| 100.0 * rate;
        let [time, roll, pitch] = self.means.map(number);
        let figures: [String; COLUMNS.len()] = [
            self.tasks.to_string(),
            match self.interval {
                Some([low, high]) => {
                    format!("{:.1} ({:.1}-{:.1})", percent(self.success), percent(low), percent(high))
                }
                None => format!("{:.1}", percent(self.success)),
            },
            time,
            roll,
            pitch,
            count(Outcome::Rollover).to_string(),
            count(Outcome::Stuck).to_string(),
            count(Outcome::Timeout).to_string(),
            count(Outcome::OutOfBounds).to_string(),
            (count(Outcome::PlannerError) + count(Outcome::SimError)).to_string(),
        ];
        let flags = self.flags.iter().map(|n| n.map_or_else(|| "-".to_owned(), |n| n.to_string()));
        figures.into_iter().chain(flags).collect()
    }
}

/// Rows of figures as plain text under their heads, `head` over the names. Where that is wider than `width` columns, it is parted
/// into tables below each other.
#[must_use]
pub fn table(head: &str, rows: &[TableRow], width: Option<usize>) -> String {
    let line = |name: &str, cells: Vec<String>| -> Vec<String> {
        std::iter::once(name.to_owned()).chain(cells).collect()
    };
    let mut lines = vec![line(head, heads())];
    lines.extend(rows.iter().map(|row| line(&row.name, row.cells())));
    let widths: Vec<usize> =
        (0..lines[0].len()).map(|c| lines.iter().map(|l| l[c].chars().count()).max().unwrap_or(0)).collect();
    let mut table = String::new();
    for (k, part) in parts(&widths, width).into_iter().enumerate() {
        if k > 0 {
            table.push('\n');
        }
        for cells in &lines {
            let pad = |c: usize| " ".repeat(widths[c] - cells[c].chars().count());
            // Names to the left, figures to the right.
            let mut line = format!("{}{}", cells[0], pad(0));
            for c in part.clone() {
                line += &format!("  {}{}", pad(c), cells[c]);
            }
            table += line.trim_end();
            table.push('\n');
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_parted_so_that_each_part_with_the_names_is_within_the_width() {
        assert_eq!(parts(&[10, 5, 5, 5], None), vec![1..4; 1]);
        // 10 + 2 + 5 + 2 + 5 = 24.
        assert_eq!(parts(&[10, 5, 5, 5], Some(24)), [1..3, 3..4]);
        assert_eq!(parts(&[10, 5, 5, 5], Some(23)), [1..2, 2..3, 3..4]);
        // A column that is too wide stands alone.
        assert_eq!(parts(&[10, 50, 5], Some(20)), [1..2, 2..3]);
    }

    #[test]
    fn lines_are_broken_between_words() {
        assert_eq!(wrapped("one two three\nfour\n", None), "one two three\nfour\n");
        assert_eq!(wrapped("one two three\nfour\n", Some(9)), "one two\n  three\nfour\n");
        assert_eq!(wrapped("seventeen letters\n", Some(5)), "seventeen\n  letters\n");
    }
}
