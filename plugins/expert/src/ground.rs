//! Cost of each position and heading for a vehicle.

use vb_sdk::rng::Rng;
use vb_sdk::{GridFrame, LabelMap, PlannerError, Task, math};

/// Directions of path segments: the neighbours on the grid and the knight's moves between them, counter-clockwise from
/// east, (columns, rows).
pub(crate) const HEADINGS: [(i32, i32); 16] = [
    (1, 0),
    (2, 1),
    (1, 1),
    (1, 2),
    (0, 1),
    (-1, 2),
    (-1, 1),
    (-2, 1),
    (-1, 0),
    (-2, -1),
    (-1, -1),
    (-1, -2),
    (0, -1),
    (1, -2),
    (1, -1),
    (2, -1),
];

/// Tangent of the maximum slope that a vehicle climbs, by terrain class: typical friction less rolling resistance; for
/// deformable terrain the slopes that the HMMWV climbs in the validation (docs/validation.md), rounded.
const CLIMB: [f64; 10] = [0.5, 0.7, 0.5, 0.28, 0.45, 0.55, 0.36, 0.25, 0.25, 0.2];
/// Additional cost per metre of each terrain class: sinkage costs time and may immobilise the vehicle.
const SOFT: [f64; 10] = [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.5, 0.4, 0.6];

/// Costs of all positions and headings; infinite where the vehicle collides.
pub(crate) struct Ground {
    pub(crate) frame: GridFrame,
    /// Indexed by row, column, heading.
    cost: Vec<f32>,
}

impl Ground {
    pub(crate) fn new(task: &Task, caution: f64) -> Result<Self, PlannerError> {
        let (elevation, semantics) = (task.elevation()?, task.semantics()?);
        let frame = elevation.frame;
        let clearance = clearance(task, frame, task.occupancy()?);
        let v = &task.vehicle;
        let (front, side) = (0.5 * v.wheelbase, 0.5 * v.track);
        let mut cost = Vec::with_capacity(clearance.len() * HEADINGS.len());
        for row in 0..frame.rows {
            for col in 0..frame.cols {
                let (x, y) = frame.position(row, col);
                let gap = clearance[(row * frame.cols + col) as usize];
                let class = usize::from(semantics.nearest(x, y)).min(9);
                for (dx, dy) in HEADINGS {
                    let length = f64::from(dx * dx + dy * dy).sqrt();
                    let (c, s) = (f64::from(dx) / length, f64::from(dy) / length);
                    let z = |u: f64, w: f64| elevation.bilinear(x + c * u - s * w, y + s * u + c * w);
                    let [fl, fr, rl, rr] = [(front, side), (front, -side), (-front, side), (-front, -side)]
                        .map(|(u, w)| z(u, w));
                    let rise = 0.5 * (fl + fr - rl - rr) / v.wheelbase;
                    let roll = 0.5 * (fl + rl - fr - rr) / v.track;
                    let twist = 0.5 * (fl - fr - rl + rr) / v.track;
                    let plane = 0.25 * (fl + fr + rl + rr);
                    // Height of the terrain between the wheels, as a fraction of the ground clearance.
                    let belly = [
                        (-0.5 * front, 0.0),
                        (0.0, 0.0),
                        (0.5 * front, 0.0),
                        (0.0, 0.5 * side),
                        (0.0, -0.5 * side),
                    ]
                    .map(|(u, w)| (z(u, w) - plane - rise * u - roll * w) / v.ground_clearance);
                    let belly = belly.into_iter().fold(0.0, f64::max);
                    let square = |v: f64| v * v;
                    let steep = (rise / CLIMB[class]).max(0.0);
                    let pose = 6.0 * square(roll / 0.36)
                        + 2.0 * square(rise / 0.36)
                        + 3.0 * square(twist / 0.36)
                        + 6.0 * square((belly - 0.4).max(0.0) / 0.6)
                        + 6.0 * square((steep - 0.4).max(0.0) / 0.6)
                        + 2.0 * square((1.0 - gap / v.width).max(0.0));
                    let blocked = gap < 0.5 * v.width + 0.1 * v.scale;
                    let value = if blocked { f64::INFINITY } else { 1.0 + SOFT[class] + caution * pose };
                    cost.push(value as f32);
                }
            }
        }
        Ok(Self { frame, cost })
    }

    /// Cost per metre at a node with a heading.
    pub(crate) fn cost(&self, row: i32, col: i32, heading: usize) -> f32 {
        let (rows, cols) = (self.frame.rows as i32, self.frame.cols as i32);
        if row < 0 || col < 0 || row >= rows || col >= cols {
            return f32::INFINITY;
        }
        self.cost[(row * cols + col) as usize * HEADINGS.len() + heading]
    }

    /// Multiplies the cost of each position by a random factor, equal for all headings.
    pub(crate) fn perturb(&mut self, rng: &mut Rng, spread: f64) {
        for costs in self.cost.chunks_exact_mut(HEADINGS.len()) {
            let factor = math::exp(spread * rng.normal()) as f32;
            for cost in costs {
                *cost = 1.0 + (*cost - 1.0 + 0.2) * factor;
            }
        }
    }
}

/// Distance from each node of the elevation map to the nearest obstacle or the edge of the world, capped, m.
fn clearance(task: &Task, frame: GridFrame, occupied: &LabelMap) -> Vec<f64> {
    let reach = 2.0 * task.vehicle.width;
    let mut distance = vec![reach; (frame.rows * frame.cols) as usize];
    let edge = |i: u32, n: u32| f64::from(i.min(n - 1 - i)) * frame.resolution;
    for row in 0..frame.rows {
        for col in 0..frame.cols {
            let d = &mut distance[(row * frame.cols + col) as usize];
            *d = d.min(edge(row, frame.rows)).min(edge(col, frame.cols));
        }
    }
    let span = (reach / frame.resolution) as i64 + 1;
    for orow in 0..occupied.frame.rows {
        for ocol in 0..occupied.frame.cols {
            if occupied.at(orow, ocol) == 0 {
                continue;
            }
            let (x, y) = occupied.frame.position(orow, ocol);
            let (r, c) = frame.fractional(x, y);
            let range = |v: f64, n: u32| (v as i64 - span).max(0)..(v as i64 + span + 2).min(i64::from(n));
            for row in range(r, frame.rows) {
                for col in range(c, frame.cols) {
                    let (px, py) = frame.position(row as u32, col as u32);
                    let d = &mut distance[row as usize * frame.cols as usize + col as usize];
                    *d = d.min(math::hypot(px - x, py - y) - 0.5 * occupied.frame.resolution);
                }
            }
        }
    }
    distance
}
