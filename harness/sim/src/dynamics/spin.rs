//! Wheel spins under driveline and brakes.

use super::Vehicle;
use crate::V3;
use crate::powertrain::{Demand, Wheels};
use crate::state::{Controls, Gear};
use vb_vehicle::MAX_WHEELS;

impl Vehicle {
    /// What the driver asks of the powertrain, with what a governor leaves of the throttle. In reverse the governor looks at
    /// the speed backwards. The gearbox goes by the speed of the reference point, which is what a driver is told.
    pub(super) fn demand(&self, controls: &Controls) -> Demand {
        let forward = self.q * V3::x();
        let speed = self.v.dot(&forward);
        let ahead = if self.drive.gear() == Gear::Reverse { -speed } else { speed };
        let throttle = self.governor.map_or(controls.throttle, |g| controls.throttle.min(g.ceiling(ahead)));
        let turning = self.w.cross(&(self.q * self.reference)).dot(&forward);
        Demand { throttle, gear: controls.gear, speed: speed + turning }
    }

    /// Advances the spins; returns the torque of driveline and brake on each wheel, which the chassis reacts.
    pub(super) fn spin_wheels(&mut self, controls: Controls, dt: f64) -> [f64; MAX_WHEELS] {
        let n = self.corners.len();
        let (mut spins, mut moments) = ([0.0; MAX_WHEELS], [0.0; MAX_WHEELS]);
        let (mut brakes, mut torques) = ([0.0; MAX_WHEELS], [0.0; MAX_WHEELS]);
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            spins[i] = c.spin;
            moments[i] = f.spin_moment;
            brakes[i] = controls.brake * c.brake_torque;
        }
        let mut wheels = Wheels {
            spins: &mut spins[..n],
            moments: &moments[..n],
            brakes: &brakes[..n],
            torques: &mut torques[..n],
        };
        let demand = self.demand(&controls);
        self.drive.advance(&demand, &mut wheels, dt);
        for (c, spin) in self.corners.iter_mut().zip(spins) {
            c.spin = spin;
        }
        torques
    }
}
