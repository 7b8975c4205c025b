//! Axes of plots as SVG.

use std::fmt::Write as _;

use crate::{escape, number};

/// Ticks of an axis at most.
const MOST: usize = 1000;

/// Round values within a range, about as many as wanted, and never more than a thousand. A range that has no finite length, or
/// whose ends are the wrong way round, has none.
#[must_use]
pub fn ticks(low: f64, high: f64, wanted: f64) -> Vec<f64> {
    let length = high - low;
    if !(length.is_finite() && length >= 0.0 && wanted > 0.0) {
        return Vec::new();
    }
    let raw = (length / wanted).clamp(1e-9, f64::MAX);
    let mut unit = 1.0;
    while unit > raw {
        unit /= 10.0;
    }
    while unit * 10.0 <= raw {
        unit *= 10.0;
    }
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * unit).into_iter().find(|s| *s >= raw).unwrap_or(unit);
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last).take(MOST).map(|k| k as f64 * step + 0.0).filter(|tick| tick.is_finite()).collect()
}

/// Where a value lies in a range, from 0 to 1; what is beyond it, or is no number, lies at an end. In a range without a finite
/// length everything lies in the middle.
fn fraction(value: f64, [low, high]: [f64; 2]) -> f64 {
    let length = high - low;
    if !(length.is_finite() && length > 0.0) {
        return 0.5;
    }
    (value.max(low).min(high) - low) / length
}

/// Digits behind the point that tell ticks apart.
#[must_use]
pub fn digits(ticks: &[f64]) -> usize {
    let step = if ticks.len() > 1 { ticks[1] - ticks[0] } else { 1.0 };
    [0.999, 0.0999, 0.00999, 0.000_999].iter().filter(|s| step < **s).count()
}

/// Where the plot's area lies in its picture, and what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Width of the picture, in its own units.
    pub width: f64,
    pub height: f64,
    /// Width of the margin at the left.
    pub left: f64,
    /// Width of the margin at the right.
    pub right: f64,
    /// Height of the margin at the top.
    pub top: f64,
    /// Height of the margin at the bottom.
    pub bottom: f64,
    /// Values at the left and the right edge of the area.
    pub x: [f64; 2],
    /// Values at the lower and the upper edge of the area.
    pub y: [f64; 2],
}

impl Frame {
    /// Where a value lies across; what is beyond the area is put at its edge.
    #[must_use]
    pub fn sx(&self, x: f64) -> f64 {
        let w = self.width - self.left - self.right;
        self.left + fraction(x, self.x) * w
    }

    /// Where a value lies from the top; what is beyond the area is put at its edge.
    #[must_use]
    pub fn sy(&self, y: f64) -> f64 {
        let h = self.height - self.top - self.bottom;
        self.top + (1.0 - fraction(y, self.y)) * h
    }

    /// Widens one of the ranges so that a unit is as long across as upwards: for maps.
    pub fn make_square(&mut self) {
        let (w, h) = (self.width - self.left - self.right, self.height - self.top - self.bottom);
        let scale = ((self.x[1] - self.x[0]) / w).max((self.y[1] - self.y[0]) / h);
        let about = |range: [f64; 2], length: f64| {
            let centre = 0.5 * (range[0] + range[1]);
            [centre - 0.5 * scale * length, centre + 0.5 * scale * length]
        };
        (self.x, self.y) = (about(self.x, w), about(self.y, h));
    }

    /// Begins the picture, which has a name for those who don't see it.
    pub fn open(&self, s: &mut String, label: &str) {
        let _ = write!(
            s,
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
            self.width,
            self.height,
            escape(label)
        );
    }

    /// Lines across with their values at the left.
    pub fn y_axis(&self, s: &mut String, wanted: f64) {
        self.y_lines(s, wanted);
        let all = ticks(self.y[0], self.y[1], wanted);
        let n = digits(&all);
        for t in all {
            let _ = write!(
                s,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                self.left - 6.0,
                self.sy(t) + 4.0,
                number(t, n)
            );
        }
    }

    /// Lines across alone, for plots whose values stand beside a neighbour.
    pub fn y_lines(&self, s: &mut String, wanted: f64) {
        for t in ticks(self.y[0], self.y[1], wanted) {
            let y = self.sy(t);
            let class = if t == 0.0 { "grid origin" } else { "grid" };
            let _ = write!(
                s,
                "<line class=\"{class}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                self.left,
                self.width - self.right
            );
        }
    }

    /// Lines upwards at `ticks` with texts below.
    pub fn x_ticks(&self, s: &mut String, ticks: &[(f64, String)]) {
        for (t, text) in ticks {
            let x = self.sx(*t);
            let _ = write!(
                s,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/><text class=\"tick\" x=\"{x:.1}\" \
                 y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                self.top,
                self.height - self.bottom,
                self.height - self.bottom + 16.0,
                escape(text)
            );
        }
    }

    /// Lines upwards with their values below.
    pub fn x_axis(&self, s: &mut String, wanted: f64) {
        let all = ticks(self.x[0], self.x[1], wanted);
        let n = digits(&all);
        let ticks: Vec<_> = all.into_iter().map(|t| (t, number(t, n))).collect();
        self.x_ticks(s, &ticks);
    }

    /// The base line and the texts of the axes.
    pub fn texts(&self, s: &mut String, x: &str, y: &str) {
        let base = self.height - self.bottom;
        let (cx, cy) = (0.5 * (self.left + self.width - self.right), 0.5 * (self.top + base));
        let _ = write!(
            s,
            "<line class=\"base\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{base:.1}\" y2=\"{base:.1}\"/>\
             <text class=\"axis\" x=\"{cx:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text class=\"axis\" transform=\"translate(12 {cy:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.left,
            self.width - self.right,
            self.height - 6.0,
            escape(x),
            escape(y)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        assert_eq!(ticks(0.0, 100.0, 4.0), [0.0, 50.0, 100.0]);
        assert_eq!(ticks(0.0, 1.0, 5.0).len(), 6);
        assert_eq!(ticks(0.0, 10.0, 5.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let texts = |t: &[f64]| t.iter().map(|v| number(*v, digits(t))).collect::<Vec<_>>();
        assert_eq!(texts(&ticks(-0.13, 0.27, 4.0)), ["−0.1", "0.0", "0.1", "0.2"]);
        assert_eq!(texts(&ticks(0.0, 0.001, 4.0)), ["0.0000", "0.0005", "0.0010"]);
        assert_eq!(
            ticks(9990.0, 10_050.0, 6.0),
            [9990.0, 10_000.0, 10_010.0, 10_020.0, 10_030.0, 10_040.0, 10_050.0]
        );
    }

    #[test]
    fn ranges_that_can_not_be_drawn_have_no_ticks_and_end_no_program() {
        for (low, high) in [
            (0.0, f64::INFINITY),
            (f64::NEG_INFINITY, f64::INFINITY),
            (-f64::MAX, f64::MAX),
            (f64::NAN, 1.0),
            (0.0, f64::NAN),
            (1.0, 0.0),
        ] {
            assert!(ticks(low, high, 5.0).is_empty(), "{low} to {high}");
        }
        assert!(ticks(0.0, 1.0, 0.0).is_empty());
        // Any finite range has some, whatever its size.
        for high in [f64::MAX, 1e308, 1e100, 1e17, 1e-3, 1e-300, 0.0] {
            let all = ticks(0.0, high, 5.0);
            assert!((1..=7).contains(&all.len()) && all.iter().all(|t| t.is_finite()), "{high}: {all:?}");
        }
        assert!(ticks(1e300, 1e300, 5.0).len() <= 1 && ticks(1e17, 1e17 + 16.0, 5.0).len() <= 7);
        assert_eq!(ticks(0.0, 1.0, 1e9).len(), MOST);
    }

    #[test]
    fn values_lie_within_the_picture_whatever_they_are() {
        let frame =
            |x, y| Frame { width: 100.0, height: 50.0, left: 10.0, right: 10.0, top: 5.0, bottom: 5.0, x, y };
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, f64::MAX, -f64::MAX, 1e38];
        let ranges =
            [[0.0, 1.0], [4.6e17, -4.6e17], [0.0, 0.0], [f64::NAN, 1.0], [f64::NEG_INFINITY, f64::INFINITY]];
        for range in ranges {
            let mut frame = frame(range, range);
            for value in odd {
                let (x, y) = (frame.sx(value), frame.sy(value));
                assert!(
                    (10.0..=90.0).contains(&x) && (5.0..=45.0).contains(&y),
                    "{value} in {range:?}: {x}, {y}"
                );
            }
            frame.make_square();
            let mut text = String::new();
            frame.x_axis(&mut text, 5.0);
            frame.y_axis(&mut text, 5.0);
            assert!(text.len() < 10_000 && !text.contains("NaN"), "{range:?}: {text}");
        }
        let frame = frame([0.0, 10.0], [0.0, 1.0]);
        assert_eq!((frame.sx(5.0), frame.sx(-1.0), frame.sx(11.0), frame.sy(1.0)), (50.0, 10.0, 90.0, 5.0));
    }
}
