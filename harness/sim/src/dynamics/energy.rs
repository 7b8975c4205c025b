//! The vehicle's mechanical energy.

use super::{Guide, Vehicle};

impl Vehicle {
    /// Kinetic energy and energy of height less the work that the engine has done so far, J. Energy held by springs and
    /// tyres is not in it. Wheels are taken where they were at the start of the last step, which is a joule or two.
    pub(crate) fn energy_balance(&self) -> f64 {
        let spin = self.q.inverse() * self.w;
        let mut kinetic =
            0.5 * (self.mass * self.v.norm_squared() + spin.dot(&self.inertia.component_mul(&spin)));
        let mut height = -self.mass * self.gravity.dot(&self.x);
        for (c, f) in self.corners.iter().zip(&self.forces) {
            let mut mass = c.mass;
            let mut velocity = self.v + self.w.cross(&f.arm) + f.tangent * c.travel_rate;
            if let Guide::Beam(b) = c.guide {
                let b = &self.beams[b];
                let i = c.side.index();
                mass += b.hub_mass();
                velocity += b.cross[i] * self.corners[b.left + 1 - i].travel_rate;
            }
            kinetic += 0.5 * mass * velocity.norm_squared();
            height -= mass * self.gravity.dot(&(self.x + f.arm));
        }
        for b in &self.beams {
            let rates = [0, 1].map(|i| self.corners[b.left + i].travel_rate);
            let velocity =
                self.v + self.w.cross(&b.arm) + b.tangents[0] * rates[0] + b.tangents[1] * rates[1];
            kinetic += 0.5 * b.middle_mass() * velocity.norm_squared();
            height -= b.middle_mass() * self.gravity.dot(&(self.x + b.arm));
        }
        kinetic
            + height
            + self
                .drive
                .energy(|i| self.tracks.get(i).map_or(self.corners[i].spin, super::Track::sprocket_spin))
            - self.drive.work()
    }

    /// The energy that lifts the vehicle by the radius of a wheel, J.
    pub(crate) fn lift_energy(&self) -> f64 {
        self.composite().0 * vb_vehicle::GRAVITY * self.tyres[0].envelope().radius()
    }
}
