//! A speed controller.

/// A proportional-integral controller of the forward speed, which acts by throttle and brake.
///
/// u = kp·e + ki·∫e dt with e = target − speed, limited to [-1, 1]; u ≥ 0 is throttle, u < 0 is brake. With
/// kp = 1 and ki = 0 it is the speed controller of Verti-Bench, which leaves a droop of some 0.5 m/s on flat
/// ground, since holding a speed takes a throttle above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedController {
    kp: f64,
    ki: f64,
    integral: f64,
}

impl SpeedController {
    /// A controller with the gains `kp` (throttle per m/s, s/m) and `ki` (throttle per m, 1/m).
    #[must_use]
    pub fn new(kp: f64, ki: f64) -> Self {
        Self { kp, ki, integral: 0.0 }
    }

    /// The throttle and the brake, each in [0, 1], that lead from `speed` to `target` (m/s). `dt` is the time since the
    /// last call, s.
    pub fn update(&mut self, target: f64, speed: f64, dt: f64) -> (f64, f64) {
        let error = target - speed;
        let integral = self.integral + self.ki * error * dt;
        let wanted = self.kp * error + integral;
        // While the output is saturated the integral may only move back: otherwise it winds up.
        if wanted.abs() <= 1.0 || wanted * error < 0.0 {
            self.integral = integral;
        }
        let u = wanted.clamp(-1.0, 1.0);
        if u >= 0.0 { (u, 0.0) } else { (0.0, -u) }
    }

    /// Sets the integral to 0.
    pub fn reset(&mut self) {
        self.integral = 0.0;
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
}
