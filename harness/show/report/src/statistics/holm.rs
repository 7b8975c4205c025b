//! Many tests at once.

/// Adjusted p-values by Holm's step-down method (Holm 1979), in the order given: below 0.05 they hold together at a
/// family-wise error rate of 5 %, whatever depends on what.
#[must_use]
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut greatest: f64 = 0.0;
    for (k, &i) in order.iter().enumerate() {
        greatest = greatest.max((p_values.len() - k) as f64 * p_values[i]).min(1.0);
        adjusted[i] = greatest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adjusted_values_are_those_of_statsmodels() {
        // statsmodels 0.14, stats.multitest.multipletests(method="holm").
        let found = holm(&[0.01, 0.04, 0.03, 0.005, 0.2]);
        for (f, e) in found.iter().zip([0.04, 0.09, 0.09, 0.025, 0.2]) {
            assert!((f - e).abs() < 1e-15, "{found:?}");
        }
        assert_eq!(holm(&[0.7, 0.6]), [1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }
}
