//! The last stage of a drawn surface: its octaves and its steepness take the distributions that those of the scans have.
//!
//! What a decoder draws within a few samples is too weak and too near to normal, since it was trained on distances that average;
//! rocks and ledges are rare and steep. A pass takes the surface apart into octaves and maps the values of each, one by one, by a
//! curve that turns their quantiles into those of the scans (Heeger and Bergen 1995, "Pyramid-based texture analysis/synthesis").
//! That knows nothing of how octaves meet: in the scans they are strong at the same places, the ledges, and the ground between
//! is smoother than independent octaves make it. So the sum of the octaves is then multiplied, place by place, by what brings its
//! steepness to the scans' distribution.
//!
//! Octaves are differences of smoothed surfaces that keep all samples (the à trous transform with a B-spline, Starck, Murtagh and
//! Bijaoui 1998, §1.4.4), so that each sample is the same function of those about it: no lattice comes of it.

/// Octaves that a pass takes a surface apart into: waves of about 2 to 4, 4 to 8 and 8 to 16 samples.
pub const BANDS: usize = 3;
/// Samples on each side of a surface that its octaves lack.
pub const OCTAVES_REACH: usize = 2 * ((1 << BANDS) - 1);
/// Samples on each side of a surface that its steepness lacks: one by the difference, two by the kernel.
pub const STEEPNESS_REACH: usize = 3;
/// Samples that a pass needs on each side of those that it makes.
pub const REACH: usize = OCTAVES_REACH + STEEPNESS_REACH;
/// Most passes of a model.
pub const MAX_PASSES: usize = 8;
/// The cubic B-spline at its nodes: the kernel that smooths.
const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Samples row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Samples in a row.
    pub cols: usize,
    /// The samples, in the decoder's unit.
    pub values: Vec<f32>,
}

impl Plane {
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.cols.max(1)
    }

    /// Without so many samples on each side.
    ///
    /// # Panics
    /// If nothing is left.
    #[must_use]
    pub fn inner(&self, margin: usize) -> Self {
        assert!(2 * margin < self.cols.min(self.rows()), "a margin leaves something in the middle");
        let cols = self.cols - 2 * margin;
        let lines = self.values.chunks_exact(self.cols).skip(margin).take(self.rows() - 2 * margin);
        Self { cols, values: lines.flat_map(|l| l[margin..margin + cols].iter().copied()).collect() }
    }

    /// The mean by the kernel over samples `step` apart, without the 2 · `step` samples on each side that lack neighbours.
    fn smoothed(&self, step: usize) -> Self {
        let (cols, rows) = (self.cols - 4 * step, self.rows() - 4 * step);
        // Down the columns first, then along the rows; sums from the first to the last of five.
        let mut down = vec![0.0f32; rows * self.cols];
        for (row, line) in down.chunks_exact_mut(self.cols).enumerate() {
            for (k, w) in KERNEL.iter().enumerate() {
                let from = &self.values[(row + k * step) * self.cols..][..self.cols];
                for (sum, v) in line.iter_mut().zip(from) {
                    *sum += w * v;
                }
            }
        }
        let mut values = vec![0.0f32; rows * cols];
        for (line, from) in values.chunks_exact_mut(cols).zip(down.chunks_exact(self.cols)) {
            for (k, w) in KERNEL.iter().enumerate() {
                for (sum, v) in line.iter_mut().zip(&from[k * step..]) {
                    *sum += w * v;
                }
            }
        }
        Self { cols, values }
    }

    /// The octave that smoothing over samples `step` apart takes away, and what it leaves, both narrower by 2 · `step` on each
    /// side.
    ///
    /// # Panics
    /// If the plane has no more than 4 · `step` samples along a side.
    #[must_use]
    pub fn octave(&self, step: usize) -> (Self, Self) {
        let smooth = self.smoothed(step);
        let mut rough = self.inner(2 * step);
        for (v, s) in rough.values.iter_mut().zip(&smooth.values) {
            *v -= s;
        }
        (rough, smooth)
    }

    /// How steep the plane is about each sample: the root of the smoothed sum of squares of its differences over two samples
    /// along columns and rows, so in the plane's unit; narrower by [`STEEPNESS_REACH`] on each side.
    ///
    /// # Panics
    /// If nothing would be left.
    #[must_use]
    pub fn steepness(&self) -> Self {
        let mut squares = self.inner(1);
        let cols = squares.cols;
        for (i, s) in squares.values.iter_mut().enumerate() {
            let at = (i / cols + 1) * self.cols + i % cols + 1;
            let across = self.values[at + 1] - self.values[at - 1];
            let down = self.values[at + self.cols] - self.values[at - self.cols];
            *s = across * across + down * down;
        }
        let mut steepness = squares.smoothed(1);
        for s in &mut steepness.values {
            *s = s.sqrt();
        }
        steepness
    }

    /// The plane after a pass, narrower by [`REACH`] on each side.
    ///
    /// # Panics
    /// If nothing would be left.
    #[must_use]
    pub fn mapped(&self, pass: &Pass) -> Self {
        let (detail, rest) = self.with_octaves(&pass.octaves);
        let steepness = detail.steepness();
        let (mut detail, rest) = (detail.inner(STEEPNESS_REACH), rest.inner(STEEPNESS_REACH));
        for ((d, s), r) in detail.values.iter_mut().zip(&steepness.values).zip(&rest.values) {
            *d = *d * pass.steepness.factor(*s) + r;
        }
        detail
    }

    /// The sum of the octaves after these curves, the finest first, and what lies below the octaves; both narrower by
    /// [`OCTAVES_REACH`] on each side.
    ///
    /// # Panics
    /// If nothing would be left.
    #[must_use]
    pub fn with_octaves(&self, curves: &[Curve; BANDS]) -> (Self, Self) {
        let mut sum = Self { cols: self.cols - 2 * OCTAVES_REACH, values: Vec::new() };
        sum.values.resize(sum.cols * (self.rows() - 2 * OCTAVES_REACH), 0.0);
        let mut rest = self.clone();
        for (band, curve) in curves.iter().enumerate() {
            let (rough, smooth) = rest.octave(1 << band);
            let margin = (rough.cols - sum.cols) / 2;
            let lines = rough.values.chunks_exact(rough.cols).skip(margin);
            for (line, from) in sum.values.chunks_exact_mut(sum.cols).zip(lines) {
                for (s, v) in line.iter_mut().zip(&from[margin..]) {
                    *s += curve.at(*v);
                }
            }
            rest = smooth;
        }
        (sum, rest)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// For each octave, the finest first, the curve from its drawn heights to those of the scans.
    pub octaves: [Curve; BANDS],
    /// The curve from drawn steepness to that of the scans.
    pub steepness: Curve,
}

/// A curve of straight pieces that never falls, from values of a drawn surface to those of the scans, in the decoder's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    from: Vec<f32>,
    to: Vec<f32>,
}

impl Curve {
    /// Least and largest number of knots.
    pub const KNOTS: [usize; 2] = [2, 1024];

    /// Through these knots. Below the first and above the last a value is multiplied by what multiplies that knot.
    ///
    /// # Errors
    /// What is wrong with the knots, in words: their number; `from` that doesn't rise or ends at 0; `to` that falls; or numbers
    /// that are none.
    pub fn new(from: Vec<f32>, to: Vec<f32>) -> Result<Self, String> {
        let [least, most] = Self::KNOTS;
        if from.len() != to.len() || !(least..=most).contains(&from.len()) {
            return Err(format!("{} and {} knots: must be as many, {least} to {most}", from.len(), to.len()));
        }
        if from.iter().chain(&to).any(|v| !v.is_finite()) {
            return Err("has knots that are not numbers".into());
        }
        if from.windows(2).any(|w| w[0] >= w[1]) || from[0] == 0.0 || from[from.len() - 1] == 0.0 {
            return Err("knots must increase, and the first and the last must not be 0".into());
        }
        if to.windows(2).any(|w| w[0] > w[1]) {
            return Err("knots result in decreasing heights: must increase".into());
        }
        Ok(Self { from, to })
    }

    /// What a value becomes.
    #[must_use]
    pub fn at(&self, value: f32) -> f32 {
        let after = self.from.partition_point(|f| *f <= value);
        if after == 0 {
            return value * (self.to[0] / self.from[0]);
        }
        if after == self.from.len() {
            return value * (self.to[after - 1] / self.from[after - 1]);
        }
        let (a, b) = (after - 1, after);
        let t = (value - self.from[a]) / (self.from[b] - self.from[a]);
        self.to[a] + t * (self.to[b] - self.to[a])
    }

    /// What multiplies a value: what it becomes over itself.
    #[must_use]
    pub fn factor(&self, value: f32) -> f32 {
        if value <= self.from[0] { self.to[0] / self.from[0] } else { self.at(value) / value }
    }

    /// Where the knots lie and where they lead.
    #[must_use]
    pub fn knots(&self) -> (&[f32], &[f32]) {
        (&self.from, &self.to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::rng::Stream;

    fn noise(rows: usize, cols: usize) -> Plane {
        let mut rng = Stream::new(1, &["bands"]);
        Plane { cols, values: (0..rows * cols).map(|_| rng.normal(0.0, 1.0) as f32).collect() }
    }

    fn straight(gain: f32) -> Curve {
        Curve::new(vec![-1.0, 0.0, 2.0], vec![-gain, 0.0, 2.0 * gain]).unwrap()
    }

    fn pass(octaves: [f32; 3], steepness: f32) -> Pass {
        Pass { octaves: octaves.map(straight), steepness: straight(steepness) }
    }

    #[test]
    fn octaves_add_up_to_the_surface() {
        let plane = noise(60, 50);
        let same = plane.mapped(&pass([1.0; 3], 1.0));
        let inner = plane.inner(REACH);
        assert_eq!((same.cols, same.rows()), (50 - 34, 60 - 34));
        for (a, b) in same.values.iter().zip(&inner.values) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
        // Three times the octaves, or three times the steepness: the same.
        let (a, b) = (plane.mapped(&pass([3.0; 3], 1.0)), plane.mapped(&pass([1.0; 3], 3.0)));
        for ((a, b), same) in a.values.iter().zip(&b.values).zip(&same.values) {
            assert!((a - b).abs() < 1e-5 && (a - same).abs() > 1e-6, "{a} {b} {same}");
        }
    }

    #[test]
    fn the_steepness_of_a_plane_is_its_rise_over_two_samples() {
        // Rising 3 along a column and 4 along a row each sample: √(6² + 8²) over two.
        let plane = Plane { cols: 9, values: (0..99).map(|i| (3 * (i / 9) + 4 * (i % 9)) as f32).collect() };
        let steepness = plane.steepness();
        assert_eq!((steepness.cols, steepness.rows()), (3, 5));
        assert!(steepness.values.iter().all(|s| (s - 10.0).abs() < 1e-5), "{:?}", steepness.values);
    }

    #[test]
    fn an_octave_is_what_the_spline_takes_away() {
        // Of cos(ωx) the kernel [1 4 6 4 1]/16 leaves cos⁴(ω·step/2), along the one direction in which it varies.
        let (cols, step, omega) = (64, 2, 0.7);
        let wave = |i: usize| vb_math::cos(omega * (i % cols) as f64);
        let plane = Plane { cols, values: (0..40 * cols).map(|i| wave(i) as f32).collect() };
        let (rough, smooth) = plane.octave(step);
        let kept = vb_math::cos(omega * step as f64 / 2.0);
        let kept = kept * kept * kept * kept;
        for (i, (r, s)) in rough.values.iter().zip(&smooth.values).enumerate() {
            let whole = vb_math::cos(omega * (i % rough.cols + 2 * step) as f64);
            assert!((f64::from(*s) - kept * whole).abs() < 1e-6 && (f64::from(*r + *s) - whole).abs() < 1e-6);
        }
    }

    #[test]
    fn a_sample_has_the_same_bits_in_whichever_rectangle_it_is_made() {
        let plane = noise(60, 70);
        let curves = pass([2.0, 0.5, 1.5], 1.5);
        let whole = plane.mapped(&curves);
        let part = plane.inner(5).mapped(&curves);
        assert_eq!(part, whole.inner(5));
    }

    #[test]
    fn a_curve_goes_through_its_knots_and_on_in_proportion() {
        let c = Curve::new(vec![-2.0, 0.0, 1.0], vec![-6.0, 1.0, 2.0]).unwrap();
        // On the knots, half way between two, and beyond the first and the last.
        for (x, y) in
            [(-2.0, -6.0), (0.0, 1.0), (1.0, 2.0), (-1.0, -2.5), (0.5, 1.5), (-4.0, -12.0), (3.0, 6.0)]
        {
            assert_eq!(c.at(x), y, "{x}");
        }
        assert_eq!([c.factor(-4.0), c.factor(0.5), c.factor(3.0)], [3.0, 3.0, 2.0]);
        for (from, to, told) in [
            (vec![-1.0], vec![-1.0], "1 and 1 knots"),
            (vec![-1.0, 1.0], vec![1.0], "2 and 1 knots"),
            (vec![-1.0, f32::NAN], vec![0.0, 1.0], "not numbers"),
            (vec![0.0, 0.5], vec![0.0, 1.0], "not be 0"),
            (vec![-1.0, -1.0, 1.0], vec![0.0, 0.0, 1.0], "must increase"),
            (vec![-1.0, 1.0], vec![1.0, 0.0], "decreasing"),
        ] {
            let error = Curve::new(from, to).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
    }
}
