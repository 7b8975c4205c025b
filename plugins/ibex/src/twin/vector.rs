//! Vectors and attitudes with one number per component for each of [`LANES`](vb_sdk::mppi::LANES) vehicles.

use std::ops::{Add, AddAssign, Mul, Sub};

use vb_sdk::math;
use wide::f32x8;

/// The same number for every vehicle.
pub(super) fn all(value: f32) -> f32x8 {
    f32x8::splat(value)
}

/// Clamps a number to ±`most`.
pub(super) fn within(value: f32x8, most: f32x8) -> f32x8 {
    value.max(-most).min(most)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct V3 {
    pub(super) x: f32x8,
    pub(super) y: f32x8,
    pub(super) z: f32x8,
}

impl V3 {
    pub(super) const fn new(x: f32x8, y: f32x8, z: f32x8) -> Self {
        Self { x, y, z }
    }

    /// The same vector for every vehicle.
    pub(super) fn all([x, y, z]: [f32; 3]) -> Self {
        Self::new(all(x), all(y), all(z))
    }

    pub(super) fn dot(self, other: Self) -> f32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(super) fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }
}

impl Add for V3 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for V3 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Mul<f32x8> for V3 {
    type Output = Self;
    fn mul(self, by: f32x8) -> Self {
        Self::new(self.x * by, self.y * by, self.z * by)
    }
}

impl AddAssign for V3 {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

/// An attitude as a unit quaternion: scalar, then vector.
pub(super) type Quaternion = [f32x8; 4];

/// The attitude with these angles (rad): heading first, then pitch (positive nose down), then roll (positive right side
/// down).
pub(super) fn attitude(roll: f64, pitch: f64, yaw: f64) -> Quaternion {
    let half = |angle: f64| math::sin_cos(0.5 * angle);
    let ((sr, cr), (sp, cp), (sy, cy)) = (half(roll), half(pitch), half(yaw));
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
    .map(|v| all(v as f32))
}

/// An attitude rotated by a small angle (rad, body axes).
pub(super) fn turned([a, b, c, d]: Quaternion, angle: V3) -> Quaternion {
    let w = angle * all(0.5);
    let q = [
        a - b * w.x - c * w.y - d * w.z,
        b + a * w.x + c * w.z - d * w.y,
        c + a * w.y + d * w.x - b * w.z,
        d + a * w.z + b * w.y - c * w.x,
    ];
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|v| v / length)
}

/// The unit vectors forward, left and up of a body, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axes {
    pub(super) forward: V3,
    pub(super) left: V3,
    pub(super) up: V3,
}

impl Axes {
    pub(super) fn of([w, x, y, z]: Quaternion) -> Self {
        let (one, two) = (all(1.0), all(2.0));
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (wx, wy, wz) = (w * x, w * y, w * z);
        Self {
            forward: V3::new(one - two * (yy + zz), two * (xy + wz), two * (xz - wy)),
            left: V3::new(two * (xy - wz), one - two * (xx + zz), two * (yz + wx)),
            up: V3::new(two * (xz + wy), two * (yz - wx), one - two * (xx + yy)),
        }
    }

    /// Transforms a vector from body to world axes.
    pub(super) fn out(&self, v: V3) -> V3 {
        self.forward * v.x + self.left * v.y + self.up * v.z
    }

    /// Transforms a vector from world to body axes.
    pub(super) fn within(&self, v: V3) -> V3 {
        V3::new(v.dot(self.forward), v.dot(self.left), v.dot(self.up))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(v: V3) -> [f32; 3] {
        [v.x, v.y, v.z].map(|c| c.to_array()[0])
    }

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
    }

    #[test]
    fn angles_are_heading_then_pitch_nose_down_then_roll_right_side_down() {
        let (roll, pitch, yaw) = (0.3, 0.2, 2.0);
        let axes = Axes::of(attitude(roll, pitch, yaw));
        let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(math::sin_cos);
        let vector = |v: [f64; 3]| v.map(|c| c as f32);
        assert!(near(first(axes.forward), vector([cy * cp, sy * cp, -sp])));
        assert!(near(first(axes.left), vector([cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr])));
        let v = V3::all([1.0, -2.0, 0.5]);
        assert!(near(first(axes.within(axes.out(v))), [1.0, -2.0, 0.5]));
    }

    #[test]
    fn small_turns_add_up_to_a_large_one() {
        let mut q = attitude(0.0, 0.0, 0.4);
        for _ in 0..100 {
            q = turned(q, V3::all([0.0, 0.0, 1e-2]));
        }
        let (sin, cos) = math::sin_cos(1.4);
        assert!(near(first(Axes::of(q).forward), [cos as f32, sin as f32, 0.0]));
    }
}
