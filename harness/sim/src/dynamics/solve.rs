//! Elimination of the corners and the solution for the accelerations.

use super::{MAX_WHEELS, Vehicle};
use crate::{M3, V3};
use nalgebra::{Matrix6, Vector6};

fn skew(r: &V3) -> M3 {
    M3::new(0.0, -r.z, r.y, r.z, 0.0, -r.x, -r.y, r.x, 0.0)
}

impl Vehicle {
    pub(super) fn solve(&mut self, turn: &M3, axle_torques: &[f64; MAX_WHEELS], dt: f64) {
        let inertia = turn * M3::from_diagonal(&self.inertia) * turn.transpose();
        let gravity = self.gravity;
        let mut angular = inertia;
        let mut coupling = M3::zeros();
        let mut linear = M3::from_diagonal_element(self.mass);
        let mut moment = -self.w.cross(&(inertia * self.w));
        let mut force = gravity * self.mass;
        // Per corner: M t, tᵀMt with the dampers' implicit part, right-hand side.
        let mut reduced = [(V3::zeros(), 0.0, 0.0); MAX_WHEELS];
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            let spring = c.spring.stiffness * (c.spring.free_length - f.strut) * f.strut_rate;
            let damping = c.damper.coefficient * f.strut_rate * f.strut_rate;
            let mut along = spring - damping * c.travel_rate;
            if c.travel > c.stops.jounce {
                along -= c.stops.stiffness * (c.travel - c.stops.jounce);
            } else if c.travel < c.stops.rebound {
                along -= c.stops.stiffness * (c.travel - c.stops.rebound);
            }
            let bias = self.w.cross(&self.w.cross(&f.arm)) + self.w.cross(&f.tangent) * (2.0 * c.travel_rate);
            let applied = f.force + gravity * c.mass;
            let mt = f.inertia * f.tangent;
            let d = mt.dot(&f.tangent) + dt * damping;
            let rhs = f.tangent.dot(&applied) + f.tilt.dot(&f.moment) + along - mt.dot(&bias);
            let articulated = f.inertia - mt * mt.transpose() / d;
            let passed = applied - f.inertia * bias - mt * (rhs / d);
            let s = skew(&f.arm);
            let sm = s * articulated;
            angular -= sm * s;
            coupling += sm;
            linear += articulated;
            force += passed;
            // The driveline reacts on the chassis; a spinning wheel resists being turned.
            let gyroscopic = self.w.cross(&(f.axis * (c.spin_inertia * c.spin)));
            moment += f.arm.cross(&passed) + f.moment - f.axis * axle_torques[i] - gyroscopic;
            reduced[i] = (mt, d, rhs);
        }
        let mut a = Matrix6::zeros();
        a.fixed_view_mut::<3, 3>(0, 0).copy_from(&angular);
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling);
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&coupling.transpose());
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&linear);
        let mut b = Vector6::zeros();
        b.fixed_rows_mut::<3>(0).copy_from(&moment);
        b.fixed_rows_mut::<3>(3).copy_from(&force);
        // Positive definite for every finite state; if it isn't, the state isn't finite, which the caller reports.
        let solution = a.cholesky().map_or_else(|| Vector6::repeat(f64::NAN), |c| c.solve(&b));
        let alpha = solution.fixed_rows::<3>(0).into_owned();
        let acceleration = solution.fixed_rows::<3>(3).into_owned();
        for (i, (c, f)) in self.corners.iter_mut().zip(&self.forces).enumerate() {
            let (mt, d, rhs) = reduced[i];
            let hub = acceleration + alpha.cross(&f.arm);
            c.travel_rate += dt * (rhs - mt.dot(&hub)) / d;
            c.travel += dt * c.travel_rate;
        }
        self.v += acceleration * dt;
        self.w += alpha * dt;
    }
}
