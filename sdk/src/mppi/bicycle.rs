//! The kinematic bicycle: steering and speed follow their commands with rate limits.

use super::{LANES, Lanes, Model};
use crate::{Pose, Vehicle, math};

/// The states of [`LANES`] planar bicycles, in the world frame. The reference point is midway between the axles.
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
    /// Wheel steering, −1 to 1, positive to the left.
    pub steering: Lanes,
}

impl BicycleState {
    /// The state of the vehicle, equal for all bicycles, with this steering.
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
    /// Path curvature of the reference point at full lock, 1/m, without turning in place.
    pub curvature: f32,
    /// The yaw rate at full lock and standstill, rad/s: 0 for vehicles that cannot turn in place.
    pub turn_rate_in_place: f32,
    /// The maximum steering rate, 1/s.
    pub steer_rate: f32,
    /// The time constant of the speed response, s.
    pub lag: f32,
    /// The maximum acceleration and deceleration, m/s².
    pub acceleration: f32,
}

impl Bicycle {
    /// The bicycle with the turning radius, the turn rate in place and the steering rate of this vehicle. Its time
    /// constant, 0.5 s at full scale, and its acceleration of 3 m/s² are typical of a speed controller with a gain of 1
    /// s/m. In Froude scaling the time constant scales with the square root of the vehicle's scale, while the
    /// acceleration is constant.
    #[must_use]
    pub fn of(vehicle: &Vehicle) -> Self {
        // Together they give the turning radius at nine tenths of the top speed, near which the radius of skid steering
        // is specified.
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
            // The heading rotates as a vector, with a third-order small-angle rotation and a Newton step that restores
            // length 1; the vehicle moves along the heading at the middle of the step.
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
