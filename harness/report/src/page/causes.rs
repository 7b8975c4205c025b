//! What stopped the vehicles: failures by cause.

use std::fmt::Write as _;

use vb_page::{escape, grouped, number};
use vb_score::{Cause, Outcome};

use super::sections::label;
use super::series::sample;
use crate::Report;
use crate::figures::{Figures, Split};

/// A column of the table: what its figures are over.
struct Column<'a> {
    /// The head, as HTML.
    head: String,
    /// The head in words, for those who hover.
    name: String,
    /// The run.
    run: usize,
    figures: &'a Figures,
    /// Whether it is over all tasks of its run, so that its tasks can be shown.
    whole: bool,
}

/// The columns: the runs; of a single run its levels of elevation and its kinds of ground.
fn columns(report: &Report) -> Vec<Column<'_>> {
    let runs = report.runs.runs.iter().zip(&report.figures).enumerate();
    if report.runs.runs.len() > 1 {
        return runs
            .map(|(run, (r, f))| {
                let head = format!("{}{}", sample(run), escape(&r.label));
                Column { head, name: r.label.clone(), run, figures: &f.all, whole: true }
            })
            .collect();
    }
    let Some(own) = report.figures.first() else { return Vec::new() };
    let all = Column { head: "all".into(), name: "all tasks".into(), run: 0, figures: &own.all, whole: true };
    let levels = [Split::Elevation, Split::Terrain].into_iter().flat_map(|split| {
        own.splits.get(split as usize).into_iter().flatten().filter(|(_, f)| f.tasks > 0).map(
            move |(level, figures)| {
                let name = format!("{} {level}", split.name());
                let head = format!("<small>{}</small><br>{}", escape(split.name()), escape(level));
                Column { head, name, run: 0, figures, whole: false }
            },
        )
    });
    std::iter::once(all).chain(levels).collect()
}

/// Failures of rollover and getting stuck by what stopped the vehicle, the most frequent first, and how all others failed.
pub(super) fn causes(s: &mut String, report: &Report) {
    let columns = columns(report);
    let mut found: Vec<(Cause, u64)> = Cause::ALL
        .iter()
        .map(|cause| (*cause, report.figures.iter().map(|f| f.all.caused(*cause)).sum()))
        .filter(|(_, n)| *n > 0)
        .collect();
    if found.is_empty() {
        s.push_str("<p>No vehicle rolled over or got stuck, or the records are of a version that doesn't say why.</p>");
        return;
    }
    found.sort_by_key(|(cause, n)| (std::cmp::Reverse(*n), *cause));
    s.push_str("<div class=\"scroll\"><table class=\"causes\"><thead><tr><th>what stopped it</th>");
    for c in &columns {
        let _ = write!(s, "<th class=\"n\">{}</th>", c.head);
    }
    s.push_str("</tr></thead><tbody>");
    let shares = |c: &Column<'_>, n: u64| 100.0 * n as f64 / c.figures.tasks.max(1) as f64;
    let of = found.iter().flat_map(|(cause, _)| columns.iter().map(|c| shares(c, c.figures.caused(*cause))));
    let most = of.fold(1e-9, f64::max);
    for (cause, _) in &found {
        let outcome = if cause.name().starts_with("rollover") { Outcome::Rollover } else { Outcome::Stuck };
        let colour = Outcome::ALL.iter().position(|o| *o == outcome).unwrap_or(0);
        let _ = write!(s, "<tr><th><i class=\"swatch o{colour}\"></i>{}</th>", escape(cause.title()));
        for c in &columns {
            let n = c.figures.caused(*cause);
            let share = shares(c, n);
            let _ = write!(
                s,
                "<td class=\"n\" title=\"{}, {}: {} of {} tasks\"><i class=\"share o{colour}\" style=\"width:{:.1}%\"></i>",
                escape(&c.name),
                escape(cause.title()),
                grouped(n),
                grouped(c.figures.tasks),
                100.0 * share / most
            );
            let told = format!("{} <small>{} %</small>", grouped(n), number(share, 1));
            if n > 0 && c.whole {
                let _ = write!(
                    s,
                    "<button type=\"button\" class=\"link\" data-cause=\"{}\" data-run=\"{}\">{told}</button></td>",
                    cause.name(),
                    c.run,
                );
            } else {
                let _ = write!(s, "{}</td>", if n > 0 { &told } else { "–" });
            }
        }
        s.push_str("</tr>");
    }
    let others: Vec<Outcome> = Outcome::ALL
        .into_iter()
        .filter(|o| !matches!(o, Outcome::Success | Outcome::Rollover | Outcome::Stuck | Outcome::HostError))
        .filter(|o| report.figures.iter().any(|f| f.all.count(*o) > 0))
        .collect();
    for outcome in others {
        let colour = Outcome::ALL.iter().position(|o| *o == outcome).unwrap_or(0);
        let _ = write!(s, "<tr><th><i class=\"swatch o{colour}\"></i>{}</th>", label(outcome));
        for c in &columns {
            let n = c.figures.count(outcome);
            let _ =
                write!(s, "<td class=\"n\">{} <small>{} %</small></td>", grouped(n), number(shares(c, n), 1));
        }
        s.push_str("</tr>");
    }
    s.push_str(
        "</tbody></table></div><p class=\"about\">Shares are of all tasks of a column. The cause is judged by loads, slip, sinkage, attitude and \
         surroundings of the last seconds (docs/scoring.md), and a task in the list below says by which figures. A click shows the tasks.</p>",
    );
}
