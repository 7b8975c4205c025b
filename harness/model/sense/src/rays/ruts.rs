//! Rays against ground that wheels have changed.

use crate::V3;
use vb_sim::Simulation;
use vb_world::Heightfield;

/// How wheels have changed the height of soft soil.
///
/// The changed surface is the heightfield plus a change of height that is constant in each cell of the soil's memory. A
/// ray is followed through those cells around the place where it meets the unchanged surface: from 20 cells in front of it,
/// for heaps, to where it comes below the changed surface. Within a cell the height under the ray is taken as linear, which
/// is exact but where an edge of the ground's triangles runs through the cell. A heap that a grazing ray meets farther in
/// front of its hit is not seen.
pub trait Ruts {
    /// By how much the ground at (x, y) is higher than it was at first, m: negative in a rut, positive on a heap; `None`
    /// where nothing has changed for some metres around.
    fn change(&self, x: f64, y: f64) -> Option<f64>;

    /// The side of the cells in which changes are remembered, m.
    fn cell(&self) -> f64;
}

impl Ruts for Simulation {
    fn change(&self, x: f64, y: f64) -> Option<f64> {
        self.soil_change(x, y)
    }

    fn cell(&self) -> f64 {
        self.soil_resolution()
    }
}

/// How far before its hit with the unchanged ground a ray is followed, in cells of the soil's memory: 2 m at full scale.
const BEFORE: f64 = 20.0;
/// How far beyond it, at most: 10 m.
const BEYOND: f64 = 100.0;

/// The distance at which a ray that meets the unchanged surface at the distance `plain` meets the changed one, m; none if it
/// doesn't within `reach`.
pub(super) fn cast(
    field: &Heightfield,
    ruts: &dyn Ruts,
    origin: &V3,
    direction: &V3,
    plain: f64,
    reach: f64,
) -> Option<f64> {
    let side = ruts.cell();
    let from = (plain - BEFORE * side).max(0.0);
    let known = |t: f64| ruts.change(origin.x + direction.x * t, origin.y + direction.y * t);
    if known(plain).is_none() && known(from).is_none() {
        return Some(plain);
    }
    let to = (plain + BEYOND * side).min(reach);
    let gap = |t: f64, change: f64| {
        let at = origin + direction * t;
        at.z - field.height(at.x, at.y) - change
    };
    // The soil's memory begins at the south-western corner of the world.
    let corner = [origin.x + field.half_x(), origin.y + field.half_y()];
    let mut t = from;
    while t < to {
        let exit = exit(side, corner, [direction.x, direction.y], t).min(to);
        let change = known(0.5 * (t + exit)).unwrap_or(0.0);
        let (first, last) = (gap(t, change), gap(exit, change));
        if first <= 0.0 {
            return Some(t);
        }
        if last <= 0.0 {
            return Some(t + (exit - t) * (first / (first - last)));
        }
        t = exit;
    }
    None
}

/// Where a ray leaves the cell that it is in at the distance `t`, always some way on. Cells begin at multiples of their
/// side.
fn exit(side: f64, origin: [f64; 2], rate: [f64; 2], t: f64) -> f64 {
    let mut exit = f64::INFINITY;
    for k in 0..2 {
        if rate[k] != 0.0 {
            let at = (origin[k] + rate[k] * t) / side;
            let bound = if rate[k] > 0.0 { at.floor() + 1.0 } else { at.ceil() - 1.0 };
            exit = exit.min(t + (bound - at) * side / rate[k]);
        }
    }
    // A vertical ray stays in its cell; a step must be seen in floating point.
    if exit.is_finite() { exit.max(t + 1e-6 * side) } else { t + side }
}
