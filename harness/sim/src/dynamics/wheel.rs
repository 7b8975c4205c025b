//! Forces of ground and obstacles on the wheels.

use super::{Forces, Ground, Vehicle};
use crate::collision::{OBSTACLE_FRICTION, WheelShape};
use crate::soil::Under;
use crate::tyre::{Contact, Patch, Tyre, WheelMotion};

/// How fast a contact may deepen over the speeds at which the wheel approaches the ground there and passes it: more than
/// any smooth ground does to a rolling wheel. Along a contact's true normal it would be 1 and 0.
const DEEPENING: [f64; 2] = [2.0, 0.5];
/// How fast it may deepen under a wheel at rest, in radii of the wheel, 1/s.
const CREEP: f64 = 0.1;

impl Vehicle {
    pub(super) fn corner_forces(&mut self, ground: &mut Ground<'_>, wheels: &[WheelShape], dt: f64) {
        let look = ground.obstacles.any_near();
        for (c, f) in self.corners.iter_mut().zip(&mut self.forces) {
            let (hub, axis) = (self.x + f.arm, f.axis);
            let motion = WheelMotion { hub, velocity: f.velocity, rotation: f.rotation, axis, spin: c.spin };
            c.load = 0.0;
            c.sinkage = 0.0;
            let tyre = &self.tyres[c.tyre];
            let envelope = tyre.envelope();
            let reach = envelope.radius();
            let under =
                if ground.soil.is_empty() { Under::Rigid } else { ground.soil.under(hub.x, hub.y, reach) };
            let facets = match (&under, wheels[c.tyre].hard()) {
                // A track's wheels stand on its belt.
                (Under::Rigid | Under::Mixed, Some(wheel)) if c.footprint.is_some() => {
                    wheel.facets(ground.heightfield, &hub, &axis, tyre.reach())
                }
                _ => None,
            };
            let rigid = |x, y| 1.0 - ground.soil.fraction(x, y, ground.soil.blend);
            let before = std::mem::take(&mut c.facets);
            let contact = match under {
                Under::Rigid | Under::Mixed if let Some(facets) = &facets => {
                    for (facet, contact) in facets.iter() {
                        let (x, y) = (contact.point.x, contact.point.y);
                        let (friction, fraction) = match under {
                            Under::Mixed => {
                                (ground.semantics.rigid_friction_around(x, y, reach), rigid(x, y))
                            }
                            _ => (ground.semantics.friction_at(x, y), 1.0),
                        };
                        if fraction <= 0.0 {
                            continue;
                        }
                        let mut patch = before.before(*facet, &contact.normal);
                        c.load += motion.tyre_force(tyre, contact, friction, fraction, &mut patch, f, dt);
                        c.facets.push(*facet, contact.normal, patch);
                    }
                    None
                }
                Under::Rigid => {
                    envelope.query_where(ground.heightfield, &hub, &axis, &mut c.clearance, |_, _| 1.0)
                }
                Under::Soil(_) => None,
                Under::Mixed => {
                    envelope.query_where(ground.heightfield, &hub, &axis, &mut c.clearance, rigid)
                }
            };
            if let Some(contact) = contact {
                let contact = motion.held(&contact, &mut c.ground_depth, reach, dt);
                let (x, y) = (contact.point.x, contact.point.y);
                let friction = match under {
                    Under::Mixed => ground.semantics.rigid_friction_around(x, y, reach),
                    _ => ground.semantics.friction_at(x, y),
                };
                c.load += motion.tyre_force(tyre, &contact, friction, 1.0, &mut c.ground_patch, f, dt);
            } else {
                c.ground_patch = Patch::default();
                c.ground_depth = 0.0;
            }
            if !ground.soil.is_empty()
                && let Some(footprint) = &mut c.footprint
                && let Some(s) = footprint.step(ground.soil, ground.heightfield, under, &motion, dt)
            {
                c.load += s.load;
                c.sinkage = s.sinkage;
                let about_axle = axis.dot(&s.moment);
                f.force += s.force;
                f.moment += s.moment - axis * about_axle;
                f.spin_moment += about_axle;
                f.inertia += s.inertia;
            }
            if look && let Some(contact) = ground.obstacles.wheel_contact(&wheels[c.tyre], &hub, &axis) {
                let contact = motion.held(&contact, &mut c.obstacle_depth, reach, dt);
                let patch = &mut c.obstacle_patch;
                c.load += motion.tyre_force(tyre, &contact, OBSTACLE_FRICTION, 1.0, patch, f, dt);
            } else {
                c.obstacle_patch = Patch::default();
                c.obstacle_depth = 0.0;
            }
        }
    }
}

impl WheelMotion {
    /// Adds the force of one contact to `f`; returns the normal force, N.
    ///
    /// `fraction`, 0 to 1, is how much of the ground there is rigid. It takes its part of the whole reaction and not of the
    /// depth, since a hard wheel that slides feels the ground across a small gap too, which a smaller depth would close.
    #[expect(clippy::too_many_arguments, reason = "one contact: its tyre, its ground and what it leaves")]
    fn tyre_force(
        &self,
        tyre: &Tyre,
        contact: &Contact,
        friction: f64,
        fraction: f64,
        patch: &mut Patch,
        f: &mut Forces,
        dt: f64,
    ) -> f64 {
        let Some(r) = tyre.react(self, contact, friction, patch, dt) else {
            return 0.0;
        };
        f.force += r.force * fraction;
        f.moment += r.moment * fraction;
        f.spin_moment += r.spin_moment * fraction;
        f.inertia += contact.normal * contact.normal.transpose() * (dt * tyre.damping() * fraction);
        r.load * fraction
    }

    /// The contact, no deeper than the wheel's motion can have made it since it was `before` (m) deep `dt` (s) ago.
    ///
    /// Heights and radii tell how deep a wheel is, but not how it got there. Where a wheel lies on its flank in a hollow,
    /// or stands with one side in a wall, what counts as its lowest point may change from one side to the other, and a wheel
    /// that was suddenly half a metre deep would throw the vehicle with energy that nothing supplied. It is let out slowly
    /// instead.
    pub(super) fn held(&self, contact: &Contact, before: &mut f64, radius: f64, dt: f64) -> Contact {
        let turning = self.rotation - self.axis * self.spin;
        let velocity = self.velocity + turning.cross(&(contact.point - self.hub));
        let approach = -velocity.dot(&contact.normal);
        let passing = (velocity + contact.normal * approach).norm();
        let most =
            *before + dt * (DEEPENING[0] * approach.max(0.0) + DEEPENING[1] * passing + CREEP * radius);
        *before = contact.depth.min(most);
        Contact { depth: *before, ..*contact }
    }
}
