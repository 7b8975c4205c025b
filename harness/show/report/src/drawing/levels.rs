//! The paper's figure: success, time, roll and pitch by elevation level, kind of ground and obstacle density.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, number};

use super::Drawing;
use super::series::{colour, marker};
use crate::Report;
use crate::figures::{Estimate, Measure, Split};

/// How far below the axis the baseline of the levels' names is: between the axis and the names stand the markers of the runs, where
/// they cover neither bars nor whiskers.
pub(crate) const NAMES: f64 = 24.0;
/// How far below the axis the middle of a marker is.
const MARKERS: f64 = 7.0;

/// What stands beside the plot of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Beside {
    /// The values of the axis at its left.
    pub(crate) values: bool,
    /// The names of the levels below it.
    pub(crate) levels: bool,
}

/// The panels, each by itself: a row a measure, a column a split.
pub(crate) fn levels(report: &Report) -> Vec<Drawing> {
    let mut panels = Vec::new();
    for measure in Measure::ALL {
        for split in Split::ALL {
            let area = Frame {
                width: 360.0,
                height: 197.0,
                left: 46.0,
                right: 8.0,
                top: 12.0,
                bottom: NAMES + 9.0,
                ..level_frame(split, top(report, measure))
            };
            let mut body = String::new();
            panel(&mut body, report, measure, split, &area, Beside { values: true, levels: true });
            let title = format!("{} by {}", measure.name(), split.name());
            panels.push(Drawing { note: measure.unit(), ..Drawing::new(title, &area, body) });
        }
    }
    panels
}

/// The ranges of a panel whose axis ends at `top`, without a place yet.
pub(crate) fn level_frame(split: Split, top: f64) -> Frame {
    Frame {
        width: 0.0,
        height: 0.0,
        left: 0.0,
        right: 0.0,
        top: 0.0,
        bottom: 0.0,
        x: [0.0, split.levels().len() as f64],
        y: [0.0, top],
    }
}

/// The end of a row's axis: the same for its panels, so that they can be compared.
pub(crate) fn top(report: &Report, measure: Measure) -> f64 {
    if measure == Measure::Success {
        return 100.0;
    }
    let figures = report.figures.iter().flat_map(|f| f.splits.iter().flatten());
    let means: Vec<Estimate> = figures.filter_map(|(_, f)| f.mean(measure)).collect();
    let greatest = means.iter().fold(0.0, |m: f64, e| m.max(e.mean));
    if greatest <= 0.0 {
        return 1.0;
    }
    let ends = means.iter().map(|e| e.interval.map_or(e.mean, |i| i.high));
    // A wide interval of few worlds must not press the rest together.
    1.05 * ends.fold(greatest, f64::max).min(2.0 * greatest)
}

/// A panel in its frame.
pub(crate) fn panel(
    s: &mut String,
    report: &Report,
    measure: Measure,
    split: Split,
    f: &Frame,
    beside: Beside,
) {
    let runs = report.runs.runs.len();
    if beside.values {
        f.y_axis(s, 4.0);
    } else {
        f.y_lines(s, 4.0);
    }
    // Bars of at most a quarter of a level's width, so that a single run is no wall.
    let bar = (0.8 / runs as f64).min(0.26);
    for (l, level) in split.levels().into_iter().enumerate() {
        let x = f.sx(l as f64 + 0.5);
        if beside.levels {
            let _ = write!(
                s,
                "<text class=\"level\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{level}</text>",
                f.height - f.bottom + NAMES
            );
        }
        for (r, own) in report.figures.iter().enumerate() {
            let Some((_, figures)) =
                own.splits.get(split as usize).and_then(|levels| levels.get(l)).filter(|(_, f)| f.tasks > 0)
            else {
                continue;
            };
            let centre = l as f64 + 0.5 + bar * (r as f64 - 0.5 * (runs as f64 - 1.0));
            let (left, right) = (f.sx(centre - 0.46 * bar), f.sx(centre + 0.46 * bar));
            let name = escape(&report.runs.runs[r].label);
            let Some(e) = figures.mean(measure) else {
                let _ = write!(
                    s,
                    "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">–<title>{name}: no values</title></text>",
                    f.sx(centre),
                    f.sy(0.0) - 3.0
                );
                continue;
            };
            let shown = |v: f64| number(measure.shown(v), 1);
            let told = e.interval.map_or_else(String::new, |i| {
                format!(", 95 % interval {} to {}", shown(i.low), shown(i.high))
            });
            let y = f.sy(measure.shown(e.mean));
            let _ = write!(
                s,
                "<g><title>{name}, {level}: {} {}{told}; {} tasks in {} worlds</title>",
                shown(e.mean),
                measure.unit(),
                figures.tasks,
                figures.worlds,
            );
            if measure.shown(e.mean) > 0.0 {
                let height = (f.sy(0.0) - y).max(0.8);
                let _ = write!(
                    s,
                    "<rect class=\"f{} bar\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" rx=\"1.5\"/>",
                    colour(r),
                    f.sy(0.0) - height,
                    right - left,
                );
            } else if e.interval.is_none() {
                // A bar of no height is none, and without a whisker nothing would say that the value is 0.
                let _ = write!(
                    s,
                    "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">0</text>",
                    f.sx(centre),
                    f.sy(0.0) - 3.0
                );
            }
            if let Some(i) = e.interval {
                let (low, high) = (f.sy(measure.shown(i.low)), f.sy(measure.shown(i.high)));
                let (x, cap) = (0.5 * (left + right), (0.22 * (right - left)).min(5.0));
                let _ = write!(
                    s,
                    "<path class=\"whisker\" d=\"M{x:.1} {low:.1}V{high:.1}M{:.1} {low:.1}h{:.1}M{:.1} {high:.1}h{:.1}\"/>",
                    x - cap,
                    2.0 * cap,
                    x - cap,
                    2.0 * cap
                );
            }
            if runs > 1 {
                marker(
                    s,
                    r,
                    [0.5 * (left + right), f.sy(0.0) + MARKERS],
                    (0.34 * (right - left)).min(4.2),
                    "",
                );
            }
            s.push_str("</g>");
        }
    }
    let base = f.sy(0.0);
    let _ = write!(
        s,
        "<line class=\"base\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{base:.1}\" y2=\"{base:.1}\"/>",
        f.left,
        f.width - f.right
    );
}
