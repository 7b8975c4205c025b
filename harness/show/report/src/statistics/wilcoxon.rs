//! Paired differences, by their ranks.

use super::normal_cdf;

/// Most differences for which the exact distribution is computed.
const EXACT: usize = 50;

/// The result of a signed-rank test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedRank {
    /// Number of differences that are not zero.
    pub count: usize,
    /// Sum of the ranks of the positive differences.
    pub positive: f64,
    /// Sum of the ranks of the negative ones.
    pub negative: f64,
    /// Two-sided p-value.
    pub p: f64,
}

/// Wilcoxon's signed-rank test (Wilcoxon 1945) of whether differences are symmetric about 0. Zeros are left out, equal
/// amounts share their mean rank. Up to 50 differences the p-value is exact, over all signs given the amounts; beyond, it
/// is by the normal approximation with the correction for ties (Lehmann 1975, p. 130), without one for continuity.
///
/// `None` if all differences are zero or there are none.
#[must_use]
pub fn wilcoxon(differences: &[f64]) -> Option<SignedRank> {
    let mut d: Vec<f64> = differences.iter().copied().filter(|v| *v != 0.0 && v.is_finite()).collect();
    if d.is_empty() {
        return None;
    }
    d.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = d.len();
    // Twice the ranks: whole numbers even where ranks are shared.
    let mut ranks = vec![0usize; n];
    let mut tie_term = 0.0;
    let mut from = 0;
    while from < n {
        let to = (from..n).find(|&k| d[k].abs() != d[from].abs()).unwrap_or(n);
        ranks[from..to].fill(from + 1 + to);
        let t = (to - from) as f64;
        tie_term += t * t * t - t;
        from = to;
    }
    let doubled = |keep: fn(f64) -> bool| -> usize {
        d.iter().zip(&ranks).filter(|(v, _)| keep(**v)).map(|(_, r)| r).sum()
    };
    let (positive, negative) = (doubled(|v| v > 0.0), doubled(|v| v < 0.0));
    let least = positive.min(negative);
    let p = if n <= EXACT {
        (2.0 * share_at_most(&ranks, least)).min(1.0)
    } else {
        let nf = n as f64;
        let mean = nf * (nf + 1.0) / 4.0;
        let variance = nf * (nf + 1.0) * (2.0 * nf + 1.0) / 24.0 - tie_term / 48.0;
        (2.0 * normal_cdf((0.5 * least as f64 - mean) / variance.sqrt())).min(1.0)
    };
    Some(SignedRank { count: n, positive: 0.5 * positive as f64, negative: 0.5 * negative as f64, p })
}

/// Share of all choices of signs whose sum of positive (doubled) ranks is at most `limit`.
fn share_at_most(ranks: &[usize], limit: usize) -> f64 {
    let mut fraction = vec![0.0; limit + 1];
    fraction[0] = 1.0;
    for &r in ranks {
        for sum in (0..=limit).rev() {
            let with = if sum >= r { fraction[sum - r] } else { 0.0 };
            fraction[sum] = 0.5 * (fraction[sum] + with);
        }
    }
    fraction.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_test_is_that_of_scipy_on_darwins_maize() {
        // Darwin's maize as in Fisher 1935; scipy.stats.wilcoxon gives statistic 24 and p 0.041259765625.
        let d = [6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75].map(f64::from);
        let r = wilcoxon(&d).unwrap();
        assert_eq!((r.count, r.negative, r.positive), (15, 24.0, 96.0));
        assert!((r.p - 0.041_259_765_625).abs() < 1e-15, "{}", r.p);
    }

    #[test]
    fn ties_share_ranks_and_zeros_are_left_out() {
        // scipy.stats.wilcoxon of the values without zeros, by all permutations of signs: 11 and 0.20703125.
        let d = [1.0, -2.0, 2.0, 3.0, 3.0, -3.0, 4.0, 0.0, 5.0, 0.0, -1.0];
        let r = wilcoxon(&d).unwrap();
        assert_eq!((r.count, r.negative), (9, 11.0));
        assert!((r.p - 0.207_031_25).abs() < 1e-15, "{}", r.p);
        assert_eq!(wilcoxon(&[0.0, 0.0]), None);
        assert_eq!(wilcoxon(&[]), None);
    }

    #[test]
    fn the_approximation_beyond_fifty_is_that_of_scipy() {
        // scipy.stats.wilcoxon(method="approx"): statistic 1281, p 0.14393573321978.
        let d: Vec<f64> = (0..80).map(|k| f64::from((k * 37) % 101 - 45) / 7.0).collect();
        let r = wilcoxon(&d).unwrap();
        assert_eq!(r.positive.min(r.negative), 1281.0);
        assert!((r.p - 0.143_935_733_219_78).abs() < 1e-13, "{}", r.p);
    }
}
