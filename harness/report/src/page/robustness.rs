//! Planners under several perception profiles.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, grouped, number, p_value, signed};
use vb_score::Outcome;

use super::sections::with_interval;
use super::series::{self, colour, line as line_class, marker};
use crate::Report;
use crate::compare::Difference;
use crate::figures::{Estimate, Measure};
use crate::robustness::Robustness;
use crate::verdict::Verdict;

/// How far the lines of planners stand apart, in distances between profiles.
const APART: f64 = 0.05;

pub(super) fn robustness(s: &mut String, report: &Report) {
    let Some(r) = &report.robustness else { return };
    series::legend(s, r.lines.iter().map(|line| line.label.as_str()));
    s.push_str("<div class=\"plots\">");
    curve(s, report, r);
    s.push_str("</div>");
    table(s, report, r);
    s.push_str(
        "<p class=\"about\">Each line is one planner under several perception profiles, with nothing else changed. Whiskers: 95 %, \
         bootstrap over worlds. Differences are from the planner's first profile, paired by tasks; p: the \
         sign-flip test over worlds, after Holm's correction over this table.</p>",
    );
}

fn curve(s: &mut String, report: &Report, r: &Robustness) {
    let last = (r.profiles.len() - 1) as f64;
    let f = Frame {
        width: 560.0,
        height: 320.0,
        left: 52.0,
        right: 14.0,
        top: 10.0,
        bottom: 42.0,
        x: [-0.35, last + 0.35],
        y: [0.0, 100.0],
    };
    let title = "Success against the perception profile";
    let _ = write!(s, "<figure><figcaption>{title}</figcaption>");
    f.open(s, title);
    f.y_axis(s, 5.0);
    let names: Vec<(f64, String)> =
        r.profiles.iter().enumerate().map(|(k, name)| (k as f64, escape(name))).collect();
    f.x_ticks(s, &names);
    let middle = (r.lines.len() as f64 - 1.0) / 2.0;
    for (k, line) in r.lines.iter().enumerate() {
        let aside = (k as f64 - middle) * APART;
        let mut path = String::new();
        let mut marks = String::new();
        for point in &line.points {
            let Some(e) = report.figures[point.run].all.mean(Measure::Success) else { continue };
            let shown = |v: f64| Measure::Success.shown(v);
            let (x, y) = (f.sx(point.profile as f64 + aside), f.sy(shown(e.mean)));
            let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "M" } else { "L" });
            if let Some(i) = e.interval {
                let _ = write!(
                    marks,
                    "<line class=\"range s{}\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>",
                    colour(k),
                    f.sy(shown(i.low)),
                    f.sy(shown(i.high))
                );
            }
            let title =
                format!("{}, {}: {} %", line.label, r.profiles[point.profile], number(shown(e.mean), 1));
            marker(&mut marks, k, [x, y], 4.4, &title);
        }
        let _ = write!(s, "<path class=\"{}\" d=\"{path}\"/>{marks}", line_class(k));
    }
    f.texts(s, "perception profile", "success, %");
    s.push_str("</svg></figure>");
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
