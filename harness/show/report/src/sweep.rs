//! Many runs of one plan: planners in the settings in which they were run, with all seeds of a planner together.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use vb_page::{Page, SORTED_TABLES, TABLE_STYLE, escape, grouped, number};
use vb_score::{Flag, Group, Outcome, Summary, TableRow, table};

use crate::drawing::series::sample;
use crate::drawing::{DRAWING_STYLE, PAGE_STYLE};
use crate::figures::{Figures, Measure};
use crate::markdown::{mean, text};
use crate::page;
use crate::page::ranking::whisker;
use crate::page::sections::with_interval;
use crate::ranking::Ranking;
use crate::runs::one_line;
use crate::table::no_formula;
use crate::{Report, ReportError, Runs};

#[derive(Clone, Debug)]
pub struct SweepRow {
    pub run: String,
    pub dir: PathBuf,
    /// What its planner is called in the sweep, with its parameters.
    pub planner: String,
    pub vehicle: String,
    pub perception: String,
    pub seed: u64,
    pub summary: Summary,
}

/// A number of things.
fn counted(n: usize, thing: &str) -> String {
    format!("{} {thing}{}", grouped(n as u64), if n == 1 { "" } else { "s" })
}

impl SweepRow {
    /// What a planner can be compared with others under: vehicle and perception profile.
    #[must_use]
    pub fn setting(&self) -> String {
        setting(&self.vehicle, &self.perception)
    }

    fn success(&self) -> Option<f64> {
        self.summary.all.as_ref().map(|all| 100.0 * all.success_rate)
    }
}

fn setting(vehicle: &str, perception: &str) -> String {
    format!("{vehicle}--{perception}")
}

/// The planners in one setting.
struct Setting {
    vehicle: String,
    perception: String,
    /// Each planner's runs as one.
    report: Report,
    /// Of each of these its number in the order of the plan.
    planners: Vec<usize>,
    /// Of each of these the least and the greatest success over the seeds, percent, if there are several.
    seeds: Vec<Option<[f64; 2]>>,
}

impl Setting {
    fn name(&self) -> String {
        one_line(&format!("{}, {}", self.vehicle, self.perception), 120)
    }

    /// The figures of a planner by its number in the plan, and the range over its seeds.
    fn of(&self, planner: usize) -> Option<(&Figures, Option<[f64; 2]>)> {
        let k = self.planners.iter().position(|p| *p == planner)?;
        Some((&self.report.figures()[k].all, self.seeds[k]))
    }

    fn ranking(&self) -> Ranking {
        self.report.order.clone().unwrap_or_else(Ranking::alone)
    }
}

/// The runs of a sweep that are done.
pub struct Sweep {
    name: String,
    rows: Vec<SweepRow>,
    /// In the order of the plan, by which they look.
    planners: Vec<String>,
    settings: Vec<Setting>,
}

impl Sweep {
    /// Reads the runs, in the order of the plan, setting by setting, and computes all figures.
    ///
    /// # Errors
    /// Returns an error if a run can't be read, or if runs are of several suites.
    pub fn new(name: &str, rows: Vec<SweepRow>) -> Result<Self, ReportError> {
        let mut planners: Vec<String> = Vec::new();
        let mut named: Vec<(&str, &str)> = Vec::new();
        let (mut known, mut known_settings) = (BTreeSet::new(), BTreeSet::new());
        for row in &rows {
            if known.insert(&row.planner) {
                planners.push(row.planner.clone());
            }
            if known_settings.insert(row.setting()) {
                named.push((&row.vehicle, &row.perception));
            }
        }
        let mut settings = Vec::with_capacity(named.len());
        for (vehicle, perception) in named {
            let own: Vec<&SweepRow> = rows
                .iter()
                .filter(|r| (r.vehicle.as_str(), r.perception.as_str()) == (vehicle, perception))
                .collect();
            let dirs: Vec<PathBuf> = own.iter().map(|r| r.dir.clone()).collect();
            let of: Vec<&str> = own.iter().map(|r| r.planner.as_str()).collect();
            let report = Report::new(Runs::read(&dirs)?.pooled(&of));
            let runs = &report.runs().runs;
            let number = |label: &str| planners.iter().position(|p| p == label).unwrap_or(0);
            let seeds = |label: &str| {
                let rates: Vec<f64> =
                    own.iter().filter(|r| r.planner == label).filter_map(|r| r.success()).collect();
                let least = rates.iter().copied().reduce(f64::min)?;
                let greatest = rates.iter().copied().reduce(f64::max)?;
                (rates.len() > 1).then_some([least, greatest])
            };
            settings.push(Setting {
                vehicle: vehicle.to_owned(),
                perception: perception.to_owned(),
                planners: runs.iter().map(|r| number(&r.label)).collect(),
                seeds: runs.iter().map(|r| seeds(&r.label)).collect(),
                report,
            });
        }
        Ok(Self { name: name.to_owned(), rows, planners, settings })
    }

    #[must_use]
    pub fn rows(&self) -> &[SweepRow] {
        &self.rows
    }

    /// What the tables hold.
    fn about(&self) -> String {
        let seeds = self.rows.iter().map(|r| r.seed).collect::<BTreeSet<_>>().len();
        let seeds = match seeds {
            0 | 1 => String::new(),
            n => format!(
                " Tasks of all {n} seeds are pooled; in parentheses the minimum and maximum success of a seed."
            ),
        };
        format!(
            "Success, % of tasks, by vehicle and perception profile. In brackets: 95 % intervals, bootstrap over worlds.{seeds}"
        )
    }

    /// Who wins in each setting, in a sentence each; nothing of settings with one planner.
    #[must_use]
    pub fn headlines(&self) -> Vec<String> {
        let told = |s: &Setting| Some(format!("{}: {}", s.name(), s.report.headline()?));
        self.settings.iter().filter_map(told).collect()
    }

    /// The results as tables of plain text, one a setting and a row a planner, as that of a run: [`table`].
    #[must_use]
    pub fn table(&self, width: Option<usize>) -> String {
        let tables = self.settings.iter().map(|s| {
            let rows = s.report.runs().runs.iter().zip(s.report.figures()).map(|(run, f)| {
                let success = f.all.mean(Measure::Success);
                TableRow {
                    name: one_line(&run.label, 120),
                    tasks: f.all.tasks,
                    success: success.map_or(0.0, |e| e.mean),
                    interval: success.and_then(|e| e.interval).map(|i| [i.low, i.high]),
                    means: [Measure::Time, Measure::Roll, Measure::Pitch].map(|m| Some(f.all.mean(m)?.mean)),
                    outcomes: f.all.outcomes,
                    flags: f.all.flags,
                }
            });
            table(&s.name(), &rows.collect::<Vec<_>>(), width)
        });
        tables.collect::<Vec<_>>().join("\n")
    }

    /// Success of each planner in each setting, and the results of each setting by rank, as GitHub-flavoured Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut s = format!("| {} |", text(&self.name));
        for setting in &self.settings {
            let _ = write!(s, " {} |", text(&setting.name()));
        }
        let _ = writeln!(s, "\n|:--|{}", "--:|".repeat(self.settings.len()));
        for (k, planner) in self.planners.iter().enumerate() {
            let _ = write!(s, "| {} |", text(planner));
            for setting in &self.settings {
                let cell = setting.of(k).map_or_else(
                    || "–".to_owned(),
                    |(figures, seeds)| {
                        mean(figures.mean(Measure::Success), Measure::Success) + &over_seeds(seeds)
                    },
                );
                let _ = write!(s, " {cell} |");
            }
            s.push('\n');
        }
        let _ = writeln!(s, "\n{}", self.about());
        for setting in &self.settings {
            let _ = writeln!(s, "\n## {}\n", text(&setting.name()));
            if let Some(told) = setting.report.headline() {
                let _ = writeln!(s, "{}\n", text(&told));
            }
            setting.report.markdown_results(&mut s);
        }
        s
    }

    /// The same as a page, with a link to the page of each setting in `compared` (`SETTING/index.html`).
    #[must_use]
    pub fn page(&self, compared: &[&str]) -> String {
        let mut head = format!("<h1>{}", escape(&one_line(&self.name, 120)));
        if let Some(first) = self.settings.first() {
            let _ = write!(head, " <small>on {}</small>", escape(&first.report.runs().scope()));
        }
        let _ = write!(
            head,
            "</h1><p class=\"meta\">{} of {} in {}; <a href=\"runs.csv\">all runs as CSV</a>; Verti-Bench in Rust \
             {}</p><nav><a href=\"#success\">Success</a>",
            counted(self.rows.len(), "run"),
            counted(self.planners.len(), "planner"),
            counted(self.settings.len(), "setting"),
            env!("CARGO_PKG_VERSION"),
        );
        for (k, setting) in self.settings.iter().enumerate() {
            let _ = write!(head, "<a href=\"#setting-{k}\">{}</a>", escape(&setting.name()));
        }
        head.push_str("</nav>");
        let mut s = String::from("<section id=\"success\"><h2>Success</h2>");
        self.pivot(&mut s);
        s.push_str("</section>");
        for (k, setting) in self.settings.iter().enumerate() {
            let _ = write!(s, "<section id=\"setting-{k}\"><h2>{}</h2>", escape(&setting.name()));
            if let Some(told) = setting.report.headline() {
                let _ = write!(s, "<p class=\"lead\">{}</p>", escape(&told));
            }
            page::ranking::table(&mut s, &setting.report, &setting.ranking(), &setting.planners);
            let name = self::setting(&setting.vehicle, &setting.perception);
            if compared.contains(&name.as_str()) {
                let _ = write!(
                    s,
                    "<p class=\"about\"><a href=\"{}/index.html\">All runs of this setting, compared task by task</a></p>",
                    escape(&name)
                );
            }
            s.push_str("</section>");
        }
        Page {
            title: &self.name,
            styles: &[TABLE_STYLE, DRAWING_STYLE, PAGE_STYLE],
            body: &format!("<header>{head}</header><main>{s}</main>"),
            script: SORTED_TABLES,
            ..Page::default()
        }
        .html()
    }

    /// Planners by settings.
    fn pivot(&self, s: &mut String) {
        s.push_str("<div class=\"scroll\"><table class=\"sortable ranking\"><thead><tr><th>planner</th>");
        for (k, setting) in self.settings.iter().enumerate() {
            let _ =
                write!(s, "<th class=\"n\"><a href=\"#setting-{k}\">{}</a></th>", escape(&setting.name()));
        }
        s.push_str("</tr></thead><tbody>");
        for (k, planner) in self.planners.iter().enumerate() {
            let _ = write!(s, "<tr><th>{}{}</th>", sample(k), escape(planner));
            for setting in &self.settings {
                let Some((figures, seeds)) = setting.of(k) else {
                    s.push_str("<td class=\"n\" data-v=\"-1\">–</td>");
                    continue;
                };
                let success = figures.mean(Measure::Success);
                let _ = write!(
                    s,
                    "<td class=\"n whisker-cell\" data-v=\"{}\">{}<small>{}</small>{}</td>",
                    success.map_or(-1.0, |e| e.mean),
                    with_interval(success, Measure::Success),
                    over_seeds(seeds),
                    whisker(k, success),
                );
            }
            s.push_str("</tr>");
        }
        let _ = write!(
            s,
            "</tbody></table></div><p class=\"about\">{} Click a column header to sort.</p>",
            escape(&self.about())
        );
    }

    /// A line for each run, as CSV with a header.
    pub fn csv(&self) -> Result<String, csv::Error> {
        csv_of(&self.rows)
    }
}

/// The least and the greatest success of a seed, behind a mean.
fn over_seeds(seeds: Option<[f64; 2]>) -> String {
    seeds.map_or_else(String::new, |[least, greatest]| {
        format!(" ({} to {})", number(least, 1), number(greatest, 1))
    })
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
    for flag in Flag::ALL {
        let count = all.and_then(|a| a.flags.get(&flag)).map_or_else(String::new, u64::to_string);
        columns.push((flag.to_string(), count));
    }
    let more: [(&str, String); 4] = [
        ("time_mean_s", figure(|a| a.time_mean_s)),
        ("roll_task_mean_deg", figure(|a| a.metrics.roll_task_mean_deg)),
        ("pitch_task_mean_deg", figure(|a| a.metrics.pitch_task_mean_deg)),
        ("plugin_sha256", row.summary.plugin_sha256.clone()),
    ];
    columns.extend(more.map(|(name, value)| (name.to_owned(), value)));
    columns
}

fn csv_of(rows: &[SweepRow]) -> Result<String, csv::Error> {
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
