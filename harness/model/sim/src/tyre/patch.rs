//! The contact patch between slip and force.

use crate::V3;

/// Speed that keeps slips finite on a wheel that neither slides nor turns, m/s: far below what is ever seen.
const STILL: f64 = 1e-9;

/// The state of a contact: how far the tyre has been dragged over the ground under the hub.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    /// The longitudinal and the lateral deflection, m.
    pub deflection: [f64; 2],
}

/// A contact's motion in its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slide {
    /// Velocity of the contact over the ground, longitudinal and lateral, m/s.
    pub(crate) sliding: [f64; 2],
    /// |spin · effective radius|, m/s.
    pub(crate) rolling: f64,
    /// |longitudinal speed of the hub|, m/s.
    pub(crate) forward: f64,
    /// Normal force, N, > 0.
    pub(crate) load: f64,
    /// Radial deflection, m.
    pub(crate) depth: f64,
    /// Friction coefficient of the ground, > 0.
    pub(crate) friction: f64,
}

impl Slide {
    pub(crate) fn speed(&self) -> f64 {
        norm(self.sliding)
    }

    pub(crate) fn rolling_or_still(&self) -> f64 {
        self.rolling + STILL
    }

    pub(crate) fn forward_or_still(&self) -> f64 {
        self.forward + STILL
    }
}

/// The frame of a contact in world axes, and how the wheel turns in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stance {
    /// Unit normal of the ground.
    pub(crate) normal: V3,
    /// Unit direction of rolling, in the contact plane.
    pub(crate) along: V3,
    /// Unit axle, to the left.
    pub(crate) axis: V3,
    /// Spin, rad/s, positive rolling forward.
    pub(crate) spin: f64,
    /// Distance of the contact from the hub, m.
    pub(crate) lever: f64,
}

/// What a model gives beside the radial force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneForce {
    /// On the wheel in the contact plane, along and across, N.
    pub(crate) force: [f64; 2],
    /// Aligning and overturning moment on the wheel, world axes, N m.
    pub(crate) twist: V3,
    /// Moment of rolling resistance against the spin, N m.
    pub(crate) resistance: f64,
}

/// Elastic force, over its limit, of a carcass that has settled: it yields to all of the slip curve.
pub(crate) const SETTLED: [f64; 2] = [f64::INFINITY; 2];

/// What a model's slip curve says at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Creep {
    /// Sliding speed over the steady force that it gives, a direction each, m/s/N.
    pub(crate) compliance: [f64; 2],
    /// Half axes, N, of the greatest force: hypot(a cos φ, b sin φ) for a force in direction φ.
    pub(crate) limit: [f64; 2],
}

impl Creep {
    /// The force in steady sliding, N.
    pub(crate) fn steady(&self, sliding: [f64; 2]) -> [f64; 2] {
        let force: [f64; 2] = std::array::from_fn(|k| -sliding[k] / self.compliance[k]);
        let over = excess(force, self.limit).max(1.0);
        [force[0] / over, force[1] / over]
    }
}

/// A carcass of given stiffness and damping between the hub and the patch.
///
/// Rill's first-order tyre dynamics (Road Vehicle Dynamics, 2012, §3.4): the carcass' force c u + d u̇ is the friction
/// force at the patch's own sliding velocity v − u̇, which the slip curve, made linear by its secant, gives as
/// (v − u̇)/q. So u̇ = (v − q c u)/(1 + d q). Its fixed point is the steady curve, force = v/q; its relaxation length
/// at small slip is the curve's initial slope over c; on a wheel that doesn't turn, where q = |v|/F, it is Dahl's
/// friction, a spring that yields at F. It is advanced with the implicit rule in u, so no step is too long for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carcass {
    pub(crate) stiffness: [f64; 2],
    pub(crate) damping: [f64; 2],
}

impl Carcass {
    /// The force of the springs alone, N.
    pub(crate) fn elastic(&self, patch: &Patch) -> [f64; 2] {
        [self.stiffness[0] * patch.deflection[0], self.stiffness[1] * patch.deflection[1]]
    }

    /// Advances the deflection; returns the force on the wheel, N.
    #[inline]
    pub(crate) fn advance(&self, patch: &mut Patch, sliding: [f64; 2], creep: &Creep, dt: f64) -> [f64; 2] {
        let mut force = [0.0; 2];
        for k in 0..2 {
            let (c, d, q) = (self.stiffness[k], self.damping[k], creep.compliance[k]);
            let inverse = 1.0 / (1.0 + d * q);
            let old = patch.deflection[k];
            let new = (old + dt * sliding[k] * inverse) / (1.0 + dt * c * q * inverse);
            patch.deflection[k] = new;
            force[k] = -(c * new + d * (new - old) / dt);
        }
        let spring = excess(self.elastic(patch), creep.limit);
        if spring > 1.0 {
            patch.deflection[0] /= spring;
            patch.deflection[1] /= spring;
        }
        let over = excess(force, creep.limit).max(1.0);
        [force[0] / over, force[1] / over]
    }
}

/// A force's magnitude over the limit in its direction.
fn excess(force: [f64; 2], limit: [f64; 2]) -> f64 {
    let square = force[0] * force[0] + force[1] * force[1];
    let reach = norm([force[0] * limit[0], force[1] * limit[1]]);
    if reach > 0.0 { square / reach } else { 0.0 }
}

/// The compliance `q` of a slip curve, less where the carcass still holds: while its force is below most of what
/// sliding would give (`held` is their ratio), it yields no more easily than the curve does short of sliding
/// (`creeping`). So a parked vehicle that is shaken doesn't walk, as Dahl's friction alone would let it (Dupont et al.,
/// Single state elastoplastic friction models, 2002). The fixed point, `held` = 1, stays that of the curve.
#[inline]
pub(crate) fn stick(q: f64, creeping: f64, held: f64) -> f64 {
    let base = q.min(creeping);
    base + ((held - 0.7) / 0.3).clamp(0.0, 1.0) * (q - base)
}

pub(crate) fn norm(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}
