//! The equations of motion: forces at the corners, elimination of the corners, one 6 × 6 solve, integration.
//!
//! Notation: the chassis' centre of mass has position x, velocity v, the body attitude q and angular velocity w, all
//! in the world frame. A corner is a point mass at its hub that moves along the suspension's curve; the upright's
//! rotation enters through the virtual work of the contact moment. Eliminating the corner's travel gives its
//! articulated inertia M − M t tᵀ M / (tᵀ M t) (Featherstone, Rigid Body Dynamics Algorithms, 2008, eq. 7.23), here
//! with a 3 × 3 mass since corners have no rotational inertia of their own beside spin.

use crate::collision::{OBSTACLE_FRICTION, Obstacles, WheelShape};
use crate::powertrain::Drive;
use crate::spec::{Damper, Spring, Stops, Suspension, VehicleSpec};
use crate::state::Controls;
use crate::tyre::{Brush, BrushLaw, Contact, Envelope};
use crate::{GRAVITY, M3, Quat, SuspensionTable, V3};
use nalgebra::{Matrix6, Vector6};
use vb_world::{Heightfield, Semantics};

/// What the wheels stand on.
pub(crate) struct Ground<'a> {
    pub(crate) heightfield: &'a Heightfield,
    pub(crate) semantics: &'a Semantics,
    pub(crate) obstacles: &'a Obstacles,
}

/// One wheel with its suspension.
#[derive(Clone)]
struct Corner {
    table: SuspensionTable,
    /// +1 left, −1 right.
    side: f64,
    /// The axle's reference point relative to the chassis' centre of mass, body axes.
    mount: V3,
    mass: f64,
    spin_inertia: f64,
    brake_torque: f64,
    steered: bool,
    driven: bool,
    spring: Spring,
    damper: Damper,
    stops: Stops,
    // State.
    travel: f64,
    travel_rate: f64,
    spin: f64,
    ground_brush: Brush,
    obstacle_brush: Brush,
    /// Normal force of the last step, N.
    load: f64,
}

/// What a step computes for a corner before the elimination.
#[derive(Clone, Copy)]
struct Forces {
    /// Hub relative to the centre of mass, world axes.
    arm: V3,
    /// ∂hub/∂travel, world axes.
    tangent: V3,
    axis: V3,
    tilt: V3,
    strut: f64,
    strut_rate: f64,
    /// Contact force and its moment about the hub, less what spins the wheel.
    force: V3,
    moment: V3,
    /// Moment about the axle.
    spin_moment: f64,
    /// Mass of the hub and the implicit damping of the tyre.
    inertia: M3,
}

/// The moving vehicle.
#[derive(Clone)]
pub(crate) struct Vehicle {
    mass: f64,
    inertia: V3,
    envelope: Envelope,
    law: BrushLaw,
    tyre: crate::TyreSpec,
    steering_rate: f64,
    corners: Vec<Corner>,
    drive: Drive,
    forces: Vec<Forces>,
    spins: Vec<f64>,
    pub(crate) x: V3,
    pub(crate) q: Quat,
    pub(crate) v: V3,
    pub(crate) w: V3,
    pub(crate) steering: f64,
}

fn skew(r: &V3) -> M3 {
    M3::new(0.0, -r.z, r.y, r.z, 0.0, -r.x, -r.y, r.x, 0.0)
}

impl Vehicle {
    pub(crate) fn new(spec: &VehicleSpec, tables: Vec<SuspensionTable>) -> Self {
        let com = V3::from(spec.chassis.com);
        let drive = Drive::new(spec);
        let mut corners = Vec::new();
        for (i, (axle, table)) in spec.axles.iter().zip(tables).enumerate() {
            let Suspension::DoubleWishbone { spring, damper, stops, .. } = &axle.suspension;
            for side in [1.0, -1.0] {
                corners.push(Corner {
                    table: table.clone(),
                    side,
                    mount: V3::from(axle.position) - com,
                    mass: axle.unsprung_mass,
                    spin_inertia: axle.spin_inertia,
                    brake_torque: axle.brake_torque,
                    steered: axle.steered,
                    driven: drive.is_driven(2 * i),
                    spring: *spring,
                    damper: *damper,
                    stops: *stops,
                    travel: 0.0,
                    travel_rate: 0.0,
                    spin: 0.0,
                    ground_brush: Brush::default(),
                    obstacle_brush: Brush::default(),
                    load: 0.0,
                });
            }
        }
        Self {
            mass: spec.chassis.mass,
            inertia: V3::from(spec.chassis.inertia),
            envelope: Envelope::new(&spec.tyre),
            law: BrushLaw::new(&spec.tyre),
            tyre: spec.tyre,
            steering_rate: spec.steering.rate,
            forces: Vec::with_capacity(corners.len()),
            spins: vec![0.0; corners.len()],
            corners,
            drive,
            x: V3::zeros(),
            q: Quat::identity(),
            v: V3::zeros(),
            w: V3::zeros(),
            steering: 0.0,
        }
    }

    /// Mass, moments of inertia and centre of mass of the whole vehicle at design height, relative to the chassis'
    /// centre of mass.
    pub(crate) fn composite(&self) -> (f64, V3, V3) {
        let parts: Vec<(f64, V3)> =
            self.corners.iter().map(|c| (c.mass, c.mount + c.table.at(0.0, 0.0, c.side).hub)).collect();
        let mass = self.mass + parts.iter().map(|p| p.0).sum::<f64>();
        let com = parts.iter().map(|(m, r)| r * *m).sum::<V3>() / mass;
        let about =
            |m: f64, r: V3| V3::new(r.y * r.y + r.z * r.z, r.x * r.x + r.z * r.z, r.x * r.x + r.y * r.y) * m;
        let inertia =
            self.inertia + about(self.mass, -com) + parts.iter().map(|&(m, r)| about(m, r - com)).sum::<V3>();
        (mass, inertia, com)
    }

    pub(crate) fn wheel_count(&self) -> usize {
        self.corners.len()
    }

    /// (spin, travel, normal force) of a wheel.
    pub(crate) fn wheel(&self, i: usize) -> (f64, f64, f64) {
        let c = &self.corners[i];
        (c.spin, c.travel, c.load)
    }

    /// All numbers that the next step depends on, beside the pose and velocities of the chassis.
    pub(crate) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        let corners = self.corners.iter().flat_map(|c| {
            let (g, o) = (c.ground_brush.deflection, c.obstacle_brush.deflection);
            [c.travel, c.travel_rate, c.spin, g[0], g[1], o[0], o[1]]
        });
        corners.chain([self.steering, self.drive.gear() as f64])
    }

    /// Positions and axle directions of the wheels at their present travel.
    pub(crate) fn hubs(&self) -> impl Iterator<Item = (V3, V3)> + '_ {
        self.corners.iter().map(|c| {
            let p = c.table.at(c.travel, 0.0, c.side);
            (self.x + self.q * (c.mount + p.hub), self.q * p.axis)
        })
    }

    pub(crate) fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    /// Advances velocities, travels and spins by `dt`; the pose of the chassis is left to [`Self::move_on`] or to
    /// the contact solver.
    pub(crate) fn accelerate(
        &mut self,
        controls: Controls,
        ground: &Ground<'_>,
        wheel: &WheelShape,
        dt: f64,
    ) {
        let change =
            (controls.steering - self.steering).clamp(-dt * self.steering_rate, dt * self.steering_rate);
        self.steering += change;
        let turn = *self.q.to_rotation_matrix().matrix();
        self.corner_forces(&turn, change / dt, ground, wheel, dt);
        let axle_torques = self.spin_wheels(controls, dt);
        self.solve(&turn, &axle_torques, dt);
    }

    fn corner_forces(
        &mut self,
        turn: &M3,
        steer_rate: f64,
        ground: &Ground<'_>,
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
            if let Some(contact) = self.envelope.query(ground.heightfield, &hub, &axis) {
                let friction = ground.semantics.friction_at(contact.point.x, contact.point.y);
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

    /// Advances the spins; returns the torque of driveline and brake on each wheel, which the chassis reacts.
    fn spin_wheels(&mut self, controls: Controls, dt: f64) -> [f64; MAX_WHEELS] {
        for (s, c) in self.spins.iter_mut().zip(&self.corners) {
            *s = c.spin;
        }
        let common = self.drive.common_inertia;
        let drive = self.drive.torques(&self.spins, controls.throttle, dt);
        let mut torque = [0.0; MAX_WHEELS];
        let mut held = [false; MAX_WHEELS];
        let (mut sum, mut inertia, mut count) = (0.0, 0.0, 0.0);
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            let shared = if c.driven { common } else { 0.0 };
            let free = f.spin_moment + drive[i];
            // The brake's torque is that which stops the wheel in this step, as far as it reaches.
            let cap = controls.brake * c.brake_torque;
            let stop = -c.spin * (c.spin_inertia + shared) / dt - free;
            held[i] = cap > 0.0 && stop.abs() <= cap;
            let brake = stop.clamp(-cap, cap);
            torque[i] = drive[i] + brake;
            if c.driven {
                sum += free + brake;
                inertia += c.spin_inertia + common;
                count += 1.0;
            }
        }
        let common_moment = if count > 0.0 { common * sum / inertia } else { 0.0 };
        for (i, (c, f)) in self.corners.iter_mut().zip(&self.forces).enumerate() {
            let shared = if c.driven { common_moment } else { 0.0 };
            c.spin += dt * (f.spin_moment + torque[i] - shared) / c.spin_inertia;
            if held[i] {
                c.spin = 0.0;
            }
        }
        torque
    }

    fn solve(&mut self, turn: &M3, axle_torques: &[f64; MAX_WHEELS], dt: f64) {
        let inertia = turn * M3::from_diagonal(&self.inertia) * turn.transpose();
        let gravity = V3::new(0.0, 0.0, -GRAVITY);
        let mut angular = inertia;
        let mut coupling = M3::zeros();
        let mut linear = M3::from_diagonal_element(self.mass);
        let mut moment = -self.w.cross(&(inertia * self.w));
        let mut force = gravity * self.mass;
        // Per corner: M t, tᵀMt with the dampers' implicit part, right-hand side.
        let mut reduced = [(V3::zeros(), 0.0, 0.0); MAX_WHEELS];
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            let spring = c.spring.stiffness * (c.spring.free_length - f.strut) * f.strut_rate;
            let damping = c.damper.coefficient * f.strut_rate * f.strut_rate;
            let mut along = spring - damping * c.travel_rate;
            if c.travel > c.stops.jounce {
                along -= c.stops.stiffness * (c.travel - c.stops.jounce);
            } else if c.travel < c.stops.rebound {
                along -= c.stops.stiffness * (c.travel - c.stops.rebound);
            }
            let bias = self.w.cross(&self.w.cross(&f.arm)) + self.w.cross(&f.tangent) * (2.0 * c.travel_rate);
            let applied = f.force + gravity * c.mass;
            let mt = f.inertia * f.tangent;
            let d = mt.dot(&f.tangent) + dt * damping;
            let rhs = f.tangent.dot(&applied) + f.tilt.dot(&f.moment) + along - mt.dot(&bias);
            let articulated = f.inertia - mt * mt.transpose() / d;
            let passed = applied - f.inertia * bias - mt * (rhs / d);
            let s = skew(&f.arm);
            let sm = s * articulated;
            angular -= sm * s;
            coupling += sm;
            linear += articulated;
            force += passed;
            // The driveline reacts on the chassis; a spinning wheel resists being turned.
            let gyroscopic = self.w.cross(&(f.axis * (c.spin_inertia * c.spin)));
            moment += f.arm.cross(&passed) + f.moment - f.axis * axle_torques[i] - gyroscopic;
            reduced[i] = (mt, d, rhs);
        }
        let mut a = Matrix6::zeros();
        a.fixed_view_mut::<3, 3>(0, 0).copy_from(&angular);
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling);
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&coupling.transpose());
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&linear);
        let mut b = Vector6::zeros();
        b.fixed_rows_mut::<3>(0).copy_from(&moment);
        b.fixed_rows_mut::<3>(3).copy_from(&force);
        // Positive definite for every finite state; if it isn't, the state isn't finite, which the caller reports.
        let solution = a.cholesky().map_or_else(|| Vector6::repeat(f64::NAN), |c| c.solve(&b));
        let alpha = solution.fixed_rows::<3>(0).into_owned();
        let acceleration = solution.fixed_rows::<3>(3).into_owned();
        for (i, (c, f)) in self.corners.iter_mut().zip(&self.forces).enumerate() {
            let (mt, d, rhs) = reduced[i];
            let hub = acceleration + alpha.cross(&f.arm);
            c.travel_rate += dt * (rhs - mt.dot(&hub)) / d;
            c.travel += dt * c.travel_rate;
        }
        self.v += acceleration * dt;
        self.w += alpha * dt;
    }

    /// Advances the pose of the chassis with its velocities.
    pub(crate) fn move_on(&mut self, dt: f64) {
        self.x += self.v * dt;
        self.q = Quat::new_normalize((Quat::from_scaled_axis(self.w * dt) * self.q).into_inner());
    }

    /// Kinetic energy seen from a frame that moves with `frame`, and energy of the springs, J.
    #[cfg(test)]
    fn energy(&self, frame: V3) -> f64 {
        let local = self.q.inverse() * self.w;
        let mut e = 0.5 * self.mass * (self.v - frame).norm_squared()
            + 0.5 * local.dot(&self.inertia.component_mul(&local));
        for c in &self.corners {
            let p = c.table.at(c.travel, 0.0, c.side);
            let arm = self.q * (c.mount + p.hub);
            let v = self.v - frame + self.w.cross(&arm) + self.q * p.hub_rate * c.travel_rate;
            let stretch = p.strut - c.spring.free_length;
            e += 0.5 * c.mass * v.norm_squared() + 0.5 * c.spring.stiffness * stretch * stretch;
        }
        e
    }
}

/// Greatest number of wheels.
pub(crate) const MAX_WHEELS: usize = 16;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Suspension;

    #[test]
    fn in_free_fall_without_dampers_energy_stays() {
        let mut spec =
            VehicleSpec::parse(include_str!("../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap();
        for axle in &mut spec.axles {
            let Suspension::DoubleWishbone { damper, stops, .. } = &mut axle.suspension;
            damper.coefficient = 0.0;
            // Out of reach: the stops' energy isn't in the sum.
            (stops.jounce, stops.rebound) = (0.5, -0.5);
        }
        let tables = spec.axles.iter().map(|a| {
            let rack = if a.steered { spec.steering.rack_travel } else { 0.0 };
            SuspensionTable::solve(&a.suspension, rack).unwrap()
        });
        let mut vehicle = Vehicle::new(&spec, tables.collect());
        vehicle.x.z = 100.0;
        vehicle.w = V3::new(0.9, -0.5, 0.7);
        for (i, c) in vehicle.corners.iter_mut().enumerate() {
            c.travel = if i < 2 { 0.03 } else { 0.0 };
        }
        let world = vb_world::Heightfield::flat(3, 3, 1.0, 0.0);
        let semantics = Semantics {
            rows: 1,
            cols: 1,
            patch: 2.0,
            classes: vec![vb_world::TerrainClass::Clay],
            friction: vec![0.6],
        };
        let empty = Obstacles::none();
        let ground = Ground { heightfield: &world, semantics: &semantics, obstacles: &empty };
        let wheel = WheelShape::new(&spec.tyre);
        let before = vehicle.energy(V3::zeros());
        let mut worst: f64 = 0.0;
        for k in 1..=1500 {
            vehicle.accelerate(Controls::default(), &ground, &wheel, 1e-3);
            vehicle.move_on(1e-3);
            // In a frame that falls along, gravity does no work.
            let frame = V3::new(0.0, 0.0, -GRAVITY * 1e-3 * f64::from(k));
            worst = worst.max((vehicle.energy(frame) - before).abs());
        }
        assert!(vehicle.x.z < 90.0, "it falls");
        // Symplectic Euler: an error of the order of the step, no drift.
        assert!(worst < 0.02 * before, "{worst} J of {before} J");
    }
}
