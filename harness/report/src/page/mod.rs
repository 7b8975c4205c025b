//! The page.

mod comparison;
mod figure;
pub(crate) mod html;
mod plot;
mod sections;
mod tasks;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use base64::Engine as _;
use sha2::{Digest as _, Sha256};

use crate::Report;
use html::{escape, grouped};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The whole page.
pub(crate) fn page(report: &Report, replays: &BTreeSet<String>, files: &[&str]) -> String {
    let first = &report.runs.runs[0].header;
    let title = match &report.runs.runs[..] {
        [one] => one.label.clone(),
        many => format!("{} planners", many.len()),
    };
    let mut s = String::with_capacity(1 << 20);
    // No script but the page's own is run, whatever a planner's texts hold.
    let own = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    let tasks: u64 = report.figures.iter().map(|f| f.all.tasks).sum();
    let _ = write!(
        s,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{own}'\"><title>{title} on {suite}</title><style>{STYLE}</style>\
         </head><body><header><h1>{title} <small>on {suite}</small></h1><p class=\"meta\">{tasks} results in {worlds} worlds; suite hash \
         <code title=\"{hash}\">{}</code>; Verti-Bench in Rust {}</p><nav>",
        escape(first.suite.hash.get(..12).unwrap_or(&first.suite.hash)),
        env!("CARGO_PKG_VERSION"),
        title = escape(&title),
        suite = escape(&crate::runs::one_line(&first.suite.name, 80)),
        tasks = grouped(tasks),
        worlds = grouped(report.runs.worlds.len() as u64),
        hash = escape(&first.suite.hash),
    );
    let mut sections: Vec<(&str, &str)> = vec![("overview", "Overview"), ("figure", "Figure")];
    if report.comparison.is_some() {
        sections.push(("comparison", "Comparison"));
    }
    sections.extend([
        ("outcomes", "Outcomes"),
        ("worlds", "Worlds"),
        ("distributions", "Distributions"),
        ("fuel", "Fuel"),
        ("tasks", "Tasks"),
        ("about", "About"),
    ]);
    for (id, name) in &sections {
        let _ = write!(s, "<a href=\"#{id}\">{name}</a>");
    }
    s.push_str("</nav></header><main>");
    sections::notes(&mut s, report);
    for (id, name) in sections {
        let _ = write!(s, "<section id=\"{id}\"><h2>{name}</h2>");
        match id {
            "overview" => sections::overview(&mut s, report),
            "figure" => {
                sections::legend(&mut s, report);
                figure::figure(&mut s, report);
                s.push_str(
                    "<p class=\"about\">Bars are means, whiskers their 95 % intervals by the bootstrap over worlds: tasks of a world \
                     are not independent. Time is that of successful tasks, angles are over all samples of all tasks, as the paper's \
                     figure has them.</p>",
                );
            }
            "comparison" => comparison::comparison(&mut s, report),
            "outcomes" => sections::outcomes(&mut s, report),
            "worlds" => sections::worlds(&mut s, report),
            "distributions" => sections::distributions(&mut s, report),
            "fuel" => sections::fuel(&mut s, report),
            "tasks" => tasks::tasks(&mut s, report, replays, files),
            _ => sections::about(&mut s, report),
        }
        s.push_str("</section>");
    }
    let _ = writeln!(s, "</main><script>{SCRIPT}</script></body></html>");
    s
}
