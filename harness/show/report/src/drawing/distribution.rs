//! Distributions as small multiples: a row a run, with one axis for all, so that ten runs are as legible as two.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, number};
use vb_score::{Distribution, Extent, Measured, Metrics, Ride};

use super::series::colour;
use super::{Drawing, TEXT, fit, width};
use crate::Report;
use crate::runs::Row;

const BINS: usize = 40;

/// What the axis counts in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors, for what goes over several powers of ten; values of 0 or less count as 1.
    Logarithmic,
}

impl Scale {
    /// Where a value lies along the axis.
    fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => vb_math::ln(value.max(1.0)) / std::f64::consts::LN_10,
        }
    }
}

/// Values of each run in bins.
struct Bins {
    scale: Scale,
    low: f64,
    width: f64,
    /// Shares of the values, by run.
    fractions: Vec<Vec<f64>>,
    counts: Vec<usize>,
    medians: Vec<Option<f64>>,
}

impl Bins {
    /// Bins that hold the values of all runs but the far tails, which the outer bins take in; none without values.
    fn new(values: &[Vec<f64>], scale: Scale) -> Option<Self> {
        let sorted = |values: &mut dyn Iterator<Item = f64>| {
            let mut all: Vec<f64> = values.filter(|v| v.is_finite()).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let all = sorted(&mut values.iter().flatten().map(|v| scale.place(*v)));
        if all.is_empty() {
            return None;
        }
        let at = |p: f64| all[((all.len() - 1) as f64 * p).round() as usize];
        let (low, high) = (at(0.002), at(0.998));
        let (low, high) = match scale {
            // Whole powers of ten at both ends, so that there are values to read.
            Scale::Logarithmic => (low.floor(), high.floor() + 1.0),
            Scale::Linear if high - low < 1e-9 => (low - 0.5, high + 0.5),
            Scale::Linear if low > 0.0 && low < 0.25 * high => (0.0, high),
            Scale::Linear => (low, high),
        };
        let width = (high - low) / BINS as f64;
        let fraction = |v: &Vec<f64>| {
            let mut bins = vec![0.0; BINS];
            for x in v.iter().filter(|x| x.is_finite()) {
                let at = (scale.place(*x) - low) / width;
                bins[(at.max(0.0) as usize).min(BINS - 1)] += 1.0 / v.len() as f64;
            }
            bins
        };
        let median = |v: &Vec<f64>| {
            let own = sorted(&mut v.iter().copied());
            own.get(own.len() / 2).map(|upper| 0.5 * (own[(own.len() - 1) / 2] + upper))
        };
        Some(Self {
            scale,
            low,
            width,
            fractions: values.iter().map(fraction).collect(),
            counts: values.iter().map(Vec::len).collect(),
            medians: values.iter().map(median).collect(),
        })
    }

    /// The rows below each other in this width, with their names if there are several.
    fn draw(&self, title: &str, unit: &str, labels: &[&str], wide: f64) -> Drawing {
        let top = self.fractions.iter().flatten().fold(1e-9_f64, |m, v| m.max(*v));
        let runs = self.fractions.len();
        let (name, bars) = match runs {
            1 => (18.0, 150.0),
            2..=4 => (18.0, 40.0),
            5..=8 => (17.0, 22.0),
            _ => (16.0, 18.0),
        };
        let row = name + bars;
        let f = Frame {
            width: wide,
            height: 6.0 + row * runs as f64 + 42.0,
            left: 18.0,
            right: 18.0,
            top: 6.0,
            bottom: 42.0,
            x: [self.low, self.low + self.width * BINS as f64],
            y: [0.0, 1.0],
        };
        let mut s = String::new();
        match self.scale {
            // About a value each 70 units.
            Scale::Linear => f.x_axis(&mut s, (wide / 70.0).clamp(3.0, 6.0)),
            Scale::Logarithmic => f.x_ticks(&mut s, &powers(f.x)),
        }
        for (k, bins) in self.fractions.iter().enumerate() {
            let base = f.top + row * (k as f64 + 1.0) - 1.0;
            let y = |v: f64| base - (bars - 3.0) * v / top;
            let mut d = format!("M{:.1} {base:.1}", f.sx(self.low));
            for (b, v) in bins.iter().enumerate() {
                let edge = f.sx(self.low + (b + 1) as f64 * self.width);
                let _ = write!(d, "V{:.1}H{edge:.1}", y(*v));
            }
            let _ = write!(d, "V{base:.1}Z");
            let tasks = if self.counts[k] == 1 { "task" } else { "tasks" };
            let told = self.medians[k].map_or_else(|| "none".to_owned(), |m| format!("median {}", short(m)));
            let room = f.width - f.left - f.right - width(&told, TEXT) - 8.0;
            let label = if runs > 1 { escape(&fit(labels[k], TEXT, room)) } else { String::new() };
            let _ = write!(
                s,
                "<path class=\"curve s{c} f{c}\" d=\"{d}\"><title>{}: {} {tasks}</title></path><line class=\"base\" x1=\"{left:.1}\" \
                 x2=\"{:.1}\" y1=\"{base:.1}\" y2=\"{base:.1}\"/><text class=\"name\" x=\"{left:.1}\" y=\"{:.1}\">{label}</text>",
                escape(labels[k]),
                self.counts[k],
                f.width - f.right,
                base - bars - 2.0,
                c = colour(k),
                left = f.left,
            );
            if let Some(m) = self.medians[k] {
                let x = f.sx(self.scale.place(m));
                let _ = write!(s, "<path class=\"median\" d=\"M{x:.1} {base:.1}v{:.1}\"/>", 2.0 - bars);
            }
            let _ = write!(
                s,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{told}</text>",
                f.width - f.right,
                base - bars - 2.0
            );
        }
        f.texts(&mut s, &format!("{unit}; maximum bar: {} % of the tasks", number(100.0 * top, 0)), "");
        Drawing::new(title, &f, s)
    }
}

/// The function that reads a value of a task, if the task has it.
type Value = Box<dyn Fn(&Row) -> Option<f64>>;

/// A value of each task whose distribution is drawn.
pub(crate) struct Quantity {
    pub(crate) title: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) value: Value,
}

impl Quantity {
    /// The quantities of papers, or with [`Extent::Pages`] of HTML reports, which begin with them: the traversal time, and the
    /// measures that are declared as drawn.
    pub(crate) fn all(whose: Extent) -> Vec<Self> {
        let value = Box::new(|r: &Row| r.succeeded().then_some(r.time));
        let mut papers = vec![Self { title: "Traversal time of successes", unit: "s", value }];
        let mut pages = Vec::new();
        let measures = drawn(Metrics::MEASURES, |r| r.metrics.as_ref());
        for (of, quantity) in measures.chain(drawn(Ride::MEASURES, |r| r.ride.as_ref())) {
            if of == Extent::Papers { papers.push(quantity) } else { pages.push(quantity) }
        }
        if whose != Extent::Papers {
            papers.append(&mut pages);
        }
        papers
    }
}

/// The measures of a part of a record that are drawn.
fn drawn<T>(
    measures: &'static [Measured<T>],
    part: fn(&Row) -> Option<&T>,
) -> impl Iterator<Item = (Extent, Quantity)> {
    measures.iter().filter_map(move |m| {
        let Distribution { title, unit, of } = m.distribution?;
        let value = move |r: &Row| {
            let counts = of != Extent::Failures || !r.succeeded();
            part(r).filter(|_| counts).and_then(|part| m.number(part))
        };
        Some((of, Quantity { title, unit, value: Box::new(value) }))
    })
}

/// The distribution of a quantity over the tasks of each run; none where no task has it.
pub(crate) fn distribution(report: &Report, of: &Quantity, scale: Scale, wide: f64) -> Option<Drawing> {
    let runs = &report.runs.runs;
    let labels: Vec<&str> = runs.iter().map(|r| r.label.as_str()).collect();
    let values: Vec<Vec<f64>> =
        runs.iter().map(|run| run.counted().filter_map(&of.value).collect()).collect();
    Some(Bins::new(&values, scale)?.draw(of.title, of.unit, &labels, wide))
}

/// A value in few characters: `12.3`, `45.6 k`, `7.8 M`.
fn short(v: f64) -> String {
    let (scaled, unit) = match v.abs() {
        a if a >= 1e9 => (v / 1e9, "\u{2009}G"),
        a if a >= 1e6 => (v / 1e6, "\u{2009}M"),
        a if a >= 1e4 => (v / 1e3, "\u{2009}k"),
        _ => (v, ""),
    };
    format!("{}{unit}", number(scaled, if scaled.abs() < 100.0 { 1 } else { 0 }))
}

/// Powers of ten within a range of logarithms, and 2 and 5 times them where there are few.
fn powers(range: [f64; 2]) -> Vec<(f64, String)> {
    let mut power = 1.0;
    let mut at = 0.0;
    let mut found = Vec::new();
    let factors: &[f64] = if range[1] - range[0] > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    // No number of a record has more digits.
    while at <= range[1].min(400.0) {
        for factor in factors {
            let place = at + Scale::Logarithmic.place(*factor);
            if place >= range[0] - 1e-9 && place <= range[1] + 1e-9 {
                let value = factor * power;
                let text = match value {
                    v if v >= 1e9 => format!("{}\u{2009}G", v / 1e9),
                    v if v >= 1e6 => format!("{}\u{2009}M", v / 1e6),
                    v if v >= 1e3 => format!("{}\u{2009}k", v / 1e3),
                    v => v.to_string(),
                };
                found.push((place, text));
            }
        }
        power *= 10.0;
        at += 1.0;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bin_and_foreign_names_are_text() {
        let h = Bins::new(&[vec![1.0, 2.0, 2.0, 1e9], vec![f64::NAN]], Scale::Linear).unwrap();
        assert!((h.fractions[0].iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(h.medians, [Some(2.0), None]);
        let s = h.draw("a < b", "m", &["<script>", "b"], 460.0).body;
        assert!(s.contains("&lt;script&gt;") && !s.contains("<script") && !s.contains("NaN"), "{s}");
        assert!(Bins::new(&[vec![], vec![]], Scale::Linear).is_none());
        assert!(Bins::new(&[vec![3.0]], Scale::Linear).is_some());
    }

    #[test]
    fn a_logarithmic_axis_goes_from_a_power_of_ten_to_another() {
        let values = vec![vec![300.0, 20_000.0], vec![0.0, 4e6]];
        let h = Bins::new(&values, Scale::Logarithmic).unwrap();
        assert_eq!((h.low, h.low + h.width * BINS as f64), (0.0, 7.0));
        let texts = |range| powers(range).into_iter().map(|(_, t)| t).collect::<Vec<_>>();
        assert_eq!(texts([2.0, 5.0]), ["100", "1\u{2009}k", "10\u{2009}k", "100\u{2009}k"]);
        assert_eq!(texts([5.0, 6.0]), ["100\u{2009}k", "200\u{2009}k", "500\u{2009}k", "1\u{2009}M"]);
        assert_eq!((short(12.34), short(123_456.0)), ("12.3".into(), "123\u{2009}k".into()));
    }
}
