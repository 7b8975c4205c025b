//! Rigid body with six degrees of freedom, and the forces on it.

use super::shape::Shape;
use super::vector::{Axes, V3, all, turned};
use super::{GRAVITY, State};

/// The body in a step; vectors are in world axes.
#[derive(Clone, Copy)]
pub(super) struct Body {
    /// The centre of mass, m.
    pub(super) place: V3,
    pub(super) axes: Axes,
    /// Velocity of the centre of mass, m/s.
    pub(super) velocity: V3,
    /// Angular velocity, rad/s.
    pub(super) turning: V3,
}

/// The forces on the body, N, and their moments about the centre of mass, N m.
pub(super) struct Push {
    force: V3,
    moment: V3,
}

impl Push {
    pub(super) fn weight(mass: f32) -> Self {
        Self { force: V3::all([0.0, 0.0, -mass * GRAVITY]), moment: V3::all([0.0; 3]) }
    }

    /// Adds a force at a point relative to the centre of mass.
    pub(super) fn add(&mut self, at: V3, force: V3) {
        self.force += force;
        self.moment += at.cross(force);
    }
}

impl State {
    pub(super) fn axes(&self) -> Axes {
        Axes::of(self.attitude)
    }

    pub(super) fn body(&self) -> Body {
        let axes = self.axes();
        Body { place: self.place, axes, velocity: self.velocity, turning: axes.out(self.rotation) }
    }

    /// Integrates Euler's equations, velocities first.
    pub(super) fn advance(&mut self, shape: &Shape, push: &Push, dt: f32) {
        self.velocity += push.force * all(dt / shape.mass);
        let m = self.axes().within(push.moment);
        let [ix, iy, iz] = shape.inertia.map(all);
        let w = self.rotation;
        self.rotation += V3::new(
            (m.x - (iz - iy) * w.y * w.z) / ix,
            (m.y - (ix - iz) * w.z * w.x) / iy,
            (m.z - (iy - ix) * w.x * w.y) / iz,
        ) * all(dt);
        self.drift(dt);
    }

    /// Integrates the position with the current velocity.
    pub(super) fn drift(&mut self, dt: f32) {
        self.attitude = turned(self.attitude, self.rotation * all(dt));
        self.place += self.velocity * all(dt);
    }
}
