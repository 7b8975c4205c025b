//! The torque of engines over speed and throttle.

use super::Engine;
use crate::table::interpolate;

/// Part of its maximum speed over which the torque of a simple engine ends. Ours: the source drops it at once, which
/// chatters.
const CUT_OFF: f64 = 0.01;

/// The torque of an engine and how it changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EngineTorque {
    /// The torque, N m; negative is drag.
    pub torque: f64,
    /// ∂torque/∂speed, N m s.
    pub by_speed: f64,
    /// ∂torque/∂throttle, N m.
    pub by_throttle: f64,
}

impl Engine {
    /// The torque at an engine speed (rad/s, ≥ 0) and a throttle in [0, 1], N m.
    #[must_use]
    pub fn torque(&self, speed: f64, throttle: f64) -> f64 {
        self.torque_and_slopes(speed, throttle).torque
    }

    /// The inertia of the engine, at its own speed, kg m².
    #[must_use]
    #[inline]
    pub fn inertia(&self) -> f64 {
        match self {
            Self::Map { inertia, .. } | Self::Simple { inertia, .. } | Self::Electric { inertia, .. } => {
                *inertia
            }
        }
    }

    /// The torque and its slopes at an engine speed (rad/s, ≥ 0) and a throttle in [0, 1].
    #[inline]
    #[must_use]
    pub fn torque_and_slopes(&self, speed: f64, throttle: f64) -> EngineTorque {
        let (mut throttle, mut gain) = (throttle, 1.0);
        let ((full, full_slope), (closed, closed_slope)) = match self {
            Self::Map { full_throttle, closed_throttle, .. } => {
                (interpolate(full_throttle, speed), interpolate(closed_throttle, speed))
            }
            Self::Simple { torque, power, max_speed, .. } => {
                (simple(*torque, *power, *max_speed, speed), (0.0, 0.0))
            }
            Self::Electric { torque, regeneration, friction, voltage, .. } => {
                if !voltage.is_empty() {
                    (throttle, gain) = interpolate(voltage, throttle);
                }
                // Armature with constant flux: torque ∝ (voltage − back-EMF), so shorted it brakes ∝ speed.
                let (stall, no_load) = (torque[0][1], torque[torque.len() - 1][0]);
                let slope = -regeneration * stall / no_load;
                (interpolate(torque, speed), (slope * speed - friction, slope))
            }
        };
        EngineTorque {
            torque: closed + (full - closed) * throttle,
            by_speed: closed_slope + (full_slope - closed_slope) * throttle,
            by_throttle: (full - closed) * gain,
        }
    }
}

/// Torque of a simple engine at full throttle and its derivative: T up to P/T, then P over speed.
#[inline]
fn simple(torque: f64, power: f64, max_speed: f64, speed: f64) -> (f64, f64) {
    let (t, slope) =
        if speed * torque <= power { (torque, 0.0) } else { (power / speed, -power / (speed * speed)) };
    let over = (speed - max_speed) / (CUT_OFF * max_speed);
    if over <= 0.0 {
        (t, slope)
    } else if over < 1.0 {
        (t * (1.0 - over), slope * (1.0 - over) - t / (CUT_OFF * max_speed))
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simple_engine_gives_its_torque_then_its_power_then_nothing() {
        // Gator (vehicles/gator.yaml): 200 N m, 14 kW, 3500 rpm; corner speed 70 rad/s.
        let e = Engine::Simple { torque: 200.0, power: 14_000.0, max_speed: 366.519, inertia: 0.0 };
        assert_eq!(e.torque(0.0, 1.0), 200.0);
        assert_eq!(e.torque(69.9, 0.5), 100.0);
        assert!((e.torque(140.0, 1.0) - 100.0).abs() < 1e-12);
        assert!((e.torque(350.0, 1.0) * 350.0 - 14_000.0).abs() < 1e-9);
        assert_eq!(e.torque(371.0, 1.0), 0.0);
        assert_eq!(e.torque(100.0, 0.0), 0.0);
    }

    #[test]
    fn a_motor_with_full_regeneration_is_a_direct_current_motor() {
        // T = T_stall (u − ω/ω₀); ARTcar: 1.6 N m, 503.7 rad/s (vehicles/artcar.yaml).
        let motor = |regeneration| Engine::Electric {
            torque: vec![[0.0, 1.6], [503.702, 0.0]],
            regeneration,
            friction: 0.0,
            voltage: Vec::new(),
            inertia: 0.0,
        };
        for (u, w) in [(1.0, 0.0), (1.0, 251.851), (0.3, 300.0), (0.0, 100.0)] {
            let expected = 1.6 * (u - w / 503.702);
            assert!((motor(1.0).torque(w, u) - expected).abs() < 1e-12, "{u} {w}");
        }
        assert_eq!(motor(0.0).torque(100.0, 0.0), 0.0);
        // Friction of motor and gears is there with the throttle closed, at rest too.
        let geared = Engine::Electric {
            torque: vec![[0.0, 1.6], [503.702, 0.0]],
            regeneration: 0.0,
            friction: 0.02,
            voltage: Vec::new(),
            inertia: 0.0,
        };
        assert_eq!([geared.torque(0.0, 0.0), geared.torque(200.0, 0.0)], [-0.02, -0.02]);
        assert_eq!(geared.torque(0.0, 1.0), 1.6);
    }

    #[test]
    fn a_speed_controller_sets_the_voltage_of_the_motor() {
        // At the voltage u a motor with T = T_stall (u − ω/ω₀) runs at u ω₀ without load.
        let motor = Engine::Electric {
            torque: vec![[0.0, 1.6], [500.0, 0.0]],
            regeneration: 1.0,
            friction: 0.0,
            voltage: vec![[0.0, 0.0], [0.2, 0.0], [0.6, 0.25], [1.0, 1.0]],
            inertia: 0.0,
        };
        for (throttle, voltage) in [(0.1, 0.0), (0.4, 0.125), (0.6, 0.25), (0.8, 0.625), (1.0, 1.0)] {
            assert!(motor.torque(voltage * 500.0, throttle).abs() < 1e-12, "{throttle}");
            assert!((motor.torque(0.0, throttle) - 1.6 * voltage).abs() < 1e-12, "{throttle}");
        }
        let law = motor.torque_and_slopes(100.0, 0.5);
        let by_throttle = (motor.torque(100.0, 0.5 + 1e-6) - motor.torque(100.0, 0.5 - 1e-6)) / 2e-6;
        assert!((law.by_throttle - by_throttle).abs() < 1e-6, "{} {by_throttle}", law.by_throttle);
    }

    #[test]
    fn the_slopes_are_those_of_the_torque() {
        let map = Engine::Map {
            full_throttle: vec![[0.0, 400.0], [100.0, 900.0], [200.0, -300.0]],
            closed_throttle: vec![[0.0, 0.0], [150.0, -40.0]],
            inertia: 0.0,
        };
        let simple = Engine::Simple { torque: 200.0, power: 14_000.0, max_speed: 300.0, inertia: 0.0 };
        for e in [map, simple] {
            for (speed, throttle) in [(30.0, 0.2), (120.0, 0.8), (180.0, 1.0), (301.5, 0.6)] {
                let l = e.torque_and_slopes(speed, throttle);
                let h = 1e-5;
                let by_speed = (e.torque(speed + h, throttle) - e.torque(speed - h, throttle)) / (2.0 * h);
                let by_throttle = e.torque(speed, 1.0) - e.torque(speed, 0.0);
                assert!((l.by_speed - by_speed).abs() < 1e-5 && (l.by_throttle - by_throttle).abs() < 1e-9);
            }
        }
    }
}
