//! Forces of ground and obstacles on the wheels.

use super::{Forces, Ground, Vehicle};
use crate::collision::{OBSTACLE_FRICTION, WheelShape};
use crate::soil::{BLEND, Under, WheelMotion};
use crate::tyre::{Contact, Motion, Patch, Tyre};
use crate::{M3, V3};

impl Vehicle {
    pub(super) fn corner_forces(
        &mut self,
        turn: &M3,
        steer_rate: f64,
        ground: &mut Ground<'_>,
        wheel: &WheelShape,
        dt: f64,
    ) {
        self.forces.clear();
        let look = ground.obstacles.any_near();
        for c in &mut self.corners {
            let command = if c.steered { self.steering } else { 0.0 };
            let pose = c.table.at(c.travel, command, c.side);
            let arm = turn * (c.mount + pose.hub);
            let axis = turn * pose.axis;
            let tangent = turn * pose.hub_rate;
            let tilt = turn * pose.tilt_rate;
            let hub = self.x + arm;
            let mut hub_velocity = self.v + self.w.cross(&arm) + tangent * c.travel_rate;
            if c.steered {
                hub_velocity += turn * (pose.hub_steer_rate * steer_rate);
            }
            let mut f = Forces {
                arm,
                tangent,
                axis,
                tilt,
                strut: pose.strut,
                strut_rate: pose.strut_rate,
                force: V3::zeros(),
                moment: V3::zeros(),
                spin_moment: 0.0,
                inertia: M3::from_diagonal_element(c.mass),
            };
            let rotation = self.w + tilt * c.travel_rate + axis * c.spin;
            let motion = Motion { hub, velocity: hub_velocity, rotation, axis, spin: c.spin };
            c.load = 0.0;
            c.sinkage = 0.0;
            let envelope = self.tyre.envelope();
            let reach = envelope.radius();
            let under =
                if ground.soil.is_empty() { Under::Rigid } else { ground.soil.under(hub.x, hub.y, reach) };
            let contact = match under {
                Under::Rigid => envelope.query(ground.heightfield, &hub, &axis),
                Under::Soil(_) => None,
                Under::Mixed => {
                    let rigid = |x, y| 1.0 - ground.soil.share(x, y, BLEND);
                    envelope.query_where(ground.heightfield, &hub, &axis, rigid)
                }
            };
            if let Some(contact) = contact {
                let (x, y) = (contact.point.x, contact.point.y);
                let friction = match under {
                    Under::Mixed => ground.semantics.rigid_friction_around(x, y, reach),
                    _ => ground.semantics.friction_at(x, y),
                };
                c.load += motion.tyre_force(&self.tyre, &contact, friction, &mut c.ground_patch, &mut f, dt);
            } else {
                c.ground_patch = Patch::default();
            }
            if !ground.soil.is_empty() {
                let motion = WheelMotion { hub, velocity: hub_velocity, rotation, axis };
                if let Some(s) = c.footprint.step(ground.soil, ground.heightfield, under, &motion, dt) {
                    c.load += s.load;
                    c.sinkage = s.sinkage;
                    let about_axle = axis.dot(&s.moment);
                    f.force += s.force;
                    f.moment += s.moment - axis * about_axle;
                    f.spin_moment += about_axle;
                    f.inertia += s.inertia;
                }
            }
            if look && let Some(contact) = ground.obstacles.wheel_contact(wheel, &hub, &axis) {
                c.load += motion.tyre_force(
                    &self.tyre,
                    &contact,
                    OBSTACLE_FRICTION,
                    &mut c.obstacle_patch,
                    &mut f,
                    dt,
                );
            } else {
                c.obstacle_patch = Patch::default();
            }
            self.forces.push(f);
        }
    }
}

impl Motion {
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
