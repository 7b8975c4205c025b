//! Planners held against each other, pair by pair.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, grouped, p_value, signed};

use super::ranking::{diff_button, interval};
use super::sections::legend;
use super::series::{colour, line, marker};
use crate::compare::Difference;
use crate::figures::Measure;
use crate::ranking::Ranking;
use crate::runs::one_line;
use crate::verdict::Verdict;
use crate::{Comparison, Report};

/// Pairs up to this number are listed at once, more after a click.
const PAIRS: usize = 6;

pub(super) fn comparison(s: &mut String, report: &Report) {
    let (Some(c), Some(ranking)) = (&report.comparison, &report.ranking) else { return };
    legend(s, report);
    s.push_str("<div class=\"plots\">");
    for measure in Measure::ALL {
        forest(s, report, c, ranking, measure);
    }
    profile(s, report, c);
    s.push_str("</div>");
    decision(s, c);
    let open = if c.pairs.len() <= PAIRS { " open" } else { "" };
    let _ = write!(
        s,
        "<details class=\"more-figures\"{open}><summary>All {} with their tests</summary>",
        if c.pairs.len() == 1 {
            "figures of the pair".to_owned()
        } else {
            format!("{} pairs", c.pairs.len())
        }
    );
    table(s, report, c);
    s.push_str(
        "<p class=\"about\">Worlds: those that differ, of those that are needed if they are too few. The last column assumes more and decides nothing: McNemar's exact test takes tasks as independent, which they \
         are not within a world; Wilcoxon's signed-rank test counts each world the same, however many tasks it has. Neither is corrected.</p></details>",
    );
}

/// Which test decides, and why.
fn decision(s: &mut String, c: &Comparison) {
    let pairs = c.pairs.len();
    let _ = write!(
        s,
        "<p class=\"about\"><b>X − Y</b> is X's value less Y's, on the tasks that both have done: of time where both succeed, of angles \
         the mean over tasks of their means. Better is more success, less time and less tilt. <b>The sign-flip test over worlds decides</b>, \
         for all four figures: it flips the signs of whole worlds, since tasks of a world are not independent. {} Intervals (95 %, \
         bootstrap over worlds) say how large a difference is; each is for itself, so one may leave out zero where the test, which \
         minds the number of pairs and of worlds, is not certain. <b>Too few worlds</b>: had all worlds that differ done so the same way, \
         it would not have been certain either.</p>",
        if pairs == 1 {
            "Each figure is a family of one test, so nothing is corrected.".to_owned()
        } else {
            format!(
                "Each figure is a family of {pairs} tests, one a pair, which Holm's correction makes hold together at 5 %: success decides who \
                 wins, the others are secondary and correct only themselves."
            )
        }
    );
}

/// The class of a difference that is certain.
fn class(d: &Difference) -> &'static str {
    match d.verdict {
        Some(Verdict::Better) => "better",
        Some(Verdict::Worse) => "worse",
        _ => "open",
    }
}

/// What is said of a difference, in two or three words.
fn verdict(d: &Difference) -> String {
    match d.verdict {
        Some(Verdict::TooFewWorlds { .. }) => "too few worlds".into(),
        Some(Verdict::Uncorrected { .. }) => "not as one of many".into(),
        _ => d.told(),
    }
}

/// The number of worlds that differ, and how many would have to if they are too few.
fn needed(d: &Difference) -> String {
    match d.verdict {
        Some(Verdict::TooFewWorlds { needed }) => format!("{} of {needed}", d.worlds),
        _ => d.worlds.to_string(),
    }
}

/// Differences of one measure with their intervals.
fn forest(s: &mut String, report: &Report, c: &Comparison, ranking: &Ranking, measure: Measure) {
    let found: Vec<_> = ranking
        .lines()
        .into_iter()
        .filter_map(|(x, y)| Some((x, y, c.between(x, y, measure)?)))
        .filter_map(|(x, y, d)| Some((x, y, d.difference?, d)))
        .collect();
    if found.is_empty() {
        return;
    }
    let ends = found.iter().flat_map(|(_, _, e, _)| {
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
    let (zero, base) = (f.sx(0.0), f.height - f.bottom);
    let good = if measure.more_is_better() { zero } else { f.left };
    let _ = write!(
        s,
        "<rect class=\"good\" x=\"{good:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
        f.top,
        zero - f.left,
        base - f.top
    );
    f.x_axis(s, 6.0);
    let _ = write!(
        s,
        "<line class=\"zero\" x1=\"{zero:.1}\" x2=\"{zero:.1}\" y1=\"{:.1}\" y2=\"{base:.1}\"/>",
        f.top
    );
    for (k, (x, y, e, d)) in found.iter().enumerate() {
        let at = f.top + row * (k as f64 + 0.7);
        let name = |run: usize| escape(&one_line(&report.runs.runs[run].label, 25));
        let word = verdict(d);
        let _ = write!(
            s,
            "<text class=\"pair {class}\" x=\"{:.1}\" y=\"{y:.1}\">{} − {}</text><text class=\"pair {class}\" x=\"{:.1}\" y=\"{y:.1}\" \
             text-anchor=\"end\">{word}</text>",
            f.left,
            name(*x),
            name(*y),
            f.width - f.right,
            class = class(d),
            y = at - 9.0,
        );
        let shown = |v: f64| measure.shown(v);
        if let Some(i) = e.interval {
            let _ = write!(
                s,
                "<line class=\"range s{}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>",
                colour(*x),
                f.sx(shown(i.low)),
                f.sx(shown(i.high))
            );
        }
        let told = format!(
            "{} {} ({}), {} tasks; {}",
            signed(shown(e.mean), 2),
            measure.difference_unit(),
            interval(measure, Some(*e)),
            grouped(d.tasks),
            d.told()
        );
        marker(s, *x, [f.sx(shown(e.mean)), at], 4.2, &told);
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
            "<path class=\"{}\" d=\"{d}\"><title>{}</title></path>",
            line(k),
            escape(&report.runs.runs[k].label)
        );
        // Markers of several lines stand apart along the axis, also where the lines lie on each other.
        let at = vb_math::exp(f.x[1] * (k as f64 + 0.5) / c.profiles.len() as f64);
        marker(s, k, [f.sx(vb_math::ln(at)), f.sy(100.0 * p.at(at))], 4.2, "");
    }
    f.texts(s, "times the best planner's time", &format!("% of {} tasks", c.profile_tasks));
    s.push_str("</svg></figure>");
}

fn table(s: &mut String, report: &Report, c: &Comparison) {
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable pairs\"><thead><tr><th>X − Y</th><th>figure</th><th class=\"n\">difference</th><th \
         class=\"n\">95 % interval</th><th class=\"n\">p</th><th class=\"n\">p (Holm)</th><th>X is</th><th class=\"n\">tasks</th><th \
         class=\"n\">worlds</th><th class=\"n\">both</th><th class=\"n\">X only</th><th class=\"n\">Y only</th><th \
         class=\"n\">neither</th><th class=\"n\">McNemar, Wilcoxon</th></tr></thead><tbody>",
    );
    for p in &c.pairs {
        for d in &p.differences {
            let certain = d.verdict.is_some_and(Verdict::is_certain);
            let text = |p: Option<f64>| {
                format!(
                    "<td class=\"n\" data-v=\"{}\">{}</td>",
                    p.unwrap_or(2.0),
                    escape(&p.map_or_else(|| "–".into(), p_value))
                )
            };
            let _ = write!(
                s,
                "<tr{}><td class=\"of\">{} − {}</td><td class=\"of\">{}, {}</td><td class=\"n\" data-v=\"{}\">{}</td><td class=\"n\">{}</td>{}{}<td><span \
                 class=\"verdict {}\">{}</span></td><td class=\"n\" data-v=\"{}\">{}</td><td class=\"n\" data-v=\"{}\">{}</td>",
                if certain { " class=\"holds\"" } else { "" },
                escape(&report.runs.runs[p.b].label),
                escape(&report.runs.runs[p.a].label),
                d.measure.name(),
                d.measure.difference_unit(),
                d.difference.map_or_else(String::new, |e| e.mean.to_string()),
                d.difference.map_or_else(|| "–".into(), |e| signed(d.measure.shown(e.mean), 2)),
                interval(d.measure, d.difference),
                text(d.p),
                // What says nothing must not look as if it said that there is no difference.
                text(d.adjusted.filter(|_| !matches!(d.verdict, Some(Verdict::TooFewWorlds { .. })))),
                class(d),
                verdict(d),
                d.tasks,
                grouped(d.tasks),
                d.worlds,
                needed(d),
            );
            if d.measure == Measure::Success {
                let neither = p.common - p.both - p.only_a - p.only_b;
                let _ = write!(
                    s,
                    "<td class=\"n\" data-v=\"{0}\">{1}</td><td class=\"n\" data-v=\"{2}\">{3}</td><td class=\"n\" data-v=\"{4}\">{5}</td><td \
                     class=\"n\" data-v=\"{neither}\">{6}</td>",
                    p.both,
                    grouped(p.both),
                    p.only_b,
                    diff_button(p.b, p.a, p.only_b),
                    p.only_a,
                    diff_button(p.a, p.b, p.only_a),
                    grouped(neither)
                );
            } else {
                s.push_str("<td></td><td></td><td></td><td></td>");
            }
            s.push_str(&text(d.secondary));
            s.push_str("</tr>");
        }
    }
    s.push_str("</tbody></table></div>");
}
