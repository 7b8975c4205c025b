//! Who wins: the ranking, and each planner against each.

use std::fmt::Write as _;

use vb_page::{escape, grouped, p_value, signed};

use super::sections::with_interval;
use crate::drawing::series::{colour, marker, sample};
use crate::figures::{Estimate, Measure};
use crate::ranking::Ranking;
use crate::runs::one_line;
use crate::verdict::{Difference, Verdict};
use crate::{Comparison, Report};

/// Planners beyond this number have differences of success without a digit behind the point, for the width of a telephone.
const DIGITS: usize = 6;

/// The result in a sentence.
pub(super) fn headline(s: &mut String, report: &Report) {
    if let Some(told) = report.headline() {
        // A p-value stays on one line.
        let told = told.replace("(p < ", "(p\u{a0}<\u{a0}").replace("(p = ", "(p\u{a0}=\u{a0}");
        let _ = write!(s, "<p class=\"lead\">{}</p>", escape(&told));
    }
}

pub(super) fn ranking(s: &mut String, report: &Report) {
    let (Some(c), Some(ranking)) = (&report.comparison, report.ranking()) else { return };
    let looks: Vec<usize> = (0..report.runs.runs.len()).collect();
    table(s, report, ranking, &looks);
    s.push_str(
        "<p class=\"about\">Rank: 1 + number of planners with a significantly higher success rate; a range contains the possible ranks. \
         Success determines the ranking; time, roll and pitch are secondary.</p>",
    );
    matrix(s, report, c, ranking, Measure::Success);
    key(s);
    s.push_str(
        "<details class=\"more-figures\"><summary>Time, roll and pitch</summary><div class=\"matrices\">",
    );
    for measure in [Measure::Time, Measure::Roll, Measure::Pitch] {
        matrix(s, report, c, ranking, measure);
    }
    s.push_str("</div></details>");
}

/// What a planner is called where there is little room: `A` for the first of the ranking.
fn letter(position: usize) -> String {
    let one = |k: usize| char::from(b'A' + (k % 26) as u8).to_string();
    if position < 26 { one(position) } else { one(position / 26 - 1) + &one(position) }
}

/// The ranking as a table; each run looks as the one of this number does elsewhere on the page.
pub(crate) fn table(s: &mut String, report: &Report, ranking: &Ranking, looks: &[usize]) {
    s.push_str(
        "<div class=\"scroll\"><table class=\"sortable ranking\"><thead><tr><th></th><th class=\"n\">rank</th><th>planner</th><th \
         class=\"n\">success % (95 %)</th><th class=\"fixed\"></th><th>not significant against</th><th class=\"n\">tasks</th><th class=\"n\">time, s</th><th \
         class=\"n\">|roll|, °</th><th class=\"n\">|pitch|, °</th></tr></thead><tbody>",
    );
    let position = |run: usize| ranking.places.iter().position(|p| p.run == run).unwrap_or(0);
    for (k, p) in ranking.places.iter().enumerate() {
        let all = &report.figures[p.run].all;
        let success = all.mean(Measure::Success);
        let ties: Vec<String> = p.ties.iter().map(|run| letter(position(*run))).collect();
        let _ = write!(
            s,
            "<tr><td>{}</td><td class=\"n\" data-v=\"{}\"><b>{}</b></td><th>{}{}</th><td class=\"n\" data-v=\"{}\">{}</td><td \
             class=\"whisker-cell\">{}</td><td class=\"of\">{}</td><td class=\"n\" data-v=\"{}\">{}</td>",
            letter(k),
            p.rank,
            p.told(),
            sample(looks[p.run]),
            escape(&report.runs.runs[p.run].label),
            success.map_or(-1.0, |e| e.mean),
            with_interval(success, Measure::Success),
            whisker(looks[p.run], success),
            if ties.is_empty() { "–".into() } else { ties.join(" ") },
            all.tasks,
            grouped(all.tasks),
        );
        for measure in [Measure::Time, Measure::Roll, Measure::Pitch] {
            let e = all.mean(measure);
            let _ = write!(
                s,
                "<td class=\"n\" data-v=\"{}\">{}</td>",
                e.map_or_else(String::new, |e| e.mean.to_string()),
                with_interval(e, measure)
            );
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div>");
}

/// A rate and its interval on a line from 0 to 100 %.
pub(crate) fn whisker(run: usize, e: Option<Estimate>) -> String {
    let Some(e) = e else { return String::new() };
    let x = |v: f64| 150.0 * v.clamp(0.0, 1.0);
    let mut s = String::from(
        "<svg viewBox=\"-6 0 162 16\" aria-hidden=\"true\"><path class=\"grid\" d=\"M0 2V14M37.5 2V14M75 2V14M112.5 2V14M150 2V14\"/><path \
         class=\"base\" d=\"M0 8H150\"/>",
    );
    if let Some(i) = e.interval {
        let _ =
            write!(s, "<path class=\"range s{}\" d=\"M{:.1} 8H{:.1}\"/>", colour(run), x(i.low), x(i.high));
    }
    marker(&mut s, run, [x(e.mean), 8.0], 4.2, "");
    s.push_str("</svg>");
    s
}

/// Differences of one measure, each planner less each.
fn matrix(s: &mut String, report: &Report, c: &Comparison, ranking: &Ranking, measure: Measure) {
    let order: Vec<usize> = ranking.places.iter().map(|p| p.run).collect();
    let found = |x: usize, y: usize| c.between(x, y, measure);
    let digits = usize::from(measure != Measure::Success || order.len() <= DIGITS);
    let amount = |d: &Difference| d.difference.map_or(0.0, |e| e.mean.abs());
    let greatest =
        c.pairs.iter().filter_map(|p| p.differences.get(measure as usize)).map(amount).fold(0.0, f64::max);
    let _ = write!(
        s,
        "<div class=\"scroll\"><table class=\"matrix\"><caption>{}, {}: row − column</caption><thead><tr><td></td>",
        measure.name(),
        measure.difference_unit()
    );
    for (k, run) in order.iter().enumerate() {
        let _ = write!(s, "<th title=\"{}\">{}</th>", escape(&report.runs.runs[*run].label), letter(k));
    }
    s.push_str("</tr></thead><tbody>");
    for (k, x) in order.iter().enumerate() {
        let label = escape(&report.runs.runs[*x].label);
        let _ = write!(s, "<tr><th><b>{}</b> {label}</th>", letter(k));
        for y in &order {
            let Some(d) = (x != y).then(|| found(*x, *y)).flatten() else {
                s.push_str("<td class=\"none\"></td>");
                continue;
            };
            let Some(e) = d.difference else {
                s.push_str("<td class=\"open\">–</td>");
                continue;
            };
            let strong = if amount(&d) >= 0.5 * greatest { " strong" } else { "" };
            let good = (e.mean > 0.0) == measure.more_is_better();
            let class = match d.verdict {
                Some(Verdict::Better) => format!("better{strong}"),
                Some(Verdict::Worse) => format!("worse{strong}"),
                _ if e.mean == 0.0 => "open".into(),
                _ => format!("open {}", if good { "rather-better" } else { "rather-worse" }),
            };
            let few = if matches!(d.verdict, Some(Verdict::TooFewWorlds { .. })) { " few" } else { "" };
            let value = signed(measure.shown(e.mean), digits);
            let told = escape(&told(report, &d, *x, *y));
            let _ = match measure {
                Measure::Success => write!(
                    s,
                    "<td class=\"{class}{few}\"><button type=\"button\" data-does=\"{x}\" data-not=\"{y}\" title=\"{told}\">{value}</button></td>"
                ),
                _ => write!(s, "<td class=\"{class}{few}\" title=\"{told}\">{value}</td>"),
            };
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div>");
}

/// A cell of the matrix in words.
fn told(report: &Report, d: &Difference, x: usize, y: usize) -> String {
    let name = |run: usize| one_line(&report.runs.runs[run].label, 60);
    let v = |v: f64| signed(d.measure.shown(v), 2);
    let mut text = format!("{} − {}: ", name(x), name(y));
    if let Some(e) = d.difference {
        let _ = write!(text, "{} {}", v(e.mean), d.measure.difference_unit());
        if let Some(i) = e.interval {
            let _ = write!(text, " [{}, {}]", v(i.low), v(i.high));
        }
    }
    let _ = write!(text, " over {} tasks; {}", grouped(d.tasks), d.told());
    let few = matches!(d.verdict, Some(Verdict::TooFewWorlds { .. }));
    if let Some((p, adjusted)) = d.p.zip(d.adjusted).filter(|_| !few) {
        let _ = write!(text, "; p {}, corrected {}", p_value(p), p_value(adjusted));
    }
    text
}

fn key(s: &mut String) {
    s.push_str(
        "<p class=\"key cells\"><span><i class=\"cell better strong\"></i><i class=\"cell better\"></i>significantly better</span><span><i \
         class=\"cell worse strong\"></i><i class=\"cell worse\"></i>significantly worse</span><span><i class=\"cell open rather-better\"></i><i \
         class=\"cell open rather-worse\"></i>not significant</span><span class=\"few-key\">too few worlds</span></p><p class=\"about\">Strong \
         colours: at least half of the maximum difference. Click a cell to list the tasks that the row solves and the column does not.</p>",
    );
}

/// A count of tasks that leads to their list: those that `x` does and `y` doesn't.
pub(super) fn diff_button(x: usize, y: usize, count: u64) -> String {
    format!(
        "<button type=\"button\" class=\"link\" data-does=\"{x}\" data-not=\"{y}\">{}</button>",
        grouped(count)
    )
}

#[cfg(test)]
mod tests {
    use super::letter;

    #[test]
    fn letters_go_on_behind_z() {
        assert_eq!([0, 25, 26, 27, 52].map(letter), ["A", "Z", "AA", "AB", "BA"]);
    }
}
