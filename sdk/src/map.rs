//! Map lookup. Positions are in the world frame: x east, y north, in m.

use crate::GridFrame;

/// Samples on a square grid, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: crate::bytes::Sample")
)]
pub struct Map<T> {
    /// The positions of the samples.
    pub frame: GridFrame,
    /// The `rows * cols` samples, row-major, with row 0 in the south.
    #[cfg_attr(feature = "serde", serde(with = "crate::bytes"))]
    pub data: Vec<T>,
}

/// The terrain at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// The height above the world frame's origin, m.
    pub z: f64,
    /// The slope towards the east, ∂z/∂x, m/m.
    pub dzdx: f64,
    /// The slope towards the north, ∂z/∂y, m/m.
    pub dzdy: f64,
}

impl GridFrame {
    /// The position (x, y) of the sample (row, col), m.
    #[must_use]
    pub fn position(&self, row: u32, col: u32) -> (f64, f64) {
        (self.origin_x + f64::from(col) * self.resolution, self.origin_y + f64::from(row) * self.resolution)
    }

    /// The position of (x, y) as a fractional (row, col), which may lie outside the map.
    #[must_use]
    pub fn fractional(&self, x: f64, y: f64) -> (f64, f64) {
        ((y - self.origin_y) / self.resolution, (x - self.origin_x) / self.resolution)
    }

    /// Whether (x, y) is within the rectangle of the outermost samples, including its border.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let (r, c) = self.fractional(x, y);
        r >= 0.0 && c >= 0.0 && r <= f64::from(self.rows) - 1.0 && c <= f64::from(self.cols) - 1.0
    }

    /// Whether (x, y) is within one of the squares of side `resolution` around the samples.
    #[must_use]
    pub fn covers(&self, x: f64, y: f64) -> bool {
        let (r, c) = self.fractional(x, y);
        r >= -0.5 && c >= -0.5 && r < f64::from(self.rows) - 0.5 && c < f64::from(self.cols) - 0.5
    }
}

impl<T: Copy> Map<T> {
    /// The value of the sample (row, col).
    ///
    /// # Panics
    /// Panics if the sample does not exist.
    #[must_use]
    pub fn at(&self, row: u32, col: u32) -> T {
        assert!(row < self.frame.rows && col < self.frame.cols, "no sample ({row}, {col})");
        self.data[row as usize * self.frame.cols as usize + col as usize]
    }

    /// The value of the sample nearest to (x, y); outside the map, the nearest sample at the edge.
    ///
    /// # Panics
    /// Panics if the map is empty.
    #[must_use]
    pub fn nearest(&self, x: f64, y: f64) -> T {
        let (r, c) = self.frame.fractional(x, y);
        // The cast saturates: values below 0 and NaN become 0.
        let index = |v: f64, n: u32| ((v + 0.5).max(0.0) as u32).min(n.saturating_sub(1));
        self.at(index(r, self.frame.rows), index(c, self.frame.cols))
    }
}

impl Map<f32> {
    /// The cell that contains (x, y), the position within it, and its corner heights in the order south-west,
    /// south-east, north-west, north-east. Outside the map, the nearest edge cell.
    fn cell(&self, x: f64, y: f64) -> (f64, f64, [f64; 4]) {
        let frame = &self.frame;
        assert!(frame.rows >= 2 && frame.cols >= 2, "a surface takes at least 2 x 2 samples");
        let (r, c) = frame.fractional(x, y);
        let row = (r.max(0.0) as u32).min(frame.rows - 2);
        let col = (c.max(0.0) as u32).min(frame.cols - 2);
        let z = |i, j| f64::from(self.at(row + i, col + j));
        (c - f64::from(col), r - f64::from(row), [z(0, 0), z(0, 1), z(1, 0), z(1, 1)])
    }

    /// The height and the slope of the terrain at (x, y), as in the simulator: each cell consists of two triangles
    /// along the diagonal from its south-west to its north-east corner. Outside the map, the planes of the edge cells
    /// are extended; [`GridFrame::contains`] reports whether (x, y) is on the map.
    ///
    /// # Panics
    /// Panics if there are fewer than 2 × 2 samples.
    #[must_use]
    pub fn ground(&self, x: f64, y: f64) -> Ground {
        let (u, v, [sw, se, nw, ne]) = self.cell(x, y);
        let (gu, gv) = if v >= u { (ne - nw, nw - sw) } else { (se - sw, ne - se) };
        let resolution = self.frame.resolution;
        Ground { z: sw + gu * u + gv * v, dzdx: gu / resolution, dzdy: gv / resolution }
    }

    /// The height at (x, y) by bilinear interpolation, m: smoother than the terrain of the simulator, and equal to it
    /// at the samples. Outside the map, the height at the nearest point of the edge.
    ///
    /// # Panics
    /// Panics if there are fewer than 2 × 2 samples.
    #[must_use]
    pub fn bilinear(&self, x: f64, y: f64) -> f64 {
        let (u, v, [sw, se, nw, ne]) = self.cell(x, y);
        let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        (sw * (1.0 - u) + se * u) * (1.0 - v) + (nw * (1.0 - u) + ne * u) * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples (row, col) at x = 10 + 2·col, y = −4 + 2·row.
    fn map<T>(rows: u32, cols: u32, data: Vec<T>) -> Map<T> {
        Map { frame: GridFrame { rows, cols, resolution: 2.0, origin_x: 10.0, origin_y: -4.0 }, data }
    }

    #[test]
    fn a_plane_is_reproduced_everywhere() {
        // z = 1 + 0.5 (x − 10) − 0.25 (y + 4), exact in f32.
        let data = (0..12).map(|i| 1.0 + (i % 4) as f32 - 0.5 * (i / 4) as f32).collect();
        let m = map(3, 4, data);
        for (x, y) in [(10.0, -4.0), (12.3, -1.7), (15.9, -0.1), (16.0, 0.0), (9.0, -5.0), (17.0, 3.0)] {
            let g = m.ground(x, y);
            assert!((g.z - (1.0 + 0.5 * (x - 10.0) - 0.25 * (y + 4.0))).abs() < 1e-12, "{x} {y}: {g:?}");
            assert_eq!((g.dzdx, g.dzdy), (0.5, -0.25));
            if m.frame.contains(x, y) {
                assert!((m.bilinear(x, y) - g.z).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_cell_is_cut_from_south_west_to_north_east() {
        // Only the south-east corner is raised: the north-western triangle stays level, the other slopes.
        let m = map(2, 2, vec![0.0, 1.0, 0.0, 0.0]);
        assert_eq!(m.ground(10.5, -3.0), Ground { z: 0.0, dzdx: 0.0, dzdy: 0.0 });
        // Below the diagonal z = u − v with u = 0.75, v = 0.25.
        assert_eq!(m.ground(11.5, -3.5), Ground { z: 0.5, dzdx: 0.5, dzdy: -0.5 });
        // Bilinear: u (1 − v).
        assert_eq!(m.bilinear(11.5, -3.5), 0.75 * 0.75);
    }

    #[test]
    fn nearest_takes_the_closest_sample_and_the_edge_beyond_it() {
        let m = map(2, 3, vec![0u8, 1, 2, 3, 4, 5]);
        assert_eq!(m.nearest(10.9, -4.9), 0);
        assert_eq!(m.nearest(11.1, -3.1), 1);
        assert_eq!(m.nearest(13.0, -2.9), 5);
        assert_eq!(m.nearest(-100.0, 100.0), 3);
        assert_eq!(m.nearest(f64::NAN, f64::NAN), 0);
    }

    #[test]
    fn contains_ends_at_the_samples_and_covers_half_a_cell_further() {
        let f = map(2, 3, vec![0u8; 6]).frame;
        assert!(f.contains(10.0, -4.0) && f.contains(14.0, -2.0) && !f.contains(14.1, -2.0));
        assert!(f.covers(14.9, -1.1) && !f.covers(15.1, -2.0) && f.covers(9.0, -5.0) && !f.covers(8.9, -5.0));
        assert_eq!(f.position(1, 2), (14.0, -2.0));
    }
}
