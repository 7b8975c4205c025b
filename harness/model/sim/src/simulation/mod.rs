//! One vehicle in one world, from the start pose on.

mod place;
#[cfg(feature = "rig")]
mod rig;

#[cfg(feature = "rig")]
pub use rig::Rig;

use crate::collision::{ChassisContacts, Footing, Obstacles, Surroundings};
use crate::dynamics::{Ground, Vehicle};
use crate::error::SimError;
use crate::granular::Beds;
use crate::monitor::{EnergyMonitor, PERIOD};
use crate::soil::{SoilGround, SoilSet};
use crate::state::{Controls, VehicleState};
use crate::tyre::Envelope;
use crate::{V3, normal_of};
use std::sync::Arc;
use vb_vehicle::{MAX_WHEELS, VehicleModel};
use vb_world::{Pose2, World};

/// The settings by which a simulation is stepped.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SimOptions {
    /// The fixed time step, s.
    pub step: f64,
    /// The longest time that the vehicle may take to come to rest before the clock starts, s.
    pub settle_time: f64,
    pub start: Start,
    /// The side of the cells in which the soil remembers ruts, at scale 1, m. It is scaled with the world.
    pub soil_resolution: f64,
}

/// The way in which a vehicle comes to the ground at the start.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Start {
    /// The vehicle is set down with brakes on and comes to rest before the clock starts.
    Settled,
    /// The clock starts with the vehicle level and at rest in the air, and it falls under the planner's commands.
    Dropped {
        /// The height of the reference point above the ground there, m. It is greater where the vehicle would otherwise
        /// touch the ground; obstacles aren't looked for.
        height: f64,
        /// The number by which the start's coordinates are divided to find the place whose ground height is taken: 1,
        /// or how far the raster is stretched from which that height is read.
        stretch: f64,
    },
}

impl Default for SimOptions {
    /// 1 ms, at which the results of a rugged drive have converged (docs/physics.md), 3 s, and the 0.1 m of the
    /// original.
    fn default() -> Self {
        Self { step: 1e-3, settle_time: 3.0, start: Start::Settled, soil_resolution: 0.1 }
    }
}

/// Bounds of a valid state: speed, m/s and rad/s, and depth of a hub below the ground at full scale, m. The depth in soil is
/// unbounded for a vehicle with `hull_passes_soil`, as in Chrono.
const FASTEST: f64 = 200.0;
const DEEPEST: f64 = 1.5;
/// Steps between two looks for obstacles in reach.
const LOOK_AROUND: u64 = 16;
/// How far around the vehicle obstacles are looked for beside the way until the next look, m: for what it turns by until then, and
/// for wheels that have moved in their springs.
const AROUND: f64 = 0.2;
/// Vertical part of the vehicle's up direction below which it lies on its side or roof.
const LYING: f64 = 0.5;
/// How near the middle of a wheel's face comes to the ground on which the wheel stands, in radii of the wheel.
const FACE_NEAR: f64 = 0.1;
/// Sine of the wheel's lean from the ground's normal up to which its face never meets soil, however deep the wheel has sunk.
const STRAIGHT: f64 = 0.5;
/// How near the hull comes to ground or obstacles at full scale before rapier is asked, m: beyond the 0.02 m at which it
/// begins to see contacts.
const HULL_NEAR: f64 = 0.025;

/// Counts and maxima since the start of a simulation. They don't change it and are no part of its state.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Diagnostics {
    /// The maximum of the mechanical energy that neither engine nor steering supplied, J: the level of a leaky bucket that
    /// the rises of kinetic energy and energy of height fill. Springs and tyres that relax show in it, so it isn't zero.
    pub energy_surplus: f64,
    /// The surplus (J) above which the simulation counts as diverged: it lifts the vehicle by the radius of a wheel.
    pub energy_allowed: f64,
    /// The fraction of wheel-steps in which a contact was deeper than the motion of the wheel explains, so that its depth
    /// was limited.
    pub held: f64,
    /// The fraction of steps in which the contact solver ran for the hull.
    pub hull_contact: f64,
    /// The fraction of steps in which the load on the steering gear exceeded its force.
    pub steering_stalled: f64,
}

/// A simulation of one vehicle in one world. A clone is a snapshot: it goes on exactly as the original does.
#[derive(Clone)]
pub struct Simulation {
    world: Arc<World>,
    options: SimOptions,
    vehicle: Vehicle,
    reference: V3,
    obstacles: Obstacles,
    soil: SoilGround,
    beds: Beds,
    chassis: ChassisContacts,
    steps: u64,
    /// Steps in which the contact solver ran.
    contact_steps: u64,
    energy: EnergyMonitor,
    /// Steps between two looks at the energy.
    look_at_energy: u64,
}

impl Simulation {
    /// Puts the vehicle at `start` (world frame) on the ground, with brakes on, and lets it come to rest, or leaves it
    /// in the air, as the options say. The clock then starts at 0. A world as an `Arc` will do where few simulations are made
    /// in it.
    ///
    /// # Errors
    /// Returns [`SimError::NoSoil`] for a class of the world that the set has no soil for, [`SimError::Grains`] for grains of a bed
    /// that are larger than a wheel, [`SimError::Bed`] for a bed that can't be filled, and [`SimError::Diverged`] if the state becomes one that no vehicle can have.
    pub fn new(
        surroundings: impl Into<Surroundings>,
        model: &VehicleModel,
        soils: &SoilSet,
        start: Pose2,
        options: SimOptions,
    ) -> Result<Self, SimError> {
        let surroundings = surroundings.into();
        let world = surroundings.world().clone();
        let spec = model.spec();
        let soil_resolution = options.soil_resolution * world.scale;
        let soil = SoilGround::new(&world, soils, soil_resolution)?;
        let vehicle = Vehicle::new(spec, model.axles(), soil_resolution);
        let (mass, inertia, com) = vehicle.composite();
        let chassis = ChassisContacts::new(spec, &surroundings, mass, inertia, com, options.step);
        let radius = vehicle.envelopes().map(Envelope::radius).fold(f64::INFINITY, f64::min);
        let tools = |grain: f64| vehicle.tools(spec, grain);
        let beds = Beds::new(&world, surroundings.packings(), tools, radius, options.step)?;
        let mut simulation = Self {
            obstacles: Obstacles::new(&surroundings),
            soil,
            beds,
            reference: -V3::from(spec.chassis.com),
            look_at_energy: ((PERIOD / options.step).round() as u64).max(1),
            energy: EnergyMonitor::new(vehicle.weight_and_radius()),
            world,
            options,
            vehicle,
            chassis,
            steps: 0,
            contact_steps: 0,
        };
        match options.start {
            Start::Settled => {
                simulation.place(start);
                simulation.settle()?;
            }
            Start::Dropped { height, stretch } => {
                simulation.place_above(start, height, stretch);
                simulation.check()?;
            }
        }
        Ok(simulation)
    }

    /// Tells the hull what is below it.
    fn pass_over_soil(&mut self) {
        let passes = self.chassis.passes_soil();
        if self.soil.is_empty() || !(passes || self.chassis.has_faces()) {
            return;
        }
        let body = self.vehicle.body();
        let mut stand = [false; MAX_WHEELS];
        if (body.q * V3::z()).z > LYING {
            let wheels = self.vehicle.hubs().zip(self.vehicle.envelopes());
            for (stands, ((hub, axis), envelope)) in stand.iter_mut().zip(wheels) {
                let under = self.world.heightfield.at(hub.x, hub.y);
                let normal = normal_of([under.dzdx, under.dzdy]);
                let lean = axis.dot(&normal).abs();
                let face = (hub.z - under.z) * normal.z - envelope.half_width() * lean;
                let has_soil = self.soil.soil_at(hub.x, hub.y).is_some();
                let own_forces = passes || has_soil || self.soil.is_granular(hub.x, hub.y);
                *stands = own_forces && (lean < STRAIGHT || face > FACE_NEAR * envelope.radius());
            }
        }
        self.chassis.pass_over(passes && self.soil.soil_at(body.x_world.x, body.x_world.y).is_some(), stand);
    }

    fn step(&mut self, controls: Controls) {
        let near = !self.begin_step(controls) && self.look();
        self.finish_step(near);
    }

    /// The first part of a step: forces change the velocities. It tells whether the hull is known to be clear of ground and
    /// obstacles at the end of the step. If it isn't, the second part, [`Self::look`], finds out; the third,
    /// [`Self::finish_step`], has to be told. A step in parts is the same as one of [`Self::advance`], which also looks for a
    /// state that no vehicle can have; they are apart for those who step many vehicles at a time and gather the few that
    /// are near to something.
    #[must_use]
    pub fn begin_step(&mut self, controls: Controls) -> bool {
        let dt = self.options.step;
        if self.steps.is_multiple_of(LOOK_AROUND) {
            self.look_around();
        }
        let mut ground = Ground {
            soil: &mut self.soil,
            heightfield: &self.world.heightfield,
            semantics: &self.world.semantics,
            obstacles: &self.obstacles,
            beds: &mut self.beds,
        };
        self.vehicle.accelerate(controls, &mut ground, dt);
        self.pass_over_soil();
        let body = self.vehicle.body();
        self.chassis.is_known_clear(&self.obstacles, &body.x_world, &body.q, self.hull_margin())
    }

    /// Notes which obstacles and heaps hull, wheels and belts may come near to until the next look.
    fn look_around(&mut self) {
        let body = self.vehicle.body();
        let bound = self.chassis.bound().max(self.vehicle.bound());
        let way = body.v_world.norm() * self.options.step * LOOK_AROUND as f64;
        self.obstacles.look_around(&body.x_world, bound + AROUND + way);
        if self.soil.has_soil() && !self.chassis.passes_soil() {
            self.chassis.look_for_heaps(&self.soil, &body.x_world, &body.q);
        }
    }

    /// The second part of a step, where the hull isn't known to be clear: whether it may touch ground or obstacles at the end of
    /// the step.
    #[must_use]
    pub fn look(&mut self) -> bool {
        let (margin, body) = (self.hull_margin(), self.vehicle.body());
        self.chassis.may_touch(&self.world.heightfield, &self.obstacles, &body.x_world, &body.q, margin)
    }

    /// How near the hull may be to something without touching it within this step, m.
    fn hull_margin(&self) -> f64 {
        let body = self.vehicle.body();
        let way = (body.v_world.norm() + body.w_world.norm() * self.chassis.bound()) * self.options.step;
        HULL_NEAR * self.world.scale + way + self.chassis.heaps()
    }

    /// The last part of a step: the pose follows the velocities, by way of the contact solver where the hull is `near`
    /// something.
    pub fn finish_step(&mut self, near: bool) {
        if near {
            let body = self.vehicle.body_mut();
            let footing = Footing { semantics: &self.world.semantics, soil: &self.soil };
            self.chassis.resolve(
                &footing,
                &mut body.x_world,
                &mut body.q,
                &mut body.v_world,
                &mut body.w_world,
            );
            self.contact_steps += 1;
        } else {
            self.vehicle.body_mut().move_on(self.options.step);
        }
        self.steps += 1;
        if self.steps.is_multiple_of(self.look_at_energy) {
            // Beyond the edge the ground is made up.
            let at = self.vehicle.body().x_world;
            if self.world.heightfield.contains(at.x, at.y) {
                self.energy.push(self.vehicle.energy_balance());
            } else {
                self.energy.forget();
            }
        }
    }

    /// Advances the simulation by `steps` steps with constant controls.
    ///
    /// # Errors
    /// Returns [`SimError::Diverged`] if the state becomes one that no vehicle can have.
    pub fn advance(&mut self, controls: Controls, steps: u64) -> Result<(), SimError> {
        self.advance_watched(controls, steps, |_| ())
    }

    /// Advances the simulation like [`Self::advance`], and shows it to `watch` after each step.
    ///
    /// # Errors
    /// Returns [`SimError::Diverged`] if the state becomes one that no vehicle can have.
    pub fn advance_watched(
        &mut self,
        controls: Controls,
        steps: u64,
        mut watch: impl FnMut(&Self),
    ) -> Result<(), SimError> {
        for _ in 0..steps {
            self.step(controls);
            watch(self);
            // The state to look at is the first that is wrong.
            if self.energy.exceeded() {
                break;
            }
        }
        self.check()
    }

    /// Looks whether the state is one that a vehicle can have.
    ///
    /// # Errors
    /// Returns [`SimError::Diverged`] if it isn't.
    pub fn check(&self) -> Result<(), SimError> {
        let (vehicle, body) = (&self.vehicle, self.vehicle.body());
        let finite = |a: &V3| a.iter().all(|x| x.is_finite());
        // Beyond the edge the ground is made up, and a vehicle may fall for as long as the rules let it.
        let ground = &self.world.heightfield;
        let inside = ground.contains(body.x_world.x, body.x_world.y);
        let deepest = DEEPEST * self.world.scale;
        let swallows = |hub: &V3| self.chassis.passes_soil() && self.soil.soil_at(hub.x, hub.y).is_some();
        let deep = |hub: &V3| {
            ground.contains(hub.x, hub.y) && ground.height(hub.x, hub.y) > hub.z + deepest && !swallows(hub)
        };
        let what = if !finite(&body.x_world) || !body.q.coords.iter().all(|x| x.is_finite()) {
            "a pose that is not finite"
        } else if !finite(&body.v_world) || !finite(&body.w_world) {
            "a velocity that is not finite"
        } else if !vehicle.inner_state().all(f64::is_finite) {
            "a wheel's state that is not finite"
        } else if inside && (body.v_world.norm() > FASTEST || body.w_world.norm() > FASTEST) {
            "a speed beyond 200 m/s or rad/s"
        } else if vehicle.hubs().any(|(hub, _)| deep(&hub)) {
            "a wheel deep below the ground"
        } else if self.energy.exceeded() {
            "mechanical energy that nothing supplied"
        } else {
            return Ok(());
        };
        Err(SimError::Diverged { time: self.time(), what, state: self.describe() })
    }

    /// The state in one line, every number in full, for messages about a failure.
    fn describe(&self) -> String {
        let (vehicle, body) = (&self.vehicle, self.vehicle.body());
        let wheels: Vec<String> = (0..vehicle.wheel_count())
            .map(|i| {
                let w = vehicle.wheel(i);
                format!("[{:?}, {:?}, {:?}, {:?}]", w.speed, w.deflection, w.load, w.sinkage)
            })
            .collect();
        format!(
            "x {:?}, q {:?}, v {:?}, w {:?}, steering {:?}, wheels (spin, travel, load, sinkage) {}",
            body.x_world.as_slice(),
            body.q.coords.as_slice(),
            body.v_world.as_slice(),
            body.w_world.as_slice(),
            vehicle.steering(),
            wheels.join(" ")
        )
    }

    /// The simulated time since the start, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.options.step
    }

    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The number of steps since the start in which the hull was near enough to something for the contact solver to
    /// run.
    #[must_use]
    pub fn contact_steps(&self) -> u64 {
        self.contact_steps
    }

    /// Counts and maxima since the start that show how the simulation itself did.
    #[must_use]
    pub fn diagnostics(&self) -> Diagnostics {
        let fraction = |count: u64, of: u64| if of > 0 { count as f64 / of as f64 } else { 0.0 };
        Diagnostics {
            energy_surplus: self.energy.surplus(),
            energy_allowed: self.energy.allowed(),
            held: fraction(self.vehicle.held(), self.steps * self.vehicle.wheel_count() as u64),
            hull_contact: fraction(self.contact_steps, self.steps),
            steering_stalled: fraction(self.vehicle.stalled(), self.steps),
        }
    }

    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The cells of the ground that have yielded: the position (x, y) of the centre, the depth of the rut below its rim
    /// and the height of the heap, all in m. What lies under a wheel appears when the wheel has moved on.
    pub fn ruts(&self) -> impl Iterator<Item = ([f64; 2], f64, f64)> + '_ {
        self.soil
            .grid
            .cells()
            .filter(|(_, c)| c.plastic > 0.0 || c.raised > 0.0)
            .map(|(p, c)| (p, c.plastic, c.raised))
    }

    /// The grains of the world's granular beds: centres in world axes, m, and radii, m.
    pub fn grains(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        self.beds.grains()
    }

    /// By how much the ground at (x, y) is higher than it was at first, m: the height of the heap less the depth of the
    /// rut. It is `None` outside the world, and where nothing has touched the soil for some metres around.
    #[must_use]
    pub fn soil_change(&self, x: f64, y: f64) -> Option<f64> {
        self.soil.grid.touched(x, y).map(|c| c.raised - c.plastic)
    }

    /// The side of the cells in which the soil remembers ruts, m.
    #[must_use]
    pub fn soil_resolution(&self) -> f64 {
        self.soil.grid.resolution()
    }

    #[must_use]
    pub fn state(&self) -> VehicleState {
        let (vehicle, body) = (&self.vehicle, self.vehicle.body());
        let arm = body.q * self.reference;
        let inverse = body.q.inverse();
        VehicleState {
            time: self.time(),
            position: body.x_world + arm,
            attitude: body.q,
            velocity_body: inverse * (body.v_world + body.w_world.cross(&arm)),
            angular_velocity_body: inverse * body.w_world,
            wheels: (0..vehicle.wheel_count()).map(|i| vehicle.wheel(i)).collect(),
            steering: vehicle.steering(),
            gear: vehicle.gear(),
            engine_speed: vehicle.drive_state().engine_speed,
        }
    }

    /// The velocity of a point of the chassis, given in its frame (m), in world axes, m/s.
    #[must_use]
    pub fn velocity_of(&self, point: [f64; 3]) -> [f64; 3] {
        let body = self.vehicle.body();
        (body.v_world + body.w_world.cross(&(body.q * (V3::from(point) + self.reference)))).into()
    }

    /// A vector in world axes along the axes of the body.
    #[must_use]
    pub fn in_body_axes(&self, vector: [f64; 3]) -> [f64; 3] {
        (self.vehicle.body().q.inverse() * V3::from(vector)).into()
    }

    /// The vertical component of the body's upward axis: the cosine of the tilt.
    #[must_use]
    pub fn upward(&self) -> f64 {
        (self.vehicle.body().q * V3::z()).z
    }

    /// The number of wheels on which ground or obstacles press.
    #[must_use]
    pub fn loaded_wheels(&self) -> usize {
        (0..self.vehicle.wheel_count()).filter(|i| self.vehicle.wheel(*i).load > 0.0).count()
    }

    /// What the engine and its shafts did in the last step.
    #[must_use]
    pub fn drive(&self) -> crate::DriveState {
        self.vehicle.drive_state()
    }

    /// Feeds the state of the vehicle into `sink`, in a fixed order: its pose, its velocities, the states of its wheels,
    /// footprints, tracks and driveline, and a gravity that a test rig has changed. Ruts that it has left and grains are not in it;
    /// two drives in which they differ differ in it as soon as a wheel meets one.
    pub fn visit_state(&self, mut sink: impl FnMut(f64)) {
        let (vehicle, body) = (&self.vehicle, self.vehicle.body());
        body.x_world
            .iter()
            .chain(body.q.coords.iter())
            .chain(body.v_world.iter())
            .chain(body.w_world.iter())
            .for_each(|&x| sink(x));
        vehicle.inner_state().for_each(&mut sink);
        if vehicle.gravity_world != Vehicle::GRAVITY {
            vehicle.gravity_world.iter().for_each(|&x| sink(x));
        }
    }
}
