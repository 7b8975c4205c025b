//! Values that mark places without a height although the file doesn't say so.

/// Marks that programs write and that no survey has for heights.
const MARKS: [f64; 9] = [
    -9999.0,
    -99999.0,
    -999_999.0,
    -9_999_999.0,
    -32768.0,
    -32767.0,
    -2_147_483_648.0,
    2_147_483_647.0,
    4_294_967_295.0,
];
/// Values that are marks in some files and heights in others.
const PERHAPS: [f64; 7] = [0.0, -999.0, 9999.0, 32767.0, 65535.0, 99999.0, 999_999.0];
/// No unit makes heights of such values.
const HUGE: f64 = 1e9;
/// The least distance of a mark from all other values.
const GAP: f64 = 500.0;

/// The value that is a mark by all appearance: one too large for a height, one that programs use for it at a distance from all other
/// values, or one that is a mark in some files and farther from all others than they are from each other. `None` if there is
/// none, or nothing but it.
pub(super) fn find(values: &[f64]) -> Option<f64> {
    let huge = |v: f64| v.abs() >= HUGE;
    let mut candidates: Vec<f64> = values.iter().copied().find(|v| huge(*v)).into_iter().collect();
    let first = candidates.len();
    candidates.extend(MARKS);
    candidates.extend(PERHAPS);
    let mut present = vec![false; candidates.len()];
    // Most heights are told from marks by their size.
    for v in values.iter().filter(|v| **v == 0.0 || v.abs() >= 999.0) {
        if let Some(k) = candidates.iter().position(|c| c == v) {
            present[k] = true;
        }
    }
    let range = |mark: f64| {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for v in values.iter().filter(|v| !v.is_nan() && **v != mark) {
            range = [range[0].min(*v), range[1].max(*v)];
        }
        range
    };
    let found = candidates.into_iter().enumerate().zip(present).filter(|(_, present)| *present);
    found.map(|(candidate, _)| candidate).find_map(|(k, mark)| {
        let [low, high] = range(mark);
        let apart = (low - mark).max(mark - high);
        let sure = k < first || apart > if k < first + MARKS.len() { GAP } else { GAP.max(high - low) };
        (low <= high && sure).then_some(mark)
    })
}

/// Makes holes of a mark; of huge ones of all that are as large.
pub(super) fn mark(values: &mut [f64], mark: f64) -> usize {
    let mut count = 0;
    for v in values {
        if *v == mark || (mark.abs() >= HUGE && v.abs() >= HUGE) {
            *v = f64::NAN;
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_far_from_everything_else() {
        assert_eq!(find(&[100.0, 101.0, -9999.0, 124.0]), Some(-9999.0));
        assert_eq!(find(&[3000.0, 0.5, -9999.0, 1240.0]), Some(-9999.0));
        assert_eq!(find(&[29_332.0, 31_000.0, 0.0]), Some(0.0));
        assert_eq!(find(&[100.0, -3.402_82e38, 120.0]), Some(-3.402_82e38));
        assert_eq!(find(&[1.0, -32768.0]), Some(-32768.0));
        assert_eq!(find(&[-2000.0, 8028.0, -9999.0]), Some(-9999.0));
        assert_eq!(find(&[600.0, 65535.0, 900.0]), Some(65535.0));
        assert_eq!(find(&[0.0, 20_000.0, 45_000.0, 65535.0]), None);
        // Sea floor, the sea beside a hill, and whole numbers of millimetres are heights.
        assert_eq!(find(&[-10_500.0, -9999.0, -9_400.0]), None);
        assert_eq!(find(&[0.0, 12.0, 300.0]), None);
        assert_eq!(find(&[99_960.0, 99_999.0, 124_510.0]), None);
        assert_eq!(find(&[0.0; 4]), None);
    }
}
