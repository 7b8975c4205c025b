//! The equations of motion: forces at the corners, elimination of the corners, one 6 × 6 solve, integration.
//!
//! Notation: the chassis' centre of mass has position x and velocity v, the body attitude q and angular velocity w, all
//! in the world frame (`x_world` and so on, where a name stands alone). A corner is a point mass at its hub that moves along the suspension's curve; the upright's
//! rotation enters through the virtual work of the contact moment. Eliminating the corner's travel gives its
//! articulated inertia M − M t tᵀ M / (tᵀ M t) (Featherstone, Rigid Body Dynamics Algorithms, 2008, eq. 7.23), here
//! with a 3 × 3 mass since corners have no rotational inertia of their own beside spin. A beam is three such points
//! that move with two travels (`beam`).
//!
//! What stays as it is (`design`), what changes from step to step (`state`) and what the stages of a step hand on are kept
//! apart. The stages are functions that say what they take and what they give, in the order in which [`Vehicle::accelerate`]
//! calls them:
//!
//! | stage | takes | gives |
//! |---|---|---|
//! | `steering` | what the driver asks, load of the last step | the steering command and its rate |
//! | `kinematics` | design, motion of chassis and wheels, steering | placements of wheels and beams |
//! | `contact` | placements, ground | forces on the wheels, with what contacts remember and the soil brought up to date |
//! | `granular` | placements, granular beds | the same forces with those of the beds, forces on belts and hull, with the grains advanced |
//! | `track` | placements, ground, forces on the wheels | the same forces with those of the belts, thrusts |
//! | `drive` | spins, forces or thrusts, what the driver asks | new spins, torques, with engine and gearbox advanced |
//! | `solve` (with `beam`) | placements, forces, new spins, torques | what is added to the velocities |
//! | `integrate` | all of what was given | the state after the step |

mod beam;
mod contact;
mod design;
mod drive;
mod energy;
mod facets;
mod granular;
mod ground;
mod integrate;
mod kinematics;
mod obstacles;
#[cfg(feature = "rig")]
mod rig;
mod solve;
mod stand;
mod state;
mod steering;
mod track;

pub(crate) use ground::Ground;
pub use stand::WheelStand;

use crate::V3;
use crate::powertrain::DriveState;
use crate::state::{Controls, Gear, WheelState};
use crate::tyre::Envelope;
use contact::Forces;
use design::{Design, Guide};
use drive::Shafts;
use kinematics::{BeamPlacement, Kinematics, Placement};
use state::{Body, State};
use std::sync::Arc;
use steering::Steering;
use track::Laid;
use vb_vehicle::GRAVITY;
use vb_vehicle::VehicleSpec;
use vb_vehicle::kinematics::AxleKinematics;

#[derive(Clone)]
pub(crate) struct Vehicle {
    design: Arc<Design>,
    state: State,
    /// What the last step computed on its way, for those who look at the vehicle.
    last: Given,
    /// The acceleration of gravity, m/s².
    pub(crate) gravity_world: V3,
}

/// What the stages of a step give that is more than a few numbers. Each step fills it anew, so that steps take no memory.
#[derive(Clone)]
struct Given {
    /// Of the wheels.
    placements: Vec<Placement>,
    beams: Vec<BeamPlacement>,
    /// How each track's belt lies.
    laid: Vec<Laid>,
    /// On each wheel.
    forces: Vec<Forces>,
}

impl Vehicle {
    /// The acceleration of gravity in world axes, m/s², where no test rig has changed it.
    pub(crate) const GRAVITY: V3 = V3::new(0.0, 0.0, -GRAVITY);

    pub(crate) fn new(spec: &VehicleSpec, axles: &[AxleKinematics], soil_resolution: f64) -> Self {
        let design = Design::new(spec, axles);
        Self {
            state: State::new(&design, spec, soil_resolution),
            last: Given {
                placements: vec![Placement::NOWHERE; design.corners.len()],
                beams: vec![BeamPlacement::default(); design.beams.len()],
                laid: design.tracks.iter().map(Laid::new).collect(),
                forces: vec![Forces::default(); design.corners.len()],
            },
            design: Arc::new(design),
            gravity_world: Self::GRAVITY,
        }
    }

    /// The bodies of the vehicle that meet grains of a mean radius (m).
    pub(crate) fn tools(&self, spec: &VehicleSpec, grain: f64) -> Vec<vb_granular::Tool> {
        granular::tools(&self.design, spec, grain)
    }

    pub(crate) fn body(&self) -> &Body {
        &self.state.body
    }

    pub(crate) fn body_mut(&mut self) -> &mut Body {
        &mut self.state.body
    }

    /// The steering command after the limits of rate and force, in [-1, 1].
    pub(crate) fn steering(&self) -> f64 {
        self.state.steering.command
    }

    /// Mass, moments of inertia and centre of mass of the whole vehicle at design height, relative to the chassis'
    /// centre of mass.
    pub(crate) fn composite(&self) -> (f64, V3, V3) {
        self.design.composite()
    }

    /// The distance from the chassis' centre of mass within which wheels and belts lie at design height, m.
    pub(crate) fn bound(&self) -> f64 {
        self.design.bound
    }

    pub(crate) fn wheel_count(&self) -> usize {
        self.design.corners.len()
    }

    pub(crate) fn wheel(&self, i: usize) -> WheelState {
        let (w, f) = (&self.state.wheels[i], &self.last.forces[i]);
        WheelState {
            speed: w.spin * self.design.corners[i].gearing,
            deflection: w.travel,
            load: f.load,
            sinkage: f.sinkage,
        }
    }

    pub(crate) fn drive_state(&self) -> DriveState {
        self.state.drive.state()
    }

    pub(crate) fn gear(&self) -> Gear {
        self.state.drive.gear()
    }

    /// All numbers that the next step depends on, beside the pose and velocities of the chassis.
    pub(crate) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        self.state.inner()
    }

    /// Positions and axle directions of the wheels at their present travel.
    pub(crate) fn hubs(&self) -> impl Iterator<Item = (V3, V3)> + '_ {
        let body = &self.state.body;
        self.design.corners.iter().enumerate().map(|(i, c)| {
            let (hub, axis) = self.design.guided(c, self.travels(i), 0.0);
            (body.x_world + body.q * (c.mount + hub), body.q * axis)
        })
    }

    /// Travels of the axle of a wheel, left and right.
    fn travels(&self, i: usize) -> [f64; 2] {
        let wheels = &self.state.wheels;
        match self.design.corners[i].guide {
            Guide::Beam(b) => [0, 1].map(|k| wheels[self.design.beams[b].left + k].travel),
            _ => [wheels[i].travel; 2],
        }
    }

    /// The outline of every wheel's tyre.
    pub(crate) fn envelopes(&self) -> impl Iterator<Item = &Envelope> + '_ {
        self.design.corners.iter().map(|c| self.design.envelope(c))
    }

    /// Kinetic energy and energy of height less the work that engine and steering have done so far, J. Energy held by
    /// springs and tyres is not in it.
    pub(crate) fn energy_balance(&self) -> f64 {
        energy::balance(
            &self.design,
            &self.state,
            &self.last.placements,
            &self.last.beams,
            &self.gravity_world,
        )
    }

    /// The weight of the vehicle, N, and the radius of a wheel of its first tyre, m.
    pub(crate) fn weight_and_radius(&self) -> [f64; 2] {
        [self.composite().0 * GRAVITY, self.design.tyres[0].envelope().radius()]
    }

    /// Wheel-steps so far in which the depth of a contact was limited.
    pub(crate) fn held(&self) -> u64 {
        self.state.contacts.iter().map(|c| c.held).sum()
    }

    /// Steps so far in which the load on the steering exceeded its force.
    pub(crate) fn stalled(&self) -> u64 {
        self.state.steering.stalled
    }

    /// Starts to count for diagnostics from here.
    pub(crate) fn count_anew(&mut self) {
        self.state.contacts.iter_mut().for_each(|c| c.held = 0);
        self.state.steering.stalled = 0;
    }

    /// Advances velocities, travels and spins by `dt`; the pose of the chassis is left to [`Body::move_on`] or to
    /// the contact solver.
    pub(crate) fn accelerate(&mut self, controls: Controls, ground: &mut Ground<'_>, dt: f64) {
        let Self { design, state, last, gravity_world } = self;
        let Given { placements, beams, laid, forces } = last;
        let steering = Steering::follow(controls.steering, design, &state.steering, dt);
        let kinematics = Kinematics::place(design, &state.body, &state.wheels, steering, placements, beams);
        track::carry_shear(&design.tracks, &state.belts, &mut state.contacts, dt);
        contact::touch_wheels(design, &kinematics, ground, &mut state.contacts, forces, dt);
        let on_hull = granular::press(design, &kinematics, ground.beds, &state.belts, laid, forces, dt);
        let shafts = if design.tracks.is_empty() {
            Shafts::of_wheels(design, &state.wheels, forces, controls.brake)
        } else {
            track::pull_tracks(design, &kinematics, ground, &mut state.belts, laid, forces, dt);
            let thrusts = [0, 1].map(|i| laid[i].total_thrust());
            Shafts::of_sprockets(design, &state.belts, thrusts, forces, controls.brake, steering.command)
        };
        let load = contact::steering_load(design, &kinematics, forces);
        state.steering.bear(load, steering.rate, dt);
        let demand = drive::demand(design, &state.body, state.drive.gear(), &controls, steering.command);
        let driven = shafts.advance(&design.tracks, &mut state.drive, &demand, dt);
        let increments = solve::solve(design, &kinematics, forces, on_hull, &driven, gravity_world, dt);
        integrate::integrate(state, steering, &driven, &increments, dt);
    }
}

#[cfg(test)]
mod tests;
