//! Elimination of the corners and the solution for the accelerations.

use super::{Guide, Vehicle};
use crate::{M3, V3};
use vb_vehicle::MAX_WHEELS;
use vb_vehicle::table::interpolate;

pub(super) fn skew(r: &V3) -> M3 {
    M3::new(0.0, -r.z, r.y, r.z, 0.0, -r.x, -r.y, r.x, 0.0)
}

/// Solves [A C; Cᵀ L] (α, a) = (moment, force) by Cholesky's decomposition; not a number where the matrix isn't positive
/// definite. It is for every finite state; if it isn't, the state isn't finite, which the caller reports.
///
/// Written out since nalgebra's own goes through views of a size that is known when it runs, which takes several times as
/// long. The order of operations is the same.
#[inline]
fn accelerations(angular: &M3, coupling: &M3, linear: &M3, moment: &V3, force: &V3) -> (V3, V3) {
    const N: usize = 6;
    // Lower triangle, column by column.
    let mut l = [[0.0; N]; N];
    for j in 0..3 {
        for i in 0..3 {
            l[j][i] = angular[(i, j)];
            l[j][3 + i] = coupling[(j, i)];
            l[3 + j][3 + i] = linear[(i, j)];
        }
    }
    let mut b = [moment.x, moment.y, moment.z, force.x, force.y, force.z];
    for j in 0..N {
        for k in 0..j {
            let column = l[k];
            let factor = -column[j];
            for (value, x) in l[j][j..].iter_mut().zip(&column[j..]) {
                *value += factor * x;
            }
        }
        let diagonal = l[j][j];
        if diagonal.is_nan() || diagonal <= 0.0 {
            return (V3::repeat(f64::NAN), V3::repeat(f64::NAN));
        }
        let root = diagonal.sqrt();
        l[j][j] = root;
        for value in &mut l[j][j + 1..] {
            *value /= root;
        }
    }
    for i in 0..N {
        b[i] /= l[i][i];
        for k in i + 1..N {
            b[k] += -b[i] * l[i][k];
        }
    }
    for i in (0..N).rev() {
        let mut sum = 0.0;
        for k in i + 1..N {
            sum += l[i][k] * b[k];
        }
        b[i] = (b[i] - sum) / l[i][i];
    }
    (V3::new(b[0], b[1], b[2]), V3::new(b[3], b[4], b[5]))
}

impl Vehicle {
    /// Of the air, N, world axes.
    fn resistance(&self) -> V3 {
        let speed = self.v.norm();
        if self.resistance.is_empty() || speed <= 0.0 {
            return V3::zeros();
        }
        // A table that starts above zero must not push a vehicle at rest.
        let force = interpolate(&self.resistance, speed).0 * (speed / 0.1).min(1.0);
        self.v * (-force / speed)
    }

    pub(super) fn solve(&mut self, turn: &M3, axle_torques: &[f64; MAX_WHEELS], dt: f64) {
        let inertia = turn * M3::from_diagonal(&self.inertia) * turn.transpose();
        let gravity = self.gravity;
        let mut angular = inertia;
        let mut coupling = M3::zeros();
        let mut linear = M3::from_diagonal_element(self.mass);
        let mut moment = -self.w.cross(&(inertia * self.w));
        let mut force = gravity * self.mass + self.resistance();
        // Per corner: M t, tᵀMt with the dampers' implicit part, right-hand side.
        let mut reduced = [(V3::zeros(), 0.0, 0.0); MAX_WHEELS];
        // What anti-roll bars add: force along the travel, implicit damping.
        let mut twisted = [(0.0, 0.0); MAX_WHEELS];
        for bar in &self.bars {
            let pair = [bar.left, bar.left + 1];
            let [l, r] = pair.map(|i| (&self.corners[i], &self.forces[i]));
            let rate = l.1.bar_rate * l.0.travel_rate - r.1.bar_rate * r.0.travel_rate;
            let torque = bar.stiffness * (l.1.bar - r.1.bar) + bar.damping * rate;
            for (i, sign) in pair.into_iter().zip([1.0, -1.0]) {
                let ratio = self.forces[i].bar_rate;
                twisted[i] = (-sign * torque * ratio, bar.damping * ratio * ratio);
            }
        }
        for (i, (c, f)) in self.corners.iter().zip(&self.forces).enumerate() {
            // The driveline reacts on the chassis; a spinning wheel resists being turned.
            let gyroscopic = self.w.cross(&(f.axis * (c.spin_inertia * c.spin)));
            moment += f.moment - f.axis * axle_torques[i] - gyroscopic;
            if let Guide::Beam(_) = c.guide {
                continue;
            }
            if let Guide::Mount(_) = c.guide {
                let bias = self.w.cross(&self.w.cross(&f.arm));
                let passed = f.force + gravity * c.mass - f.inertia * bias;
                let s = skew(&f.arm);
                let sm = s * f.inertia;
                angular -= sm * s;
                coupling += sm;
                linear += f.inertia;
                force += passed;
                moment += f.arm.cross(&passed);
                continue;
            }
            let (mut along, mut damping) = twisted[i];
            for (k, strut) in c.struts.iter().enumerate().take(2) {
                let ratio = f.strut_rates[k];
                let resistance = strut.resistance(ratio * c.travel_rate) * ratio * ratio;
                along += strut.force(f.struts[k]) * ratio - resistance * c.travel_rate;
                damping += resistance;
            }
            if let Some(stops) = &c.stops {
                along -= stops.force(c.travel);
            }
            let bias = self.w.cross(&self.w.cross(&f.arm))
                + self.w.cross(&f.tangent) * (2.0 * c.travel_rate)
                + f.bend;
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
            moment += f.arm.cross(&passed);
            reduced[i] = (mt, d, rhs);
        }
        let mut beams = [None; MAX_WHEELS / 2];
        for (b, kept) in self.beams.iter().zip(&mut beams) {
            let pair = b.left..b.left + 2;
            let (p, remembered) =
                b.eliminate(&self.corners[pair.clone()], &self.forces[pair], &self.w, &self.gravity, dt);
            angular += p.angular;
            coupling += p.coupling;
            linear += p.linear;
            moment += p.moment;
            force += p.force;
            *kept = Some(remembered);
        }
        let (alpha, acceleration) = accelerations(&angular, &coupling, &linear, &moment, &force);
        for (i, (c, f)) in self.corners.iter_mut().zip(&self.forces).enumerate() {
            if !matches!(c.guide, Guide::Table(_)) {
                continue;
            }
            let (mt, d, rhs) = reduced[i];
            let hub = acceleration + alpha.cross(&f.arm);
            c.travel_rate += dt * (rhs - mt.dot(&hub)) / d;
            c.travel += dt * c.travel_rate;
        }
        for (b, kept) in self.beams.iter().zip(&beams) {
            let Some(kept) = kept else { continue };
            let travels = kept.travels(&alpha, &acceleration);
            for (c, change) in self.corners[b.left..b.left + 2].iter_mut().zip(travels.iter()) {
                c.travel_rate += dt * change;
                c.travel += dt * c.travel_rate;
            }
        }
        self.v += acceleration * dt;
        self.w += alpha * dt;
    }
}
