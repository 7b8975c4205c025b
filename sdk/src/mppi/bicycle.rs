//! The kinematic bicycle: steering and speed follow their commands at limited rates.

use super::{LANES, Lanes, Model};
use crate::{Pose, Vehicle, math};

/// The states of [`LANES`] bicycles in the plane, in the world frame. The reference point lies halfway between the
/// axles.
#[derive(Clone, Debug, PartialEq)]
pub struct BicycleState {
    /// The positions of the reference points along x (east), m.
    pub x: Lanes,
    /// The positions of the reference points along y (north), m.
    pub y: Lanes,
    /// The cosines of the headings.
    pub cos: Lanes,
    /// The sines of the headings; the heading is counted counter-clockwise from east.
    pub sin: Lanes,
    /// The forward speeds, m/s.
    pub speed: Lanes,
    /// The steering that the wheels have at present, in −1 to 1, positive to the left.
    pub steering: Lanes,
}

impl BicycleState {
    /// The states in which every bicycle is where the vehicle is, with its steering at this command.
    #[must_use]
    pub fn of(pose: &Pose, steering: f64) -> Self {
        let (sin, cos) = math::sin_cos(pose.yaw);
        let all = |v: f64| [v as f32; LANES];
        Self {
            x: all(pose.position.x),
            y: all(pose.position.y),
            cos: all(cos),
            sin: all(sin),
            speed: all(pose.linear_velocity.x),
            steering: all(steering),
        }
    }
}

/// A kinematic bicycle. Its commands are the steering (−1 to 1, positive to the left) and the speed (m/s).
#[derive(Clone, Debug, PartialEq)]
pub struct Bicycle {
    /// The curvature of the reference point's path at full lock, 1/m, without what turning in place adds.
    pub curvature: f32,
    /// The yaw rate at full lock and standstill, rad/s: 0 but for vehicles that turn in place.
    pub turn_rate_in_place: f32,
    /// The greatest rate of the steering, 1/s.
    pub steer_rate: f32,
    /// The time constant with which the speed follows its command, s.
    pub lag: f32,
    /// The greatest acceleration and deceleration, m/s².
    pub acceleration: f32,
}

impl Bicycle {
    /// The bicycle with the turning radius, the rate of turning in place and the steering rate of this vehicle. Its lag, half a second at full size,
    /// and its acceleration of 3 m/s² are typical of a speed controller with a gain of 1 s/m. By Froude's rule the lag
    /// grows with the square root of the vehicle's scale, while the acceleration is the same at any scale.
    #[must_use]
    pub fn of(vehicle: &Vehicle) -> Self {
        // Together they make the turning radius at nine tenths of the top speed, near which skid steering's is told.
        let in_place = vehicle.turn_rate_in_place / (0.9 * vehicle.max_speed);
        Self {
            curvature: (1.0 / vehicle.min_turn_radius - in_place) as f32,
            turn_rate_in_place: vehicle.turn_rate_in_place as f32,
            steer_rate: vehicle.max_steer_rate as f32,
            lag: (0.5 * vehicle.scale.sqrt()) as f32,
            acceleration: 3.0,
        }
    }
}

impl Model<2> for Bicycle {
    type State = BicycleState;

    fn step(&self, s: &mut BicycleState, [steering, speed]: &[Lanes; 2], dt: f32) {
        let most = self.steer_rate * dt;
        let gain = (dt / self.lag).min(1.0);
        let change = self.acceleration * dt;
        let spin = self.turn_rate_in_place * dt;
        for l in 0..LANES {
            s.steering[l] += (steering[l] - s.steering[l]).clamp(-most, most);
            s.speed[l] += (gain * (speed[l] - s.speed[l])).clamp(-change, change);
            let way = s.speed[l] * dt;
            let turn = (way * self.curvature + spin) * s.steering[l];
            // The heading turns as a vector, by a small angle to the third order, and is brought back to length 1 by one
            // step of Newton's; the vehicle moves along the heading of the middle of the step.
            let (half, square) = (0.5 * turn, turn * turn);
            let (c, n) = (s.cos[l], s.sin[l]);
            s.x[l] += way * (c - half * n);
            s.y[l] += way * (n + half * c);
            let (a, b) = (1.0 - 0.5 * square, turn * (1.0 - square / 6.0));
            let (c, n) = (c * a - n * b, n * a + c * b);
            let length = 1.5 - 0.5 * (c * c + n * n);
            (s.cos[l], s.sin[l]) = (c * length, n * length);
        }
    }
}
