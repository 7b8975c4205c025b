//! Wheel spins under driveline and brakes.

use super::{MAX_WHEELS, Vehicle};
use crate::state::Controls;

impl Vehicle {
    /// Advances the spins; returns the torque of driveline and brake on each wheel, which the chassis reacts.
    pub(super) fn spin_wheels(&mut self, controls: Controls, dt: f64) -> [f64; MAX_WHEELS] {
        for (s, c) in self.spins.iter_mut().zip(&self.corners) {
            *s = c.spin;
        }
        let common = self.drive.common_inertia;
        let drive = self.drive.torques(&self.spins, controls.throttle, dt);
        let mut torque = [0.0; MAX_WHEELS];
        let mut held = [false; MAX_WHEELS];
        let (mut sum, mut inertia, mut count) = (0.0, 0.0, 0.0);
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            let shared = if c.driven { common } else { 0.0 };
            let free = f.spin_moment + drive[i];
            // The brake's torque is that which stops the wheel in this step, as far as it reaches.
            let cap = controls.brake * c.brake_torque;
            let stop = -c.spin * (c.spin_inertia + shared) / dt - free;
            held[i] = cap > 0.0 && stop.abs() <= cap;
            let brake = stop.clamp(-cap, cap);
            torque[i] = drive[i] + brake;
            if c.driven {
                sum += free + brake;
                inertia += c.spin_inertia + common;
                count += 1.0;
            }
        }
        let common_moment = if count > 0.0 { common * sum / inertia } else { 0.0 };
        for (i, (c, f)) in self.corners.iter_mut().zip(&self.forces).enumerate() {
            let shared = if c.driven { common_moment } else { 0.0 };
            c.spin += dt * (f.spin_moment + torque[i] - shared) / c.spin_inertia;
            if held[i] {
                c.spin = 0.0;
            }
        }
        torque
    }
}
