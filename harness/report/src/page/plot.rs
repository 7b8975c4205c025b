//! Histograms of runs as SVG, for a page in light and dark.

use std::fmt::Write as _;

use vb_page::escape;
use vb_page::plot::Frame;

/// Number of colours that the page's style has for runs.
pub(super) const COLOURS: usize = 8;

/// The class of a run's colour.
pub(super) fn colour(run: usize) -> usize {
    run % COLOURS
}

/// Values of each run in bins.
pub(super) struct Histogram {
    low: f64,
    width: f64,
    /// Shares of the values, by run.
    fractions: Vec<Vec<f64>>,
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
        let fraction = |v: &Vec<f64>| {
            let mut bins = vec![0.0; BINS];
            for x in v.iter().filter(|x| x.is_finite()) {
                bins[(((x - low) / width).max(0.0) as usize).min(BINS - 1)] += 1.0 / v.len() as f64;
            }
            bins
        };
        Some(Self {
            low,
            width,
            fractions: values.iter().map(fraction).collect(),
            counts: values.iter().map(Vec::len).collect(),
        })
    }

    /// The histograms over each other.
    pub(super) fn draw(&self, title: &str, axis: &str, labels: &[String]) -> String {
        let top = self.fractions.iter().flatten().fold(1e-9_f64, |m, v| m.max(*v));
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
        for (k, bins) in self.fractions.iter().enumerate() {
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
        assert!((h.fractions[0].iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let s = h.draw("a < b", "m", &["<script>".into(), "b".into()]);
        assert!(s.contains("&lt;script&gt;") && !s.contains("<script") && !s.contains("NaN"), "{s}");
        assert!(Histogram::new(&[vec![], vec![]]).is_none());
        assert!(Histogram::new(&[vec![3.0]]).is_some());
    }
}
