//! Planners held against each other, pair by pair.

use std::fmt::Write as _;

use vb_page::{escape, grouped, p_value, signed};

use super::ranking::diff_button;
use super::sections::legend;
use crate::drawing::{PAGE_FIGURE, forest, profile};
use crate::figures::Measure;
use crate::verdict::{Difference, Verdict};
use crate::{Comparison, Report};

/// Pairs up to this number are listed at once, more after a click.
const PAIRS: usize = 6;

pub(super) fn comparison(s: &mut String, report: &Report) {
    let (Some(c), Some(ranking)) = (&report.comparison, &report.order) else { return };
    legend(s, report);
    s.push_str("<div class=\"plots\">");
    let forests = Measure::ALL.into_iter().filter_map(|m| forest(report, c, ranking, m, PAGE_FIGURE));
    forests.chain(profile(report, c, PAGE_FIGURE)).for_each(|drawing| drawing.show(s));
    s.push_str("</div>");
    decision(s, c);
    let open = if c.pairs.len() <= PAIRS { " open" } else { "" };
    let _ = write!(
        s,
        "<details class=\"more-figures\"{open}><summary>All {} with tests</summary>",
        if c.pairs.len() == 1 {
            "figures of the pair".to_owned()
        } else {
            format!("{} pairs", c.pairs.len())
        }
    );
    table(s, report, c);
    s.push_str(
        "<p class=\"about\">Worlds: number of worlds that differ, and the number needed if there are too few. The last column has secondary tests without correction: McNemar's exact test assumes independent tasks, \
         but tasks of a world are dependent; Wilcoxon's signed-rank test weights all worlds equally, independent of their number of tasks.</p></details>",
    );
}

/// Which test decides, and why.
fn decision(s: &mut String, c: &Comparison) {
    let pairs = c.pairs.len();
    let _ = write!(
        s,
        "<p class=\"about\"><b>X − Y</b> is X's value less Y's on common tasks: of time on tasks that both complete, of angles \
         the mean over tasks of their means. Better: more success, less time, less tilt. <b>The sign-flip test over worlds determines the \
         verdict</b> of all four measures: it flips the signs of whole worlds, because tasks of a world are dependent. {} Intervals (95 %, \
         bootstrap over worlds) are not corrected for multiple comparisons, so an interval may exclude 0 although the test is not \
         significant. <b>Too few worlds</b>: the test cannot be significant, even if all worlds that differ have the same sign.</p>",
        if pairs == 1 {
            "Each measure has one test, so there is no correction.".to_owned()
        } else {
            format!(
                "Holm's correction controls the error of the {pairs} tests of each measure, one per pair, at 5 %. Success determines the \
                 ranking; the other measures are secondary and are corrected separately."
            )
        }
    );
}

/// The number of worlds that differ, and how many would have to if they are too few.
fn needed(d: &Difference) -> String {
    match d.verdict {
        Some(Verdict::TooFewWorlds { needed }) => format!("{} of {needed}", d.worlds),
        _ => d.worlds.to_string(),
    }
}

fn table(s: &mut String, report: &Report, c: &Comparison) {
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable pairs\"><thead><tr><th>X − Y</th><th>measure</th><th class=\"n\">difference</th><th \
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
                d.interval(),
                text(d.p),
                // What says nothing must not look as if it said that there is no difference.
                text(d.adjusted.filter(|_| !matches!(d.verdict, Some(Verdict::TooFewWorlds { .. })))),
                d.class(),
                d.short(),
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
