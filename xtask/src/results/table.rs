//! Summaries of runs as tables.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{Entry, published};

type Row<'a> = (&'a Entry, Value);

const LEVELS: [&str; 3] = ["low", "medium", "high"];

/// The results of every row, and what was published of its planners below.
pub(super) fn results(rows: &[Row<'_>]) -> String {
    let mut text = String::from(
        "| | success % (95 %) | low | medium | high | rigid | deformable | mixed | rollover % | stuck % | tilt > 30° % | \
         time s | mean \\|roll\\| ° (low, medium, high) | mean \\|pitch\\| ° (low, medium, high) | strict % | > 2.5 g % | > 6 W % |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (entry, summary) in rows {
        let all = &summary["all"];
        let [low, high] = ["success_low", "success_high"].map(|k| percent(&all[k]));
        let by = |group: &str, name: &str, figure: &str| number(&summary[group][name][figure]);
        let success = |group: &str, name: &str| percent(&summary[group][name]["success_rate"]);
        let angles = |figure: &str| LEVELS.map(|l| by("elevation", l, figure)).join(", ");
        let mut cells =
            vec![entry.label.to_owned(), format!("{} ({low}–{high})", percent(&all["success_rate"]))];
        cells.extend(LEVELS.map(|l| success("elevation", l)));
        cells.extend(["rigid", "deformable", "mixed"].map(|t| success("terrain", t)));
        cells.extend(["rollover", "stuck"].map(|o| fraction(&all["three_way"][o], all)));
        cells.push(fraction(&all["flags"]["tilted"], all));
        cells.push(number(&all["time_mean_s"]));
        cells.push(angles("roll_mean_deg"));
        cells.push(angles("pitch_mean_deg"));
        cells.extend(["strict", "over_2_5_g", "over_6_w"].map(|f| fraction(&all["flags"][f], all)));
        text += &line(&cells);
    }
    let mut told = Vec::new();
    for (entry, _) in rows {
        let Some(p) = published::of(entry.plugin).filter(|p| !told.contains(&p.plugin)) else { continue };
        told.push(p.plugin);
        let name = entry.label.split(',').next().unwrap_or(entry.label);
        let mut cells = vec![format!("paper: {name}"), format!("{:.1}", p.success)];
        cells.extend(p.levels.iter().map(|l| format!("{:.1}", l.success)));
        cells.extend(["", "", ""].map(str::to_owned));
        cells.extend([p.rollover, p.stuck].map(|f| format!("{f:.1}")));
        cells.push(String::new());
        // Over the successful trials, as ours.
        let weight: f64 = p.levels.iter().map(|l| l.success).sum();
        let time: f64 = p.levels.iter().map(|l| l.success * l.time).sum();
        cells.push(format!("{:.1}", time / weight));
        let angles = |of: fn(&published::Level) -> f64| {
            p.levels.iter().map(|l| format!("{:.1}", of(l))).collect::<Vec<_>>().join(", ")
        };
        cells.push(angles(|l| l.roll));
        cells.push(angles(|l| l.pitch));
        cells.extend(["", "", ""].map(str::to_owned));
        text += &line(&cells);
    }
    text
}

/// A few columns of [`results`], for the README.
pub(super) fn summary(rows: &[Row<'_>]) -> String {
    let mut text = String::from(
        "| | success % (95 %) | low | medium | high | rollover % | stuck % | tilt > 30° % | time s |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let wanted =
        ["success % (95 %)", "low", "medium", "high", "rollover %", "stuck %", "tilt > 30° %", "time s"];
    let table = results(rows);
    let mut lines =
        table.lines().map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect::<Vec<_>>());
    let columns: Vec<usize> = lines
        .next()
        .map(|head| wanted.iter().filter_map(|w| head.iter().position(|c| c == w)).collect())
        .unwrap_or_default();
    for cells in lines.skip(1) {
        let chosen = std::iter::once(&0).chain(&columns).map(|&c| cells.get(c).copied().unwrap_or_default());
        text += &line(&chosen.map(str::to_owned).collect::<Vec<_>>());
    }
    text
}

/// Causes of failure, % of the tasks, in order of decreasing frequency.
pub(super) fn causes(rows: &[Row<'_>]) -> String {
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    for (cause, count) in rows.iter().filter_map(|(_, s)| s["all"]["causes"].as_object()).flatten() {
        *counts.entry(cause).or_default() += count.as_u64().unwrap_or_default();
    }
    let mut causes: Vec<(&str, u64)> = counts.into_iter().collect();
    causes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let names = causes.iter().map(|(cause, _)| cause.replace('_', " "));
    let mut text = line(&std::iter::once(String::new()).chain(names).collect::<Vec<_>>());
    text += &line(&vec!["---".to_owned(); causes.len() + 1]).replace(' ', "");
    for (entry, summary) in rows {
        let all = &summary["all"];
        let shares = causes.iter().map(|(cause, _)| fraction(&all["causes"][cause], all));
        text += &line(&std::iter::once(entry.label.to_owned()).chain(shares).collect::<Vec<_>>());
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

/// A count as percentage of a group's tasks.
fn fraction(count: &Value, group: &Value) -> String {
    let tasks = group["tasks"].as_f64().unwrap_or(f64::NAN);
    format!("{:.1}", 100.0 * count.as_f64().unwrap_or(0.0) / tasks)
}

#[cfg(test)]
mod tests {
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
        let pid = Entry { plugin: "pid", label: "PID", params: &[] };
        let slow = Entry { plugin: "pid", label: "PID, 3 m/s", params: &["speed=3"] };
        let rows = [(&pid, summary.clone()), (&slow, summary)];
        let text = results(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 5, "{text}");
        let columns = |line: &str| line.replace("\\|", "").matches('|').count();
        assert!(lines.iter().all(|line| columns(line) == 18), "{text}");
        assert!(lines[2].starts_with(
            "| PID | 25.0 (10.0–50.0) | 25.0 | 25.0 | 25.0 | 25.0 | – | – | 12.5 | 62.5 | 37.5 | – |"
        ));
        assert!(lines[4].starts_with("| paper: PID | 48.8 | 85.9 |"), "{text}");
        let text = super::summary(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[2], "| PID | 25.0 (10.0–50.0) | 25.0 | 25.0 | 25.0 | 12.5 | 62.5 | 37.5 | – |");
        assert!(
            lines[4].starts_with("| paper: PID | 48.8 | 85.9 | 50.4 | 7.9 | 14.7 | 36.5 |  | 24."),
            "{text}"
        );
        let text = causes(&rows);
        assert_eq!(text.lines().next(), Some("|  | high centred | rollover at speed |"));
        assert_eq!(text.lines().last(), Some("| PID, 3 m/s | 62.5 | 12.5 |"));
        assert_eq!(text.lines().nth(1), Some("|---|---|---|"));
    }
}
