//! Speed controllers.

use crate::Gear;

/// A proportional-integral controller of the forward speed, with throttle and brake as outputs.
///
/// u = kp·e + ki·∫e dt with e = target − speed, clamped to [-1, 1]; u ≥ 0 is throttle, u < 0 is brake. With kp = 1 and
/// ki = 0 it is the speed controller of Verti-Bench, which has a steady-state error of about 0.5 m/s on flat terrain,
/// because constant speed needs throttle.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedController {
    kp: f64,
    ki: f64,
    integral: f64,
}

impl SpeedController {
    /// Creates a controller with the gains `kp` (throttle per m/s, s/m) and `ki` (throttle per m, 1/m).
    #[must_use]
    pub fn new(kp: f64, ki: f64) -> Self {
        Self { kp, ki, integral: 0.0 }
    }

    /// Returns throttle and brake, each in [0, 1], for the current speed and the target (m/s). `dt` is the time since
    /// the last call, s.
    pub fn update(&mut self, target: f64, speed: f64, dt: f64) -> (f64, f64) {
        let error = target - speed;
        let integral = self.integral + self.ki * error * dt;
        let wanted = self.kp * error + integral;
        // Anti-windup: while the output is saturated, the integral may only decrease in magnitude.
        if wanted.abs() <= 1.0 || wanted * error < 0.0 {
            self.integral = integral;
        }
        let u = wanted.clamp(-1.0, 1.0);
        if u >= 0.0 { (u, 0.0) } else { (0.0, -u) }
    }

    /// The integral, as throttle (brake if negative).
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Resets the integral to 0.
    pub fn reset(&mut self) {
        self.integral = 0.0;
    }
}

/// Controls a signed speed with throttle, brake and gear: a [`SpeedController`] per direction of travel, reset at each
/// change. Speeds are converted to full scale (Froude scaling), so that the gains apply at every scale.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedKeeper {
    controller: SpeedController,
    /// Root of the world's scale.
    pace: f64,
    /// Target speed, m/s.
    target: f64,
}

impl SpeedKeeper {
    /// The gains: throttle per m/s of error, and per metre.
    const GAINS: (f64, f64) = (0.6, 0.15);

    /// Creates a controller with the target 0, in a world of this scale.
    #[must_use]
    pub fn new(scale: f64) -> Self {
        let (kp, ki) = Self::GAINS;
        Self { controller: SpeedController::new(kp, ki), pace: scale.sqrt(), target: 0.0 }
    }

    /// The integral of the controller, as throttle (brake if negative).
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.controller.integral()
    }

    /// Sets the target speed, m/s, negative in reverse.
    pub fn aim(&mut self, target: f64) {
        if (target < 0.0) != (self.target < 0.0) {
            self.controller.reset();
        }
        self.target = target;
    }

    /// Returns throttle and brake, each in [0, 1], and the gear, for this forward speed (m/s). `dt` is the time since
    /// the last call, s.
    pub fn update(&mut self, speed: f64, dt: f64) -> (f64, f64, Gear) {
        let (gear, along) = if self.target < 0.0 { (Gear::Reverse, -1.0) } else { (Gear::Forward, 1.0) };
        let (target, speed) = (along * self.target / self.pace, along * speed / self.pace);
        let (throttle, brake) = self.controller.update(target, speed, dt);
        (throttle, brake, gear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_one_turns_the_speed_error_into_throttle_or_brake() {
        let mut c = SpeedController::new(1.0, 0.0);
        assert_eq!(c.update(3.0, 2.75, 0.1), (0.25, 0.0));
        assert_eq!(c.update(3.0, 3.5, 0.1), (0.0, 0.5));
        assert_eq!(c.update(3.0, 3.0, 0.1), (0.0, 0.0));
        assert_eq!(c.update(3.0, 0.0, 0.1), (1.0, 0.0));
        assert_eq!(c.update(3.0, 9.0, 0.1), (0.0, 1.0));
    }

    #[test]
    fn the_integral_removes_the_droop_and_does_not_wind_up() {
        // Plant dv/dt = 2u − 0.2v: at 3 m/s it needs u = 0.3, which P control alone reaches only with a droop.
        let drive = |ki: f64| {
            let (mut c, mut v, mut top) = (SpeedController::new(1.0, ki), 0.0, 0.0f64);
            for _ in 0..3000 {
                let (throttle, brake) = c.update(3.0, v, 0.01);
                v += 0.01 * (2.0 * (throttle - brake) - 0.2 * v);
                top = top.max(v);
            }
            (v, top)
        };
        // P alone: 2(3 − v) = 0.2v.
        assert!((drive(0.0).0 - 6.0 / 2.2).abs() < 1e-3);
        let (v, top) = drive(0.5);
        assert!((v - 3.0).abs() < 1e-3, "{v}");
        assert!(top < 3.4, "overshoot to {top}");
    }

    #[test]
    fn reset_forgets_the_integral() {
        let mut c = SpeedController::new(0.0, 1.0);
        c.update(1.0, 0.5, 1.0);
        assert_eq!(c.update(1.0, 1.0, 1.0), (0.5, 0.0));
        c.reset();
        assert_eq!(c.update(1.0, 1.0, 1.0), (0.0, 0.0));
    }

    #[test]
    fn a_change_of_direction_changes_the_gear_and_forgets_the_integral() {
        let mut k = SpeedKeeper::new(1.0);
        k.aim(2.0);
        // 0.6 of 1 m/s, and the integral of the step itself comes with the next.
        let (throttle, brake, gear) = k.update(1.0, 0.1);
        assert_eq!((brake, gear), (0.0, Gear::Forward));
        assert!((throttle - 0.615).abs() < 1e-12, "{throttle}");
        k.aim(-2.0);
        // Still rolling forward: 3 m/s too fast for reverse, so all throttle would be wanted against it.
        assert_eq!(k.update(-1.0, 0.1), (throttle, 0.0, Gear::Reverse));
        // Faster than wanted in reverse: the brake.
        let (throttle, brake, gear) = k.update(-4.0, 0.1);
        assert!(throttle == 0.0 && brake > 0.9 && gear == Gear::Reverse);
    }

    #[test]
    fn a_small_vehicle_is_kept_as_a_large_one_at_speeds_of_froude_s_rule() {
        let (mut large, mut small) = (SpeedKeeper::new(1.0), SpeedKeeper::new(0.25));
        large.aim(2.0);
        small.aim(1.0);
        assert_eq!(large.update(1.0, 0.1), small.update(0.5, 0.1));
    }
}
