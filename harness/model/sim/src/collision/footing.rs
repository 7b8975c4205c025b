//! What the hull stands on, contact by contact: friction of the ground and the present surface of soil.
//!
//! rapier knows one ground, rigid and of one friction. Its contacts are corrected before it solves them. The friction of a
//! manifold is the mean of what lies under its points, weighted by the impulses that they bore last. A point over soil is
//! as deep as the present surface there makes it, with ruts and heaps.

use rapier3d_f64::prelude::*;
use vb_world::Semantics;

use super::from_vector;
use crate::soil::SoilGround;

/// The ground under the hull.
pub(crate) struct Footing<'a> {
    pub(crate) semantics: &'a Semantics,
    pub(crate) soil: &'a SoilGround,
}

/// Points on the way from a contact to the middle of its manifold at which the surface of soil is looked up.
const SAMPLES: usize = 6;
/// Fraction of this way for which the contact stands; other contacts stand for the rest.
const SHARE: f64 = 0.5;
/// Impulse of a contact that bore nothing yet, N s: so small that any other outweighs it.
const NOTHING: f64 = 1e-9;
/// The bits of a solver contact's number that tell the point of the manifold; above them is rapier's mark of new contacts.
const POINT: u64 = 0x7fff_ffff;

impl Footing<'_> {
    /// The friction coefficient of a hull of steel, whose own is `hull`, on the ground at a position: the minimum of the
    /// hull's and the patch's on rigid ground, and that of the interface of steel and soil on soil.
    pub(crate) fn friction(&self, hull: f64, x: f64, y: f64) -> f64 {
        match self.soil.soil_at(x, y) {
            Some(soil) => soil.steel_friction.min(hull),
            None => self.semantics.friction_at(x, y).min(hull),
        }
    }

    /// By how much the surface at a position is higher than at first, m.
    fn change(&self, x: f64, y: f64) -> Option<f64> {
        self.soil.grid.touched(x, y).map(|cell| cell.raised - cell.plastic)
    }

    /// By how much the surface that carries a face of the hull at one of its contacts is higher than at first, m. The
    /// highest surface carries the face: it is looked for from the contact half the way to the middle of all contacts, which
    /// the face covers.
    fn bearing(&self, contact: Vector, middle: Vector) -> f64 {
        let Some(here) = self.change(contact.x, contact.y) else { return 0.0 };
        let step = (middle - contact) * (SHARE / SAMPLES as f64);
        (1..=SAMPLES).fold(here, |highest, k| {
            let at = contact + step * k as f64;
            highest.max(self.change(at.x, at.y).unwrap_or(0.0))
        })
    }
}

/// The correction of the contacts with the ground.
pub(super) struct Correction<'a> {
    pub(super) footing: &'a Footing<'a>,
    pub(super) ground: ColliderHandle,
    /// The friction of the hull.
    pub(super) hull: f64,
}

impl PhysicsHooks for Correction<'_> {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let first = context.collider1 == self.ground;
        if !first && context.collider2 != self.ground {
            return;
        }
        let Some(manifold) = context.rigid_mut() else { return };
        let count = manifold.solver_contacts.len();
        if count == 0 {
            return;
        }
        let on_ground = |c: &SolverContact| if first { c.anchor1 } else { c.anchor2 };
        let (mut sum, mut weights) = (0.0, 0.0);
        for c in manifold.solver_contacts.iter() {
            let at = on_ground(c);
            let point = &manifold.manifold.points[(c.contact_id[0] & POINT) as usize];
            let weight = point.data.warmstart_impulse.max(0.0) + NOTHING;
            sum += weight * self.footing.friction(self.hull, at.x, at.y);
            weights += weight;
        }
        *manifold.friction = sum / weights;
        if self.footing.soil.is_empty() {
            return;
        }
        // The grains of a bed press on the hull themselves.
        manifold.solver_contacts.retain(|c| {
            let at = on_ground(c);
            !self.footing.soil.is_granular(at.x, at.y)
        });
        let count = manifold.solver_contacts.len();
        if count == 0 {
            return;
        }
        let middle = manifold.solver_contacts.iter().map(on_ground).sum::<Vector>() / count as f64;
        let upwards = from_vector(*manifold.normal).z.abs();
        for c in manifold.solver_contacts.iter_mut() {
            c.dist -= self.footing.bearing(on_ground(c), middle) * upwards;
        }
    }
}
