//! Two planners' successes on the same tasks.

/// Two-sided p-value of McNemar's exact test (McNemar 1947; the binomial form in Agresti 2002, section 10.1.1): `only_a`
/// tasks succeed with one planner alone, `only_b` with the other alone. 1 where they never differ.
///
/// It takes tasks as independent; tasks in one world are less than that.
#[must_use]
pub fn mcnemar(only_a: u64, only_b: u64) -> f64 {
    let n = only_a + only_b;
    let k = only_a.min(only_b);
    if n == 0 || 2 * k == n {
        return 1.0;
    }
    // P(X ≤ k) of a fair coin: the greatest term by logarithms, the others by their ratios downwards.
    let (nf, kf) = (n as f64, k as f64);
    let ln_gamma = |x: f64| vb_math::ln_gamma(x + 1.0);
    let ln_term = ln_gamma(nf) - ln_gamma(kf) - ln_gamma(nf - kf) - nf * std::f64::consts::LN_2;
    let (mut ratio, mut sum) = (1.0, 1.0);
    let mut i = kf;
    while i > 0.0 && ratio > 1e-18 {
        ratio *= i / (nf - i + 1.0);
        sum += ratio;
        i -= 1.0;
    }
    (2.0 * vb_math::exp(ln_term) * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_are_those_of_statsmodels() {
        // statsmodels 0.14, stats.contingency_tables.mcnemar(exact=True).
        for (b, c, p) in [
            (6, 16, 0.052_478_790_283_203_125),
            (0, 5, 0.0625),
            (33, 21, 0.133_674_235_364_105_22),
            (3, 3, 1.0),
            (10, 0, 0.001_953_125),
            (500, 600, 0.002_819_544_991_436_425),
            (0, 0, 1.0),
        ] {
            let found = mcnemar(b, c);
            assert!((found - p).abs() < 1e-11 * p.max(1e-3), "{b} {c}: {found}");
            assert_eq!(found, mcnemar(c, b));
        }
    }

    #[test]
    fn a_million_tasks_are_no_matter() {
        let p = mcnemar(500_000, 501_000);
        // Normal approximation with continuity correction: z = 999/√1001000 = 0.998501, p = 0.31804.
        assert!((p - 0.318_04).abs() < 2e-4, "{p}");
        assert_eq!(mcnemar(0, 1_000_000), 0.0);
    }
}
