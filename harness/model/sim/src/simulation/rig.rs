//! Test rigs.

use super::Simulation;
use crate::state::VehicleState;
use crate::{Quat, V3};

/// Interventions that no driver can make, for tests, validation and comparisons with records. The energy that they give
/// doesn't count as one that nothing supplied.
pub struct Rig<'a>(&'a mut Simulation);

impl Simulation {
    /// The test rig on which the vehicle stands.
    pub fn rig(&mut self) -> Rig<'_> {
        Rig(self)
    }
}

impl Rig<'_> {
    /// Turns the vehicle about its long axis by `roll` (rad, positive with the right side down) and lifts the centre of mass
    /// of its chassis to `height` (m) above the ground under it, at rest: for tests of rollovers.
    pub fn overturn(&mut self, roll: f64, height: f64) {
        let body = self.0.vehicle.body_mut();
        body.q *= Quat::from_axis_angle(&V3::x_axis(), roll);
        body.x_world.z = self.0.world.heightfield.height(body.x_world.x, body.x_world.y) + height;
        body.v_world = V3::zeros();
        body.w_world = V3::zeros();
        self.0.energy.forget();
    }

    /// Lifts the vehicle until its reference point is `height` (m) above the ground under it: level, at rest, with the
    /// wheels at design height. It serves drops and free fall.
    pub fn lift(&mut self, height: f64) {
        let body = self.0.vehicle.body_mut();
        let forward = body.q * V3::x();
        body.q = Quat::from_axis_angle(&V3::z_axis(), vb_math::atan2(forward.y, forward.x));
        body.x_world.z = self.0.world.heightfield.height(body.x_world.x, body.x_world.y) + height
            - (body.q * self.0.reference).z;
        body.v_world = V3::zeros();
        body.w_world = V3::zeros();
        self.0.vehicle.reset_wheels();
        self.0.energy.forget();
    }

    /// Gives the vehicle a velocity (m/s, world axes) as a whole, without turning; the wheels keep their spins. It
    /// serves slides and trips.
    pub fn throw(&mut self, velocity_world: [f64; 3]) {
        self.0.vehicle.body_mut().v_world = V3::from(velocity_world);
        self.0.vehicle.body_mut().w_world = V3::zeros();
        self.0.energy.forget();
    }

    /// Puts the vehicle into a state: pose, velocities, speeds and travels of the wheels, steering, the speed of an engine
    /// behind a converter, the direction that is in, and a forward gear (counted from 1, at most the highest). The wheels
    /// don't move against the chassis, and nothing is remembered of the way there. It serves comparisons with records.
    pub fn put(&mut self, state: &VehicleState, gear: usize) {
        let body = self.0.vehicle.body_mut();
        body.q = state.attitude;
        let arm = body.q * self.0.reference;
        body.x_world = state.position - arm;
        body.w_world = body.q * state.angular_velocity_body;
        body.v_world = body.q * state.velocity_body - body.w_world.cross(&arm);
        self.0.vehicle.reset_wheels();
        self.0.vehicle.put_wheels(state, gear);
        self.0.energy.forget();
    }

    /// Sets the acceleration of gravity, m/s² in world axes, as a tilt table does. It is (0, 0,
    /// −[`vb_vehicle::GRAVITY`]) at first.
    pub fn set_gravity(&mut self, gravity_world: [f64; 3]) {
        self.0.vehicle.gravity_world = V3::from(gravity_world);
        self.0.energy.forget();
    }

    /// Makes the wheels of the left and of the right side turn at these speeds (rad/s, positive forwards) from the next step on,
    /// whatever the controls ask for; `None` lets the motors turn them again. Returns whether the vehicle is skid steered on
    /// wheels: others go on as before. It serves comparisons with records.
    pub fn turn_sides(&mut self, spins: Option<[f64; 2]>) -> bool {
        self.0.vehicle.prescribe_spins(spins)
    }
}
