//! Elevation as files have it.

/// Elevation on a square grid in the order of images: row-major, first row in the north. Holes are NaN. (A `vb_world::Raster`,
/// which lies in the world, has its first row in the south.)
#[derive(Clone, Debug, PartialEq)]
pub struct ElevationImage {
    rows: usize,
    cols: usize,
    values: Vec<f64>,
    /// Distance between samples in metres, where the file says so.
    resolution: Option<f64>,
}

impl ElevationImage {
    /// A raster of row-major values, first row in the north.
    ///
    /// # Panics
    /// If the number of values is not `rows * cols`.
    #[must_use]
    pub fn new(rows: usize, cols: usize, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), rows * cols, "a raster has rows × columns values");
        Self { rows, cols, values, resolution: None }
    }

    /// The same samples with a known distance between them, m.
    #[must_use]
    pub fn with_resolution(self, resolution: Option<f64>) -> Self {
        Self { resolution, ..self }
    }

    /// Number of rows, north to south.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns, west to east.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Row-major values; NaN is a hole.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Distance between samples in metres, where it is known.
    #[must_use]
    pub fn resolution(&self) -> Option<f64> {
        self.resolution
    }

    /// The sample at a row from the north and a column from the west.
    #[inline]
    #[must_use]
    pub fn at(&self, row: usize, col: usize) -> f64 {
        self.values[row * self.cols + col]
    }

    /// The height at a row and a column between samples by the four about it; beyond the outermost ones they go on level. NaN beside
    /// a hole.
    #[inline]
    #[must_use]
    pub fn between(&self, row: f64, col: f64) -> f64 {
        let split = |v: f64, n: usize| {
            let v = v.clamp(0.0, (n - 1) as f64);
            let low = (v as usize).min(n.saturating_sub(2));
            (low, (low + 1).min(n - 1), v - low as f64)
        };
        let (r0, r1, v) = split(row, self.rows);
        let (c0, c1, u) = split(col, self.cols);
        // A sample without weight may be a hole.
        let part = |r: usize, c: usize, w: f64| if w > 0.0 { w * self.at(r, c) } else { 0.0 };
        part(r0, c0, (1.0 - v) * (1.0 - u))
            + part(r0, c1, (1.0 - v) * u)
            + part(r1, c0, v * (1.0 - u))
            + part(r1, c1, v * u)
    }

    pub fn flip_rows(&mut self) {
        let cols = self.cols;
        for r in 0..self.rows / 2 {
            let (north, south) = self.values.split_at_mut((self.rows - 1 - r) * cols);
            north[r * cols..(r + 1) * cols].swap_with_slice(&mut south[..cols]);
        }
    }

    pub fn flip_cols(&mut self) {
        self.values.chunks_exact_mut(self.cols).for_each(<[f64]>::reverse);
    }

    /// The part of `rows` × `cols` samples whose north-western one is (`row`, `col`).
    ///
    /// # Panics
    /// If it reaches over an edge.
    #[must_use]
    pub fn window(&self, row: usize, col: usize, rows: usize, cols: usize) -> Self {
        assert!(row + rows <= self.rows && col + cols <= self.cols, "a window lies within its raster");
        let line = |r: usize| self.values[r * self.cols + col..r * self.cols + col + cols].iter().copied();
        Self { rows, cols, values: (row..row + rows).flat_map(line).collect(), resolution: self.resolution }
    }

    #[must_use]
    pub fn holes(&self) -> usize {
        self.values.iter().filter(|v| v.is_nan()).count()
    }

    /// Every `n`-th sample along rows and columns from (`row`, `col`) on. A surface is known by its heights at places, as the nodes
    /// of a world have them; a mean over squares would flatten its ledges.
    ///
    /// # Panics
    /// If `n` is 0, or the first sample lies outside.
    #[must_use]
    pub fn thinned(&self, row: usize, col: usize, n: usize) -> Self {
        assert!(
            n > 0 && row < self.rows && col < self.cols,
            "the first of every n-th sample lies within its raster"
        );
        let (rows, cols) = ((self.rows - row).div_ceil(n), (self.cols - col).div_ceil(n));
        let values = (0..rows * cols).map(|i| self.at(row + i / cols * n, col + i % cols * n)).collect();
        Self { rows, cols, values, resolution: self.resolution.map(|p| p * n as f64) }
    }

    /// Means over squares of `n` × `n` samples, each a sample of the result. A square of which less than half is
    /// measured is a hole. What is left over in the south and east is dropped.
    ///
    /// # Panics
    /// If `n` is 0.
    #[must_use]
    pub fn reduced(&self, n: usize) -> Self {
        assert!(n > 0, "a mean is over one sample at least");
        let (rows, cols) = (self.rows / n, self.cols / n);
        let mut values = Vec::with_capacity(rows * cols);
        for r in 0..rows {
            for c in 0..cols {
                let (mut sum, mut count) = (0.0, 0usize);
                for y in 0..n {
                    for x in 0..n {
                        let v = self.at(r * n + y, c * n + x);
                        if !v.is_nan() {
                            sum += v;
                            count += 1;
                        }
                    }
                }
                values.push(if 2 * count >= n * n { sum / count as f64 } else { f64::NAN });
            }
        }
        Self { rows, cols, values, resolution: self.resolution.map(|p| p * n as f64) }
    }

    /// Takes away the plane that fits the measured samples best (least squares): the lie of the land, or the tilt
    /// of a sensor. Without three measured samples that span a plane nothing changes.
    pub fn level(&mut self) {
        // Normal equations about the centre of gravity of the measured samples.
        let place = |i: usize| ((i % self.cols) as f64, (i / self.cols) as f64);
        let (mut n, mut mean) = (0.0, [0.0; 3]);
        for (i, &z) in self.values.iter().enumerate().filter(|(_, z)| !z.is_nan()) {
            let (x, y) = place(i);
            n += 1.0;
            for (m, v) in mean.iter_mut().zip([x, y, z]) {
                *m += v;
            }
        }
        if n < 3.0 {
            return;
        }
        let mean = mean.map(|m| m / n);
        let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (i, &z) in self.values.iter().enumerate().filter(|(_, z)| !z.is_nan()) {
            let (x, y) = place(i);
            let (x, y, z) = (x - mean[0], y - mean[1], z - mean[2]);
            xx += x * x;
            xy += x * y;
            yy += y * y;
            xz += x * z;
            yz += y * z;
        }
        let det = xx * yy - xy * xy;
        if det <= 1e-9 * xx * yy {
            return;
        }
        let (a, b) = ((xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det);
        let cols = self.cols;
        for (i, z) in self.values.iter_mut().enumerate() {
            let (x, y) = ((i % cols) as f64, (i / cols) as f64);
            *z -= mean[2] + a * (x - mean[0]) + b * (y - mean[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levelling_takes_away_a_plane_and_nothing_else() {
        // A plane plus a wave that is orthogonal to planes on this grid: sign changes in the pattern + - - +.
        let wave = |r: usize, c: usize| [1.0, -1.0, -1.0, 1.0][r % 4] * [1.0, -1.0, -1.0, 1.0][c % 4];
        let plane = |r: usize, c: usize| 3.0 + 0.5 * c as f64 - 0.25 * r as f64;
        let all = |f: &dyn Fn(usize, usize) -> f64| (0..32).map(|i| f(i / 8, i % 8)).collect::<Vec<_>>();
        let mut r = ElevationImage::new(4, 8, all(&|r, c| plane(r, c) + wave(r, c)));
        r.level();
        for (got, want) in r.values().iter().zip(all(&wave)) {
            assert!((got - want).abs() < 1e-12, "{got} {want}");
        }
        // Holes stay holes and count for nothing.
        let mut r =
            ElevationImage::new(4, 8, all(&|r, c| if (r, c) == (2, 3) { f64::NAN } else { plane(r, c) }));
        r.level();
        assert_eq!(r.holes(), 1);
        assert!(r.values().iter().filter(|v| !v.is_nan()).all(|v| v.abs() < 1e-12));
        // One row spans no plane.
        let mut line = ElevationImage::new(1, 4, vec![1.0, 2.0, 4.0, 8.0]);
        line.level();
        assert_eq!(line.values(), [1.0, 2.0, 4.0, 8.0]);
    }

    #[test]
    fn thinning_keeps_every_so_many_th_sample() {
        // 0 to 19 in rows of five: from row 1, column 0 on every third.
        let r = ElevationImage::new(4, 5, (0..20).map(f64::from).collect()).with_resolution(Some(0.25));
        let thin = r.thinned(1, 0, 3);
        assert_eq!((thin.rows(), thin.cols(), thin.resolution()), (1, 2, Some(0.75)));
        assert_eq!(thin.values(), [5.0, 8.0]);
        assert_eq!(r.thinned(0, 1, 2).values(), [1.0, 3.0, 11.0, 13.0]);
    }

    #[test]
    fn reduction_averages_what_is_measured_and_needs_half_of_it() {
        let n = f64::NAN;
        let r = ElevationImage::new(2, 6, vec![1.0, 2.0, 1.0, n, n, n, 3.0, 6.0, n, 3.0, n, 4.0])
            .with_resolution(Some(0.5));
        let half = r.reduced(2);
        assert_eq!((half.rows(), half.cols(), half.resolution()), (1, 3, Some(1.0)));
        assert_eq!(half.values()[..2], [3.0, 2.0]);
        assert!(half.values()[2].is_nan());
    }
}
