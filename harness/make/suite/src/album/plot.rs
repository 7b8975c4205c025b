//! Distributions as SVG, for a page in light and dark.

use std::fmt::Write as _;

use vb_page::escape;
use vb_page::plot::Frame;

use crate::statistics::Histogram;

/// Share of the values at either end that a plot leaves out: the far tail would press the rest together.
const TAIL: f64 = 0.0005;

/// A distribution with its name and the number of its colour in the page's style.
pub(super) struct Curve<'a> {
    pub(super) name: &'a str,
    pub(super) colour: usize,
    pub(super) histogram: &'a Histogram,
}

/// The range that holds all but the tails of all curves.
fn range(curves: &[Curve<'_>]) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for c in curves {
        let h = c.histogram;
        let (mut sum, mut first, mut last) = (0.0, None, 0);
        for (k, fraction) in h.fraction.iter().enumerate() {
            sum += fraction;
            if sum > TAIL && first.is_none() {
                first = Some(k);
            }
            if sum - fraction < 1.0 - TAIL {
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
        .flat_map(|c| c.histogram.fraction.iter().map(|s| s / c.histogram.width))
        .fold(0.0, f64::max)
        .max(1e-12);
    let f = Frame {
        width: 560.0,
        height: 300.0,
        left: 50.0,
        right: 14.0,
        top: 12.0,
        bottom: 44.0,
        x: [x0, x1],
        y: [0.0, 1.05 * top],
    };
    let mut s = format!("<figure><figcaption>{}</figcaption>", escape(title));
    f.open(&mut s, title);
    f.x_axis(&mut s, 8.0);
    for c in curves {
        let histogram = c.histogram;
        let mut d = format!("M{:.1} {:.1}", f.sx(histogram.low), f.sy(0.0));
        for (k, fraction) in histogram.fraction.iter().enumerate() {
            let edge = histogram.low + k as f64 * histogram.width;
            // What lies in the tails, beyond the range, is not drawn at its edge.
            if edge + histogram.width <= x0 + 1e-9 || edge >= x1 - 1e-9 {
                continue;
            }
            let y = f.sy(fraction / histogram.width);
            let _ = write!(d, "L{:.1} {y:.1}L{:.1} {y:.1}", f.sx(edge), f.sx(edge + histogram.width));
        }
        let end = histogram.low + histogram.fraction.len() as f64 * histogram.width;
        let _ = write!(d, "L{:.1} {:.1}", f.sx(end), f.sy(0.0));
        let _ = write!(s, "<path class=\"curve c{}\" d=\"{d}\"/>", c.colour);
    }
    f.texts(&mut s, axis, "density");
    s.push_str("</svg><ul class=\"legend\">");
    for c in curves {
        let _ = write!(s, "<li><i class=\"swatch b{}\"></i>{}</li>", c.colour, escape(c.name));
    }
    s.push_str("</ul></figure>");
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(low: f64, fraction: &[f64]) -> Histogram {
        Histogram { low, width: 1.0, fraction: fraction.to_vec() }
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
