//! The force of one contact.
//!
//! A linear spring and damper along the normal, a tangential spring and damper up to Coulomb's bound (Cundall and Strack, Géotechnique 29,
//! 1979), and an elastic-plastic rolling spring (Iwashita and Oda, J. Eng. Mech. 124, 1998; model C of Ai et al., Powder Technology 206,
//! 2011).

use crate::V3;

/// The constants of contacts of one pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Law {
    /// N/m.
    pub(crate) stiffness: f64,
    /// Damping ratio of the normal and the tangential spring.
    pub(crate) damping: f64,
    pub(crate) friction: f64,
    pub(crate) rolling_resistance: f64,
    /// Attraction over cross-section, Pa.
    pub(crate) cohesion: f64,
}

/// History variables of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Memory {
    /// Stretch of the tangential spring, m.
    pub(crate) slip: V3,
    /// Angle of the rolling spring, rad.
    pub(crate) roll: V3,
}

/// A contact of a grain with something else, as they are now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// Unit normal from the other to the grain.
    pub(crate) normal: V3,
    /// Overlap, m, > 0.
    pub(crate) depth: f64,
    /// Velocity of the grain's surface relative to the other's at the contact, m/s.
    pub(crate) velocity: V3,
    /// Angular velocity of the grain relative to the other's, rad/s.
    pub(crate) spin: V3,
    /// Reduced mass, kg, and reduced radius, m.
    pub(crate) mass: f64,
    pub(crate) radius: f64,
    /// Radius of the smaller grain, m.
    pub(crate) smaller: f64,
}

/// A surface near a grain's centre.
pub(crate) struct Surface {
    /// Signed distance of the grain's centre from the surface, m, negative inside.
    pub(crate) distance: f64,
    /// Unit normal out of the surface.
    pub(crate) normal: V3,
    /// Velocity of the surface at the point closest to the centre, m/s.
    pub(crate) velocity: V3,
    /// Angular velocity of the surface, rad/s.
    pub(crate) spin: V3,
    pub(crate) law: Law,
}

/// Tangential over normal stiffness: 2/7 gives both springs of a sphere the same period (Silbert et al., Phys. Rev. E 64, 2001).
const TANGENTIAL: f64 = 2.0 / 7.0;
/// Stiffness of the rolling spring over normal stiffness and (rolling resistance × reduced radius)² (Ai et al. 2011, eq. 16 and 17).
const ROLLING: f64 = 2.25;

/// Moment of inertia of a sphere over mass and square of the radius.
const SPHERE: f64 = 0.4;

/// A force, or a shorter one in its direction.
fn bounded(force: V3, bound: f64) -> V3 {
    let wanted = force.norm();
    if wanted > bound { force * (bound / wanted) } else { force }
}

impl Law {
    /// Force on the grain, N, and the moment of rolling resistance on it, N m, after a step of `dt`.
    #[inline]
    pub(crate) fn act(&self, pair: &Pair, memory: &mut Memory, dt: f64) -> (V3, V3) {
        let n = pair.normal;
        let along = pair.velocity.dot(&n);
        let damper = 2.0 * self.damping * (self.stiffness * pair.mass).sqrt();
        // Damping never pulls.
        let push = (self.stiffness * pair.depth - damper * along).max(0.0);
        let sliding = pair.velocity - n * along;
        // The spring follows the turning of the normal.
        let mut slip = memory.slip + sliding * dt;
        slip -= n * slip.dot(&n);
        let stiffness = TANGENTIAL * self.stiffness;
        let damper_t = damper * TANGENTIAL.sqrt();
        let bound = self.friction * push;
        let spring = slip.norm() * stiffness;
        let friction = if spring > bound {
            slip *= bound / spring;
            slip * -stiffness
        } else {
            bounded(-(slip * stiffness + sliding * damper_t), bound)
        };
        memory.slip = slip;
        let mut moment = V3::zeros();
        if self.rolling_resistance > 0.0 {
            let arm = self.rolling_resistance * pair.radius;
            let stiffness = ROLLING * self.stiffness * arm * arm;
            let mut roll = memory.roll + pair.spin * dt;
            let (bound, spring) = (arm * push, stiffness * roll.norm());
            moment = if spring > bound {
                roll *= bound / spring;
                roll * -stiffness
            } else {
                let damper = 2.0 * self.damping * (stiffness * SPHERE * pair.mass).sqrt() * pair.radius;
                bounded(-(roll * stiffness + pair.spin * damper), bound)
            };
            memory.roll = roll;
        }
        let attraction = self.cohesion * std::f64::consts::PI * pair.smaller * pair.smaller;
        (n * (push - attraction) + friction, moment)
    }

    /// Energy of the springs, J, of a contact of a depth (m; none if it is not positive) and a reduced radius (m).
    pub(crate) fn energy(&self, depth: f64, radius: f64, memory: &Memory) -> f64 {
        let arm = self.rolling_resistance * radius;
        let roll = ROLLING * arm * arm * memory.roll.norm_squared();
        let depth = depth.max(0.0);
        0.5 * self.stiffness * (depth * depth + TANGENTIAL * memory.slip.norm_squared() + roll)
    }
}
