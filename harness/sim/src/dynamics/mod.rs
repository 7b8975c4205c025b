//! The equations of motion: forces at the corners, elimination of the corners, one 6 × 6 solve, integration.
//!
//! Notation: the chassis' centre of mass has position x, velocity v, the body attitude q and angular velocity w, all
//! in the world frame. A corner is a point mass at its hub that moves along the suspension's curve; the upright's
//! rotation enters through the virtual work of the contact moment. Eliminating the corner's travel gives its
//! articulated inertia M − M t tᵀ M / (tᵀ M t) (Featherstone, Rigid Body Dynamics Algorithms, 2008, eq. 7.23), here
//! with a 3 × 3 mass since corners have no rotational inertia of their own beside spin. A beam is three such points
//! that move with two travels (`beam`).

mod beam;
mod energy;
mod facets;
mod pose;
mod solve;
mod spin;
mod stand;
mod track;
mod wheel;

use crate::collision::{Obstacles, WheelShape};
use crate::powertrain::{Drive, Load};
use crate::soil::{Footprint, SoilGround, WHEEL};
use crate::state::{Controls, VehicleState, WheelState};
use crate::tyre::{Clearance, Envelope, Patch, Tyre};
use crate::{M3, Quat, V3};
use beam::Beam;
use facets::FacetPatches;
pub use stand::WheelStand;
use std::sync::Arc;
use track::Track;
use vb_vehicle::GRAVITY;
use vb_vehicle::kinematics::{AxleKinematics, CornerTable, Element, Side, elements, moves};
use vb_vehicle::{
    VehicleSpec,
    powertrain::Governor,
    suspension::{AntiRoll, Stops},
};
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
    guide: Guide,
    side: Side,
    /// Number of its tyre.
    tyre: usize,
    /// The axle's reference point relative to the chassis' centre of mass, body axes.
    mount: V3,
    mass: f64,
    spin_inertia: f64,
    /// Speed of the wheel over its spin: more than 1 within a belt, whose outer face has the spin.
    gearing: f64,
    brake_torque: f64,
    steered: bool,
    /// Springs and dampers in the order of the tables.
    struts: Vec<Element>,
    stops: Option<Stops>,
    // State.
    travel: f64,
    travel_rate: f64,
    spin: f64,
    ground_patch: Patch,
    obstacle_patch: Patch,
    /// How deep the wheel was in the ground and in an obstacle a step ago, m.
    ground_depth: f64,
    obstacle_depth: f64,
    /// Of a hard wheel: its contacts with the ground, which then has no patch of its own.
    facets: FacetPatches,
    /// No state: it saves work.
    clearance: Clearance,
    /// None where the wheel is part of a track, which has one for all.
    footprint: Option<Footprint<WHEEL>>,
    /// Greatest depth of the wheel below undisturbed soil in the last step, m.
    sinkage: f64,
    /// Normal force of the last step, N.
    load: f64,
}

/// What guides a wheel.
#[derive(Clone)]
enum Guide {
    /// A linkage of its own.
    Table(Arc<CornerTable>),
    /// Fixed to the chassis.
    Mount(Arc<CornerTable>),
    /// The beam of this number.
    Beam(usize),
}

/// A bar between two wheels that are guided independently, of which the left one has this number.
#[derive(Clone, Copy)]
struct Bar {
    left: usize,
    stiffness: f64,
    damping: f64,
}

/// What a step computes for a corner before the elimination.
#[derive(Clone, Copy, Default)]
struct Forces {
    /// Hub relative to the centre of mass, world axes.
    arm: V3,
    /// ∂hub/∂travel, world axes.
    tangent: V3,
    /// Part of the hub's acceleration that comes from the bend of its path, world axes.
    bend: V3,
    axis: V3,
    tilt: V3,
    struts: [f64; 2],
    strut_rates: [f64; 2],
    bar: f64,
    bar_rate: f64,
    /// Velocity of the hub, steering included, and rotation of the wheel, spin included.
    velocity: V3,
    rotation: V3,
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
    resistance: Vec<[f64; 2]>,
    /// The vehicle's tyre first, then those of axles with their own.
    tyres: Vec<Tyre>,
    steering_rate: f64,
    corners: Vec<Corner>,
    beams: Vec<Beam>,
    /// Left and right, or none.
    tracks: Vec<Track>,
    bars: Vec<Bar>,
    drive: Drive,
    governor: Option<Governor>,
    /// The vehicle's reference point relative to the chassis' centre of mass, body axes.
    reference: V3,
    forces: Vec<Forces>,
    /// World axes, m/s².
    pub(crate) gravity: V3,
    pub(crate) x: V3,
    pub(crate) q: Quat,
    pub(crate) v: V3,
    pub(crate) w: V3,
    pub(crate) steering: f64,
}

impl Vehicle {
    pub(crate) fn new(spec: &VehicleSpec, axles: &[AxleKinematics], soil_resolution: f64) -> Self {
        let com = V3::from(spec.chassis.com);
        let drive = Drive::new(&track::sprockets(spec).unwrap_or_else(|| Load::wheels(spec)));
        let (mut corners, mut beams, mut bars) = (Vec::new(), Vec::new(), Vec::new());
        let mut tyres = vec![Tyre::new(&spec.tyre)];
        for (i, (axle, kinematics)) in spec.axles.iter().zip(axles).enumerate() {
            let suspension = &axle.suspension;
            let mount = V3::from(axle.position) - com;
            let tyre = axle.tyre.as_ref().map_or(0, |tyre| {
                tyres.push(Tyre::new(tyre));
                tyres.len() - 1
            });
            let (radius, width) = (spec.tyre_of(axle).radius(), spec.tyre_of(axle).width());
            let bar = match suspension.anti_roll {
                Some(AntiRoll::Travel { stiffness }) => (stiffness, 0.0),
                Some(AntiRoll::Bar { stiffness, damping, .. }) => (stiffness, damping),
                None => (0.0, 0.0),
            };
            if let (Some(kinematics), Some(beam)) = (kinematics.beam(), suspension.linkage.beam()) {
                beams.push(Beam::new(kinematics, beam, 2 * i, mount, &suspension.linkage, bar.0));
            } else if bar.0 > 0.0 {
                bars.push(Bar { left: 2 * i, stiffness: bar.0, damping: bar.1 });
            }
            for side in [Side::Left, Side::Right] {
                let guide = match kinematics.corner(side) {
                    Some(table) if moves(&suspension.linkage) => Guide::Table(table),
                    Some(table) => Guide::Mount(table),
                    None => Guide::Beam(beams.len() - 1),
                };
                corners.push(Corner {
                    guide,
                    side,
                    tyre,
                    mount,
                    mass: axle.unsprung_mass,
                    spin_inertia: axle.spin_inertia,
                    gearing: track::gearing(spec, axle),
                    brake_torque: axle.brake_torque,
                    steered: axle.steering.is_some(),
                    struts: elements(suspension),
                    stops: suspension.stops.clone(),
                    travel: 0.0,
                    travel_rate: 0.0,
                    spin: 0.0,
                    ground_patch: Patch::default(),
                    obstacle_patch: Patch::default(),
                    ground_depth: 0.0,
                    obstacle_depth: 0.0,
                    facets: FacetPatches::default(),
                    clearance: Clearance::default(),
                    footprint: spec
                        .tracks
                        .is_none()
                        .then(|| Footprint::wheel(radius, width, soil_resolution)),
                    sinkage: 0.0,
                    load: 0.0,
                });
            }
        }
        let mut vehicle = Self {
            mass: spec.chassis.mass,
            inertia: V3::from(spec.chassis.inertia),
            resistance: spec.chassis.resistance.clone(),
            tyres,
            steering_rate: spec.steering.rate,
            forces: vec![Forces::default(); corners.len()],
            corners,
            beams,
            tracks: Vec::new(),
            bars,
            drive,
            governor: spec.powertrain.governor,
            reference: -com,
            gravity: V3::new(0.0, 0.0, -GRAVITY),
            x: V3::zeros(),
            q: Quat::identity(),
            v: V3::zeros(),
            w: V3::zeros(),
            steering: 0.0,
        };
        let hubs: Vec<V3> =
            vehicle.corners.iter().map(|c| c.mount + vehicle.guided(c, [0.0; 2], 0.0).0).collect();
        vehicle.tracks = (0..2).filter_map(|side| Track::new(spec, side, &hubs, soil_resolution)).collect();
        vehicle
    }

    /// Mass, moments of inertia and centre of mass of the whole vehicle at design height, relative to the chassis'
    /// centre of mass.
    pub(crate) fn composite(&self) -> (f64, V3, V3) {
        let wheels = self.corners.iter().map(|c| (c.mass, c.mount + self.guided(c, [0.0; 2], 0.0).0));
        let beams = self.beams.iter().map(|b| (b.mass, b.mount + b.middle()));
        let parts: Vec<(f64, V3)> = wheels.chain(beams).collect();
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
        WheelState { speed: c.spin * c.gearing, deflection: c.travel, load: c.load, sinkage: c.sinkage }
    }

    pub(crate) fn drive_state(&self) -> crate::DriveState {
        self.drive.state()
    }

    /// The direction that is in.
    pub(crate) fn gear(&self) -> crate::Gear {
        self.drive.gear()
    }

    /// All numbers that the next step depends on, beside the pose and velocities of the chassis.
    pub(crate) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        let corners = self.corners.iter().flat_map(|c| {
            let (g, o) = (c.ground_patch.deflection, c.obstacle_patch.deflection);
            let depths = [c.ground_depth, c.obstacle_depth];
            let motion = [c.travel, c.travel_rate, c.spin, g[0], g[1], o[0], o[1]].into_iter().chain(depths);
            motion.chain(c.facets.digest()).chain(c.footprint.iter().flat_map(Footprint::digest))
        });
        let tracks = self.tracks.iter().flat_map(Track::digest);
        corners.chain([self.steering]).chain(self.drive.inner_state()).chain(tracks)
    }

    /// Positions and axle directions of the wheels at their present travel.
    pub(crate) fn hubs(&self) -> impl Iterator<Item = (V3, V3)> + '_ {
        self.corners.iter().map(|c| {
            let (hub, axis) = self.guided(c, self.travels(c), 0.0);
            (self.x + self.q * (c.mount + hub), self.q * axis)
        })
    }

    /// The outline of every wheel's tyre.
    pub(crate) fn envelopes(&self) -> impl Iterator<Item = &Envelope> + '_ {
        self.corners.iter().map(|c| self.tyres[c.tyre].envelope())
    }

    /// Brings all wheels to design height, at rest and without tyre forces.
    pub(crate) fn reset_wheels(&mut self) {
        for c in &mut self.corners {
            (c.travel, c.travel_rate, c.spin, c.load) = (0.0, 0.0, 0.0, 0.0);
            (c.ground_patch, c.obstacle_patch) = (Patch::default(), Patch::default());
            (c.ground_depth, c.obstacle_depth) = (0.0, 0.0);
            c.facets = FacetPatches::default();
        }
        self.tracks.iter_mut().for_each(Track::reset);
    }

    /// Gives the wheels speeds and travels, and puts steering, engine and gear as they are told.
    pub(crate) fn put_wheels(&mut self, state: &VehicleState, gear: usize) {
        for (c, wheel) in self.corners.iter_mut().zip(&state.wheels) {
            (c.travel, c.spin) = (wheel.deflection, wheel.speed / c.gearing);
            // However deep the wheels are there.
            (c.ground_depth, c.obstacle_depth) = (f64::MAX, f64::MAX);
        }
        self.steering = state.steering;
        self.drive.engage(state.gear, gear, state.engine_speed);
    }

    /// Advances velocities, travels and spins by `dt`; the pose of the chassis is left to [`Self::move_on`] or to
    /// the contact solver.
    pub(crate) fn accelerate(
        &mut self,
        controls: Controls,
        ground: &mut Ground<'_>,
        wheels: &[WheelShape],
        dt: f64,
    ) {
        let change =
            (controls.steering - self.steering).clamp(-dt * self.steering_rate, dt * self.steering_rate);
        self.steering += change;
        let turn = *self.q.to_rotation_matrix().matrix();
        self.place_wheels(&turn, change / dt);
        self.carry_shear(dt);
        self.corner_forces(ground, wheels, dt);
        let axle_torques = if self.tracks.is_empty() {
            self.spin_wheels(controls, dt)
        } else {
            self.track_forces(ground, &turn, dt);
            self.spin_tracks(controls, dt)
        };
        self.solve(&turn, &axle_torques, dt);
    }

    /// Advances the pose of the chassis with its velocities.
    pub(crate) fn move_on(&mut self, dt: f64) {
        self.x += self.v * dt;
        self.q = Quat::new_normalize((Quat::from_scaled_axis(self.w * dt) * self.q).into_inner());
    }
}

#[cfg(test)]
mod tests;
