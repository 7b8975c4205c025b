//! Distributions as SVG, for a page in light and dark.

use super::html::{escape, number};
use crate::statistics::Histogram;
use std::fmt::Write as _;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 44.0;
/// Share of the values at either end that a plot leaves out: the far tail would press the rest together.
const TAIL: f64 = 0.0005;

/// A distribution with its name and the number of its colour in the page's style.
pub(super) struct Curve<'a> {
    pub(super) name: &'a str,
    pub(super) colour: usize,
    pub(super) histogram: &'a Histogram,
}

/// Round values that cover a range.
fn ticks(low: f64, high: f64, wanted: f64) -> Vec<f64> {
    let raw = ((high - low) / wanted).max(1e-9);
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

/// The range that holds all but the tails of all curves.
fn range(curves: &[Curve<'_>]) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for c in curves {
        let h = c.histogram;
        let (mut sum, mut first, mut last) = (0.0, None, 0);
        for (k, share) in h.share.iter().enumerate() {
            sum += share;
            if sum > TAIL && first.is_none() {
                first = Some(k);
            }
            if sum - share < 1.0 - TAIL {
                last = k + 1;
            }
        }
        let edge = |k: usize| h.low + k as f64 * h.width;
        if let Some(first) = first {
            range = [range[0].min(edge(first)), range[1].max(edge(last))];
        }
    }
    if range[0] < range[1] { range } else { [0.0, 1.0] }
}

/// Distributions over each other as density: the area under each curve is one.
pub(super) fn plot(title: &str, axis: &str, curves: &[Curve<'_>]) -> String {
    let [x0, x1] = range(curves);
    let top = curves
        .iter()
        .flat_map(|c| c.histogram.share.iter().map(|s| s / c.histogram.width))
        .fold(0.0, f64::max)
        .max(1e-12);
    let (w, h) = (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    let sx = |x: f64| LEFT + (x.clamp(x0, x1) - x0) / (x1 - x0) * w;
    let sy = |y: f64| TOP + (1.0 - y / (1.05 * top)) * h;
    let mut s = String::new();
    let title = escape(title);
    let _ = write!(
        s,
        "<figure><figcaption>{title}</figcaption><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{title}\">"
    );
    let all = ticks(x0, x1, 8.0);
    let step = if all.len() > 1 { all[1] - all[0] } else { 1.0 };
    let digits = usize::from(step < 1.0) + usize::from(step < 0.1);
    for t in all {
        let x = sx(t);
        let _ = write!(
            s,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{:.1}\"/><text class=\"tick\" x=\"{x:.1}\" \
             y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            TOP + h,
            TOP + h + 16.0,
            number(t + 0.0, digits)
        );
    }
    for c in curves {
        let histogram = c.histogram;
        let mut d = format!("M{:.1} {:.1}", sx(histogram.low), sy(0.0));
        for (k, share) in histogram.share.iter().enumerate() {
            let edge = histogram.low + k as f64 * histogram.width;
            // What lies in the tails, beyond the range, is not drawn at its edge.
            if edge + histogram.width <= x0 + 1e-9 || edge >= x1 - 1e-9 {
                continue;
            }
            let y = sy(share / histogram.width);
            let _ = write!(d, "L{:.1} {y:.1}L{:.1} {y:.1}", sx(edge), sx(edge + histogram.width));
        }
        let end = histogram.low + histogram.share.len() as f64 * histogram.width;
        let _ = write!(d, "L{:.1} {:.1}", sx(end), sy(0.0));
        let _ = write!(s, "<path class=\"curve c{}\" d=\"{d}\"/>", c.colour);
    }
    let _ = write!(
        s,
        "<line class=\"base\" x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/><text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" \
         text-anchor=\"middle\">{}</text><text class=\"axis\" transform=\"translate(30 {:.1}) rotate(-90)\" \
         text-anchor=\"middle\">density</text></svg><ul class=\"legend\">",
        LEFT + w,
        TOP + h,
        TOP + h,
        LEFT + 0.5 * w,
        HEIGHT - 8.0,
        escape(axis),
        TOP + 0.5 * h,
    );
    for c in curves {
        let _ = write!(s, "<li><i class=\"swatch b{}\"></i>{}</li>", c.colour, escape(c.name));
    }
    s.push_str("</ul></figure>");
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(low: f64, share: &[f64]) -> Histogram {
        Histogram { low, width: 1.0, share: share.to_vec() }
    }

    #[test]
    fn the_range_leaves_out_tails_and_holds_all_curves() {
        let (a, b) = (curve(0.0, &[0.0004, 0.5, 0.4993, 0.0003]), curve(-2.0, &[1.0]));
        let c = |histogram| Curve { name: "x", colour: 0, histogram };
        assert_eq!(range(&[c(&a)]), [1.0, 3.0]);
        assert_eq!(range(&[c(&a), c(&b)]), [-2.0, 3.0]);
        assert_eq!(range(&[]), [0.0, 1.0]);
    }

    #[test]
    fn a_plot_of_nothing_or_of_one_value_is_still_drawn_and_names_are_text() {
        let (none, one) = (curve(0.0, &[]), curve(3.0, &[1.0]));
        let s = plot(
            "a < b",
            "x",
            &[
                Curve { name: "<script>", colour: 0, histogram: &none },
                Curve { name: "one", colour: 1, histogram: &one },
            ],
        );
        assert!(s.contains("a &lt; b") && s.contains("&lt;script&gt;"), "{s}");
        assert!(!s.contains("<script") && !s.contains("NaN") && !s.contains("inf"), "{s}");
    }
}
