//! Forces of ground and obstacles on the wheels.

use super::{Forces, Ground, Vehicle};
use crate::collision::{OBSTACLE_FRICTION, WheelShape};
use crate::soil::{BLEND, Under, WheelMotion};
use crate::tyre::{Brush, BrushLaw, Contact};
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
            let reach = self.tyre.radius;
            let under =
                if ground.soil.is_empty() { Under::Rigid } else { ground.soil.under(hub.x, hub.y, reach) };
            let contact = match under {
                Under::Rigid => self.envelope.query(ground.heightfield, &hub, &axis),
                Under::Soil(_) => None,
                Under::Mixed => {
                    let rigid = |x, y| 1.0 - ground.soil.share(x, y, BLEND);
                    self.envelope.query_where(ground.heightfield, &hub, &axis, rigid)
                }
            };
            if let Some(contact) = contact {
                let (x, y) = (contact.point.x, contact.point.y);
                let friction = match under {
                    Under::Mixed => ground.semantics.rigid_friction_around(x, y, reach),
                    _ => ground.semantics.friction_at(x, y),
                };
                let friction = friction.min(self.tyre.friction);
                c.load += motion.tyre_force(
                    &self.tyre,
                    &self.law,
                    &contact,
                    friction,
                    &mut c.ground_brush,
                    &mut f,
                    dt,
                );
            } else {
                c.ground_brush = Brush::default();
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
                let friction = OBSTACLE_FRICTION.min(self.tyre.friction);
                c.load += motion.tyre_force(
                    &self.tyre,
                    &self.law,
                    &contact,
                    friction,
                    &mut c.obstacle_brush,
                    &mut f,
                    dt,
                );
            } else {
                c.obstacle_brush = Brush::default();
            }
            self.forces.push(f);
        }
    }
}

/// How a wheel moves.
struct Motion {
    hub: V3,
    velocity: V3,
    rotation: V3,
    axis: V3,
    spin: f64,
}

impl Motion {
    /// Adds the force of one contact to `f`; returns the normal force.
    #[allow(clippy::too_many_arguments, reason = "tyre, contact and wheel are three things")]
    fn tyre_force(
        &self,
        tyre: &crate::TyreSpec,
        law: &BrushLaw,
        contact: &Contact,
        friction: f64,
        brush: &mut Brush,
        f: &mut Forces,
        dt: f64,
    ) -> f64 {
        let n = contact.normal;
        let arm = contact.point - self.hub;
        let normal_speed = self.velocity.dot(&n);
        let load = tyre.vertical_stiffness * contact.depth - tyre.vertical_damping * normal_speed;
        if load <= 0.0 {
            brush.deflection = [0.0; 2];
            return 0.0;
        }
        // A contact at the wheel's side has no rolling direction; any one in its plane will do.
        let along = self
            .axis
            .cross(&n)
            .try_normalize(0.05)
            .unwrap_or_else(|| n.cross(&V3::z()).try_normalize(1e-6).unwrap_or_else(V3::x));
        let across = n.cross(&along);
        // The tread rolls on a radius between the loaded and the free one (Rill: one third of the deflection).
        let lever = arm.norm();
        let rolling_arm = if lever > 0.0 { arm * ((lever + 2.0 / 3.0 * contact.depth) / lever) } else { arm };
        let patch = self.velocity + self.rotation.cross(&rolling_arm);
        let rolling_speed = (self.axis.cross(&rolling_arm) * self.spin).norm();
        let sliding = [patch.dot(&along), patch.dot(&across)];
        let t = brush.advance(law, sliding, rolling_speed, load, friction, dt);
        let tangential = along * t[0] + across * t[1];
        let total = tangential + n * load;
        let moment = arm.cross(&total);
        f.force += total;
        f.moment += moment - self.axis * self.axis.dot(&moment);
        // The pressure acts through the axle; only friction and rolling resistance turn the wheel.
        let resistance = tyre.rolling_resistance * load * lever * (self.spin * lever / 0.1).clamp(-1.0, 1.0);
        f.spin_moment += self.axis.dot(&rolling_arm.cross(&tangential)) - resistance;
        f.inertia += n * n.transpose() * (dt * tyre.vertical_damping);
        load
    }
}
