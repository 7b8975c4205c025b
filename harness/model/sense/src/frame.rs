//! Places and attitudes.

use crate::{Quat, V3};
use vb_sim::VehicleState;

/// Where a body is: the position of its origin, m, and the rotation from its axes to those of the frame that it is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) at: V3,
    pub(crate) turn: Quat,
}

impl Frame {
    /// The vehicle in the world.
    pub(crate) fn of(state: &VehicleState) -> Self {
        Self { at: state.position, turn: state.attitude }
    }

    /// Part `share` of the way from this place to another that is a small turn away.
    pub(crate) fn towards(&self, other: &Self, share: f64) -> Self {
        Self { at: self.at.lerp(&other.at, share), turn: self.turn.nlerp(&other.turn, share) }
    }

    /// What is at `inner` in this body's frame, in the frame that this body is in.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        Self { at: self.point(&inner.at), turn: self.turn * inner.turn }
    }

    /// A point of the body in the frame that the body is in.
    pub(crate) fn point(&self, p: &V3) -> V3 {
        self.at + self.turn * p
    }
}

/// The rotation by a yaw, then a pitch about the turned y axis, then a roll about the turned x axis, rad.
pub(crate) fn attitude(roll: f64, pitch: f64, yaw: f64) -> Quat {
    Quat::from_axis_angle(&V3::z_axis(), yaw)
        * Quat::from_axis_angle(&V3::y_axis(), pitch)
        * Quat::from_axis_angle(&V3::x_axis(), roll)
}

/// The same vector as planners see it.
pub(crate) fn vec3(v: &V3) -> vb_sdk::Vec3 {
    vb_sdk::Vec3 { x: v.x, y: v.y, z: v.z }
}
