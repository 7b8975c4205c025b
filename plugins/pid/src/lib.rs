//! The PID planner of the Verti-Bench paper: steers by the heading error to a local goal on the global path, and
//! controls the speed.
//!
//! Every control period, the local goal is the point on the global path 10 m (times the vehicle's scale) past the
//! closest point. The heading error e is the angle between the heading and the bearing of the local goal: steering =
//! kp·e + ki·∫e dt + kd·de/dt, with kp = 1 per radian and ki = kd = 0 as in the released code. Throttle and brake come
//! from a proportional controller of the forward speed with gain 1 per m/s. It uses neither terrain nor obstacles: the
//! global path avoids obstacles.

use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, math};

vb_sdk::export_planner! {
    planner: Pid,
    name: "pid",
    about: "Steers by the heading error to a point on the global path, and controls the speed",
    control_period: 0.1,
    params: {
        speed: 5.0 => "target speed, m/s at full scale",
        lookahead: 10.0 => "look-ahead distance of the local goal along the global path, m at full scale",
        kp: 1.0 => "proportional gain of the steering, 1/rad",
        ki: 0.0 => "integral gain of the steering, 1/(rad s)",
        kd: 0.0 => "derivative gain of the steering, s/rad",
        speed_kp: 1.0 => "proportional gain of the speed controller, s/m at full scale",
    }
}

#[derive(Clone, Debug)]
pub struct Pid {
    follower: Follower,
    lookahead: f64,
    steering: Steering,
    target_speed: f64,
    speed: SpeedController,
    period: f64,
}

/// A PID controller of an angle.
#[derive(Clone, Debug)]
struct Steering {
    kp: f64,
    ki: f64,
    kd: f64,
    integral: f64,
    last: Option<f64>,
}

impl Steering {
    fn update(&mut self, error: f64, dt: f64) -> f64 {
        self.integral += error * dt;
        // The error jumps by a full turn where it wraps; the heading does not.
        let rate = self.last.map_or(0.0, |last| math::turn(last, error) / dt);
        self.last = Some(error);
        (self.kp * error + self.ki * self.integral + self.kd * rate).clamp(-1.0, 1.0)
    }
}

impl Planner for Pid {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let lookahead = task.param_positive("lookahead")? * task.vehicle.scale;
        Ok(Self {
            // Twice the look-ahead distance exceeds the motion per step, and is shorter than the distance to another
            // bend.
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            steering: Steering {
                kp: task.param_f64("kp")?,
                ki: task.param_f64("ki")?,
                kd: task.param_f64("kd")?,
                integral: 0.0,
                last: None,
            },
            // Speeds scale with the root of lengths (Froude).
            target_speed: task.param_positive("speed")? * task.vehicle.scale.sqrt(),
            speed: SpeedController::new(task.param_f64("speed_kp")? / task.vehicle.scale.sqrt(), 0.0),
            period: task.control_period,
        })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        let pose = observation.pose()?;
        let (x, y) = (pose.position.x, pose.position.y);
        self.follower.update(x, y);
        let goal = self.follower.look_ahead(self.lookahead);
        let error = math::turn(pose.yaw, math::atan2(goal.y - y, goal.x - x));
        let steering = self.steering.update(error, self.period);
        let (throttle, brake) = self.speed.update(self.target_speed, pose.linear_velocity.x, self.period);
        Ok(Command { steering, throttle, brake, ..Command::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};
    use vb_sdk::{Param, Point2, Pose, Vec3, Vehicle};

    /// Angles of right-angled triangles with legs 1:5 and 1:2, rad.
    const ATAN_FIFTH: f64 = 0.197_395_559_849_880_75;
    const ATAN_HALF: f64 = 0.463_647_609_000_806_1;

    /// Drives east along the x axis, 100 m, with the default parameters but for `params`.
    fn task(params: &[(&str, &str)]) -> Task {
        let default = [
            ("speed", "5.0"),
            ("lookahead", "10.0"),
            ("kp", "1"),
            ("ki", "0"),
            ("kd", "0"),
            ("speed_kp", "1"),
        ];
        let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
        Task {
            path: (0..=100).map(|i| Point2 { x: f64::from(i), y: 0.0 }).collect(),
            vehicle: Vehicle { scale: 1.0, ..Vehicle::default() },
            control_period: 0.1,
            params: default.iter().map(|(k, d)| Param { key: (*k).into(), value: value(k, d) }).collect(),
            ..Task::default()
        }
    }

    fn at(x: f64, y: f64, yaw: f64, speed: f64) -> Observation {
        let linear_velocity = Vec3 { x: speed, ..Vec3::default() };
        Observation::of(Pose { position: Vec3 { x, y, z: 0.0 }, yaw, linear_velocity, ..Pose::default() })
    }

    fn steering(task: &Task, observation: &Observation) -> f64 {
        Pid::init(task).unwrap().step(observation).unwrap().steering
    }

    #[test]
    fn steering_is_the_bearing_of_the_point_ten_metres_ahead() {
        let t = task(&[]);
        assert_eq!(steering(&t, &at(5.0, 0.0, 0.0, 3.0)), 0.0);
        // 2 m left of the path: the local goal lies 10 m ahead and 2 m to the right.
        let e = ATAN_FIFTH;
        assert!((steering(&t, &at(5.0, 2.0, 0.0, 3.0)) + e).abs() < 1e-12);
        assert!((steering(&t, &at(5.0, 2.0, 0.3, 3.0)) + e + 0.3).abs() < 1e-12);
        assert!((steering(&task(&[("kp", "0.5")]), &at(5.0, 2.0, 0.0, 3.0)) + 0.5 * e).abs() < 1e-12);
        let near = task(&[("lookahead", "4")]);
        assert!((steering(&near, &at(5.0, 2.0, 0.0, 3.0)) + ATAN_HALF).abs() < 1e-12);
    }

    #[test]
    fn the_speed_scales_by_the_root_of_the_vehicle() {
        // At 1/4 of the scale 5 m/s become 2.5 m/s, and 0.25 m/s too slow is what 0.5 m/s is at full scale.
        let mut t = task(&[]);
        t.vehicle.scale = 0.25;
        let c = Pid::init(&t).unwrap().step(&at(0.0, 0.0, 0.0, 2.25)).unwrap();
        assert_eq!((c.throttle, c.brake), (0.5, 0.0));
    }

    #[test]
    fn the_look_ahead_scales_with_the_vehicle() {
        let mut t = task(&[]);
        t.vehicle.scale = 0.1;
        assert!((steering(&t, &at(0.5, 0.5, 0.0, 1.0)) + ATAN_HALF).abs() < 1e-12);
    }

    #[test]
    fn steering_stays_within_the_wheel_lock_and_takes_the_short_way_round() {
        let t = task(&[]);
        assert_eq!(steering(&t, &at(5.0, 0.0, FRAC_PI_2, 3.0)), -1.0);
        assert_eq!(steering(&t, &at(5.0, 0.0, -PI + 0.1, 3.0)), 1.0);
        assert_eq!(steering(&t, &at(5.0, 0.0, PI - 0.1, 3.0)), -1.0);
    }

    #[test]
    fn integral_and_derivative_act_when_they_are_set() {
        // A constant error of 0.2 rad for 1 s: integral 0.2 rad s, derivative 0.
        let mut p = Pid::init(&task(&[("kp", "0"), ("ki", "2"), ("kd", "1")])).unwrap();
        let commands: Vec<f64> =
            (0..10).map(|_| p.step(&at(0.0, 0.0, -0.2, 0.0)).unwrap().steering).collect();
        assert!((commands[9] - 0.4).abs() < 1e-12);
        // The heading turns by 0.01 rad in 0.1 s: de/dt = −0.1 rad/s.
        let turned = p.step(&at(0.0, 0.0, -0.19, 0.0)).unwrap().steering;
        assert!((turned - (2.0 * (0.2 + 0.019) - 0.1)).abs() < 1e-12);
    }

    #[test]
    fn the_speed_error_goes_to_throttle_or_brake() {
        let mut p = Pid::init(&task(&[("speed", "5")])).unwrap();
        let slow = p.step(&at(0.0, 0.0, 0.0, 4.5)).unwrap();
        assert_eq!((slow.throttle, slow.brake), (0.5, 0.0));
        let fast = p.step(&at(0.0, 0.0, 0.0, 5.25)).unwrap();
        assert_eq!((fast.throttle, fast.brake), (0.0, 0.25));
    }

    #[test]
    fn a_bad_parameter_is_refused_by_name() {
        for (key, value) in [("speed", "fast"), ("speed", "0"), ("lookahead", "-1"), ("kp", "NaN")] {
            let message = Pid::init(&task(&[(key, value)])).unwrap_err().to_string();
            assert!(message.contains(key) && message.contains(value), "{message}");
        }
    }
}
