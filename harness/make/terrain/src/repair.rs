//! Pits and spikes that no real terrain has, and holes.

use crate::ElevationImage;

/// A sample is suspect where it is further from the median of its neighbours than this many times the usual distance.
const DEVIATION: f64 = 6.0;
/// And isolated: at most so many of the 24 neighbours lie nearer to it than half way to their median. On the corner
/// of a real step eight do.
const ALLIES: usize = 3;
/// Standard deviation of a normal distribution over its median absolute deviation.
const MAD: f64 = 1.4826;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// Samples that were too low.
    pub pits: usize,
    /// Samples that were too high.
    pub spikes: usize,
}

/// Replaces isolated pits and spikes, such as the black specks of depth images, by the median of their neighbours.
///
/// The test is local and robust: a sample is replaced where it differs from the median of the 5 × 5 samples about it
/// (without itself) by more than six usual differences – 1.4826 times the median of that difference over the raster –
/// and no more than three of them take its side. So specks of up to four samples go; cliffs, ledges and boulders, which have
/// neighbours at their own height, stay.
pub fn repair(raster: &mut ElevationImage) -> Repaired {
    let (rows, cols) = (raster.rows(), raster.cols());
    let mut neighbours = Vec::with_capacity(24);
    let mut around = |r: usize, c: usize| {
        neighbours.clear();
        for y in r.saturating_sub(2)..(r + 3).min(rows) {
            for x in c.saturating_sub(2)..(c + 3).min(cols) {
                let v = raster.at(y, x);
                if (y, x) != (r, c) && !v.is_nan() {
                    neighbours.push(v);
                }
            }
        }
        // Fewer say nothing of what is usual here.
        (neighbours.len() >= 8 && !raster.at(r, c).is_nan()).then(|| {
            let median = median(&mut neighbours);
            let deviation = raster.at(r, c) - median;
            let allies =
                neighbours.iter().filter(|v| (*v - raster.at(r, c)).abs() < 0.5 * deviation.abs()).count();
            (median, deviation, allies)
        })
    };
    let found: Vec<_> = (0..rows * cols).map(|i| around(i / cols, i % cols)).collect();
    let mut usual: Vec<f64> = found.iter().flatten().map(|(_, d, _)| d.abs()).collect();
    if usual.is_empty() {
        return Repaired::default();
    }
    let limit = DEVIATION * MAD * median(&mut usual);
    let mut repaired = Repaired::default();
    for (value, found) in raster.values_mut().iter_mut().zip(found) {
        if let Some((median, deviation, allies)) = found
            && deviation.abs() > limit
            && allies <= ALLIES
        {
            *value = median;
            if deviation < 0.0 { repaired.pits += 1 } else { repaired.spikes += 1 }
        }
    }
    repaired
}

/// The median; of an even number the upper one. The slice is reordered.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Fills holes smoothly: each hole's sample becomes the mean of its four neighbours (Laplace's equation), as a soap film spans
/// a frame. What was not measured is 0 throughout a raster without any measured sample.
pub fn fill(raster: &mut ElevationImage) {
    let (rows, cols) = (raster.rows(), raster.cols());
    let holes: Vec<usize> = (0..rows * cols).filter(|i| raster.values()[*i].is_nan()).collect();
    if holes.is_empty() {
        return;
    }
    let known = (rows * cols - holes.len()) as f64;
    let start = raster.values().iter().filter(|v| !v.is_nan()).sum::<f64>() / known.max(1.0);
    for &i in &holes {
        raster.values_mut()[i] = start;
    }
    // Gauss–Seidel with over-relaxation; holes are small, and their edge is what matters.
    for _ in 0..400 {
        let mut change = 0.0f64;
        for &i in &holes {
            let (r, c) = (i / cols, i % cols);
            let mut sum = 0.0;
            let mut n = 0.0;
            let mut add = |r: usize, c: usize| {
                sum += raster.at(r, c);
                n += 1.0;
            };
            if r > 0 {
                add(r - 1, c);
            }
            if r + 1 < rows {
                add(r + 1, c);
            }
            if c > 0 {
                add(r, c - 1);
            }
            if c + 1 < cols {
                add(r, c + 1);
            }
            if n > 0.0 {
                let step = 1.5 * (sum / n - raster.at(r, c));
                raster.values_mut()[i] += step;
                change = change.max(step.abs());
            }
        }
        if change < 1e-9 {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gentle waves, with a little of everything.
    fn hills(rows: usize, cols: usize) -> ElevationImage {
        let z =
            |r: usize, c: usize| vb_math::sin(0.3 * r as f64) + vb_math::cos(0.2 * c as f64 + 0.1 * r as f64);
        ElevationImage::new(rows, cols, (0..rows * cols).map(|i| z(i / cols, i % cols)).collect())
    }

    #[test]
    fn specks_are_replaced_and_counted_and_nothing_else_changes() {
        let clean = hills(30, 40);
        let mut damaged = clean.clone();
        // A pit of one sample, a spike of one, and a pit of 2 × 2.
        let pits = [(5, 5), (20, 30), (20, 31), (21, 30), (21, 31)];
        for (r, c) in pits {
            damaged.values_mut()[r * 40 + c] = -20.0;
        }
        damaged.values_mut()[12 * 40 + 20] = 15.0;
        assert_eq!(repair(&mut damaged), Repaired { pits: 5, spikes: 1 });
        for (i, (a, b)) in damaged.values().iter().zip(clean.values()).enumerate() {
            let speck = pits.contains(&(i / 40, i % 40)) || i == 12 * 40 + 20;
            // Neighbours within two samples: the waves rise by at most 0.5 a sample.
            assert!(if speck { (a - b).abs() < 1.0 } else { a == b }, "{i}: {a} {b}");
        }
    }

    #[test]
    fn a_cliff_with_its_corner_and_a_boulder_stay() {
        let mut r = hills(30, 40);
        for i in 0..30 * 40 {
            let (row, col) = (i / 40, i % 40);
            // A plateau with a right-angled corner, and a block of 3 × 3.
            if row >= 15 && col >= 22 {
                r.values_mut()[i] += 10.0;
            }
            if (5..8).contains(&row) && (5..8).contains(&col) {
                r.values_mut()[i] += 10.0;
            }
        }
        let before = r.clone();
        assert_eq!(repair(&mut r), Repaired::default());
        assert_eq!(r, before);
    }

    #[test]
    fn a_filled_hole_spans_its_frame_as_a_film_does() {
        // A plane is its own film.
        let plane = |i: usize| 2.0 * (i % 9) as f64 - 0.5 * (i / 9) as f64;
        let mut r = ElevationImage::new(7, 9, (0..63).map(plane).collect());
        for (row, col) in [(2, 3), (2, 4), (3, 3), (3, 4), (4, 4)] {
            r.values_mut()[row * 9 + col] = f64::NAN;
        }
        fill(&mut r);
        for (i, v) in r.values().iter().enumerate() {
            assert!((v - plane(i)).abs() < 1e-6, "{i}: {v}");
        }
        let mut empty = ElevationImage::new(2, 2, vec![f64::NAN; 4]);
        fill(&mut empty);
        assert_eq!(empty.values(), [0.0; 4]);
    }
}
