//! The state that a simulation tells about the vehicle, and the controls that it takes.

use crate::{Quat, V3};
use vb_math::{asin, atan2};

/// The direction of a gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Gear {
    /// The reverse gear: the engine drives backwards.
    Reverse,
    /// The engine is uncoupled.
    Neutral,
    /// The forward gears, between which the gearbox shifts by itself.
    #[default]
    Forward,
}

/// The controls that the driver asks for, already within their ranges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Controls {
    /// The steering, in [-1, 1], positive to the left.
    pub steering: f64,
    /// The throttle, in [0, 1].
    pub throttle: f64,
    /// The brake, in [0, 1].
    pub brake: f64,
    /// The direction that the driver wants. Neutral comes at once. A direction opposed to the motion, or to the one that is
    /// in, waits until the vehicle is slower than its file's `direction_change.speed`, with the former one in and the
    /// throttle closed, and then takes the latency of that file, without torque. A vehicle without a reverse gear goes to
    /// neutral instead.
    pub gear: Gear,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelState {
    /// The spin, rad/s, positive when rolling forward.
    pub speed: f64,
    /// The suspension travel from the design position, m, positive in compression.
    pub deflection: f64,
    /// The normal force of the ground and of obstacles, N.
    pub load: f64,
    /// The depth at which the wheel's lowest point in its middle plane lies below undisturbed soil that it presses on,
    /// m; 0 on rigid ground. For a track's wheel it is the depth at which the belt lies under it.
    pub sinkage: f64,
}

/// The state of the vehicle at its reference point, the origin of the chassis frame. World axes are x east, y north, z
/// up; body axes are x forward, y left, z up.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleState {
    /// The simulated time, s.
    pub time: f64,
    /// The position of the reference point in the world frame, m.
    pub position: V3,
    /// The attitude: the rotation from body axes to world axes.
    pub attitude: Quat,
    /// The velocity of the reference point over the ground, in body axes, m/s.
    pub velocity_body: V3,
    /// The angular velocity of the chassis over the ground, in body axes, rad/s.
    pub angular_velocity_body: V3,
    /// The wheels, front to back, left before right.
    pub wheels: Vec<WheelState>,
    /// The steering command after the limits of rate and force, in [-1, 1], positive to the left.
    pub steering: f64,
    /// The direction that is in: neutral while a change of direction interrupts the torque.
    pub gear: Gear,
    /// The speed of the engine, rad/s, not negative. One without a converter turns with the gearbox, and 0 stands for its
    /// speed in neutral.
    pub engine_speed: f64,
}

impl VehicleState {
    /// The roll, the pitch and the yaw, rad. The attitude is the heading first, then the pitch (positive nose down),
    /// then the roll (positive right side down), as ISO 8855 and Chrono's `GetCardanAnglesXYZ` define them.
    #[must_use]
    pub fn roll_pitch_yaw(&self) -> (f64, f64, f64) {
        let q = self.attitude.quaternion();
        let (w, x, y, z) = (q.w, q.i, q.j, q.k);
        let roll = atan2(2.0 * (y * z + w * x), w * w - x * x - y * y + z * z);
        let pitch = asin((2.0 * (w * y - x * z)).clamp(-1.0, 1.0));
        let yaw = atan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z);
        (roll, pitch, yaw)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(attitude: Quat) -> VehicleState {
        VehicleState {
            time: 0.0,
            position: V3::zeros(),
            attitude,
            velocity_body: V3::zeros(),
            angular_velocity_body: V3::zeros(),
            wheels: vec![],
            steering: 0.0,
            gear: Gear::Forward,
            engine_speed: 0.0,
        }
    }

    #[test]
    fn angles_are_heading_then_pitch_nose_down_then_roll_right_side_down() {
        let q = Quat::from_axis_angle(&V3::z_axis(), 2.0)
            * Quat::from_axis_angle(&V3::y_axis(), 0.3)
            * Quat::from_axis_angle(&V3::x_axis(), -0.7);
        let (roll, pitch, yaw) = state(q).roll_pitch_yaw();
        assert!((roll + 0.7).abs() < 1e-12 && (pitch - 0.3).abs() < 1e-12 && (yaw - 2.0).abs() < 1e-12);
        let nose = state(Quat::from_axis_angle(&V3::y_axis(), 0.3)).attitude * V3::x();
        assert!(nose.z < 0.0, "positive pitch lowers the nose");
        let right = state(Quat::from_axis_angle(&V3::x_axis(), 0.3)).attitude * -V3::y();
        assert!(right.z < 0.0, "positive roll lowers the right side");
    }
}
