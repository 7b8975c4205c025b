//! Many runs of one plan in one table.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use vb_page::{Page, SORTED_TABLES, TABLE_STYLE, escape, number};
use vb_score::{Group, Outcome, Summary};

use crate::markdown::text;
use crate::table::no_formula;

/// A run of a sweep.
#[derive(Clone, Debug)]
pub struct SweepRow {
    /// The name of the run.
    pub run: String,
    /// What its planner is called in the sweep, with its parameters.
    pub planner: String,
    /// The name of the vehicle.
    pub vehicle: String,
    /// The name of the perception profile.
    pub perception: String,
    /// The seed.
    pub seed: u64,
    /// The result.
    pub summary: Summary,
}

impl SweepRow {
    /// What a planner can be compared with others under: vehicle and perception profile.
    #[must_use]
    pub fn setting(&self) -> String {
        format!("{}--{}", self.vehicle, self.perception)
    }

    fn success(&self) -> Option<f64> {
        self.summary.all.as_ref().map(|all| 100.0 * all.success_rate)
    }
}

/// The runs of one planner in one setting.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    /// Mean over the seeds, and the least and the greatest, percent.
    mean: f64,
    least: f64,
    greatest: f64,
    seeds: usize,
}

impl Cell {
    fn of(values: &[f64]) -> Option<Self> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let (least, greatest) =
            (values.iter().copied().reduce(f64::min)?, values.iter().copied().reduce(f64::max)?);
        Some(Self { mean, least, greatest, seeds: values.len() })
    }

    fn text(self) -> String {
        let v = |v| number(v, 1);
        if self.seeds < 2 {
            return v(self.mean);
        }
        format!("{} [{}, {}]", v(self.mean), v(self.least), v(self.greatest))
    }
}

/// Planners by settings, in the order of the plan.
struct Pivot<'a> {
    planners: Vec<&'a str>,
    settings: Vec<(&'a str, &'a str)>,
    cells: BTreeMap<(&'a str, (&'a str, &'a str)), Cell>,
}

impl<'a> Pivot<'a> {
    fn new(rows: &'a [SweepRow]) -> Self {
        let mut values: BTreeMap<_, Vec<f64>> = BTreeMap::new();
        let (mut planners, mut settings) = (Vec::new(), Vec::new());
        let (mut known_planners, mut known_settings) = (BTreeSet::new(), BTreeSet::new());
        for row in rows {
            let setting = (row.vehicle.as_str(), row.perception.as_str());
            if known_planners.insert(row.planner.as_str()) {
                planners.push(row.planner.as_str());
            }
            if known_settings.insert(setting) {
                settings.push(setting);
            }
            values.entry((row.planner.as_str(), setting)).or_default().extend(row.success());
        }
        let cells = values.into_iter().filter_map(|(key, values)| Some((key, Cell::of(&values)?))).collect();
        Self { planners, settings, cells }
    }

    fn seeds(&self) -> usize {
        self.cells.values().map(|c| c.seeds).max().unwrap_or(0)
    }

    fn about(&self) -> String {
        let seeds = match self.seeds() {
            0 | 1 => String::new(),
            n => format!("; mean [least, greatest] over {n} seeds"),
        };
        format!("Success in percent of the tasks, by vehicle and perception profile{seeds}.")
    }
}

/// Success of each planner in each setting, as GitHub-flavoured Markdown.
#[must_use]
pub fn sweep_markdown(name: &str, rows: &[SweepRow]) -> String {
    let pivot = Pivot::new(rows);
    let mut s = format!("| {} |", text(name));
    for (vehicle, perception) in &pivot.settings {
        let _ = write!(s, " {}, {} |", text(vehicle), text(perception));
    }
    let _ = writeln!(s, "\n|:--|{}", "--:|".repeat(pivot.settings.len()));
    for planner in &pivot.planners {
        let _ = write!(s, "| {} |", text(planner));
        for setting in &pivot.settings {
            let cell = pivot.cells.get(&(*planner, *setting)).map_or_else(|| "–".to_owned(), |c| c.text());
            let _ = write!(s, " {cell} |");
        }
        s.push('\n');
    }
    let _ = writeln!(s, "\n{}", pivot.about());
    s
}

/// The columns of a run's figures with their values.
fn columns(row: &SweepRow) -> Vec<(String, String)> {
    let all = row.summary.all.as_ref();
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let figure = |get: fn(&Group) -> Option<f64>| number(all.and_then(get));
    let mut columns: Vec<(String, String)> = [
        ("run", row.run.clone()),
        ("planner", row.planner.clone()),
        ("vehicle", row.vehicle.clone()),
        ("perception", row.perception.clone()),
        ("seed", row.seed.to_string()),
        ("tasks", all.map_or(0, |a| a.tasks).to_string()),
        ("success_rate", figure(|a| Some(a.success_rate))),
        ("success_low", figure(|a| a.success_low)),
        ("success_high", figure(|a| a.success_high)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into();
    for outcome in Outcome::ALL.into_iter().filter(|o| *o != Outcome::HostError) {
        let count = all.and_then(|a| a.outcomes.get(&outcome)).copied().unwrap_or(0);
        columns.push((outcome.to_string(), count.to_string()));
    }
    let more: [(&str, String); 4] = [
        ("time_mean_s", figure(|a| a.time_mean_s)),
        ("roll_task_mean_deg", figure(|a| a.roll_task_mean_deg)),
        ("pitch_task_mean_deg", figure(|a| a.pitch_task_mean_deg)),
        ("plugin_sha256", row.summary.plugin_sha256.clone()),
    ];
    columns.extend(more.map(|(name, value)| (name.to_owned(), value)));
    columns
}

/// A line for each run, as CSV with a header.
///
/// # Errors
/// Returns an error of the writer.
pub fn sweep_csv(rows: &[SweepRow]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (k, row) in rows.iter().enumerate() {
        let columns = columns(row);
        if k == 0 {
            writer.write_record(columns.iter().map(|(name, _)| name))?;
        }
        writer.write_record(columns.iter().map(|(_, value)| no_formula(value).into_owned()))?;
    }
    let bytes = writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The same as a page, with a link to the page of each setting in `compared` (`SETTING/index.html`).
#[must_use]
pub fn sweep_page(name: &str, rows: &[SweepRow], compared: &[&str]) -> String {
    let pivot = Pivot::new(rows);
    let mut body = format!(
        "<main><h1>{}</h1><p>{}</p><div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>planner",
        escape(name),
        escape(&pivot.about())
    );
    for (vehicle, perception) in &pivot.settings {
        let (setting, label) =
            (format!("{vehicle}--{perception}"), escape(&format!("{vehicle}, {perception}")));
        let _ = match compared.contains(&setting.as_str()) {
            true => write!(body, "<th class=\"n\"><a href=\"{}/index.html\">{label}</a>", escape(&setting)),
            false => write!(body, "<th class=\"n\">{label}"),
        };
    }
    body.push_str("</tr></thead><tbody>");
    for planner in &pivot.planners {
        let _ = write!(body, "<tr><th>{}", escape(planner));
        for setting in &pivot.settings {
            let _ = match pivot.cells.get(&(*planner, *setting)) {
                Some(cell) => write!(body, "<td class=\"n\" data-v=\"{}\">{}", cell.mean, cell.text()),
                None => write!(body, "<td class=\"n\" data-v=\"-1\">–"),
            };
        }
        body.push_str("</tr>");
    }
    body.push_str("</tbody></table></div><p class=\"about\">A click on a column's head sorts by it");
    if !compared.is_empty() {
        body.push_str("; a link leads to the comparison of its planners");
    }
    body.push_str(". <a href=\"runs.csv\">All runs as CSV</a>.</p></main>");
    Page { title: name, styles: &[TABLE_STYLE], body: &body, script: SORTED_TABLES, ..Page::default() }.html()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(planner: &str, vehicle: &str, seed: u64, success: u64) -> SweepRow {
        let group = serde_json::json!({
            "tasks": 10, "outcomes": {"success": success, "stuck": 10 - success}, "three_way": {},
            "success_rate": success as f64 / 10.0, "clamped": 0,
        });
        let summary = serde_json::json!({
            "schema": 3, "harness_version": "0.2.0", "suite": "s", "suite_hash": "", "planner": planner, "plugin_sha256": "aa",
            "vehicle": vehicle, "scale": 1.0, "seed": seed, "rules": "paper", "rules_hash": "", "planned": 10, "undecided": [],
            "all": group, "elevation": {}, "terrain": {}, "density": {}, "world": {},
        });
        SweepRow {
            run: format!("{planner}--{vehicle}--oracle--{seed}"),
            planner: planner.to_owned(),
            vehicle: vehicle.to_owned(),
            perception: "oracle".to_owned(),
            seed,
            summary: serde_json::from_value(summary).unwrap(),
        }
    }

    fn rows() -> Vec<SweepRow> {
        vec![
            row("pid,speed=3", "hmmwv", 0, 4),
            row("pid,speed=3", "hmmwv", 1, 5),
            row("=<b>", "gator", 0, 10),
        ]
    }

    #[test]
    fn a_cell_has_the_mean_and_the_range_over_seeds_and_what_was_not_driven_is_a_dash() {
        let markdown = sweep_markdown("mine", &rows());
        assert!(
            markdown.starts_with("| mine | hmmwv, oracle | gator, oracle |\n|:--|--:|--:|\n"),
            "{markdown}"
        );
        assert!(markdown.contains("| pid,speed=3 | 45.0 [40.0, 50.0] | – |"), "{markdown}");
        assert!(markdown.contains("| =&lt;b&gt; | – | 100.0 |"), "{markdown}");
        assert!(markdown.contains("mean [least, greatest] over 2 seeds"));
    }

    #[test]
    fn a_page_sorts_and_links_and_its_texts_are_no_markup() {
        let page = sweep_page("mine", &rows(), &["hmmwv--oracle"]);
        assert!(
            page.contains("<a href=\"hmmwv--oracle/index.html\">hmmwv, oracle</a>")
                && !page.contains("gator--oracle/")
        );
        assert!(
            page.contains("data-v=\"45\">45.0 [40.0, 50.0]")
                && page.contains("&lt;b&gt;")
                && !page.contains("<b>")
        );
    }

    #[test]
    fn a_table_has_a_line_for_each_run_and_no_formulas() {
        let csv = sweep_csv(&rows()).unwrap();
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with("run,planner,vehicle,perception,seed,tasks,success_rate,"), "{csv}");
        assert!(
            lines[1].starts_with("pid,speed=3--hmmwv")
                || lines[1]
                    .starts_with("\"pid,speed=3--hmmwv--oracle--0\",\"pid,speed=3\",hmmwv,oracle,0,10,0.4,"),
            "{csv}"
        );
        assert_eq!(lines.len(), 4);
        assert!(lines[3].starts_with("'=<b>--gator--oracle--0,'=<b>,gator,oracle,0,10,1,"), "{csv}");
        assert!(
            lines[0].contains(",success,rollover,stuck,timeout,") && !lines[0].contains("host_error"),
            "{csv}"
        );
    }
}
