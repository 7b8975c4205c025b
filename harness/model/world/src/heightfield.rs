//! The ground surface: heights on a square grid, triangulated.

use std::ops::RangeInclusive;

/// Heights on a regular grid, which is centred on the world's origin.
///
/// Node (row, col) lies at x = (col − (cols−1)/2)·resolution, y = (row − (rows−1)/2)·resolution. Each cell is cut along the
/// diagonal from its south-west to its north-east corner, as Chrono's height-map patches are: with u, v in [0, 1]
/// measured from the south-west corner, the north-western triangle is v ≥ u.
#[derive(Clone, Debug, PartialEq)]
pub struct Heightfield {
    rows: usize,
    cols: usize,
    resolution: f64,
    /// Kept for the step loop, which asks for a hundred heights a step: 1 / resolution, and half the extents.
    inverse_resolution: f64,
    half: [f64; 2],
    heights: Vec<f64>,
    /// The heights (m) that the 16-bit levels 0 and 65 535 stand for, where the heights came from levels.
    level_range: Option<[f64; 2]>,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The height above the world's origin, m.
    pub z: f64,
    /// The slope ∂z/∂x (towards the east) of the triangle, m/m.
    pub dzdx: f64,
    /// The slope ∂z/∂y (towards the north) of the triangle, m/m.
    pub dzdy: f64,
}

/// One triangle of the surface, for many questions about points that are near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The south-western corner of its cell, m.
    pub corner: [f64; 2],
    /// The height there, m.
    pub z: f64,
    /// The side of the cell, m.
    pub resolution: f64,
    /// Whether it is the cell's north-western half.
    pub upper: bool,
    /// The slopes ∂z/∂x and ∂z/∂y, m/m.
    pub gradient: [f64; 2],
}

/// The surface for a caller that asks for heights near each other: it keeps the last cell, in which the next point
/// mostly lies. Its heights are those of [`Heightfield::height`], bit for bit.
#[derive(Clone, Debug)]
pub struct Nearby<'a> {
    field: &'a Heightfield,
    /// South-western corner of the cell, in resolutions from that of the grid, and its opposite; nothing lies between them
    /// at first.
    low: [f64; 2],
    high: [f64; 2],
    /// Heights of its corners: south-west, south-east, north-west, north-east.
    corners: [f64; 4],
}

impl<'a> Nearby<'a> {
    /// The surface with no cell kept yet.
    #[inline]
    #[must_use]
    pub fn new(field: &'a Heightfield) -> Self {
        Self { field, low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2], corners: [0.0; 4] }
    }

    /// The height at (x, y), m.
    #[inline]
    #[must_use]
    pub fn height(&mut self, x: f64, y: f64) -> f64 {
        let f = self.field;
        let (fx, fy) = ((x + f.half[0]) * f.inverse_resolution, (y + f.half[1]) * f.inverse_resolution);
        let known = (fx >= self.low[0]) & (fx < self.high[0]) & (fy >= self.low[1]) & (fy < self.high[1]);
        if !known {
            self.look(fx, fy);
        }
        let (u, v) = (fx - self.low[0], fy - self.low[1]);
        let [z00, z10, z01, z11] = self.corners;
        let rise = if v >= u { [z11 - z01, z01 - z00] } else { [z10 - z00, z11 - z10] };
        z00 + rise[0] * u + rise[1] * v
    }

    fn look(&mut self, fx: f64, fy: f64) {
        let f = self.field;
        let (col, row) = f.indices(fx, fy);
        self.low = [col as f64, row as f64];
        self.high = self.low.map(|k| k + 1.0);
        self.corners = f.corners(col, row);
    }
}

/// Where a point lies in the grid.
struct Cell {
    col: usize,
    row: usize,
    /// From the south-western corner, in resolutions; beyond [0, 1] outside the grid.
    within: [f64; 2],
    /// Whether it is on the north-western triangle.
    upper: bool,
    /// Height of the south-western corner.
    z: f64,
    /// Rise of the triangle over a resolution along x and y.
    rise: [f64; 2],
}

impl Facet {
    /// The height at (x, y), m; `None` if the point doesn't lie on this triangle.
    #[inline]
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let (u, v) = (x - self.corner[0], y - self.corner[1]);
        let inside = (u >= 0.0)
            & (v >= 0.0)
            & (u < self.resolution)
            & (v < self.resolution)
            & ((v >= u) == self.upper);
        inside.then_some(self.z + self.gradient[0] * u + self.gradient[1] * v)
    }
}

impl Heightfield {
    /// A surface from row-major heights (m) at a distance of `resolution` (m), with row 0 in the south and column 0 in
    /// the west.
    ///
    /// # Panics
    /// Panics if there are fewer than 2 × 2 nodes, `heights` has another length than `rows * cols`, or `resolution` is
    /// not positive. Data from outside is validated before it comes here.
    #[must_use]
    pub fn new(rows: usize, cols: usize, resolution: f64, heights: Vec<f64>) -> Self {
        assert!(rows >= 2 && cols >= 2 && heights.len() == rows * cols && resolution > 0.0);
        let half = [cols, rows].map(|n| 0.5 * (n - 1) as f64 * resolution);
        Self {
            rows,
            cols,
            resolution,
            inverse_resolution: 1.0 / resolution,
            half,
            heights,
            level_range: None,
        }
    }

    /// A surface from 16-bit levels as they are stored: level v stands for `low + (high − low)·(v / 65535)` with
    /// `[low, high] = range` in metres. The levels are row-major, with row 0 in the south. An 8-bit grey g, stored as
    /// 257·g, gives exactly g / 255 of the range, since 257·g / 65535 and g / 255 are the same fraction.
    ///
    /// # Panics
    /// Panics as [`Heightfield::new`] does.
    #[must_use]
    pub fn from_levels(rows: usize, cols: usize, resolution: f64, range: [f64; 2], levels: &[u16]) -> Self {
        let [low, high] = range;
        let heights = levels.iter().map(|&v| low + (high - low) * (f64::from(v) / 65535.0)).collect();
        Self { level_range: Some(range), ..Self::new(rows, cols, resolution, heights) }
    }

    /// The range \[low, high\] (m) and the nearest levels that stand for these heights. They are exact for a surface
    /// from [`Heightfield::from_levels`]; those of any other surface are rounded to 1/65535 of its own relief.
    #[must_use]
    pub fn to_levels(&self) -> ([f64; 2], Vec<u16>) {
        let range = self.level_range.unwrap_or_else(|| {
            let (low, high) = self.range();
            [low, high]
        });
        let [low, high] = range;
        let level = |z: f64| if high > low { ((z - low) / (high - low) * 65535.0).round() as u16 } else { 0 };
        (range, self.heights.iter().map(|&z| level(z)).collect())
    }

    /// A level surface at the height `z` (m).
    #[must_use]
    pub fn flat(rows: usize, cols: usize, resolution: f64, z: f64) -> Self {
        Self::new(rows, cols, resolution, vec![z; rows * cols])
    }

    /// The number of node rows, from south to north.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of node columns, from west to east.
    #[must_use]
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// The distance between nodes, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// The heights of all nodes, row-major, m.
    #[must_use]
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// The height of a node, m.
    #[inline]
    #[must_use]
    pub fn node(&self, row: usize, col: usize) -> f64 {
        self.heights[row * self.cols + col]
    }

    /// Half the extent along x, m.
    #[must_use]
    pub fn half_x(&self) -> f64 {
        self.half[0]
    }

    /// Half the extent along y, m.
    #[must_use]
    pub fn half_y(&self) -> f64 {
        self.half[1]
    }

    /// Tells whether (x, y) lies on the surface.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        x.abs() <= self.half_x() && y.abs() <= self.half_y()
    }

    /// The heights of the lowest and the highest node, m.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        self.heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &z| (lo.min(z), hi.max(z)))
    }

    /// The height and the gradient at (x, y). Beyond the edge, the planes of the edge cells are continued.
    #[inline]
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> SurfacePoint {
        let inv = self.inverse_resolution;
        let c = self.cell(x, y);
        SurfacePoint {
            z: c.z + c.rise[0] * c.within[0] + c.rise[1] * c.within[1],
            dzdx: c.rise[0] * inv,
            dzdy: c.rise[1] * inv,
        }
    }

    /// The cell at (x, y), the nearest one beyond the edge, and its triangle there.
    #[inline(always)]
    fn cell(&self, x: f64, y: f64) -> Cell {
        let inv = self.inverse_resolution;
        let fx = (x + self.half[0]) * inv;
        let fy = (y + self.half[1]) * inv;
        let (col, row) = self.indices(fx, fy);
        let (u, v) = (fx - col as f64, fy - row as f64);
        let [z00, z10, z01, z11] = self.corners(col, row);
        let upper = v >= u;
        let rise = if upper { [z11 - z01, z01 - z00] } else { [z10 - z00, z11 - z10] };
        Cell { col, row, within: [u, v], upper, z: z00, rise }
    }

    /// Column and row of the cell at a place in resolutions from the south-western corner; the nearest beyond the edge.
    #[inline]
    fn indices(&self, fx: f64, fy: f64) -> (usize, usize) {
        // By way of u32, which a conversion reaches with fewer instructions.
        let col = (fx.max(0.0) as u32 as usize).min(self.cols - 2);
        let row = (fy.max(0.0) as u32 as usize).min(self.rows - 2);
        (col, row)
    }

    /// Heights of a cell's corners: south-west, south-east, north-west, north-east.
    #[inline]
    fn corners(&self, col: usize, row: usize) -> [f64; 4] {
        let i = row * self.cols + col;
        let (south, north) = (&self.heights[i..i + 2], &self.heights[i + self.cols..i + self.cols + 2]);
        [south[0], south[1], north[0], north[1]]
    }

    /// The triangle at (x, y); beyond the edge, that of the edge cell.
    #[inline]
    #[must_use]
    pub fn facet(&self, x: f64, y: f64) -> Facet {
        self.facet_and_height(x, y).0
    }

    /// The triangle at (x, y) as [`Self::facet`] tells it, and the height there as [`Self::height`] does, m.
    #[inline(always)]
    #[must_use]
    pub fn facet_and_height(&self, x: f64, y: f64) -> (Facet, f64) {
        let c = self.cell(x, y);
        let facet = Facet {
            corner: [
                c.col as f64 * self.resolution - self.half[0],
                c.row as f64 * self.resolution - self.half[1],
            ],
            resolution: self.resolution,
            upper: c.upper,
            z: c.z,
            gradient: [c.rise[0] * self.inverse_resolution, c.rise[1] * self.inverse_resolution],
        };
        (facet, c.z + c.rise[0] * c.within[0] + c.rise[1] * c.within[1])
    }

    /// The height at (x, y), m. Beyond the edge, the planes of the edge cells are continued.
    #[inline]
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        self.at(x, y).z
    }

    /// The greatest height within the square of half side `reach` (m) about (x, y), or an upper bound of it, m; `None`
    /// where it would take more than a few nodes to tell.
    #[inline]
    #[must_use]
    pub fn ceiling(&self, x: f64, y: f64, reach: f64) -> Option<f64> {
        const FEW: usize = 3;
        let [rows, cols] = self.nodes_about(x, y, reach)?;
        let are_few = |nodes: &RangeInclusive<usize>| nodes.end() - nodes.start() <= FEW;
        (are_few(&rows) && are_few(&cols)).then(|| self.highest_of(rows, cols))
    }

    /// The greatest height within the square of half side `reach` (m) about (x, y), or an upper bound of it, m: infinite where
    /// the square goes over the edge, beyond which the planes of the edge's cells go on.
    #[must_use]
    pub fn highest(&self, x: f64, y: f64, reach: f64) -> f64 {
        self.nodes_about(x, y, reach).map_or(f64::INFINITY, |[rows, cols]| self.highest_of(rows, cols))
    }

    /// The rows and the columns of the nodes that bound the square of half side `reach` (m) about (x, y); `None` where it goes over
    /// the edge.
    #[inline]
    fn nodes_about(&self, x: f64, y: f64, reach: f64) -> Option<[RangeInclusive<usize>; 2]> {
        if x.abs() + reach > self.half[0] || y.abs() + reach > self.half[1] {
            return None;
        }
        let index = |v: f64| (v * self.inverse_resolution).max(0.0) as u32 as usize;
        let nodes = |v: f64, half: f64, n: usize| {
            index(v - reach + half).min(n - 1)..=(index(v + reach + half) + 1).min(n - 1)
        };
        Some([nodes(y, self.half[1], self.rows), nodes(x, self.half[0], self.cols)])
    }

    #[inline]
    fn highest_of(&self, rows: RangeInclusive<usize>, cols: RangeInclusive<usize>) -> f64 {
        let mut top = f64::NEG_INFINITY;
        for row in rows {
            let start = row * self.cols;
            for z in &self.heights[start + cols.start()..=start + cols.end()] {
                // One instruction, unlike `max`, which minds what isn't a number.
                top = if *z > top { *z } else { top };
            }
        }
        top
    }

    /// Bounds of |∂z/∂x| and |∂z/∂y| on all triangles that reach into the square of half side `reach` (m) about (x, y).
    /// The true values exceed neither of them by as much as the rounding of the heights. It is `None` where the square
    /// goes over the edge.
    #[must_use]
    pub fn steepest(&self, x: f64, y: f64, reach: f64) -> Option<[f64; 2]> {
        let inside = x.abs() + reach <= self.half[0] && y.abs() + reach <= self.half[1];
        if !inside {
            return None;
        }
        // A node more on each side, so that no rounding leaves a cell out.
        let range = |v: f64, half: f64, n: usize| {
            let first = ((v - reach + half) * self.inverse_resolution) as usize;
            let last = ((v + reach + half) * self.inverse_resolution) as usize;
            (first.saturating_sub(1), (last + 2).min(n - 1))
        };
        let (c0, c1) = range(x, self.half[0], self.cols);
        let (r0, r1) = range(y, self.half[1], self.rows);
        let mut most = [0.0_f64; 2];
        for row in r0..=r1 {
            for col in c0..=c1 {
                let z = self.node(row, col);
                // A triangle's gradient is the rise along its two sides that follow the grid.
                if col < c1 {
                    most[0] = most[0].max((self.node(row, col + 1) - z).abs());
                }
                if row < r1 {
                    most[1] = most[1].max((self.node(row + 1, col) - z).abs());
                }
            }
        }
        Some(most.map(|rise| rise * self.inverse_resolution))
    }

    /// The same surface with every length multiplied by `s`.
    #[must_use]
    pub fn scaled(&self, s: f64) -> Self {
        let heights = self.heights.iter().map(|z| z * s).collect();
        let level_range = self.level_range.map(|r| r.map(|z| z * s));
        Self { level_range, ..Self::new(self.rows, self.cols, self.resolution * s, heights) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One cell of 2 m with corner heights 0 (SW), 1 (SE), 2 (NW), 7 (NE).
    fn cell() -> Heightfield {
        Heightfield::new(2, 2, 2.0, vec![0.0, 1.0, 2.0, 7.0])
    }

    #[test]
    fn cells_are_cut_from_the_south_west_to_the_north_east() {
        // By hand, with the diagonal of Chrono's `RigidTerrain::AddPatch`: north-western triangle z = 0 + (7 - 2) u + 2
        // v, south-eastern z = 1 u + (7 - 1) v.
        let at = |u: f64, v: f64| cell().at(2.0 * u - 1.0, 2.0 * v - 1.0);
        assert!((at(0.25, 0.75).z - (1.25 + 1.5)).abs() < 1e-15);
        assert!((at(0.75, 0.25).z - (0.75 + 1.5)).abs() < 1e-15);
        assert_eq!((at(0.25, 0.75).dzdx, at(0.25, 0.75).dzdy), (2.5, 1.0));
        assert_eq!((at(0.75, 0.25).dzdx, at(0.75, 0.25).dzdy), (0.5, 3.0));
        assert_eq!((at(0.0, 0.0).z, at(1.0, 0.0).z, at(0.0, 1.0).z, at(1.0, 1.0).z), (0.0, 1.0, 2.0, 7.0));
        // Beyond the edge the plane goes on.
        assert!((at(0.75, -0.25).z - (0.75 - 1.5)).abs() < 1e-15);
    }

    #[test]
    fn no_point_lies_above_the_ceiling_and_the_ceiling_is_not_far_above_the_highest() {
        let heights = (0..81).map(|i| f64::from((i * 7919 % 101) as u8) * 0.02).collect();
        let h = Heightfield::new(9, 9, 1.0, heights);
        for (x, y, reach) in [(0.2, -1.3, 0.4), (-2.5, 2.5, 0.9), (1.0, 1.0, 0.0)] {
            let top = h.ceiling(x, y, reach).unwrap();
            for i in 0..=20 {
                for j in 0..=20 {
                    let at = |v: f64, k: i32| v + reach * (0.1 * f64::from(k) - 1.0);
                    assert!(h.height(at(x, i), at(y, j)) <= top);
                }
            }
        }
        assert_eq!(h.ceiling(0.0, 0.0, 3.0), None, "too many nodes");
        assert_eq!(h.ceiling(4.0, 0.0, 0.5), None, "over the edge");
        assert_eq!(Heightfield::flat(9, 9, 1.0, 0.7).ceiling(0.3, 0.1, 0.5), Some(0.7));
        assert_eq!(h.highest(0.3, 0.1, 0.5), h.ceiling(0.3, 0.1, 0.5).unwrap());
        assert_eq!(h.highest(0.0, 0.0, 4.0), h.range().1, "the square is the whole field");
        assert_eq!(h.highest(4.0, 0.0, 0.5), f64::INFINITY, "over the edge");
    }

    #[test]
    fn whoever_asks_nearby_gets_the_same_bits() {
        let heights = (0..81).map(|i| f64::from((i * 7919 % 101) as u8) * 0.02).collect();
        let h = Heightfield::new(9, 9, 0.3, heights);
        let mut nearby = Nearby::new(&h);
        // In small steps, from beyond one edge to beyond the other, and along cells' edges.
        for j in 0..60 {
            let y = f64::from(j) * 0.05 - 1.5;
            for i in 0..300 {
                let x = f64::from(i) * 0.01 - 1.5;
                assert_eq!(nearby.height(x, y).to_bits(), h.height(x, y).to_bits(), "{x} {y}");
            }
        }
        assert!(nearby.height(f64::NAN, 0.0).is_nan());
    }

    #[test]
    fn no_slope_is_above_the_steepest_nearby_and_the_steepest_is_found() {
        let heights = (0..81).map(|i| f64::from((i * 7919 % 101) as u8) * 0.02).collect();
        let h = Heightfield::new(9, 9, 0.5, heights);
        for (x, y, reach) in [(0.2, -0.3, 0.4), (-1.0, 0.9, 0.05), (0.5, 0.5, 1.0)] {
            let [sx, sy] = h.steepest(x, y, reach).unwrap();
            for i in 0..=40 {
                for j in 0..=40 {
                    let at = |v: f64, k: i32| v + reach * (0.05 * f64::from(k) - 1.0);
                    let p = h.at(at(x, i), at(y, j));
                    assert!(p.dzdx.abs() <= sx && p.dzdy.abs() <= sy, "{p:?} {sx} {sy}");
                }
            }
        }
        assert_eq!(h.steepest(1.8, 0.0, 0.5), None, "over the edge");
        let ramp = Heightfield::new(9, 9, 0.5, (0..81).map(|i| 0.1 * f64::from(i % 9)).collect());
        let [sx, sy] = ramp.steepest(0.3, 0.1, 0.5).unwrap();
        assert!((sx - 0.2).abs() < 1e-12 && sy == 0.0, "{sx} {sy}");
    }

    #[test]
    fn a_facet_has_the_height_and_gradient_of_the_surface_on_itself_and_none_elsewhere() {
        let heights = (0..81).map(|i| f64::from((i * 7919 % 101) as u8) * 0.02).collect();
        let h = Heightfield::new(9, 9, 0.5, heights);
        let f = h.facet(0.1, 0.3);
        assert_eq!(f.gradient, [h.at(0.1, 0.3).dzdx, h.at(0.1, 0.3).dzdy]);
        for (x, y, on) in [(0.1, 0.3, true), (0.2, 0.45, true), (0.3, 0.1, false), (-0.1, 0.3, false)] {
            match f.height(x, y) {
                Some(z) => assert!(on && (z - h.height(x, y)).abs() < 1e-12),
                None => assert!(!on, "{x} {y}"),
            }
        }
    }

    #[test]
    fn levels_of_eight_bits_stand_for_exact_shares() {
        let levels: Vec<u16> = (0..256).map(|g| 257 * g).collect();
        let h = Heightfield::from_levels(16, 16, 1.0, [0.0, 4.8], &levels);
        for g in 0..256 {
            assert_eq!(h.heights()[g], 4.8 * (g as f64 / 255.0));
        }
        assert_eq!(h.to_levels(), ([0.0, 4.8], levels));
        assert_eq!(Heightfield::flat(2, 2, 1.0, 3.0).to_levels(), ([3.0, 3.0], vec![0; 4]));
    }
}
