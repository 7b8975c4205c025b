//! The state of a vehicle at a moment, and what is derived from it.

use vb_math::{acos, cos, sin_cos};

use super::{Body, GRAVITY};

/// The state of a wheel at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelMoment {
    /// The angular velocity about the axle, rad/s, positive when rolling forward.
    pub spin: f64,
    /// The normal force of ground and obstacles, N.
    pub load: f64,
    /// The depth in soil, m.
    pub sinkage: f64,
}

/// The state of a vehicle at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The time, s.
    pub time: f64,
    /// The position of the reference point in the world, m.
    pub position: [f64; 3],
    /// The roll, rad, positive with the right side down.
    pub roll: f64,
    /// The pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// The heading, rad.
    pub yaw: f64,
    /// The velocity in body axes, m/s.
    pub velocity: [f64; 3],
    /// The angular velocity about the body's upward axis, rad/s.
    pub yaw_rate: f64,
    /// The throttle, in [0, 1].
    pub throttle: f64,
    /// Whether the reverse gear is in.
    pub reverse: bool,
    /// The wheels, front to back, left before right.
    pub wheels: Vec<WheelMoment>,
}

impl Moment {
    /// The angle between the vehicle's upward axis and the vertical, rad.
    #[must_use]
    pub fn tilt(&self) -> f64 {
        acos((cos(self.pitch) * cos(self.roll)).clamp(-1.0, 1.0))
    }

    /// A point of the body in the world, m. The attitude is the heading first, then the pitch, then the roll.
    pub(super) fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let ((sr, cr), (sp, cp), (sy, cy)) = (sin_cos(self.roll), sin_cos(self.pitch), sin_cos(self.yaw));
        let (y, z) = (cr * y - sr * z, sr * y + cr * z);
        let (x, z) = (cp * x + sp * z, -sp * x + cp * z);
        let p = self.position;
        [p[0] + cy * x - sy * y, p[1] + sy * x + cy * y, p[2] + z]
    }

    /// The direction of travel that the gear asks for: 1 forwards, -1 backwards.
    pub(super) fn direction(&self) -> f64 {
        if self.reverse { -1.0 } else { 1.0 }
    }

    /// The corners of the vehicle, seen from above and grown by a margin (m) to the front, the rear and the sides, in the
    /// world.
    pub(super) fn outline(&self, body: &Body, [front, rear, side]: [f64; 3]) -> Vec<[f64; 2]> {
        let (sin, cos) = sin_cos(self.yaw);
        let (f, r, w) = (body.front + front, body.rear + rear, body.half_width + side);
        [[f, w], [-r, w], [-r, -w], [f, -w]]
            .map(|[x, y]| [self.position[0] + cos * x - sin * y, self.position[1] + sin * x + cos * y])
            .to_vec()
    }

    /// The part of the weight that the wheels don't bear, of that which presses the vehicle on its plane.
    pub(super) fn on_hull(&self, body: &Body) -> f64 {
        let loads: f64 = self.wheels.iter().map(|w| w.load).sum();
        1.0 - loads / (body.mass * GRAVITY * cos(self.tilt()).max(0.1))
    }

    /// The slip of a wheel: the difference of the speeds of its rim and of the vehicle over the larger of the two, so that it
    /// lies within 0 and 2; a wheel at rest has none.
    pub(super) fn slip(&self, wheel: usize, body: &Body) -> f64 {
        let rim = self.wheels[wheel].spin * body.wheel_radius;
        let fastest = rim.abs().max(self.velocity[0].abs()).max(0.1 * body.scale.sqrt());
        (rim - self.velocity[0]).abs() / fastest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn points_are_placed_by_heading_then_pitch_then_roll() {
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let at =
            |roll, pitch, yaw| Moment { position: [1.0, 2.0, 3.0], roll, pitch, yaw, ..Moment::default() };
        // The nose points north; then it points down; then the right side is down.
        assert!(near(at(0.0, 0.0, FRAC_PI_2).place([1.0, 0.0, 0.0]), [1.0, 3.0, 3.0]));
        assert!(near(at(0.0, FRAC_PI_2, 0.0).place([1.0, 0.0, 0.0]), [1.0, 2.0, 2.0]));
        assert!(near(at(FRAC_PI_2, 0.0, 0.0).place([0.0, -1.0, 0.0]), [1.0, 2.0, 2.0]));
        // With the nose north and the right side down, the roof looks east.
        assert!(near(at(FRAC_PI_2, 0.0, FRAC_PI_2).place([0.0, 0.0, 1.0]), [2.0, 2.0, 3.0]));
    }
}
