//! Sampling a raster at the nodes of a world.

use std::borrow::Cow;

use vb_terrain::ElevationImage;

/// A raster laid out in metres: its middle is the origin, x east, y north; a sample stands for the square about it.
#[derive(Clone, Debug)]
pub(crate) struct Layout<'a> {
    raster: Cow<'a, ElevationImage>,
    resolution: f64,
    /// The north-western sample.
    first: [f64; 2],
}

impl<'a> Layout<'a> {
    /// A raster of `resolution` metres, averaged over squares of several samples where they lie closer than every other
    /// node of a grid of `wanted` metres: else what is between the nodes would become noise of the nodes.
    pub(crate) fn new(raster: &'a ElevationImage, resolution: f64, wanted: f64) -> Self {
        let half = |n: usize| 0.5 * (n - 1) as f64 * resolution;
        let first = [-half(raster.cols()), half(raster.rows())];
        let n = (wanted / resolution * (1.0 + 1e-9)) as usize;
        if n < 2 {
            return Self { raster: Cow::Borrowed(raster), resolution, first };
        }
        let shift = 0.5 * (n - 1) as f64 * resolution;
        Self {
            raster: Cow::Owned(raster.reduced(n)),
            resolution: resolution * n as f64,
            first: [first[0] + shift, first[1] - shift],
        }
    }

    /// Row from the north and column from the west of a position, in samples.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(self.first[1] - y) / self.resolution, (x - self.first[0]) / self.resolution]
    }

    /// Height at a position by the four samples about it; beyond the outermost ones they go on level. NaN beside a
    /// hole.
    pub(crate) fn height(&self, at: [f64; 2]) -> f64 {
        let [row, col] = self.place(at);
        self.raster.between(row, col)
    }

    /// The sample whose square a position is in, or the nearest one.
    pub(crate) fn nearest(&self, at: [f64; 2]) -> f64 {
        let [row, col] = self.place(at);
        let index = |v: f64, n: usize| ((v + 0.5).max(0.0) as usize).min(n - 1);
        self.raster.at(index(row, self.raster.rows()), index(col, self.raster.cols()))
    }
}

/// Extents of a raster along x and y, m.
pub(crate) fn extents(raster: &ElevationImage, resolution: f64) -> [f64; 2] {
    [raster.cols() as f64 * resolution, raster.rows() as f64 * resolution]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z = 2x − 3y + 7 on samples of 0.5 m.
    fn plane(rows: usize, cols: usize) -> ElevationImage {
        let x = |c: usize| 0.5 * (c as f64 - 0.5 * (cols - 1) as f64);
        let y = |r: usize| 0.5 * (0.5 * (rows - 1) as f64 - r as f64);
        ElevationImage::new(
            rows,
            cols,
            (0..rows * cols).map(|i| 2.0 * x(i % cols) - 3.0 * y(i / cols) + 7.0).collect(),
        )
    }

    #[test]
    fn a_plane_is_sampled_as_it_is_at_any_resolution() {
        for wanted in [0.2, 0.5, 1.0, 1.7] {
            let plane = plane(40, 60);
            let layout = Layout::new(&plane, 0.5, wanted);
            for at in [[0.0, 0.0], [3.3, -2.1], [-11.0, 7.9]] {
                let z = 2.0 * at[0] - 3.0 * at[1] + 7.0;
                assert!((layout.height(at) - z).abs() < 1e-9, "{wanted}: {} {z}", layout.height(at));
            }
        }
    }

    #[test]
    fn a_hole_is_felt_beside_it_only() {
        let mut values = vec![1.0; 25];
        values[12] = f64::NAN;
        let raster = ElevationImage::new(5, 5, values);
        let layout = Layout::new(&raster, 1.0, 1.0);
        assert!(layout.height([0.0, 0.0]).is_nan() && layout.height([0.4, -0.9]).is_nan());
        assert_eq!((layout.height([1.0, 0.0]), layout.height([2.0, 2.0])), (1.0, 1.0));
    }

    #[test]
    fn a_label_holds_for_the_square_about_its_sample() {
        let raster = ElevationImage::new(2, 2, vec![1.0, 2.0, 3.0, 4.0]);
        let layout = Layout::new(&raster, 10.0, 1.0);
        assert_eq!(
            [[-0.1, 0.1], [0.1, 0.1], [-0.1, -0.1], [9.0, -9.0]].map(|p| layout.nearest(p)),
            [1.0, 2.0, 3.0, 4.0]
        );
    }
}
