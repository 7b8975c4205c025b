//! Summaries of runs as tables.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Row;
use super::published::{self, Published};

const LEVELS: [&str; 3] = ["low", "medium", "high"];

/// A column: its header, whether the summary has it, and its cells of a run and of the published results.
struct Column {
    header: &'static str,
    in_summary: bool,
    ours: fn(&Row<'_>) -> String,
    paper: fn(&Published) -> String,
}

const COLUMNS: [Column; 19] = [
    Column { header: "class", in_summary: true, ours: |r| r.entry.class.name().to_owned(), paper: none },
    Column { header: "rank", in_summary: true, ours: rank, paper: none },
    Column {
        header: "success % (95 %)",
        in_summary: true,
        ours: |Row { summary: s, .. }| {
            let [rate, low, high] =
                ["success_rate", "success_low", "success_high"].map(|k| percent(&s["all"][k]));
            format!("{rate} ({low}–{high})")
        },
        paper: |p| format!("{:.1}", p.success),
    },
    Column {
        header: "of those known to be solvable %",
        in_summary: true,
        ours: |r| r.of_solvable.map_or_else(|| "–".to_owned(), |share| format!("{:.1}", 100.0 * share)),
        paper: none,
    },
    Column { header: "low", in_summary: true, ours: |r| level(r, 0), paper: |p| published_level(p, 0) },
    Column { header: "medium", in_summary: true, ours: |r| level(r, 1), paper: |p| published_level(p, 1) },
    Column { header: "high", in_summary: true, ours: |r| level(r, 2), paper: |p| published_level(p, 2) },
    Column { header: "rigid", in_summary: false, ours: |r| terrain(r, "rigid"), paper: none },
    Column { header: "deformable", in_summary: false, ours: |r| terrain(r, "deformable"), paper: none },
    Column { header: "mixed", in_summary: false, ours: |r| terrain(r, "mixed"), paper: none },
    Column {
        header: "rollover %",
        in_summary: true,
        ours: |r| share(r, &r.all()["three_way"]["rollover"]),
        paper: |p| format!("{:.1}", p.rollover),
    },
    Column {
        header: "stuck %",
        in_summary: true,
        ours: |r| share(r, &r.all()["three_way"]["stuck"]),
        paper: |p| format!("{:.1}", p.stuck),
    },
    Column { header: "tilt > 30° %", in_summary: true, ours: |r| flag(r, "tilted"), paper: none },
    Column {
        header: "time s",
        in_summary: true,
        ours: |r| number(&r.all()["time_mean_s"]),
        // Mean over the successful trials, as ours.
        paper: |p| {
            let Some(levels) = &p.levels else { return String::new() };
            let weight: f64 = levels.iter().map(|l| l.success).sum();
            let time: f64 = levels.iter().map(|l| l.success * l.time).sum();
            format!("{:.1}", time / weight)
        },
    },
    Column {
        header: "mean \\|roll\\| ° (low, medium, high)",
        in_summary: false,
        ours: |r| angles(r, "roll_mean_deg"),
        paper: |p| published_angles(p, |l| l.roll),
    },
    Column {
        header: "mean \\|pitch\\| ° (low, medium, high)",
        in_summary: false,
        ours: |r| angles(r, "pitch_mean_deg"),
        paper: |p| published_angles(p, |l| l.pitch),
    },
    Column { header: "strict %", in_summary: false, ours: |r| flag(r, "strict"), paper: none },
    Column { header: "> 2.5 g %", in_summary: false, ours: |r| flag(r, "over_2_5_g"), paper: none },
    Column { header: "> 6 W %", in_summary: false, ours: |r| flag(r, "over_6_w"), paper: none },
];

/// The place, or all places that a tie may stand for.
fn rank(row: &Row<'_>) -> String {
    match row.rank {
        None => "–".to_owned(),
        Some([first, last]) if first == last => first.to_string(),
        Some([first, last]) => format!("{first}–{last}"),
    }
}

fn level(row: &Row<'_>, i: usize) -> String {
    percent(&row.summary["elevation"][LEVELS[i]]["success_rate"])
}

fn published_level(p: &Published, i: usize) -> String {
    p.levels.as_ref().map_or_else(String::new, |levels| format!("{:.1}", levels[i].success))
}

fn terrain(row: &Row<'_>, name: &str) -> String {
    percent(&row.summary["terrain"][name]["success_rate"])
}

fn flag(row: &Row<'_>, name: &str) -> String {
    share(row, &row.all()["flags"][name])
}

fn angles(row: &Row<'_>, figure: &str) -> String {
    LEVELS.map(|l| number(&row.summary["elevation"][l][figure])).join(", ")
}

fn published_angles(p: &Published, of: fn(&published::Level) -> f64) -> String {
    let levels = p.levels.iter().flatten();
    levels.map(|l| format!("{:.1}", of(l))).collect::<Vec<_>>().join(", ")
}

fn none(_: &Published) -> String {
    String::new()
}

/// All columns of every row, followed by the published results of its planners.
pub(super) fn results(rows: &[Row<'_>]) -> String {
    table(rows, |_| true)
}

/// The columns for the README.
pub(super) fn summary(rows: &[Row<'_>]) -> String {
    table(rows, |c| c.in_summary)
}

fn table(rows: &[Row<'_>], wanted: fn(&Column) -> bool) -> String {
    let row = |name: &str, cell: &dyn Fn(&Column) -> String| {
        let cells = COLUMNS.iter().filter(|c| wanted(c)).map(cell);
        line(&std::iter::once(name.to_owned()).chain(cells).collect::<Vec<_>>())
    };
    let mut text = row("planner", &|c| c.header.to_owned());
    text += &row("---", &|_| "---".to_owned()).replace(' ', "");
    for r in rows {
        text += &row(r.entry.label, &|c| (c.ours)(r));
    }
    let mut listed = Vec::new();
    for Row { entry, .. } in rows {
        let Some(p) = published::of(entry.plugin).filter(|p| !listed.contains(&p.plugin)) else { continue };
        listed.push(p.plugin);
        let name = entry.label.split(',').next().unwrap_or(entry.label);
        text += &row(&format!("paper: {name}"), &|c| (c.paper)(p));
    }
    text
}

/// Causes of failure, % of the tasks, in order of decreasing frequency.
pub(super) fn causes(rows: &[Row<'_>]) -> String {
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    for (cause, count) in rows.iter().filter_map(|r| r.all()["causes"].as_object()).flatten() {
        *counts.entry(cause).or_default() += count.as_u64().unwrap_or_default();
    }
    let mut causes: Vec<(&str, u64)> = counts.into_iter().collect();
    causes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let names = causes.iter().map(|(cause, _)| cause.replace('_', " "));
    let mut text = line(&std::iter::once("planner".to_owned()).chain(names).collect::<Vec<_>>());
    text += &line(&vec!["---".to_owned(); causes.len() + 1]).replace(' ', "");
    for r in rows {
        let shares = causes.iter().map(|(cause, _)| share(r, &r.all()["causes"][cause]));
        text += &line(&std::iter::once(r.entry.label.to_owned()).chain(shares).collect::<Vec<_>>());
    }
    text
}

fn line(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// A figure with one decimal; a dash where there is none.
fn number(value: &Value) -> String {
    value.as_f64().map_or_else(|| "–".to_owned(), |v| format!("{v:.1}"))
}

fn percent(value: &Value) -> String {
    value.as_f64().map_or_else(|| "–".to_owned(), |v| format!("{:.1}", 100.0 * v))
}

/// A count as percentage of a run's tasks.
fn share(row: &Row<'_>, count: &Value) -> String {
    let tasks = row.all()["tasks"].as_f64().unwrap_or(f64::NAN);
    format!("{:.1}", 100.0 * count.as_f64().unwrap_or(0.0) / tasks)
}

#[cfg(test)]
mod tests {
    use super::super::{Class, Entry};
    use super::*;
    use serde_json::json;

    #[test]
    fn tables_have_a_cell_for_each_column_and_the_paper_s_rows_once_a_planner() {
        let group = json!({
            "tasks": 8, "success_rate": 0.25, "success_low": 0.1, "success_high": 0.5, "time_mean_s": null,
            "three_way": {"success": 2, "rollover": 1, "stuck": 5}, "flags": {"tilted": 3},
            "causes": {"high_centred": 5, "rollover_at_speed": 1}, "roll_mean_deg": 1.25, "pitch_mean_deg": 2.0,
        });
        let levels = json!({"low": group, "medium": group, "high": group});
        let summary = json!({"all": group, "elevation": levels, "terrain": {"rigid": group}});
        let class = Class::Classical;
        let pid = Entry { plugin: "pid", label: "PID", params: &[], class };
        let slow = Entry { plugin: "pid", label: "PID, 3 m/s", params: &["speed=3"], class };
        let rows = [
            Row { entry: &pid, summary: summary.clone(), rank: Some([1, 2]), of_solvable: Some(0.5) },
            Row { entry: &slow, summary, rank: None, of_solvable: None },
        ];
        let text = results(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 5, "{text}");
        let columns = |line: &str| line.replace("\\|", "").matches('|').count();
        assert!(lines.iter().all(|line| columns(line) == 21), "{text}");
        assert!(lines[2].starts_with(
            "| PID | classical | 1–2 | 25.0 (10.0–50.0) | 50.0 | 25.0 | 25.0 | 25.0 | 25.0 | – | – | 12.5 | 62.5 | 37.5 | – |"
        ));
        assert!(lines[3].starts_with("| PID, 3 m/s | classical | – | 25.0 (10.0–50.0) | – |"), "{text}");
        assert!(lines[4].starts_with("| paper: PID |  |  | 48.8 |  | 85.9 |"), "{text}");
        let text = super::summary(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[2],
            "| PID | classical | 1–2 | 25.0 (10.0–50.0) | 50.0 | 25.0 | 25.0 | 25.0 | 12.5 | 62.5 | 37.5 | – |"
        );
        assert!(
            lines[4].starts_with("| paper: PID |  |  | 48.8 |  | 85.9 | 50.4 | 7.9 | 14.7 | 36.5 |  | 24."),
            "{text}"
        );
        let text = causes(&rows);
        assert_eq!(text.lines().next(), Some("| planner | high centred | rollover at speed |"));
        assert_eq!(text.lines().last(), Some("| PID, 3 m/s | 62.5 | 12.5 |"));
        assert_eq!(text.lines().nth(1), Some("|---|---|---|"));
    }
}
