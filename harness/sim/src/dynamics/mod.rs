//! The equations of motion: forces at the corners, elimination of the corners, one 6 × 6 solve, integration.
//!
//! Notation: the chassis' centre of mass has position x, velocity v, the body attitude q and angular velocity w, all
//! in the world frame. A corner is a point mass at its hub that moves along the suspension's curve; the upright's
//! rotation enters through the virtual work of the contact moment. Eliminating the corner's travel gives its
//! articulated inertia M − M t tᵀ M / (tᵀ M t) (Featherstone, Rigid Body Dynamics Algorithms, 2008, eq. 7.23), here
//! with a 3 × 3 mass since corners have no rotational inertia of their own beside spin.

mod solve;
mod spin;
mod wheel;

use crate::collision::{Obstacles, WheelShape};
use crate::powertrain::Drive;
use crate::soil::{Footprint, SoilGround};
use crate::spec::{Damper, Spring, Stops, Suspension, VehicleSpec};
use crate::state::{Controls, WheelState};
use crate::tyre::{Brush, BrushLaw, Envelope};
use crate::{GRAVITY, M3, Quat, SuspensionTable, V3};
use vb_world::{Heightfield, Semantics};

/// What the wheels stand on.
pub(crate) struct Ground<'a> {
    pub(crate) soil: &'a mut SoilGround,
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
    footprint: Footprint,
    /// Greatest depth of the wheel below undisturbed soil in the last step, m.
    sinkage: f64,
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
    /// World axes, m/s².
    pub(crate) gravity: V3,
    pub(crate) x: V3,
    pub(crate) q: Quat,
    pub(crate) v: V3,
    pub(crate) w: V3,
    pub(crate) steering: f64,
}

impl Vehicle {
    pub(crate) fn new(spec: &VehicleSpec, tables: Vec<SuspensionTable>, soil_pitch: f64) -> Self {
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
                    footprint: Footprint::new(spec.tyre.radius, spec.tyre.width, soil_pitch),
                    sinkage: 0.0,
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
            gravity: V3::new(0.0, 0.0, -GRAVITY),
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

    /// The state of a wheel.
    pub(crate) fn wheel(&self, i: usize) -> WheelState {
        let c = &self.corners[i];
        WheelState { speed: c.spin, deflection: c.travel, load: c.load, sinkage: c.sinkage }
    }

    /// All numbers that the next step depends on, beside the pose and velocities of the chassis.
    pub(crate) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        let corners = self.corners.iter().flat_map(|c| {
            let (g, o) = (c.ground_brush.deflection, c.obstacle_brush.deflection);
            let motion = [c.travel, c.travel_rate, c.spin, g[0], g[1], o[0], o[1]];
            motion.into_iter().chain(c.footprint.digest())
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

    /// Brings all wheels to design height, at rest and without tyre forces.
    pub(crate) fn reset_wheels(&mut self) {
        for c in &mut self.corners {
            (c.travel, c.travel_rate, c.spin, c.load) = (0.0, 0.0, 0.0, 0.0);
            (c.ground_brush, c.obstacle_brush) = (Brush::default(), Brush::default());
        }
    }

    /// Advances velocities, travels and spins by `dt`; the pose of the chassis is left to [`Self::move_on`] or to
    /// the contact solver.
    pub(crate) fn accelerate(
        &mut self,
        controls: Controls,
        ground: &mut Ground<'_>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Suspension;

    #[test]
    fn in_free_fall_without_dampers_energy_stays() {
        let mut spec =
            VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap();
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
        let mut vehicle = Vehicle::new(&spec, tables.collect(), 0.1);
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
            soil: vb_world::SoilLevels::default(),
        };
        let empty = Obstacles::none();
        let mut soil = SoilGround::none();
        let mut ground =
            Ground { soil: &mut soil, heightfield: &world, semantics: &semantics, obstacles: &empty };
        let wheel = WheelShape::new(&spec.tyre);
        let before = vehicle.energy(V3::zeros());
        let mut worst: f64 = 0.0;
        for k in 1..=1500 {
            vehicle.accelerate(Controls::default(), &mut ground, &wheel, 1e-3);
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
