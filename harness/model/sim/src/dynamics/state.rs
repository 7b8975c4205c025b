//! What of a vehicle changes from step to step.

use super::design::{Design, Track};
use super::facets::FacetPatches;
use super::obstacles::ObstaclePatches;
use crate::powertrain::{Drive, Load};
use crate::soil::{Footprint, TRACK, WHEEL};
use crate::tyre::{Clearance, Patch};
use crate::{Quat, V3};
use vb_vehicle::VehicleSpec;

/// All that the next step depends on, beside the ground.
#[derive(Clone)]
pub(crate) struct State {
    pub(crate) body: Body,
    pub(crate) steering: SteeringState,
    /// Front to back, left before right.
    pub(super) wheels: Vec<Wheel>,
    /// What each wheel's contacts remember.
    pub(super) contacts: Vec<Contacts>,
    /// Left and right, or none.
    pub(super) belts: Vec<Belt>,
    pub(super) drive: Drive,
}

/// The motion of the chassis.
#[derive(Clone, Copy)]
pub(crate) struct Body {
    /// The position of the chassis' centre of mass, m.
    pub(crate) x_world: V3,
    /// The attitude: the rotation from body axes to world axes.
    pub(crate) q: Quat,
    /// The velocity of the chassis' centre of mass over the ground, m/s.
    pub(crate) v_world: V3,
    /// The angular velocity of the chassis, rad/s.
    pub(crate) w_world: V3,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct SteeringState {
    /// The command after the limits of rate and force, in [-1, 1].
    pub(crate) command: f64,
    /// How fast it changed in the last step, 1/s.
    pub(super) rate: f64,
    /// The generalised force of ground and obstacles on the command in the last step, N m.
    pub(super) load: f64,
    /// The work of the gears on the vehicle so far, J. Negative work is that of a load which drives them back.
    pub(super) work: f64,
    /// Steps so far in which the load exceeded the gears' force.
    pub(super) stalled: u64,
}

impl SteeringState {
    /// Takes note of the load (N m) in a step of `dt` (s) in which the command moved at a rate (1/s).
    pub(super) fn bear(&mut self, load: f64, rate: f64, dt: f64) {
        self.load = load;
        self.work -= load * rate * dt;
    }

    /// The numbers that the next step depends on.
    fn digest(&self) -> [f64; 3] {
        [self.command, self.rate, self.load]
    }
}

/// The motion of a wheel against the chassis.
#[derive(Clone, Copy, Default)]
pub(super) struct Wheel {
    /// The suspension travel, m, positive in compression.
    pub(super) travel: f64,
    /// m/s.
    pub(super) travel_rate: f64,
    /// The angular velocity about the axle, rad/s, positive rolling forward.
    pub(super) spin: f64,
}

/// What the contacts of a wheel remember from step to step.
#[derive(Clone)]
pub(super) struct Contacts {
    pub(super) ground: Patch,
    /// How deep the wheel was in the ground a step ago, m.
    pub(super) ground_depth: f64,
    pub(super) obstacles: ObstaclePatches,
    /// Steps so far in which the depth of a contact was limited. No state: it is counted for diagnostics.
    pub(super) held: u64,
    /// Of a hard wheel: its contacts with the ground, which then has no patch of its own.
    pub(super) facets: FacetPatches,
    /// No state: it saves work.
    pub(super) clearance: Clearance,
    /// None where the wheel is part of a track, which has one for all.
    pub(super) footprint: Option<Footprint<WHEEL>>,
}

/// The state of a track's belt.
#[derive(Clone)]
pub(super) struct Belt {
    /// Along its way, m/s; positive when it drives forward.
    pub(super) speed: f64,
    /// Length of its way in the last step, m.
    pub(super) length: f64,
    /// Between each wheel and the next, front to rear.
    pub(super) spans: Vec<Span>,
    pub(super) footprint: Footprint<TRACK>,
}

/// The state of a part of a belt between two wheels.
#[derive(Clone, Default)]
pub(super) struct Span {
    pub(super) ground: Patch,
    pub(super) obstacle: Patch,
    /// N, in the last step.
    pub(super) tension: f64,
    /// How far soil presses its middle inwards, m, and how fast, m/s.
    pub(super) sag: f64,
    pub(super) sag_rate: f64,
}

impl Body {
    /// At rest at the origin.
    fn at_rest() -> Self {
        Self { x_world: V3::zeros(), q: Quat::identity(), v_world: V3::zeros(), w_world: V3::zeros() }
    }

    /// Advances the pose with the velocities.
    pub(crate) fn move_on(&mut self, dt: f64) {
        self.x_world += self.v_world * dt;
        self.q = Quat::new_normalize((Quat::from_scaled_axis(self.w_world * dt) * self.q).into_inner());
    }
}

impl Contacts {
    fn new(footprint: Option<Footprint<WHEEL>>) -> Self {
        Self {
            ground: Patch::default(),
            ground_depth: 0.0,
            obstacles: ObstaclePatches::default(),
            held: 0,
            facets: FacetPatches::default(),
            clearance: Clearance::default(),
            footprint,
        }
    }

    /// The numbers that the next step depends on.
    fn digest(&self) -> impl Iterator<Item = f64> + '_ {
        let g = self.ground.deflection;
        [g[0], g[1], self.ground_depth]
            .into_iter()
            .chain(self.obstacles.digest())
            .chain(self.facets.digest())
            .chain(self.footprint.iter().flat_map(Footprint::digest))
    }
}

impl Belt {
    pub(super) fn new(track: &Track, soil_resolution: f64) -> Self {
        let half = 0.5 * track.spec.thickness;
        let mut belt = Self {
            speed: 0.0,
            length: 0.0,
            spans: vec![Span::default(); track.count() - 1],
            footprint: Footprint::track(track.reach, track.near, half, track.width, soil_resolution),
        };
        belt.reset(track);
        belt
    }

    /// At rest, without forces.
    pub(super) fn reset(&mut self, track: &Track) {
        self.speed = 0.0;
        self.length = track.length;
        self.spans.fill(Span { tension: track.spec.tension, ..Span::default() });
    }

    /// The numbers that the next step depends on, beside those of the wheels.
    fn digest(&self) -> impl Iterator<Item = f64> + '_ {
        let spans = self.spans.iter().flat_map(|s| {
            let (g, o) = (s.ground.deflection, s.obstacle.deflection);
            [g[0], g[1], o[0], o[1], s.tension, s.sag, s.sag_rate]
        });
        [self.speed, self.length].into_iter().chain(spans).chain(self.footprint.digest())
    }
}

impl State {
    /// At rest at the origin with all wheels at design height, on soil that is remembered at a resolution, m.
    pub(super) fn new(design: &Design, spec: &VehicleSpec, soil_resolution: f64) -> Self {
        let footprint = |i: usize| {
            let tyre = spec.tyre_of(&spec.axles[i / 2]);
            spec.tracks.is_none().then(|| Footprint::wheel(tyre.radius(), tyre.width(), soil_resolution))
        };
        let load = super::design::sprockets(spec).unwrap_or_else(|| Load::wheels(spec));
        Self {
            body: Body::at_rest(),
            steering: SteeringState::default(),
            wheels: vec![Wheel::default(); design.corners.len()],
            contacts: (0..design.corners.len()).map(|i| Contacts::new(footprint(i))).collect(),
            belts: design.tracks.iter().map(|t| Belt::new(t, soil_resolution)).collect(),
            drive: Drive::new(&load),
        }
    }

    /// All numbers that the next step depends on, beside the pose and velocities of the chassis.
    pub(super) fn inner(&self) -> impl Iterator<Item = f64> + '_ {
        let wheels = self.wheels.iter().zip(&self.contacts);
        let wheels =
            wheels.flat_map(|(w, c)| [w.travel, w.travel_rate, w.spin].into_iter().chain(c.digest()));
        let belts = self.belts.iter().flat_map(Belt::digest);
        wheels.chain(self.steering.digest()).chain(self.drive.inner_state()).chain(belts)
    }
}
