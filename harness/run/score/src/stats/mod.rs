//! Running statistics, and intervals.
//!
//! Ten tasks share a world, and a world that is hard for one task is hard for the others: tasks are not independent.
//! Intervals are therefore by a bootstrap that draws whole worlds.

mod bootstrap;
mod normal;
mod rate;

pub use bootstrap::{Interval, Ratio, bootstrap, bootstrap_ratio};
pub use normal::{normal_cdf, normal_quantile};
pub use rate::{BOOTSTRAP_SEED, success_interval};

/// Mean, variance and maximum in one pass (Welford 1962), combinable (Chan, Golub, LeVeque 1979, eq. 2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Running {
    pub(crate) count: u64,
    pub(crate) mean: f64,
    /// Sum of squared deviations from the mean.
    m2: f64,
    pub(crate) max: f64,
}

impl Running {
    /// Statistics with this many values of this mean, population variance and maximum.
    pub(crate) fn from_parts(count: u64, mean: f64, variance: f64, max: f64) -> Self {
        Self { count, mean, m2: variance * count as f64, max }
    }

    pub(crate) fn push(&mut self, value: f64) {
        self.max = if self.count == 0 { value } else { self.max.max(value) };
        self.count += 1;
        let delta = value - self.mean;
        self.mean += delta / self.count as f64;
        self.m2 += delta * (value - self.mean);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let delta = other.mean - self.mean;
        self.mean += delta * m / (n + m);
        self.m2 += other.m2 + delta * delta * n * m / (n + m);
        self.count += other.count;
        self.max = self.max.max(other.max);
    }

    /// Population variance; 0 without values.
    pub(crate) fn variance(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.m2 / self.count as f64 }
    }
}

/// The 97.5 % point of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % score interval (lower, upper), in [0, 1], of a rate after `successes` in `trials` (Wilson 1927; Brown, Cai,
/// DasGupta 2001, eq. 4). It takes the trials as independent; tasks in one world are less than that.
///
/// It returns `None` if there are no trials.
#[must_use]
pub fn wilson(successes: u64, trials: u64) -> Option<(f64, f64)> {
    if trials == 0 {
        return None;
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let z2 = Z * Z;
    let centre = p + z2 / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z2 / n;
    // Without successes or without failures the interval reaches 0 or 1 exactly; rounding hides it.
    let low = if successes == 0 { 0.0 } else { (centre - half) / scale };
    let high = if successes == trials { 1.0 } else { (centre + half) / scale };
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_agrees_with_published_values() {
        // Newcombe 1998, Statistics in Medicine 17:857, table I, method 3 (score, no continuity correction).
        for (r, n, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let (l, h) = wilson(r, n).unwrap();
            assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{r}/{n}: {l} {h}");
        }
        assert_eq!(wilson(0, 0), None);
        assert_eq!(wilson(7, 7).unwrap().1, 1.0);
        assert_eq!(wilson(0, 7).unwrap().0, 0.0);
    }

    #[test]
    fn mean_and_variance_are_those_of_the_values_even_far_from_zero() {
        // 4, 7, 13, 16: mean 10, population variance 22.5; a shift changes the mean only.
        let mut s = Running::default();
        [4.0, 7.0, 13.0, 16.0].iter().for_each(|v| s.push(v + 1e9));
        assert_eq!((s.mean, s.variance(), s.max, s.count), (1e9 + 10.0, 22.5, 1e9 + 16.0, 4));
    }

    #[test]
    fn merged_parts_are_as_the_whole() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0, -3.0];
        let of = |v: &[f64]| {
            let mut s = Running::default();
            v.iter().for_each(|&x| s.push(x));
            s
        };
        let whole = of(&values);
        let mut merged = Running::default();
        merged.merge(&of(&values[..2]));
        merged.merge(&of(&[]));
        merged.merge(&of(&values[2..]));
        assert_eq!((merged.count, merged.max), (whole.count, whole.max));
        assert!(
            (merged.mean - whole.mean).abs() < 1e-15 && (merged.variance() - whole.variance()).abs() < 1e-12
        );
    }
}
