//! Plots as SVG, for a page in light and dark.

use super::html::{escape, number};
use std::fmt::Write as _;

/// Number of colours that the page's style has for runs.
pub(super) const COLOURS: usize = 8;

/// The class of a run's colour.
pub(super) fn colour(run: usize) -> usize {
    run % COLOURS
}

/// Round values that cover a range.
pub(super) fn ticks(low: f64, high: f64, wanted: f64) -> Vec<f64> {
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
    (first..=last).map(|k| k as f64 * step + 0.0).collect()
}

/// Digits behind the point that tell ticks apart.
pub(super) fn digits(ticks: &[f64]) -> usize {
    let step = if ticks.len() > 1 { ticks[1] - ticks[0] } else { 1.0 };
    usize::from(step < 0.999) + usize::from(step < 0.0999) + usize::from(step < 0.00999)
}

/// Where the plot's area lies in its picture.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
}

impl Frame {
    pub(super) fn sx(&self, x: f64) -> f64 {
        let w = self.width - self.left - self.right;
        self.left + (x.clamp(self.x[0], self.x[1]) - self.x[0]) / (self.x[1] - self.x[0]) * w
    }

    pub(super) fn sy(&self, y: f64) -> f64 {
        let h = self.height - self.top - self.bottom;
        self.top + (1.0 - (y.clamp(self.y[0], self.y[1]) - self.y[0]) / (self.y[1] - self.y[0])) * h
    }

    pub(super) fn open(&self, s: &mut String, label: &str) {
        let _ = write!(
            s,
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
            self.width,
            self.height,
            escape(label)
        );
    }

    /// Lines across with their values at the left.
    pub(super) fn y_axis(&self, s: &mut String, wanted: f64) {
        let all = ticks(self.y[0], self.y[1], wanted);
        let n = digits(&all);
        for t in all {
            let y = self.sy(t);
            let _ = write!(
                s,
                "<line class=\"grid\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/><text class=\"tick\" x=\"{:.1}\" \
                 y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                self.left,
                self.width - self.right,
                self.left - 6.0,
                y + 4.0,
                number(t, n)
            );
        }
    }

    /// Lines upwards at `ticks` with texts below.
    pub(super) fn x_ticks(&self, s: &mut String, ticks: &[(f64, String)]) {
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

    pub(super) fn x_axis(&self, s: &mut String, wanted: f64) {
        let all = ticks(self.x[0], self.x[1], wanted);
        let n = digits(&all);
        let ticks: Vec<_> = all.into_iter().map(|t| (t, number(t, n))).collect();
        self.x_ticks(s, &ticks);
    }

    /// The base line and the texts of the axes.
    pub(super) fn texts(&self, s: &mut String, x: &str, y: &str) {
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

/// Values of each run in bins.
pub(super) struct Histogram {
    low: f64,
    width: f64,
    /// Shares of the values, by run.
    shares: Vec<Vec<f64>>,
    counts: Vec<usize>,
}

/// Number of bins.
const BINS: usize = 30;

impl Histogram {
    /// Bins that hold the values of all runs but the far tails, which the outer bins take in.
    pub(super) fn new(values: &[Vec<f64>]) -> Option<Self> {
        let mut all: Vec<f64> = values.iter().flatten().copied().filter(|v| v.is_finite()).collect();
        if all.is_empty() {
            return None;
        }
        all.sort_by(f64::total_cmp);
        let at = |p: f64| all[((all.len() - 1) as f64 * p).round() as usize];
        let (low, high) = (at(0.002), at(0.998));
        let (low, high) = if high - low < 1e-9 { (low - 0.5, high + 0.5) } else { (low, high) };
        let low = if low > 0.0 && low < 0.25 * high { 0.0 } else { low };
        let width = (high - low) / BINS as f64;
        let share = |v: &Vec<f64>| {
            let mut bins = vec![0.0; BINS];
            for x in v.iter().filter(|x| x.is_finite()) {
                bins[(((x - low) / width).max(0.0) as usize).min(BINS - 1)] += 1.0 / v.len() as f64;
            }
            bins
        };
        Some(Self {
            low,
            width,
            shares: values.iter().map(share).collect(),
            counts: values.iter().map(Vec::len).collect(),
        })
    }

    /// The histograms over each other.
    pub(super) fn draw(&self, title: &str, axis: &str, labels: &[String]) -> String {
        let top = self.shares.iter().flatten().fold(1e-9_f64, |m, v| m.max(*v));
        let f = Frame {
            width: 460.0,
            height: 250.0,
            left: 52.0,
            right: 12.0,
            top: 10.0,
            bottom: 42.0,
            x: [self.low, self.low + self.width * BINS as f64],
            y: [0.0, 105.0 * top],
        };
        let mut s = format!("<figure><figcaption>{}</figcaption>", escape(title));
        f.open(&mut s, title);
        f.y_axis(&mut s, 4.0);
        f.x_axis(&mut s, 7.0);
        for (k, bins) in self.shares.iter().enumerate() {
            let mut d = format!("M{:.1} {:.1}", f.sx(self.low), f.sy(0.0));
            for (b, v) in bins.iter().enumerate() {
                let edge = self.low + b as f64 * self.width;
                let y = f.sy(100.0 * v);
                let _ = write!(d, "L{:.1} {y:.1}L{:.1} {y:.1}", f.sx(edge), f.sx(edge + self.width));
            }
            let _ = write!(d, "L{:.1} {:.1}", f.sx(f.x[1]), f.sy(0.0));
            let _ = write!(
                s,
                "<path class=\"curve s{} f{}\" d=\"{d}\"><title>{}: {} tasks</title></path>",
                colour(k),
                colour(k),
                escape(&labels[k]),
                self.counts[k]
            );
        }
        f.texts(&mut s, axis, "% of tasks");
        s.push_str("</svg></figure>");
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_every_value_once_and_draws_foreign_names_as_text() {
        let h = Histogram::new(&[vec![1.0, 2.0, 2.0, 1e9], vec![f64::NAN]]).unwrap();
        assert!((h.shares[0].iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let s = h.draw("a < b", "m", &["<script>".into(), "b".into()]);
        assert!(s.contains("&lt;script&gt;") && !s.contains("<script") && !s.contains("NaN"), "{s}");
        assert!(Histogram::new(&[vec![], vec![]]).is_none());
        assert!(Histogram::new(&[vec![3.0]]).is_some());
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(0.0, 100.0, 4.0), [0.0, 50.0, 100.0]);
        assert_eq!(ticks(0.0, 1.0, 5.0).len(), 6);
        assert_eq!(digits(&[0.0, 0.05]), 2);
    }
}
