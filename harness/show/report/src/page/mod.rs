//! The page.

mod causes;
mod comparison;
pub(crate) mod ranking;
mod robustness;
pub(crate) mod sections;
mod tasks;

use std::fmt::Write as _;

use crate::drawing::{DRAWING_STYLE, PAGE_STYLE, levels};
use crate::{Beside, Report};
use vb_page::{Page, SORTED_TABLES, TABLE_STYLE, escape, grouped};

const SCRIPT: &str = include_str!("page.js");

impl Report {
    /// The page: one file that needs nothing else, no network either.
    #[must_use]
    pub fn page(&self, beside: &Beside) -> String {
        page(self, beside)
    }
}

fn page(report: &Report, beside: &Beside) -> String {
    let first = &report.runs.runs[0].header;
    let title = match (&report.title, &report.runs.runs[..]) {
        (Some(title), _) => title.clone(),
        (None, [one]) => one.label.clone(),
        (None, many) => format!("{} runs", many.len()),
    };
    let tasks: u64 = report.figures.iter().map(|f| f.all.tasks).sum();
    let suite = report.runs.scope();
    let mut head = format!(
        "<h1>{} <small>on {}</small></h1><p class=\"meta\">{} results in {} worlds; suite hash <code title=\"{hash}\">{}</code>; \
         Verti-Bench in Rust {}</p><nav>",
        escape(&title),
        escape(&suite),
        grouped(tasks),
        grouped(report.runs.worlds.len() as u64),
        escape(first.suite.hash.get(..12).unwrap_or(&first.suite.hash)),
        env!("CARGO_PKG_VERSION"),
        hash = escape(&first.suite.hash),
    );
    let mut sections: Vec<(&str, &str)> = Vec::new();
    if report.ranking().is_some() {
        sections.push(("ranking", "Ranking"));
    }
    sections.extend([("overview", "Overview"), ("figure", "Figure")]);
    if report.comparison.is_some() {
        sections.push(("comparison", "Comparison"));
    }
    if report.robustness.is_some() {
        sections.push(("robustness", "Robustness"));
    }
    sections.extend([
        ("outcomes", "Outcomes"),
        ("causes", "Causes of failures"),
        ("worlds", "Worlds"),
        ("distributions", "Distributions"),
        ("fuel", "Fuel"),
        ("tasks", "Tasks"),
        ("about", "About"),
    ]);
    for (id, name) in &sections {
        let _ = write!(head, "<a href=\"#{id}\">{name}</a>");
    }
    head.push_str("</nav>");
    let mut s = String::with_capacity(1 << 20);
    ranking::headline(&mut s, report);
    sections::notes(&mut s, report);
    for (id, name) in sections {
        let _ = write!(s, "<section id=\"{id}\"><h2>{name}</h2>");
        match id {
            "ranking" => ranking::ranking(&mut s, report),
            "overview" => sections::overview(&mut s, report),
            "figure" => {
                sections::legend(&mut s, report);
                s.push_str("<div class=\"paper\">");
                levels(report).iter().for_each(|panel| panel.show(&mut s));
                s.push_str(
                    "</div><p class=\"about\">Bars are means, whiskers 95 % intervals (bootstrap over worlds, because tasks of a world \
                     are dependent). Time: successful tasks; angles: all samples of all tasks, as in the paper's \
                     figure.</p>",
                );
            }
            "comparison" => comparison::comparison(&mut s, report),
            "robustness" => robustness::robustness(&mut s, report),
            "outcomes" => sections::outcomes(&mut s, report),
            "causes" => causes::causes(&mut s, report),
            "worlds" => sections::worlds(&mut s, report, beside),
            "distributions" => sections::distributions(&mut s, report),
            "fuel" => sections::fuel(&mut s, report),
            "tasks" => tasks::tasks(&mut s, report, beside),
            _ => sections::about(&mut s, report),
        }
        s.push_str("</section>");
    }
    Page {
        title: &format!("{title} on {suite}"),
        styles: &[TABLE_STYLE, DRAWING_STYLE, PAGE_STYLE],
        body: &format!("<header>{head}</header><main>{s}</main>"),
        script: &format!("{SORTED_TABLES}{SCRIPT}"),
        ..Page::default()
    }
    .html()
}
