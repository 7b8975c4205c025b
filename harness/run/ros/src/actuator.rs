//! From commanded velocities to steering, throttle, brake and gear.

use vb_rosmsg::messages::ackermann_msgs::AckermannDrive;
use vb_rosmsg::messages::geometry_msgs::Twist;
use vb_sdk::math::atan2;
use vb_sdk::speed::SpeedKeeper;
use vb_sdk::{Command, Gear, Vehicle};

/// The commanded motion of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setpoint {
    /// A velocity and a yaw rate in the body frame (`geometry_msgs/msg/Twist`).
    Velocity {
        /// The forward speed, m/s, negative in reverse.
        linear: f64,
        /// The yaw rate, rad/s, positive to the left.
        angular: f64,
    },
    /// A road-wheel angle and a speed (`ackermann_msgs/msg/AckermannDrive`).
    Angle {
        /// The mean road-wheel angle, rad, positive to the left.
        angle: f64,
        /// The forward speed, m/s, negative in reverse.
        speed: f64,
    },
}

impl Setpoint {
    /// The setpoint of a message.
    ///
    /// # Errors
    /// Returns the name and the value of the first number that is not finite.
    pub(crate) fn of_twist(twist: &Twist) -> Result<Self, (&'static str, f64)> {
        let numbers = [
            ("linear.x", twist.linear.x),
            ("linear.y", twist.linear.y),
            ("linear.z", twist.linear.z),
            ("angular.x", twist.angular.x),
            ("angular.y", twist.angular.y),
            ("angular.z", twist.angular.z),
        ];
        finite(&numbers)?;
        Ok(Self::Velocity { linear: twist.linear.x, angular: twist.angular.z })
    }

    /// The setpoint of a message.
    ///
    /// # Errors
    /// Returns the name and the value of the first number that is not finite.
    pub(crate) fn of_drive(drive: &AckermannDrive) -> Result<Self, (&'static str, f64)> {
        let numbers =
            [("steering_angle", f64::from(drive.steering_angle)), ("speed", f64::from(drive.speed))];
        finite(&numbers)?;
        Ok(Self::Angle { angle: numbers[0].1, speed: numbers[1].1 })
    }
}

fn finite(numbers: &[(&'static str, f64)]) -> Result<(), (&'static str, f64)> {
    numbers.iter().find(|(_, value)| !value.is_finite()).map_or(Ok(()), |bad| Err(*bad))
}

/// Tracks setpoints with a vehicle: a speed controller for throttle and brake, and the kinematics of a bicycle for the steering.
///
/// The road-wheel angle for a yaw rate ω at the speed v is atan(L ω / v) with the wheelbase L (Rajamani 2012, 2.2, at the rear axle). For
/// vehicles that steer by their driveline, the angle is that of an equivalent bicycle, as [`Vehicle::max_steer_angle`] states it.
#[derive(Clone, Debug)]
pub struct Actuator {
    keeper: SpeedKeeper,
    wheelbase: f64,
    max_steer_angle: f64,
    /// Yaw rate at full lock at standstill, rad/s; 0 for a vehicle that can't turn in place.
    turn_rate_in_place: f64,
    direction_change_speed: f64,
    /// Speeds below this one count as standing, m/s.
    standing: f64,
    /// s.
    period: f64,
    gear: Option<Gear>,
}

impl Actuator {
    /// The speed that counts as standing at scale 1, m/s; it scales by Froude's rule.
    const STANDING: f64 = 0.1;

    /// An actuator of a vehicle that is commanded every `period` seconds.
    #[must_use]
    pub fn new(vehicle: &Vehicle, period: f64) -> Self {
        Self {
            keeper: SpeedKeeper::new(vehicle.scale),
            wheelbase: vehicle.wheelbase,
            max_steer_angle: vehicle.max_steer_angle,
            turn_rate_in_place: vehicle.turn_rate_in_place,
            direction_change_speed: vehicle.direction_change_speed,
            standing: Self::STANDING * vehicle.scale.sqrt(),
            period,
            gear: None,
        }
    }

    /// Sets the gear for all further commands. Until then, it follows the sign of the speed.
    pub fn engage(&mut self, gear: Gear) {
        self.gear = Some(gear);
    }

    /// The command for a setpoint at a forward speed, m/s.
    pub fn follow(&mut self, setpoint: Setpoint, speed: f64) -> Command {
        let (target, steering) = match setpoint {
            Setpoint::Velocity { linear, angular } => (linear, self.steering(linear, angular)),
            Setpoint::Angle { angle, speed } => (speed, angle / self.max_steer_angle),
        };
        let steering = steering.clamp(-1.0, 1.0);
        let turns = matches!(setpoint, Setpoint::Velocity { angular, .. } if angular != 0.0);
        let against = match self.gear {
            Some(Gear::Forward) => target < 0.0,
            Some(Gear::Reverse) => target > 0.0,
            Some(Gear::Neutral) => true,
            None => false,
        };
        let target = if against { 0.0 } else { target };
        self.keeper.aim(target);
        let (throttle, brake, wanted) = self.keeper.update(speed, self.period);
        let gear = self.gear.unwrap_or(wanted);
        if target == 0.0 {
            // Held where it stands, but for what turns on the spot.
            let hold = !turns && speed.abs() < self.standing;
            return Command {
                steering,
                throttle: 0.0,
                brake: if hold { 1.0 } else { brake },
                gear,
                ..Command::default()
            };
        }
        if target * speed < 0.0 && speed.abs() > self.direction_change_speed {
            // The gearbox waits until the vehicle is slow enough.
            return Command { steering, throttle: 0.0, brake: 1.0, gear, ..Command::default() };
        }
        Command { steering, throttle, brake, gear, ..Command::default() }
    }

    /// The steering for a yaw rate at a speed, before clamping. Below the speed that counts as standing, it is that of this speed, or the
    /// fraction of the yaw rate in place of a vehicle that turns in place.
    fn steering(&self, linear: f64, angular: f64) -> f64 {
        if angular == 0.0 {
            return 0.0;
        }
        if linear.abs() < self.standing && self.turn_rate_in_place > 0.0 {
            return angular / self.turn_rate_in_place;
        }
        let turn = if linear < 0.0 { -angular } else { angular };
        atan2(self.wheelbase * turn, linear.abs().max(self.standing)) / self.max_steer_angle
    }

    /// The command without a setpoint: full brake.
    #[must_use]
    pub fn stop() -> Command {
        Command { brake: 1.0, ..Command::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steered() -> Vehicle {
        Vehicle {
            scale: 1.0,
            wheelbase: 3.0,
            max_steer_angle: 0.5,
            direction_change_speed: 0.5,
            ..Vehicle::default()
        }
    }

    fn actuator() -> Actuator {
        Actuator::new(&steered(), 0.1)
    }

    fn velocity(linear: f64, angular: f64) -> Setpoint {
        Setpoint::Velocity { linear, angular }
    }

    #[test]
    fn the_steering_is_that_of_a_bicycle_on_the_commanded_circle() {
        let steering = |linear: f64, angular: f64| actuator().follow(velocity(linear, angular), 0.0).steering;
        // A circle of 10 m: atan(3 / 10) of 0.5 rad.
        let wanted = 0.291_456_794_477_867_1 / 0.5;
        assert!((steering(2.0, 0.2) - wanted).abs() < 1e-12);
        assert!((steering(2.0, -0.2) + wanted).abs() < 1e-12);
        // To turn left in reverse, the wheels point right.
        assert!((steering(-2.0, 0.2) + wanted).abs() < 1e-12);
        assert_eq!(steering(2.0, 0.0), 0.0);
        assert_eq!(steering(0.0, 1.0), 1.0);
        let angle = actuator().follow(Setpoint::Angle { angle: -0.25, speed: 1.0 }, 0.0);
        assert_eq!(angle.steering, -0.5);
    }

    #[test]
    fn a_vehicle_that_turns_in_place_steers_by_its_yaw_rate_at_standstill() {
        let vehicle = Vehicle { turn_rate_in_place: 0.8, ..steered() };
        let steering = |linear: f64, angular: f64| {
            Actuator::new(&vehicle, 0.1).follow(velocity(linear, angular), 0.0).steering
        };
        assert_eq!([steering(0.0, 0.2), steering(0.0, -0.4), steering(0.0, 2.0)], [0.25, -0.5, 1.0]);
        // When it moves, it is a bicycle: atan(3 / 10) of 0.5 rad.
        assert!((steering(2.0, 0.2) - 0.291_456_794_477_867_1 / 0.5).abs() < 1e-12);
    }

    #[test]
    fn the_speed_is_kept_in_the_gear_of_its_sign() {
        let mut actuator = actuator();
        let c = actuator.follow(velocity(2.0, 0.0), 1.0);
        assert!(c.throttle > 0.5 && c.brake == 0.0 && c.gear == Gear::Forward);
        // Rolling forward, it brakes before it goes back.
        let c = actuator.follow(velocity(-2.0, 0.0), 1.0);
        assert!(c.throttle == 0.0 && c.brake == 1.0 && c.gear == Gear::Reverse);
        let c = actuator.follow(velocity(-2.0, 0.0), 0.4);
        assert!(c.throttle > 0.5 && c.brake == 0.0 && c.gear == Gear::Reverse);
    }

    #[test]
    fn a_vehicle_that_stands_is_held_unless_it_is_to_turn() {
        let mut actuator = actuator();
        assert_eq!(actuator.follow(velocity(0.0, 0.0), 0.05).brake, 1.0);
        assert!(actuator.follow(velocity(0.0, 0.5), 0.0).brake < 0.01);
        let slowing = actuator.follow(velocity(0.0, 0.0), 1.0);
        assert!(slowing.throttle == 0.0 && slowing.brake > 0.5 && slowing.brake < 1.0);
    }

    #[test]
    fn a_commanded_gear_holds_and_a_speed_against_it_means_stop() {
        let mut actuator = actuator();
        actuator.engage(Gear::Reverse);
        let c = actuator.follow(velocity(2.0, 0.0), 0.0);
        assert!(c.gear == Gear::Reverse && c.throttle == 0.0 && c.brake == 1.0);
        actuator.engage(Gear::Neutral);
        let c = actuator.follow(velocity(2.0, 0.0), 2.0);
        assert!(c.gear == Gear::Neutral && c.throttle == 0.0);
        actuator.engage(Gear::Forward);
        assert!(actuator.follow(velocity(2.0, 0.0), 0.0).throttle > 0.5);
    }

    #[test]
    fn numbers_that_are_not_finite_are_named() {
        let mut twist = Twist::default();
        twist.angular.y = f64::NAN;
        assert!(matches!(Setpoint::of_twist(&twist), Err(("angular.y", v)) if v.is_nan()));
        let drive = AckermannDrive { speed: f32::INFINITY, ..AckermannDrive::default() };
        assert_eq!(Setpoint::of_drive(&drive), Err(("speed", f64::INFINITY)));
    }
}
