//! Planners under several perception profiles.

use std::fmt::Write as _;

use vb_page::{escape, grouped, number, p_value, signed};
use vb_score::Outcome;

use super::sections::with_interval;
use crate::Report;
use crate::drawing::{robustness as curve, series};
use crate::figures::{Estimate, Measure};
use crate::robustness::Robustness;
use crate::verdict::{Difference, Verdict};

pub(super) fn robustness(s: &mut String, report: &Report) {
    let Some(r) = &report.robustness else { return };
    series::legend(s, r.lines.iter().map(|line| line.label.as_str()));
    s.push_str("<div class=\"plots\">");
    curve(report, r, 560.0).show(s);
    s.push_str("</div>");
    table(s, report, r);
    s.push_str(
        "<p class=\"about\">Each line is one planner under several perception profiles, with otherwise equal settings. Whiskers: 95 % \
         intervals, bootstrap over worlds. Differences to the planner's first profile, paired by task; p: \
         sign-flip test over worlds, after Holm's correction over this table.</p>",
    );
}

/// The corrected p-value, or that too few worlds differ for it to say anything.
fn told_p(d: &Difference) -> String {
    match (d.verdict, d.adjusted) {
        (Some(Verdict::TooFewWorlds { .. }), _) => d.told(),
        (_, Some(p)) => p_value(p),
        (_, None) => "–".into(),
    }
}

/// A difference of success with its interval: `+3.1 [−0.2, +6.4]`.
fn difference(e: Option<Estimate>) -> String {
    let Some(e) = e else { return "–".into() };
    let v = |v: f64| signed(Measure::Success.shown(v), 1);
    let interval =
        e.interval.map_or_else(String::new, |i| format!(" <small>[{}, {}]</small>", v(i.low), v(i.high)));
    format!("{}{interval}", v(e.mean))
}

fn table(s: &mut String, report: &Report, r: &Robustness) {
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>planner</th><th>profile</th><th class=\"n\">tasks</th>\
         <th class=\"n\">success % (95 %)</th><th class=\"n\">difference, points (95 %)</th><th class=\"n\">p</th>\
         <th class=\"n\">rollover %</th><th class=\"n\">stuck %</th></tr></thead><tbody>",
    );
    for line in &r.lines {
        for point in &line.points {
            let all = &report.figures[point.run].all;
            let d = point.difference.as_ref();
            let percent = |o: Outcome| number(100.0 * all.count(o) as f64 / all.tasks.max(1) as f64, 1);
            let _ = write!(
                s,
                "<tr><th>{}</th><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                escape(&line.label),
                escape(&r.profiles[point.profile]),
                grouped(all.tasks),
                with_interval(all.mean(Measure::Success), Measure::Success),
                d.map_or_else(|| "–".into(), |d| difference(d.difference)),
                escape(&d.map_or_else(|| "–".into(), told_p)),
                percent(Outcome::Rollover),
                percent(Outcome::Stuck),
            );
        }
    }
    s.push_str("</tbody></table></div>");
}
