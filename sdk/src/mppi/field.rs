//! Maps of distances or costs for rollouts.

use super::{LANES, Lanes};
use crate::{GridFrame, LabelMap, Task, math};

/// Values on a square grid in the world frame, interpolated linearly between four samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    values: Vec<f32>,
    rows: usize,
    cols: usize,
    per_metre: f32,
    origin: [f32; 2],
}

impl Field {
    /// Samples `value(x, y)`, with x and y in m, on a frame. Returns `None` for a frame of fewer than 2 × 2 samples.
    #[must_use]
    pub fn new(frame: GridFrame, mut value: impl FnMut(f64, f64) -> f64) -> Option<Self> {
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        if rows < 2 || cols < 2 {
            return None;
        }
        let mut values = Vec::with_capacity(rows * cols);
        for row in 0..frame.rows {
            for col in 0..frame.cols {
                let (x, y) = frame.position(row, col);
                values.push(value(x, y) as f32);
            }
        }
        let origin = [frame.origin_x as f32, frame.origin_y as f32];
        Some(Self { values, rows, cols, per_metre: (1.0 / frame.resolution) as f32, origin })
    }

    /// The distance to the nearest obstacle or edge of the world, m, capped at `reach` and negative outside the world.
    /// Returns `None` if the occupancy map has fewer than 2 × 2 samples, or the task has no occupancy or elevation map.
    #[must_use]
    pub fn clearance(task: &Task, reach: f64) -> Option<Self> {
        let (occupied, ground) = (task.occupancy.as_ref()?, task.elevation.as_ref()?.frame);
        let (low, high) =
            (ground.position(0, 0), ground.position(ground.rows.max(1) - 1, ground.cols.max(1) - 1));
        Self::around(occupied, low, high, reach)
    }

    /// The distance to obstacles and edges for an occupancy map, e.g. a local map, in a world from `low` to `high` (x,
    /// y), m. Unknown cells count as free. Returns `None` if the map has fewer than 2 × 2 samples.
    #[must_use]
    pub fn around(occupied: &LabelMap, low: (f64, f64), high: (f64, f64), reach: f64) -> Option<Self> {
        let frame = occupied.frame;
        let mut field =
            Self::new(frame, |x, y| (x - low.0).min(high.0 - x).min(y - low.1).min(high.1 - y).min(reach))?;
        let span = (reach / frame.resolution) as i64 + 1;
        let range =
            |i: u32, n: u32| (i64::from(i) - span).max(0)..(i64::from(i) + span + 1).min(i64::from(n));
        for orow in 0..frame.rows {
            for ocol in 0..frame.cols {
                if occupied.at(orow, ocol) != 1 {
                    continue;
                }
                for row in range(orow, frame.rows) {
                    for col in range(ocol, frame.cols) {
                        // From the edge of the occupied square, whatever its side.
                        let gap = |a: i64, b: u32| ((a - i64::from(b)).abs() as f64 - 0.5).max(0.0);
                        let d = (math::hypot(gap(row, orow), gap(col, ocol)) * frame.resolution) as f32;
                        let value = &mut field.values[row as usize * field.cols + col as usize];
                        *value = value.min(d);
                    }
                }
            }
        }
        Some(field)
    }

    /// The values at these positions (m), interpolated between the four samples around each; positions outside the
    /// frame are clamped to its edge.
    #[must_use]
    pub fn at(&self, x: &Lanes, y: &Lanes) -> Lanes {
        let most = |n: usize| (n - 1) as f32;
        let (last_col, last_row) = (most(self.cols), most(self.rows));
        let c: Lanes = x.map(|x| ((x - self.origin[0]) * self.per_metre).clamp(0.0, last_col));
        let r: Lanes = y.map(|y| ((y - self.origin[1]) * self.per_metre).clamp(0.0, last_row));
        // NaN becomes an index of 0, and remains NaN below.
        let (end_col, end_row) = (self.cols as i32 - 2, self.rows as i32 - 2);
        let col: [i32; LANES] = c.map(|c| (c as i32).min(end_col));
        let row: [i32; LANES] = r.map(|r| (r as i32).min(end_row));
        let mut corners = [[0.0; LANES]; 4];
        for l in 0..LANES {
            let i = row[l] as usize * self.cols + col[l] as usize;
            let around = &self.values[i..i + self.cols + 2];
            corners[0][l] = around[0];
            corners[1][l] = around[1];
            corners[2][l] = around[self.cols];
            corners[3][l] = around[self.cols + 1];
        }
        let [a, b, d, e] = corners;
        // A separate loop, so that all lanes are vectorised.
        let mut values = [0.0; LANES];
        for l in 0..LANES {
            let (u, v) = (c[l] - col[l] as f32, r[l] - row[l] as f32);
            let (low, high) = (a[l] + u * (b[l] - a[l]), d[l] + u * (e[l] - d[l]));
            values[l] = low + v * (high - low);
        }
        values
    }
}
