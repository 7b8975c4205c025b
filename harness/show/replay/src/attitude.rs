//! The attitude of a recorded sample as a rotation.

use nalgebra::{UnitQuaternion, Vector3};
use vb_record::Sample;

/// The attitude of a sample: body axes to world axes.
#[must_use]
pub fn attitude(s: &Sample) -> UnitQuaternion<f64> {
    let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    about(Vector3::z_axis(), s.yaw) * about(Vector3::y_axis(), s.pitch) * about(Vector3::x_axis(), s.roll)
}
