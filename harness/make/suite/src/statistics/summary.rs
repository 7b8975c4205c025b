//! Figures of many values: exact for few, in fine bins for the many nodes of all worlds.

use serde::Serialize;
use std::collections::BTreeMap;

/// The least, the mean, high percentiles and the greatest of some values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub count: usize,
    pub min: f64,
    pub mean: f64,
    pub p50: f64,
    /// The 95th percentile, by linear interpolation between order statistics.
    pub p95: f64,
    pub max: f64,
}

impl Summary {
    /// The summary of some finite values; `None` if there are no values.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        Some(Self {
            count: sorted.len(),
            min,
            mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
            p50: quantile(&sorted, 0.50),
            p95: quantile(&sorted, 0.95),
            max,
        })
    }
}

/// Quantile of ascending values by linear interpolation, as NumPy's default; `sorted` holds a value.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let k = at as usize;
    let next = sorted[(k + 1).min(sorted.len() - 1)];
    sorted[k] + (at - k as f64) * (next - sorted[k])
}

/// Counts of values in bins of one width, over any range: what a million nodes need of memory does not grow with
/// their number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tally {
    width: f64,
    bins: BTreeMap<i64, u64>,
    count: u64,
    max: f64,
}

impl Tally {
    /// Nothing yet, in bins of `width`.
    pub(crate) fn new(width: f64) -> Self {
        Self { width, bins: BTreeMap::new(), count: 0, max: f64::NEG_INFINITY }
    }

    /// Counts a finite value.
    pub(crate) fn add(&mut self, value: f64) {
        *self.bins.entry((value / self.width).floor() as i64).or_insert(0) += 1;
        self.count += 1;
        self.max = self.max.max(value);
    }

    /// Counts all that another tally of the same width counted.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (&bin, &n) in &other.bins {
            *self.bins.entry(bin).or_insert(0) += n;
        }
        self.count += other.count;
        self.max = self.max.max(other.max);
    }

    /// The greatest value, exactly; 0 of none.
    pub(crate) fn max(&self) -> f64 {
        if self.count > 0 { self.max } else { 0.0 }
    }

    /// The middle of the bin that holds the quantile, so right to half a bin; 0 of none.
    pub(crate) fn quantile(&self, q: f64) -> f64 {
        let rank = ((q * self.count as f64).ceil() as u64).max(1);
        let mut below = 0;
        for (&bin, &n) in &self.bins {
            below += n;
            if below >= rank {
                return (bin as f64 + 0.5) * self.width;
            }
        }
        0.0
    }

    /// The same counts in bins `times` as wide.
    pub(crate) fn histogram(&self, times: i64) -> Histogram {
        let mut wide: BTreeMap<i64, u64> = BTreeMap::new();
        for (&bin, &n) in &self.bins {
            *wide.entry(bin.div_euclid(times)).or_insert(0) += n;
        }
        let (first, last) = match (wide.keys().next(), wide.keys().next_back()) {
            (Some(&a), Some(&b)) => (a, b),
            _ => return Histogram { low: 0.0, width: self.width * times as f64, fraction: Vec::new() },
        };
        let width = self.width * times as f64;
        let fraction = |bin| wide.get(&bin).map_or(0.0, |&n| n as f64 / self.count as f64);
        Histogram { low: first as f64 * width, width, fraction: (first..=last).map(fraction).collect() }
    }
}

/// The distribution of values: the share of them in each bin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// The lower edge of the first bin.
    pub low: f64,
    /// The width of a bin.
    pub width: f64,
    /// The share of all values in each bin, 0 to 1.
    pub fraction: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_few_values_interpolate_between_them() {
        // By hand: of 0, 10, 20, 30, 40 the median is 20 and the 95th percentile lies at 0.95 * 4 = 3.8, so 38.
        let s = Summary::of([30.0, 0.0, 40.0, 10.0, 20.0]).unwrap();
        assert_eq!((s.count, s.min, s.mean, s.p50, s.max), (5, 0.0, 20.0, 20.0, 40.0));
        assert!((s.p95 - 38.0).abs() < 1e-12);
        let one = Summary::of([7.0]).unwrap();
        assert_eq!((one.p50, one.p95), (7.0, 7.0));
        assert_eq!(Summary::of([]), None);
    }

    #[test]
    fn a_tally_has_the_quantiles_of_its_values_to_half_a_bin_and_their_greatest_exactly() {
        let mut t = Tally::new(0.01);
        (-500..500).for_each(|k| t.add(f64::from(k) * 0.01 + 0.002));
        assert!((t.quantile(0.5) - -0.005).abs() < 0.006, "{}", t.quantile(0.5));
        assert!((t.quantile(0.95) - 4.495).abs() < 0.006, "{}", t.quantile(0.95));
        assert_eq!(t.max(), 499.0 * 0.01 + 0.002);
        assert_eq!((Tally::new(1.0).quantile(0.5), Tally::new(1.0).max()), (0.0, 0.0));
    }

    #[test]
    fn a_histogram_has_every_bin_between_the_first_and_the_last_and_shares_that_add_up_to_one() {
        let mut t = Tally::new(0.5);
        [-0.7, 0.1, 0.2, 2.9].into_iter().for_each(|v| t.add(v));
        // Bins of 1 from -1: [-1, 0), [0, 1), [1, 2), [2, 3).
        let h = t.histogram(2);
        assert_eq!((h.low, h.width), (-1.0, 1.0));
        assert_eq!(h.fraction, [0.25, 0.5, 0.0, 0.25]);
        let mut both = t.clone();
        both.merge(&t);
        assert_eq!(both.histogram(2), h);
    }
}
