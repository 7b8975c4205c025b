//! Forces of ground and obstacles on the wheels.

use super::{Forces, Ground, Vehicle};
use crate::collision::{OBSTACLE_FRICTION, WheelShape};
use crate::soil::Under;
use crate::tyre::{Contact, Patch, Tyre, WheelMotion};

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
            let rigid = |x, y| 1.0 - ground.soil.share(x, y, ground.soil.blend);
            let before = std::mem::take(&mut c.facets);
            let contact = match under {
                Under::Rigid | Under::Mixed if let Some(facets) = &facets => {
                    for (facet, contact) in facets.iter() {
                        let (x, y) = (contact.point.x, contact.point.y);
                        let (friction, share) = match under {
                            Under::Mixed => {
                                (ground.semantics.rigid_friction_around(x, y, reach), rigid(x, y))
                            }
                            _ => (ground.semantics.friction_at(x, y), 1.0),
                        };
                        if share <= 0.0 {
                            continue;
                        }
                        let contact = Contact { depth: contact.depth * share, ..*contact };
                        let mut patch = before.before(*facet, &contact.normal);
                        c.load += motion.tyre_force(tyre, &contact, friction, &mut patch, f, dt);
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
                let (x, y) = (contact.point.x, contact.point.y);
                let friction = match under {
                    Under::Mixed => ground.semantics.rigid_friction_around(x, y, reach),
                    _ => ground.semantics.friction_at(x, y),
                };
                c.load += motion.tyre_force(tyre, &contact, friction, &mut c.ground_patch, f, dt);
            } else {
                c.ground_patch = Patch::default();
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
                c.load += motion.tyre_force(tyre, &contact, OBSTACLE_FRICTION, &mut c.obstacle_patch, f, dt);
            } else {
                c.obstacle_patch = Patch::default();
            }
        }
    }
}

impl WheelMotion {
    /// Adds the force of one contact to `f`; returns the normal force.
    fn tyre_force(
        &self,
        tyre: &Tyre,
        contact: &Contact,
        friction: f64,
        patch: &mut Patch,
        f: &mut Forces,
        dt: f64,
    ) -> f64 {
        let Some(r) = tyre.react(self, contact, friction, patch, dt) else {
            return 0.0;
        };
        f.force += r.force;
        f.moment += r.moment;
        f.spin_moment += r.spin_moment;
        f.inertia += contact.normal * contact.normal.transpose() * (dt * tyre.damping());
        r.load
    }
}
