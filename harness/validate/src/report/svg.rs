//! Line plots as SVG, for a page in light and dark.

use crate::event::{LineKind, Plot};
use std::fmt::Write as _;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 44.0;
/// Colours that the page's style defines as `--c0` and so on.
pub(super) const COLOURS: usize = 8;
/// Points of a line beyond which the eye sees no difference.
const POINTS: usize = 500;

/// Text for HTML and SVG.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Round values that cover a range: first, distance, count.
fn ticks(low: f64, high: f64, wanted: f64) -> Vec<f64> {
    let raw = (high - low) / wanted;
    let mut unit = 1.0;
    while unit > raw {
        unit /= 10.0;
    }
    while unit * 10.0 <= raw {
        unit *= 10.0;
    }
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * unit).into_iter().find(|s| *s >= raw).unwrap_or(unit);
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A number of an axis, without a tail of zeros.
fn number(v: f64) -> String {
    let text = format!("{v:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    let text = if text == "-0" { "0" } else { text };
    text.replace('-', "−")
}

/// The range of some values, widened so that no line lies on the frame.
fn range(values: impl Iterator<Item = f64>, widen: f64) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    let span = high - low;
    if span <= 1e-9 * high.abs().max(1e-6) {
        return (low - 0.5, high + 0.5);
    }
    (low - widen * span, high + widen * span)
}

/// A line's points, thinned to what the eye sees: of each run of points the lowest and the highest stay.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() <= POINTS {
        return points.to_vec();
    }
    let run = points.len().div_ceil(POINTS / 2);
    let mut out = Vec::with_capacity(POINTS + 2);
    for part in points.chunks(run) {
        let (mut low, mut high) = (0, 0);
        for (k, p) in part.iter().enumerate() {
            if p[1] < part[low][1] {
                low = k;
            }
            if p[1] > part[high][1] {
                high = k;
            }
        }
        let (a, b) = (low.min(high), low.max(high));
        out.push(part[a]);
        if b != a {
            out.push(part[b]);
        }
    }
    out.extend(points.last());
    out
}

/// The plot as an SVG element with a legend below it.
pub(super) fn plot(p: &Plot) -> String {
    let points = || p.lines.iter().flat_map(|l| &l.points);
    let (mut x0, mut x1) = range(points().map(|q| q[0]), if p.map { 0.03 } else { 0.0 });
    let (mut y0, mut y1) = range(points().map(|q| q[1]), 0.05);
    let (w, h) = (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    if p.map {
        let scale = ((x1 - x0) / w).max((y1 - y0) / h);
        let (cx, cy) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
        (x0, x1) = (cx - 0.5 * scale * w, cx + 0.5 * scale * w);
        (y0, y1) = (cy - 0.5 * scale * h, cy + 0.5 * scale * h);
    }
    let sx = |x: f64| LEFT + (x - x0) / (x1 - x0) * w;
    let sy = |y: f64| TOP + (y1 - y) / (y1 - y0) * h;
    let mut s = String::new();
    let title = escape(&p.title);
    let _ = write!(
        s,
        "<figure><figcaption>{title}</figcaption><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{title}\">"
    );
    for t in ticks(x0, x1, 7.0) {
        let x = sx(t);
        let _ = write!(
            s,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{:.1}\"/>",
            TOP + h
        );
        let _ = write!(
            s,
            "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            TOP + h + 16.0,
            number(t)
        );
    }
    for t in ticks(y0, y1, 6.0) {
        let y = sy(t);
        let class = if t == 0.0 { "grid zero" } else { "grid" };
        let _ = write!(
            s,
            "<line class=\"{class}\" x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
            LEFT + w
        );
        let _ = write!(
            s,
            "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            y + 4.0,
            number(t)
        );
    }
    let _ = write!(
        s,
        "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        LEFT + 0.5 * w,
        HEIGHT - 8.0,
        escape(&p.x)
    );
    let _ = write!(
        s,
        "<text class=\"axis\" transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        TOP + 0.5 * h,
        escape(&p.y)
    );
    for l in &p.lines {
        let kind = class(l.kind);
        let colour = l.case % COLOURS;
        let shown: Vec<[f64; 2]> =
            thinned(&l.points).into_iter().filter(|q| q[0].is_finite() && q[1].is_finite()).collect();
        let mut path = String::new();
        for q in &shown {
            let _ = write!(path, "{:.1},{:.1} ", sx(q[0]), sy(q[1]));
        }
        let _ = write!(s, "<polyline class=\"{kind} c{colour}\" points=\"{}\"/>", path.trim_end());
        // Few points are values of their own, not samples of a curve.
        if shown.len() <= 8 {
            for q in &shown {
                let _ = write!(
                    s,
                    "<circle class=\"c{colour}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/>",
                    sx(q[0]),
                    sy(q[1])
                );
            }
        }
    }
    s.push_str("</svg><ul class=\"legend\">");
    for l in &p.lines {
        let _ = write!(
            s,
            "<li><svg viewBox=\"0 0 24 8\"><line class=\"{} c{}\" x1=\"0\" x2=\"24\" y1=\"4\" y2=\"4\"/></svg>{}</li>",
            class(l.kind),
            l.case % COLOURS,
            escape(&l.label)
        );
    }
    s.push_str("</ul></figure>");
    s
}

fn class(kind: LineKind) -> &'static str {
    match kind {
        LineKind::Ours => "ours",
        LineKind::Setup => "setup",
        LineKind::Reference => "reference",
        LineKind::Theory => "theory",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        assert_eq!(ticks(0.0, 10.0, 5.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(
            ticks(-0.13, 0.27, 4.0).iter().map(|t| number(*t)).collect::<Vec<_>>(),
            ["−0.1", "0", "0.1", "0.2"]
        );
        assert_eq!(
            ticks(9990.0, 10_050.0, 6.0),
            [9990.0, 10_000.0, 10_010.0, 10_020.0, 10_030.0, 10_040.0, 10_050.0]
        );
    }

    #[test]
    fn thinning_keeps_the_ends_and_the_peak() {
        let mut points: Vec<[f64; 2]> = (0..10_000).map(|k| [f64::from(k), 0.0]).collect();
        points[7777][1] = 5.0;
        let t = thinned(&points);
        assert!(t.len() <= POINTS + 2, "{}", t.len());
        assert!(t.contains(&[7777.0, 5.0]) && t[0] == [0.0, 0.0] && t[t.len() - 1] == [9999.0, 0.0]);
    }

    #[test]
    fn a_plot_without_numbers_or_with_one_value_is_still_drawn() {
        let mut p = Plot::new("a < b", "x", "y");
        p.ours("none", vec![]);
        p.ours("one", vec![[1.0, 2.0], [f64::NAN, 1.0]]);
        let s = plot(&p);
        assert!(s.contains("a &lt; b") && !s.contains("NaN") && !s.contains("inf"), "{s}");
    }
}
