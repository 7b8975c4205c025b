//! Planners held against each other.

use super::plot::colour;
use super::sections::legend;
use crate::Report;
use crate::compare::Comparison;
use crate::figures::Measure;
use std::fmt::Write as _;
use vb_page::plot::Frame;
use vb_page::{escape, grouped, number, p_value};

/// Differences that hold at this family-wise error rate are marked.
const LEVEL: f64 = 0.05;

pub(super) fn comparison(s: &mut String, report: &Report) {
    let Some(c) = &report.comparison else { return };
    legend(s, report);
    s.push_str("<div class=\"plots\">");
    for measure in Measure::ALL {
        forest(s, report, c, measure);
    }
    profile(s, report, c);
    s.push_str("</div>");
    table(s, report, c);
    s.push_str(
        "<p class=\"about\">Differences are second run less first, on the tasks that both have done: of time where both succeed, of angles \
         the mean over tasks of their means. Intervals: 95 %, bootstrap over worlds. p: McNemar's exact test over tasks for the success \
         rate, else Wilcoxon's signed-rank test over the means of worlds. After Holm's correction over all these tests, bold ones hold \
         together at 5 %.</p>",
    );
}

/// Differences of one measure with their intervals.
fn forest(s: &mut String, report: &Report, c: &Comparison, measure: Measure) {
    let found: Vec<_> = c
        .pairs
        .iter()
        .filter_map(|p| Some((p, p.differences.get(measure as usize)?)))
        .filter_map(|(p, d)| Some((p, d, d.difference?)))
        .collect();
    if found.is_empty() {
        return;
    }
    let ends = found.iter().flat_map(|(_, _, e)| {
        let i = e.interval;
        [e.mean, i.map_or(e.mean, |i| i.low), i.map_or(e.mean, |i| i.high)]
    });
    let widest = ends.map(|v| measure.shown(v).abs()).fold(1e-3, f64::max) * 1.1;
    let row = 34.0;
    let f = Frame {
        width: 460.0,
        height: 12.0 + row * found.len() as f64 + 40.0,
        left: 14.0,
        right: 14.0,
        top: 8.0,
        bottom: 40.0,
        x: [-widest, widest],
        y: [0.0, 1.0],
    };
    let title = format!("Difference of {}", measure.name());
    let _ = write!(s, "<figure><figcaption>{}</figcaption>", escape(&title));
    f.open(s, &title);
    f.x_axis(s, 6.0);
    let zero = f.sx(0.0);
    let _ = write!(
        s,
        "<line class=\"zero\" x1=\"{zero:.1}\" x2=\"{zero:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>",
        f.top,
        f.height - f.bottom
    );
    for (k, (p, d, e)) in found.iter().enumerate() {
        let y = f.top + row * (k as f64 + 0.7);
        let holds = if d.adjusted.is_some_and(|p| p < LEVEL) { " holds" } else { "" };
        let (a, b) = (&report.runs.runs[p.a].label, &report.runs.runs[p.b].label);
        let _ = write!(
            s,
            "<text class=\"pair{holds}\" x=\"{:.1}\" y=\"{:.1}\">{} − {}</text>",
            f.left,
            y - 9.0,
            escape(&crate::runs::one_line(b, 34)),
            escape(&crate::runs::one_line(a, 34))
        );
        let shown = |v: f64| measure.shown(v);
        if let Some(i) = e.interval {
            let _ = write!(
                s,
                "<line class=\"range s{}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                colour(p.b),
                f.sx(shown(i.low)),
                f.sx(shown(i.high))
            );
        }
        let told = e.interval.map_or_else(String::new, |i| {
            format!(" [{}, {}]", number(shown(i.low), 2), number(shown(i.high), 2))
        });
        let _ = write!(
            s,
            "<circle class=\"f{} dot\" cx=\"{:.1}\" cy=\"{y:.1}\" r=\"4\"><title>{}{told} {}, {} tasks</title></circle>",
            colour(p.b),
            f.sx(shown(e.mean)),
            number(shown(e.mean), 2),
            measure.unit(),
            d.tasks
        );
    }
    let unit = match measure {
        Measure::Success => "percentage points (right: the one named first succeeds more)",
        Measure::Time => "s (left: the one named first is faster)",
        Measure::Roll | Measure::Pitch => "degrees (left: the one named first tilts less)",
    };
    f.texts(s, unit, "");
    s.push_str("</svg></figure>");
}

/// Performance profiles by traversal time.
fn profile(s: &mut String, report: &Report, c: &Comparison) {
    if c.profile_tasks == 0 {
        return;
    }
    let last = c.profiles.iter().filter_map(|p| p.steps.last()).map(|l| l[0]).fold(1.0, f64::max);
    // On a logarithmic axis, up to where all have risen or four times the best.
    let end = (1.05 * last).clamp(1.2, 4.0);
    let f = Frame {
        width: 460.0,
        height: 280.0,
        left: 52.0,
        right: 14.0,
        top: 10.0,
        bottom: 42.0,
        x: [0.0, vb_math::ln(end)],
        y: [0.0, 100.0],
    };
    s.push_str("<figure><figcaption>Performance profile by traversal time</figcaption>");
    f.open(s, "Performance profile by traversal time");
    f.y_axis(s, 5.0);
    let marks: Vec<_> = [1.0, 1.1, 1.2, 1.5, 2.0, 3.0, 4.0]
        .into_iter()
        .filter(|t| *t <= end && (end < 2.2 || *t != 1.1))
        .map(|t: f64| (vb_math::ln(t), if t.fract() == 0.0 { format!("{t:.0}") } else { format!("{t}") }))
        .collect();
    f.x_ticks(s, &marks);
    for (k, p) in c.profiles.iter().enumerate() {
        let mut y = f.sy(100.0 * p.at(1.0));
        let mut d = format!("M{:.1} {y:.1}", f.sx(0.0));
        for [factor, fraction] in p.steps.iter().filter(|st| st[0] > 1.0 && st[0] <= end) {
            let next = f.sy(100.0 * fraction);
            // Thousands of tiny steps are one line to the eye.
            if (y - next).abs() >= 0.3 {
                let _ = write!(d, "H{:.1}V{next:.1}", f.sx(vb_math::ln(*factor)));
                y = next;
            }
        }
        let _ = write!(d, "H{:.1}", f.sx(f.x[1]));
        let _ = write!(
            s,
            "<path class=\"line s{}\" d=\"{d}\"><title>{}</title></path>",
            colour(k),
            escape(&report.runs.runs[k].label)
        );
    }
    f.texts(s, "times the best planner's time", &format!("% of {} tasks", c.profile_tasks));
    s.push_str("</svg></figure>");
}

fn table(s: &mut String, report: &Report, c: &Comparison) {
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>first run</th><th>second run</th><th>figure</th><th class=\"n\">tasks</th>\
         <th class=\"n\">both</th><th class=\"n\">first only</th><th class=\"n\">second only</th><th class=\"n\">neither</th>\
         <th class=\"n\">difference</th><th class=\"n\">95 % interval</th><th class=\"n\">p</th><th class=\"n\">p (Holm)</th></tr></thead><tbody>",
    );
    for p in &c.pairs {
        for d in &p.differences {
            let holds = d.adjusted.is_some_and(|p| p < LEVEL);
            let _ = write!(
                s,
                "<tr{}><td>{}</td><td>{}</td><td>{}, {}</td><td class=\"n\">{}</td>",
                if holds { " class=\"holds\"" } else { "" },
                escape(&report.runs.runs[p.a].label),
                escape(&report.runs.runs[p.b].label),
                d.measure.name(),
                d.measure.unit(),
                grouped(d.tasks),
            );
            if d.measure == Measure::Success {
                for n in [p.both, p.only_a, p.only_b, p.common - p.both - p.only_a - p.only_b] {
                    let _ = write!(s, "<td class=\"n\" data-v=\"{n}\">{}</td>", grouped(n));
                }
            } else {
                s.push_str("<td></td><td></td><td></td><td></td>");
            }
            let shown = |v: f64| number(d.measure.shown(v), 2);
            let interval = d.difference.and_then(|e| e.interval);
            let _ = write!(
                s,
                "<td class=\"n\" data-v=\"{}\">{}</td><td class=\"n\">{}</td>",
                d.difference.map_or_else(String::new, |e| e.mean.to_string()),
                d.difference.map_or_else(|| "–".into(), |e| shown(e.mean)),
                interval.map_or_else(|| "–".into(), |i| format!("{} to {}", shown(i.low), shown(i.high)))
            );
            for p in [d.p, d.adjusted] {
                let text = p.map_or_else(|| "–".into(), p_value);
                let _ = write!(s, "<td class=\"n\" data-v=\"{}\">{}</td>", p.unwrap_or(2.0), escape(&text));
            }
            s.push_str("</tr>");
        }
    }
    s.push_str("</tbody></table></div>");
}
