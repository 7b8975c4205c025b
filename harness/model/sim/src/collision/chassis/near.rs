//! Whether rapier has to be asked: what is near the hull.

use super::super::separation::separation;
use super::super::{Cuboid, Obstacles, extents, from_vector, rotation, vector};
use super::ChassisContacts;
use crate::soil::SoilGround;
use crate::{M3, Quat, V3};
use rapier3d_f64::prelude::{Pose, Vector};
use vb_world::Heightfield;

/// What looks for ground near the hull leave to the next one, to save work: it changes no answer.
#[derive(Clone, Default)]
pub(super) struct Looks {
    pub(super) near: Option<Near>,
    pub(super) clear: Option<Clear>,
}

/// The part and the triangle of the ground that were within reach of each other last.
#[derive(Clone, Copy)]
pub(super) struct Near {
    part: usize,
    cell: [usize; 2],
    upper: bool,
}

/// How far the hull was clear of the ground.
#[derive(Clone)]
pub(super) struct Clear {
    x: V3,
    axes: M3,
    /// Distance to the ground, at least, m.
    gap: f64,
}

/// What is left of a clearance for rounding, m.
const ROUNDING: f64 = 1e-9;
/// Cells along and across the sole at which heaps are looked for, at most: a larger hull has larger cells.
const MOST_CELLS: f64 = 64.0;
/// How far around the hull the ground is looked at, over the hull's bound.
const ROOM: f64 = 0.15;

impl ChassisContacts {
    /// Whether it is known from the last look that the hull hasn't come within `margin` of ground or obstacles: if so,
    /// [`Self::may_touch`] says no.
    pub(crate) fn is_known_clear(&self, obstacles: &Obstacles, x: &V3, q: &Quat, margin: f64) -> bool {
        let known = |clear| self.is_still_clear(clear, x, q.to_rotation_matrix().matrix(), margin);
        !obstacles.any_near() && (self.passes_ground() || self.looks.clear.as_ref().is_some_and(known))
    }

    /// Whether no part meets the ground now.
    fn passes_ground(&self) -> bool {
        (0..self.parts.len()).all(|part| self.passing.is(part, self.hull))
    }

    /// Whether the hull may come within `margin` of ground or obstacles.
    pub(crate) fn may_touch(
        &mut self,
        ground: &Heightfield,
        obstacles: &Obstacles,
        x: &V3,
        q: &Quat,
        margin: f64,
    ) -> bool {
        let r = q.to_rotation_matrix();
        let hull = Cuboid {
            centre: x + r * (0.5 * (self.low + self.high)),
            half: 0.5 * (self.high - self.low),
            axes: *r.matrix(),
        };
        if obstacles.any_within(&hull, margin) {
            return true;
        }
        if self.passes_ground() {
            return false;
        }
        if self.looks.clear.as_ref().is_some_and(|c| self.is_still_clear(c, x, r.matrix(), margin)) {
            return false;
        }
        self.looks.clear = None;
        let pose = Pose::from_parts(vector(x), rotation(q));
        if self.looks.near.is_some_and(|near| self.gap_to(ground, &pose, near, margin) <= margin) {
            return true;
        }
        match self.gap(ground, &pose, margin) {
            // Under the ground a hull has no triangle near it either.
            Ok(gap) if x.z > ground.height(x.x, x.y) => {
                self.looks.clear = Some(Clear { x: *x, axes: *r.matrix(), gap });
                false
            }
            Ok(_) => true,
            Err(near) => {
                self.looks.near = Some(near);
                true
            }
        }
    }

    /// Whether the hull can't have come within `margin` of the ground since it was clear.
    pub(super) fn is_still_clear(&self, c: &Clear, x: &V3, axes: &M3, margin: f64) -> bool {
        let moved = (x - c.x).norm() + (axes - c.axes).norm() * self.bound;
        c.gap - moved > margin + ROUNDING
    }

    /// A lower bound on the distance from one part of the hull to one triangle of the ground, m; not followed beyond `enough`.
    fn gap_to(&self, ground: &Heightfield, pose: &Pose, near: Near, enough: f64) -> f64 {
        let Near { part, cell: [row, col], upper } = near;
        let node = |row: usize, col: usize| {
            let (x, y) = (col as f64 * ground.resolution(), row as f64 * ground.resolution());
            let node = Vector::new(x - ground.half_x(), y - ground.half_y(), ground.node(row, col));
            pose.inverse_transform_point(node)
        };
        let third = if upper { node(row + 1, col) } else { node(row, col + 1) };
        separation(&self.parts[part], [node(row, col), node(row + 1, col + 1), third], enough)
    }

    /// A lower bound on the distance from the hull to the ground, m, as far as the ground is looked at; or, where that is
    /// within `margin`, what is near.
    fn gap(&self, ground: &Heightfield, pose: &Pose, margin: f64) -> Result<f64, Near> {
        let cells = |low: f64, high: f64, half: f64, count: usize| {
            let index = |v: f64| (((v + half) / ground.resolution()).max(0.0) as usize).min(count - 2);
            index(low)..=index(high)
        };
        let room = (ROOM * self.bound).max(2.0 * margin);
        let mut gap = room;
        let meets = |part: &usize| !self.passing.is(*part, self.hull);
        for (part, solid) in self.parts.iter().enumerate().filter(|(part, _)| meets(part)) {
            let (low, high) = extents(solid.points().iter().map(|p| from_vector(*pose * *p)));
            for row in cells(low.y - room, high.y + room, ground.half_y(), ground.rows()) {
                for col in cells(low.x - room, high.x + room, ground.half_x(), ground.cols()) {
                    let top = ground
                        .node(row, col)
                        .max(ground.node(row, col + 1))
                        .max(ground.node(row + 1, col))
                        .max(ground.node(row + 1, col + 1));
                    if low.z - top >= gap {
                        continue;
                    }
                    for upper in [false, true] {
                        let near = Near { part, cell: [row, col], upper };
                        gap = gap.min(self.gap_to(ground, pose, near, gap));
                        if gap <= margin {
                            return Err(near);
                        }
                    }
                }
            }
        }
        Ok(gap)
    }

    /// Looks how high heaps of soil stand under and around the sole, in every second cell of the soil's memory.
    /// Contacts are looked for from that height on, so that a heap is met before the hull is in it.
    pub(crate) fn look_for_heaps(&mut self, soil: &SoilGround, x: &V3, q: &Quat) {
        let (low, high) = self.sole;
        let lattice = |k: usize| {
            let cells = ((high[k] - low[k]) / (2.0 * soil.grid.resolution())).ceil();
            let cells = cells.clamp(1.0, MOST_CELLS);
            (cells as usize + 2, (high[k] - low[k]) / cells)
        };
        let [(cols, along), (rows, across)] = [lattice(0), lattice(1)];
        let place = |k: usize, spacing: f64, i: usize| low[k] + spacing * (i as f64 - 0.5);
        let (forward, left) = (*q * V3::x(), *q * V3::y());
        let mut highest = 0.0_f64;
        for row in 0..rows {
            for col in 0..cols {
                let at = x + forward * place(0, along, col) + left * place(1, across, row);
                if let Some(cell) = soil.grid.touched(at.x, at.y) {
                    highest = highest.max(cell.raised - cell.plastic);
                }
            }
        }
        self.heaps = highest;
    }
}
