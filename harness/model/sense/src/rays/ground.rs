//! Rays against the triangles of a heightfield.
//!
//! Above the cells lie coarser grids with the greatest height in each square. A ray from above goes through the squares of
//! its way and looks at the finer ones only where it comes below the highest place of the coarser (Tevs, Ihrke and Seidel,
//! "Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering", Symposium on Interactive 3D Graphics
//! and Games 2008; here each grid is four times as coarse as the next, since few long steps are foreseen better by the
//! processor than many turns between levels). From square to square it goes as Amanatides and Woo ("A fast voxel
//! traversal algorithm for ray tracing", Eurographics 1987) do. Within a cell the height under the ray is linear up to the
//! diagonal and after it, so its crossing is found in closed form. A ray that starts below the ground looks at all cells on
//! its way.

use crate::V3;
use vb_world::Heightfield;

/// How many squares of a grid make one of the next along a side.
const STEP: usize = 4;
const GRIDS: usize = 3;
/// The least number of squares along a side of a grid that is worth a look: below it, most of its squares are higher than
/// the rays of a vehicle anyway.
const WORTH: i32 = 32;

/// The part of a direction along x or y below which a ray is taken to be parallel to the other axis: over a kilometre it
/// moves by a nanometre.
const PARALLEL: f64 = 1e-12;

/// The greatest heights above a heightfield's cells, the finest grid first.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    grids: [Grid; GRIDS],
    /// Whether rays start on the coarsest grid, and not on the next.
    large: bool,
    per_metre: f64,
    /// Heights of the lowest and the highest node, m.
    range: (f64, f64),
    /// Greatest slope of any triangle, m/m.
    steepest: f64,
}

#[derive(Clone, Debug)]
struct Grid {
    rows: i32,
    cols: i32,
    /// Greatest height in each square, rounded up, m.
    most: Vec<f32>,
}

/// The least number of single precision that isn't below a number.
fn up(z: f64) -> f32 {
    let near = z as f32;
    if f64::from(near) < z { near.next_up() } else { near }
}

impl Grid {
    fn finest(field: &Heightfield) -> Self {
        let (rows, cols) = (field.rows() - 1, field.cols() - 1);
        let mut most = Vec::with_capacity(rows * cols);
        for row in 0..rows {
            for col in 0..cols {
                let south = field.node(row, col).max(field.node(row, col + 1));
                let north = field.node(row + 1, col).max(field.node(row + 1, col + 1));
                most.push(up(south.max(north)));
            }
        }
        Self { rows: rows as i32, cols: cols as i32, most }
    }

    fn coarser(&self) -> Self {
        let (fine_rows, fine_cols) = (self.rows as usize, self.cols as usize);
        let (rows, cols) = (fine_rows.div_ceil(STEP), fine_cols.div_ceil(STEP));
        let mut most = vec![f32::NEG_INFINITY; rows * cols];
        for row in 0..fine_rows {
            for col in 0..fine_cols {
                let top = &mut most[row / STEP * cols + col / STEP];
                *top = top.max(self.most[row * fine_cols + col]);
            }
        }
        Self { rows: rows as i32, cols: cols as i32, most }
    }
}

/// Where rays begin, against a heightfield.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    /// In cells from the south-western corner.
    at: [f64; 2],
    /// m.
    z: f64,
    /// Height over the surface, m; none beyond its edge.
    gap: Option<f64>,
}

impl Origin {
    pub(crate) fn new(field: &Heightfield, p: &V3) -> Self {
        let per_metre = 1.0 / field.resolution();
        Self {
            at: [(p.x + field.half_x()) * per_metre, (p.y + field.half_y()) * per_metre],
            z: p.z,
            gap: field.contains(p.x, p.y).then(|| p.z - field.height(p.x, p.y)),
        }
    }

    /// Whether it is above the surface, and not beyond its edge.
    pub(crate) fn is_above(&self) -> bool {
        self.gap.is_some_and(|gap| gap > 0.0)
    }
}

impl Ground {
    pub(crate) fn new(field: &Heightfield) -> Self {
        let finest = Grid::finest(field);
        let coarse = finest.coarser();
        let coarsest = coarse.coarser();
        Self {
            large: coarsest.rows.max(coarsest.cols) >= WORTH,
            per_metre: 1.0 / field.resolution(),
            grids: [finest, coarse, coarsest],
            range: field.range(),
            steepest: steepest(field),
        }
    }

    /// The greatest slope of the surface, m/m.
    pub(crate) fn steepest(&self) -> f64 {
        self.steepest
    }

    /// The distance at which a ray meets the surface, m; if it doesn't within `reach`, how far it is known not to. `free`
    /// is a distance up to which the caller knows that it doesn't.
    #[inline]
    pub(crate) fn cast(
        &self,
        field: &Heightfield,
        origin: &Origin,
        direction: &V3,
        free: f64,
        reach: f64,
    ) -> Result<f64, f64> {
        let (low, high) = self.range;
        if origin.z > high && direction.z >= 0.0 {
            return Err(reach);
        }
        let mut ray = Ray::new(self, field, origin, direction, reach);
        let start = match origin.gap {
            Some(gap) => gap,
            None => ray.clip(field).ok_or(0.0)?,
        };
        if start == 0.0 {
            return Ok(ray.from);
        }
        if start < 0.0 {
            ray.side = -1.0;
            return ray.march::<0>(ray.from, ray.to);
        }
        ray.from = ray.from.max(free);
        // The part of the way on which the ground can be, with some room for rounding.
        let inverse = 1.0 / direction.z;
        let room = 1e-9 * (1.0 + reach);
        if direction.z > 0.0 {
            ray.to = ray.to.min((high - origin.z) * inverse + room);
        } else if direction.z < 0.0 {
            ray.to = ray.to.min((low - origin.z) * inverse + room);
            ray.from = ray.from.max((high - origin.z) * inverse - room);
        }
        if ray.from > ray.to {
            return Err(ray.to);
        }
        if self.large { ray.march::<2>(ray.from, ray.to) } else { ray.march::<1>(ray.from, ray.to) }
    }
}

/// The greatest slope of any triangle, m/m.
fn steepest(field: &Heightfield) -> f64 {
    let mut most = 0.0_f64;
    for row in 0..field.rows() - 1 {
        for col in 0..field.cols() - 1 {
            let [sw, se] = [field.node(row, col), field.node(row, col + 1)];
            let [nw, ne] = [field.node(row + 1, col), field.node(row + 1, col + 1)];
            for [x, y] in [[ne - nw, nw - sw], [se - sw, ne - se]] {
                most = most.max(x * x + y * y);
            }
        }
    }
    most.sqrt() / field.resolution()
}

/// A ray on its way. Places are measured in cells from the south-western corner, distances along the ray in m.
struct Ray<'a> {
    grids: &'a [Grid; GRIDS],
    heights: &'a [f64],
    /// Nodes in a row.
    stride: usize,
    origin: [f64; 2],
    rate: [f64; 2],
    /// 1 / rate; 0 where there is none.
    inverse: [f64; 2],
    /// What is added to distances to the sides of squares: infinity along an axis on which the ray doesn't move.
    never: [f64; 2],
    z: f64,
    dz: f64,
    from: f64,
    to: f64,
    /// 1 for a ray above the surface, -1 below.
    side: f64,
}

impl<'a> Ray<'a> {
    #[inline]
    fn new(ground: &'a Ground, field: &'a Heightfield, origin: &Origin, d: &V3, reach: f64) -> Self {
        // A ray along the edge of the world must not leave it by rounding of its direction.
        let moves = [d.x.abs() > PARALLEL, d.y.abs() > PARALLEL];
        let rate = [0, 1].map(|k| if moves[k] { d[k] * ground.per_metre } else { 0.0 });
        Self {
            grids: &ground.grids,
            heights: field.heights(),
            stride: field.cols(),
            origin: origin.at,
            rate,
            inverse: [0, 1].map(|k| if moves[k] { 1.0 / rate[k] } else { 0.0 }),
            never: moves.map(|m| if m { 0.0 } else { f64::INFINITY }),
            z: origin.z,
            dz: d.z,
            from: 0.0,
            to: reach,
            side: 1.0,
        }
    }

    /// Leaves out the way to the surface's edge; the height over the surface there, m. None if it never comes there.
    #[cold]
    fn clip(&mut self, field: &Heightfield) -> Option<f64> {
        let count = [(field.cols() - 1) as f64, (field.rows() - 1) as f64];
        for (k, last) in count.into_iter().enumerate() {
            if self.rate[k] == 0.0 {
                if self.origin[k] < 0.0 || self.origin[k] > last {
                    return None;
                }
                continue;
            }
            let (a, b) = (-self.origin[k] * self.inverse[k], (last - self.origin[k]) * self.inverse[k]);
            self.from = self.from.max(a.min(b));
            self.to = self.to.min(a.max(b));
        }
        if self.from > self.to {
            return None;
        }
        let place = [0, 1].map(|k| self.origin[k] + self.rate[k] * self.from);
        let cell = [0, 1].map(|k| (place[k].max(0.0) as i32).min(count[k] as i32 - 1));
        Some(Cell::of(self, cell).gap(self, self.from))
    }

    /// The first hit between two distances, in the squares of grid K; if there is none, where the search ended. The surface
    /// ends at the grid's edge.
    #[inline]
    fn march<const K: usize>(&self, from: f64, to: f64) -> Result<f64, f64> {
        let grid = &self.grids[K];
        let size = const { STEP.pow(K as u32) as f64 };
        let per_size = 1.0 / size;
        // A cast rounds towards zero, which is down from 0 on.
        let square =
            |k: usize, last: i32| (((self.origin[k] + self.rate[k] * from) * per_size) as i32).clamp(0, last);
        let (mut x, mut y) = (square(0, grid.cols - 1), square(1, grid.rows - 1));
        let (ahead_x, ahead_y) = (i32::from(self.rate[0] > 0.0), i32::from(self.rate[1] > 0.0));
        let (step_x, step_y) = (2 * ahead_x - 1, 2 * ahead_y - 1);
        let side = |k: usize, bound: i32| {
            (f64::from(bound) * size - self.origin[k]) * self.inverse[k] + self.never[k]
        };
        let (mut next_x, mut next_y) = (side(0, x + ahead_x), side(1, y + ahead_y));
        let (long_x, long_y) = (size * self.inverse[0].abs(), size * self.inverse[1].abs());
        let mut t = from;
        loop {
            let along_x = next_x <= next_y;
            let exit = if along_x { next_x } else { next_y };
            let end = exit.min(to).max(t);
            let lowest = self.z + self.dz * if self.dz < 0.0 { end } else { t };
            let most = f64::from(grid.most[(y * grid.cols + x) as usize]);
            if lowest <= most || self.side < 0.0 {
                let hit =
                    if K == 0 { Cell::of(self, [x, y]).enter(self, t, end) } else { self.finer::<K>(t, end) };
                if let Some(hit) = hit {
                    return Ok(hit);
                }
            }
            if exit >= to {
                return Err(to);
            }
            t = end;
            if along_x {
                x += step_x;
                next_x += long_x;
            } else {
                y += step_y;
                next_y += long_y;
            }
            let inside = (x as u32) < (grid.cols as u32) && (y as u32) < (grid.rows as u32);
            if !inside {
                return Err(t);
            }
        }
    }

    /// The same in the squares of the next finer grid.
    #[inline]
    fn finer<const K: usize>(&self, from: f64, to: f64) -> Option<f64> {
        match K {
            2 => self.march::<1>(from, to).ok(),
            _ => self.march::<0>(from, to).ok(),
        }
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
    fn of(ray: &Ray<'_>, [col, row]: [i32; 2]) -> Self {
        let i = row as usize * ray.stride + col as usize;
        let (south, north) = (&ray.heights[i..i + 2], &ray.heights[i + ray.stride..i + ray.stride + 2]);
        Self { at: [f64::from(col), f64::from(row)], corners: [south[0], south[1], north[0], north[1]] }
    }

    /// Height of the ray over the surface at a distance, m.
    #[inline]
    fn gap(&self, ray: &Ray<'_>, t: f64) -> f64 {
        let u = ray.origin[0] + ray.rate[0] * t - self.at[0];
        let v = ray.origin[1] + ray.rate[1] * t - self.at[1];
        let [sw, se, nw, ne] = self.corners;
        // On the north-western triangle, v ≥ u, the surface rises by ne - nw along u and by nw - sw along v.
        let (along_u, along_v) = if v >= u { (ne - nw, nw - sw) } else { (se - sw, ne - se) };
        ray.z + ray.dz * t - (sw + along_u * u + along_v * v)
    }

    /// The distance at which the ray comes to the other side of the surface between two distances. It counts as hit at the
    /// first if it is on the other side already, which happens by rounding alone.
    #[inline]
    fn enter(&self, ray: &Ray<'_>, from: f64, to: f64) -> Option<f64> {
        let first = ray.side * self.gap(ray, from);
        if first <= 0.0 {
            return Some(from);
        }
        let between = |a: (f64, f64), b: (f64, f64)| a.0 + (b.0 - a.0) * (a.1 / (a.1 - b.1));
        // Where the way crosses the cell's diagonal, if it does.
        let apart = ray.rate[0] - ray.rate[1];
        let offset = (ray.origin[0] - self.at[0]) - (ray.origin[1] - self.at[1]);
        let diagonal = -offset / apart;
        let mut last = (from, first);
        if diagonal > from && diagonal < to {
            let gap = ray.side * self.gap(ray, diagonal);
            if gap <= 0.0 {
                return Some(between(last, (diagonal, gap)));
            }
            last = (diagonal, gap);
        }
        let gap = ray.side * self.gap(ray, to);
        (gap <= 0.0).then(|| between(last, (to, gap)))
    }
}
