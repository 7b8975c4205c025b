//! What stopped the vehicles: failures by cause.

use std::fmt::Write as _;

use vb_page::{escape, grouped, number};

use crate::Report;
use crate::drawing::series::sample;
use crate::drawing::{PAGE_FIGURE, causes as drawing};
use crate::failures::{Failure, Group, failures, groups};

/// The head of a column, as HTML.
fn head(report: &Report, g: &Group<'_>) -> String {
    match g.split {
        Some(split) => format!("<small>{}</small><br>{}", escape(split.name()), escape(&g.name)),
        None if report.runs.runs.len() > 1 => format!("{}{}", sample(g.run), escape(&g.name)),
        None => escape(&g.name),
    }
}

/// Failures of rollover and getting stuck by what stopped the vehicle, the most frequent first, and how all others failed.
pub(super) fn causes(s: &mut String, report: &Report) {
    let (groups, found) = (groups(report), failures(report));
    if !found.iter().any(|f| matches!(f, Failure::Cause(_))) {
        s.push_str(
            "<p>No vehicle rolled over or got stuck, or the records are of a version without causes.</p>",
        );
        return;
    }
    if let Some(drawing) = drawing(report, 1.5 * PAGE_FIGURE) {
        s.push_str("<div class=\"bars\">");
        drawing.show(s);
        s.push_str("</div>");
    }
    s.push_str("<div class=\"scroll\"><table class=\"causes\"><thead><tr><th>cause</th>");
    for g in &groups {
        let _ = write!(s, "<th class=\"n\">{}</th>", head(report, g));
    }
    s.push_str("</tr></thead><tbody>");
    let share = |g: &Group<'_>, n: u64| 100.0 * n as f64 / g.figures.tasks.max(1) as f64;
    let most =
        found.iter().flat_map(|f| groups.iter().map(|g| share(g, f.count(g.figures)))).fold(1e-9, f64::max);
    for failure in &found {
        let title = escape(&failure.title());
        let colour = failure.outcome().index();
        let _ = write!(s, "<tr><th><i class=\"swatch o{colour}\"></i>{title}</th>");
        for g in &groups {
            let n = failure.count(g.figures);
            let _ = write!(
                s,
                "<td class=\"n\" title=\"{}, {title}: {} of {} tasks\"><i class=\"share o{colour}\" style=\"width:{:.1}%\"></i>",
                escape(&g.name),
                grouped(n),
                grouped(g.figures.tasks),
                100.0 * share(g, n) / most
            );
            let told = format!("{} <small>{} %</small>", grouped(n), number(share(g, n), 1));
            match failure {
                _ if n == 0 => s.push('–'),
                Failure::Cause(cause) if g.whole => {
                    let _ = write!(
                        s,
                        "<button type=\"button\" class=\"link\" data-cause=\"{}\" data-run=\"{}\">{told}</button>",
                        cause.name(),
                        g.run,
                    );
                }
                _ => s.push_str(&told),
            }
            s.push_str("</td>");
        }
        s.push_str("</tr>");
    }
    s.push_str(
        "</tbody></table></div><p class=\"about\">Percentages of all tasks of the planner. The cause follows from loads, slip, sinkage, attitude and \
         surroundings in the last seconds (docs/scoring.md); the task list below contains the values. Click a number to list its tasks.</p>",
    );
}
