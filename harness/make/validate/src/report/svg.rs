//! Line plots as SVG, for a page in light and dark.

use crate::event::{LineKind, Plot};
use std::fmt::Write as _;
use vb_page::escape;
use vb_page::plot::Frame;

/// Colours that the page's style defines as `--c0` and so on.
pub(super) const COLOURS: usize = 8;
/// Points of a line beyond which the eye sees no difference.
const POINTS: usize = 500;

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
    let (x0, x1) = range(points().map(|q| q[0]), if p.map { 0.03 } else { 0.0 });
    let (y0, y1) = range(points().map(|q| q[1]), 0.05);
    let mut f = Frame {
        width: 560.0,
        height: 320.0,
        left: 58.0,
        right: 14.0,
        top: 12.0,
        bottom: 44.0,
        x: [x0, x1],
        y: [y0, y1],
    };
    if p.map {
        f.make_square();
    }
    let mut s = format!("<figure><figcaption>{}</figcaption>", escape(&p.title));
    f.open(&mut s, &p.title);
    f.y_axis(&mut s, 6.0);
    f.x_axis(&mut s, 7.0);
    f.texts(&mut s, &p.x, &p.y);
    for l in &p.lines {
        let kind = class(l.kind);
        let colour = l.case % COLOURS;
        let shown: Vec<[f64; 2]> =
            thinned(&l.points).into_iter().filter(|q| q[0].is_finite() && q[1].is_finite()).collect();
        let mut path = String::new();
        for q in &shown {
            let _ = write!(path, "{:.1},{:.1} ", f.sx(q[0]), f.sy(q[1]));
        }
        let _ = write!(s, "<polyline class=\"{kind} c{colour}\" points=\"{}\"/>", path.trim_end());
        // Few points are values of their own, not samples of a curve.
        if shown.len() <= 8 {
            for q in &shown {
                let _ = write!(
                    s,
                    "<circle class=\"c{colour}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/>",
                    f.sx(q[0]),
                    f.sy(q[1])
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
