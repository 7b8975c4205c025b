//! What surfaces are compared by: slopes and spectra.

use std::ops::RangeInclusive;

use vb_math::fft::{Complex, inverse_2d};

/// Slopes in degrees of every inner node of a row-major surface by central differences, in no order.
#[must_use]
pub fn slopes(heights: &[f64], cols: usize, resolution: f64) -> Vec<f64> {
    slopes_of_rows(heights, cols, resolution, 1)
}

/// The same of the nodes of every so many-th row, for surfaces of which all nodes are too many.
///
/// # Panics
/// If `every` is 0.
#[must_use]
pub fn slopes_of_rows(heights: &[f64], cols: usize, resolution: f64, every: usize) -> Vec<f64> {
    let rows = heights.len() / cols.max(1);
    let z = |r: usize, c: usize| heights[r * cols + c];
    let mut slopes = Vec::new();
    for r in (1..rows.saturating_sub(1)).step_by(every) {
        for c in 1..cols.saturating_sub(1) {
            let dx = (z(r, c + 1) - z(r, c - 1)) / (2.0 * resolution);
            let dy = (z(r + 1, c) - z(r - 1, c)) / (2.0 * resolution);
            slopes.push(vb_math::angle::degrees(vb_math::atan(vb_math::hypot(dx, dy))));
        }
    }
    slopes
}

/// The value that a share of all values does not exceed (nearest rank); the values are reordered. 0 of none.
#[must_use]
pub fn percentile(values: &mut [f64], fraction: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (fraction * values.len() as f64).ceil().max(1.0) as usize - 1;
    let rank = rank.min(values.len() - 1);
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// The same of values that are in ascending order.
#[must_use]
pub fn percentile_of_sorted(values: &[f64], fraction: f64) -> f64 {
    let rank = (fraction * values.len() as f64).ceil().max(1.0) as usize - 1;
    values.get(rank).or(values.last()).copied().unwrap_or(0.0)
}

/// Standard deviation about the mean; 0 of none.
#[must_use]
pub fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt()
}

/// Square windows of `side` × `side` samples, side by side over a row-major surface; what is left over in the south and east is
/// passed over.
pub fn windows(heights: &[f64], cols: usize, side: usize) -> impl Iterator<Item = Vec<f64>> {
    let across = cols / side.max(1);
    let down = heights.len() / cols.max(1) / side.max(1);
    (0..across * down).map(move |i| {
        let corner = i / across * side * cols + i % across * side;
        (0..side).flat_map(|r| heights[corner + r * cols..][..side].iter().copied()).collect()
    })
}

/// Mean power of square windows by wave number: entry k is the mean over all waves of about k periods along a side, k from
/// 0 to half the side.
#[derive(Clone, Debug)]
pub struct Spectrum {
    side: usize,
    taper: Vec<f64>,
    /// Sum of each wave's power over the windows.
    power: Vec<f64>,
    windows: usize,
}

impl Spectrum {
    /// For windows of `side` × `side` samples, a power of two.
    ///
    /// # Panics
    /// If the side is none.
    #[must_use]
    pub fn new(side: usize) -> Self {
        assert!(side.is_power_of_two() && side >= 4, "the side of a window is a power of two");
        // Hann's taper: windows don't end in steps.
        let taper = (0..side)
            .map(|i| {
                let s = vb_math::sin(std::f64::consts::PI * (i as f64 + 0.5) / side as f64);
                s * s
            })
            .collect();
        Self { side, taper, power: vec![0.0; side * side], windows: 0 }
    }

    /// Adds a row-major window. Its mean is taken away.
    ///
    /// # Panics
    /// If it has another size.
    pub fn add(&mut self, window: &[f64]) {
        let n = self.side;
        assert_eq!(window.len(), n * n, "a window has side × side samples");
        let mean = window.iter().sum::<f64>() / (n * n) as f64;
        let mut waves: Vec<Complex> = window
            .iter()
            .enumerate()
            .map(|(i, v)| [(v - mean) * self.taper[i / n] * self.taper[i % n], 0.0])
            .collect();
        inverse_2d(&mut waves, n);
        for (p, [re, im]) in self.power.iter_mut().zip(&waves) {
            *p += re * re + im * im;
        }
        self.windows += 1;
    }

    /// Mean power of the wave with so many periods along columns and rows.
    #[must_use]
    pub fn wave(&self, row: usize, col: usize) -> f64 {
        self.power[row * self.side + col] / self.windows.max(1) as f64
    }

    /// Mean square of the windows' values in wavelengths from the first, which belongs to them, to the second, which doesn't; samples are
    /// `resolution` apart, in the unit of the wavelengths. Corrected for what the taper takes away; `None` if a window has no such wave.
    #[must_use]
    pub fn mean_square(&self, resolution: f64, [short, long]: [f64; 2]) -> Option<f64> {
        let n = self.side;
        let wave = |i: usize| i.min(n - i) as f64 / (n as f64 * resolution);
        let (mut sum, mut waves) = (0.0, 0usize);
        for (i, p) in self.power.iter().enumerate() {
            let k = vb_math::hypot(wave(i / n), wave(i % n));
            // Rounding must not move a wave over an edge.
            if k > (1.0 + 1e-9) / long && k <= (1.0 + 1e-9) / short {
                sum += p;
                waves += 1;
            }
        }
        let taper: f64 = self.taper.iter().map(|t| t * t).sum();
        (waves > 0).then(|| sum / (taper * taper * (n * n) as f64 * self.windows.max(1) as f64))
    }

    /// Mean power by wave number.
    #[must_use]
    pub fn radial(&self) -> Vec<f64> {
        let n = self.side;
        let mut sums = vec![(0.0, 0.0); n / 2 + 1];
        let wave = |i: usize| i.min(n - i) as f64;
        for (i, p) in self.power.iter().enumerate() {
            let k = vb_math::hypot(wave(i / n), wave(i % n)).round() as usize;
            if let Some((sum, count)) = sums.get_mut(k) {
                *sum += p;
                *count += 1.0;
            }
        }
        sums.iter().map(|(sum, count)| sum / (count * self.windows.max(1) as f64)).collect()
    }
}

/// How far two radial spectra are apart: the root mean square of the ratio in decibels, over wave numbers from `first`.
#[must_use]
pub fn spectral_distance(a: &[f64], b: &[f64], first: usize) -> f64 {
    let decibels = |(a, b): (&f64, &f64)| {
        let d = 10.0 / std::f64::consts::LN_10 * (vb_math::ln(*a) - vb_math::ln(*b));
        d * d
    };
    let squares: Vec<f64> = a.iter().zip(b).skip(first).map(decibels).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Exponent of the power law that a radial spectrum follows over these wave numbers: power ~ k^exponent, by least squares of the
/// logarithms, each wave number counting alike.
#[must_use]
pub fn exponent(radial: &[f64], waves: RangeInclusive<usize>) -> f64 {
    let points: Vec<[f64; 2]> =
        waves.filter_map(|k| Some([vb_math::ln(k as f64), vb_math::ln(*radial.get(k)?)])).collect();
    let n = points.len().max(1) as f64;
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / n;
    let [x, y] = [mean(0), mean(1)];
    let rise: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    rise / points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_one_slope() {
        // Rising 1 in √3 along the diagonal of x and y: 30°.
        let s = (1.0f64 / 6.0).sqrt();
        let plane: Vec<f64> = (0..30).map(|i| s * 0.5 * ((i % 6) as f64 + (i / 6) as f64)).collect();
        let all = slopes(&plane, 6, 0.5);
        assert_eq!(all.len(), 3 * 4);
        assert!(all.iter().all(|d| (d - 30.0).abs() < 1e-9), "{all:?}");
    }

    #[test]
    fn percentiles_are_the_nearest_ranks() {
        let mut v: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|s| percentile(&mut v, s)), [1.0, 50.0, 95.0, 100.0]);
        assert_eq!(percentile(&mut [], 0.5), 0.0);
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|s| percentile_of_sorted(&sorted, s)), [1.0, 50.0, 95.0, 100.0]);
        assert_eq!(percentile_of_sorted(&[], 0.5), 0.0);
        // Of 1 and 3: mean 2, each 1 away.
        assert_eq!(deviation(&[1.0, 3.0]), 1.0);
    }

    #[test]
    fn a_wave_has_its_power_at_its_wave_number() {
        let n = 32;
        let wave = |i: usize| vb_math::sin(std::f64::consts::TAU * 5.0 * (i % n) as f64 / n as f64);
        let mut s = Spectrum::new(n);
        s.add(&(0..n * n).map(wave).collect::<Vec<_>>());
        let r = s.radial();
        let peak = (0..r.len()).max_by(|a, b| r[*a].total_cmp(&r[*b])).unwrap();
        assert_eq!(peak, 5);
        assert!(s.wave(0, 5) > 100.0 * s.wave(5, 0));
        // Ten times the power everywhere: 10 dB.
        let ten: Vec<f64> = r.iter().map(|p| 10.0 * p).collect();
        assert!((spectral_distance(&ten, &r, 1) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn bands_hold_the_mean_square_of_their_waves() {
        // sin² has a mean of 1/2, over samples of 0.5 m: waves of 32 · 0.5 / 5 = 3.2 m.
        let n = 32;
        let wave = |i: usize| vb_math::sin(std::f64::consts::TAU * 5.0 * (i % n) as f64 / n as f64);
        let mut s = Spectrum::new(n);
        s.add(&(0..n * n).map(wave).collect::<Vec<_>>());
        let square = |band| s.mean_square(0.5, band).unwrap();
        assert!((square([2.0, 6.0]) - 0.5).abs() < 1e-9 && square([1.0, 2.0]) < 1e-9);
        assert_eq!(s.mean_square(0.5, [0.1, 0.5]), None);
    }

    #[test]
    fn windows_lie_side_by_side() {
        // Of 3 rows of 5: two windows of 2 × 2 in the first two rows.
        let heights: Vec<f64> = (0..15).map(f64::from).collect();
        let all: Vec<_> = windows(&heights, 5, 2).collect();
        assert_eq!(all, [[0.0, 1.0, 5.0, 6.0], [2.0, 3.0, 7.0, 8.0]]);
        assert_eq!(windows(&[], 0, 4).count(), 0);
    }

    #[test]
    fn a_power_law_has_its_exponent() {
        // 7/k³ from the first wave on; what lies beyond the range doesn't count.
        let mut radial: Vec<f64> = (0..20).map(|k| 7.0 / f64::from(k * k * k)).collect();
        radial[15] = 1e6;
        assert!((exponent(&radial, 2..=14) + 3.0).abs() < 1e-9);
    }
}
