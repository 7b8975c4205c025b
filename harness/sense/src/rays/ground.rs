//! Rays against the triangles of a heightfield.
//!
//! Above the cells lies a pyramid of greatest heights: a square of level k covers 2^k × 2^k cells. A ray from above goes
//! through the squares of its way and looks at the finer ones only where it comes below the highest of the coarser (Tevs,
//! Ihrke and Seidel, "Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering", Symposium on
//! Interactive 3D Graphics and Games 2008). Within a cell the height under the ray is linear up to the diagonal and after
//! it, so its crossing is found in closed form. A ray that starts below the ground goes through all cells on its way.

use crate::V3;
use vb_world::Heightfield;

/// The pyramid of greatest heights above a heightfield's cells.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    levels: Vec<Level>,
    /// Heights of the lowest and the highest node, m.
    range: (f64, f64),
}

#[derive(Clone, Debug)]
struct Level {
    cols: usize,
    /// Greatest height in each square, rounded up, m.
    most: Vec<f32>,
}

/// The least number of single precision that isn't below a number.
fn up(z: f64) -> f32 {
    let near = z as f32;
    if f64::from(near) < z { near.next_up() } else { near }
}

impl Ground {
    pub(crate) fn new(field: &Heightfield) -> Self {
        let (mut rows, mut cols) = (field.rows() - 1, field.cols() - 1);
        let mut most = Vec::with_capacity(rows * cols);
        for row in 0..rows {
            for col in 0..cols {
                let south = field.node(row, col).max(field.node(row, col + 1));
                let north = field.node(row + 1, col).max(field.node(row + 1, col + 1));
                most.push(up(south.max(north)));
            }
        }
        let mut levels = vec![Level { cols, most }];
        while rows > 1 || cols > 1 {
            let finer = &levels[levels.len() - 1];
            let (fine_rows, fine_cols) = (rows, cols);
            (rows, cols) = (rows.div_ceil(2), cols.div_ceil(2));
            let mut most = Vec::with_capacity(rows * cols);
            for row in 0..rows {
                for col in 0..cols {
                    let mut top = f32::NEG_INFINITY;
                    for r in 2 * row..(2 * row + 2).min(fine_rows) {
                        for c in 2 * col..(2 * col + 2).min(fine_cols) {
                            top = top.max(finer.most[r * fine_cols + c]);
                        }
                    }
                    most.push(top);
                }
            }
            levels.push(Level { cols, most });
        }
        Self { levels, range: field.range() }
    }

    /// The distance at which a ray meets the surface, m; none if it doesn't within `reach`.
    pub(crate) fn cast(&self, field: &Heightfield, origin: &V3, direction: &V3, reach: f64) -> Option<f64> {
        let mut walk = Walk::new(field, origin, direction, reach)?;
        // The part of the way that is outside the heights that there are.
        let (low, high) = self.range;
        if origin.z > high && direction.z >= 0.0 {
            return None;
        }
        let start = walk.gap_at(walk.from);
        if start == 0.0 {
            return Some(walk.from);
        }
        if start < 0.0 {
            return walk.through_all_cells(start);
        }
        if direction.z > 0.0 {
            walk.to = walk.to.min((high - origin.z) / direction.z);
        } else if direction.z < 0.0 {
            // Rounding must not end the way before it comes to the lowest place.
            walk.to = walk.to.min((low - origin.z) / direction.z * (1.0 + 1e-9) + 1e-9);
            walk.skip_to((high - origin.z) / direction.z * (1.0 - 1e-9) - 1e-9);
        }
        walk.down_the_pyramid(&self.levels)
    }
}

/// A ray on its way through the cells. Places are measured in cells from the south-western corner, distances along the
/// ray in m.
struct Walk<'a> {
    heights: &'a [f64],
    /// Nodes in a row.
    stride: usize,
    /// The last column and row of cells.
    last: [i32; 2],
    /// The ray: origin and rate in cells, origin and rate of the height.
    origin: [f64; 2],
    rate: [f64; 2],
    inverse: [f64; 2],
    z: f64,
    dz: f64,
    from: f64,
    to: f64,
    /// The cell at `from`.
    cell: [i32; 2],
}

impl<'a> Walk<'a> {
    /// None if the ray doesn't come over the surface.
    #[inline]
    fn new(field: &'a Heightfield, origin: &V3, direction: &V3, reach: f64) -> Option<Self> {
        let per_metre = 1.0 / field.resolution();
        let half = [field.half_x(), field.half_y()];
        let start = [(origin.x + half[0]) * per_metre, (origin.y + half[1]) * per_metre];
        let rate = [direction.x * per_metre, direction.y * per_metre];
        let inverse = rate.map(|r| 1.0 / r);
        let count = [(field.cols() - 1) as f64, (field.rows() - 1) as f64];
        let (mut from, mut to) = (0.0_f64, reach);
        for k in 0..2 {
            if rate[k] == 0.0 {
                if start[k] < 0.0 || start[k] > count[k] {
                    return None;
                }
                continue;
            }
            let (a, b) = (-start[k] * inverse[k], (count[k] - start[k]) * inverse[k]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        let inside = from <= to;
        let mut walk = Self {
            heights: field.heights(),
            stride: field.cols(),
            last: [field.cols() as i32 - 2, field.rows() as i32 - 2],
            origin: start,
            rate,
            inverse,
            z: origin.z,
            dz: direction.z,
            from,
            to,
            cell: [0; 2],
        };
        walk.find_cell();
        inside.then_some(walk)
    }

    #[inline]
    fn find_cell(&mut self) {
        self.cell = [0, 1].map(|k| self.index(k, self.from));
    }

    /// Column (`k` = 0) or row of the cell at a distance.
    #[inline]
    fn index(&self, k: usize, t: f64) -> i32 {
        // A cast rounds towards zero, which is down from 0 on.
        ((self.origin[k] + self.rate[k] * t) as i32).clamp(0, self.last[k])
    }

    /// Leaves out the way up to a distance.
    #[inline]
    fn skip_to(&mut self, t: f64) {
        if t > self.from {
            self.from = t;
            self.find_cell();
        }
    }

    /// Height of the ray over the surface at a distance, m.
    fn gap_at(&self, t: f64) -> f64 {
        let cell = [0, 1].map(|k| self.index(k, t));
        Cell::at(self, cell).gap(self, t)
    }

    /// The distance at which the ray leaves a square of 2^level cells, and the axis across whose side it does.
    #[inline]
    fn exit(&self, level: u32) -> (f64, usize) {
        let side = |k: usize| {
            let square = self.cell[k] >> level;
            let bound = (square + i32::from(self.rate[k] > 0.0)) << level;
            (f64::from(bound) - self.origin[k]) * self.inverse[k]
        };
        // Along an axis that it doesn't move on, it never does: ±infinity, or not a number on the very side.
        let never = |k: usize, t: f64| if self.rate[k] == 0.0 { f64::INFINITY } else { t };
        let (x, y) = (never(0, side(0)), never(1, side(1)));
        if x <= y { (x, 0) } else { (y, 1) }
    }

    /// Moves on to the square beyond the side of `axis`, at the distance `t`; false beyond the last.
    #[inline]
    fn enter_next(&mut self, level: u32, t: f64, axis: usize) -> bool {
        let (square, other) = (self.cell[axis] >> level, 1 - axis);
        let forward = self.rate[axis] > 0.0;
        self.cell[axis] = if forward { (square + 1) << level } else { (square << level) - 1 };
        // Along the other axis it is still in the same square, whatever rounding says.
        let low = (self.cell[other] >> level) << level;
        let high = (low + (1 << level) - 1).min(self.last[other]);
        self.cell[other] = self.index(other, t).clamp(low, high);
        self.from = self.from.max(t);
        self.cell[axis] >= 0 && self.cell[axis] <= self.last[axis]
    }

    /// The first hit of a ray that starts above the surface.
    #[inline]
    fn down_the_pyramid(mut self, levels: &[Level]) -> Option<f64> {
        let top = levels.len() as u32 - 1;
        let mut level = top.min(2);
        while self.from <= self.to {
            let (exit, axis) = self.exit(level);
            let end = exit.min(self.to);
            let lowest = self.z + self.dz * if self.dz < 0.0 { end } else { self.from };
            let l = &levels[level as usize];
            let square = (self.cell[1] >> level) as usize * l.cols + (self.cell[0] >> level) as usize;
            if lowest <= f64::from(l.most[square]) {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                if let Some(t) = Cell::at(&self, self.cell).enter(&self, end, 1.0) {
                    return Some(t);
                }
            }
            if exit >= self.to {
                return None;
            }
            let before = self.cell[axis] >> (level + 1);
            if !self.enter_next(level, exit, axis) {
                return None;
            }
            if self.cell[axis] >> (level + 1) != before && level < top {
                level += 1;
            }
        }
        None
    }

    /// The first hit of a ray that starts below the surface, by `start` (m, negative).
    fn through_all_cells(mut self, start: f64) -> Option<f64> {
        while self.from <= self.to {
            let (exit, axis) = self.exit(0);
            let hit = Cell::at(&self, self.cell).enter(&self, exit.min(self.to), start.signum());
            if hit.is_some() || exit >= self.to || !self.enter_next(0, exit, axis) {
                return hit;
            }
        }
        None
    }
}

/// One cell: its place and the heights of its corners.
struct Cell {
    at: [f64; 2],
    /// South-west, south-east, north-west, north-east.
    corners: [f64; 4],
}

impl Cell {
    #[inline]
    fn at(walk: &Walk<'_>, [col, row]: [i32; 2]) -> Self {
        let i = row as usize * walk.stride + col as usize;
        let (south, north) = (&walk.heights[i..i + 2], &walk.heights[i + walk.stride..i + walk.stride + 2]);
        Self { at: [f64::from(col), f64::from(row)], corners: [south[0], south[1], north[0], north[1]] }
    }

    /// Height of the ray over the surface at a distance, m.
    #[inline]
    fn gap(&self, walk: &Walk<'_>, t: f64) -> f64 {
        let u = walk.origin[0] + walk.rate[0] * t - self.at[0];
        let v = walk.origin[1] + walk.rate[1] * t - self.at[1];
        let [sw, se, nw, ne] = self.corners;
        let rise = if v >= u { [ne - nw, nw - sw] } else { [se - sw, ne - se] };
        walk.z + walk.dz * t - (sw + rise[0] * u + rise[1] * v)
    }

    /// The distance at which the ray, which has been on the side `side` of the surface (1 above, -1 below), comes to the
    /// other one between `walk.from` and `to`. It counts as hit at the beginning if it is on the other side already, which
    /// happens by rounding alone.
    #[inline]
    fn enter(&self, walk: &Walk<'_>, to: f64, side: f64) -> Option<f64> {
        let from = walk.from;
        let mut last = (from, side * self.gap(walk, from));
        if last.1 <= 0.0 {
            return Some(from);
        }
        // Where the way crosses the diagonal of the cell, if it does.
        let apart = walk.rate[0] - walk.rate[1];
        let offset = (walk.origin[0] - self.at[0]) - (walk.origin[1] - self.at[1]);
        let diagonal = -offset / apart;
        let between = diagonal > from && diagonal < to;
        for t in [if between { diagonal } else { to }, to] {
            let gap = side * self.gap(walk, t);
            if gap <= 0.0 {
                return Some(last.0 + (t - last.0) * (last.1 / (last.1 - gap)));
            }
            last = (t, gap);
        }
        None
    }
}
