//! The standard normal distribution.

/// The probability P(Z ≤ x) of a standard normal Z, by the complementary error function (Abramowitz and Stegun 1964,
/// 26.2.29).
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * vb_math::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// The x with P(Z ≤ x) = `p` for a standard normal Z: −∞ for p ≤ 0, +∞ for p ≥ 1.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if p >= 1.0 {
        return f64::INFINITY;
    }
    // Bisection, to neighbouring numbers: a few are asked for, and nothing is simpler to trust. Below the median only,
    // where the distribution function keeps its digits.
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    let (mut low, mut high) = (-40.0, 0.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if normal_cdf(middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distribution_and_quantiles_are_those_of_scipy() {
        // scipy 1.x, stats.norm.cdf and stats.norm.ppf.
        for (x, p) in [
            (-3.0, 0.001_349_898_031_630_093_3),
            (-1.96, 0.024_997_895_148_220_435),
            (0.0, 0.5),
            (1.0, 0.841_344_746_068_542_9),
            (2.5, 0.993_790_334_674_223_8),
        ] {
            assert!((normal_cdf(x) - p).abs() < 1e-15, "{x}");
        }
        for (p, x) in [
            (1e-6, -4.753_424_308_822_899),
            (0.025, -1.959_963_984_540_054_5),
            (0.5, 0.0),
            (0.9, 1.281_551_565_544_600_4),
            (0.975, 1.959_963_984_540_054),
        ] {
            assert!((normal_quantile(p) - x).abs() < 1e-12, "{p}: {}", normal_quantile(p));
        }
        assert_eq!((normal_quantile(0.0), normal_quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
    }
}
