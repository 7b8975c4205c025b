//! Solid axles in the equations of motion.
//!
//! A beam with its wheels is a set of point masses on one line that move with two travels q: the two hubs, each with its
//! wheel's mass, and the beam's middle. Masses at the hubs and in the middle that have the beam's mass and its moment of
//! inertia stand for the beam (a rod's inertia about its own line left out). With a = G ẍ + T q̈ + b for the
//! acceleration of a point, G = [−r×, 1] and ẍ that of the chassis, the travels follow from
//! (Σ Tᵀ M T) q̈ = Q − Σ Tᵀ M (G ẍ + b) and are eliminated.

use super::{Corner, Forces, solve::skew};
use crate::{M3, V3};
use nalgebra::{Matrix2, Matrix3x2, Vector2};
use std::sync::Arc;
use vb_vehicle::kinematics::BeamAxle;
use vb_vehicle::suspension::Linkage;

/// The beam between two wheels.
#[derive(Clone)]
pub(super) struct Beam {
    pub(super) kinematics: Arc<BeamAxle>,
    /// Number of the left wheel.
    pub(super) left: usize,
    /// The axle's reference point relative to the chassis' centre of mass, body axes.
    pub(super) mount: V3,
    /// All of the beam; what of it is at each hub; and in the middle.
    pub(super) mass: f64,
    at_hub: f64,
    at_middle: f64,
    /// Whether it can only roll.
    pivots: bool,
    /// N/m over the difference of travels.
    anti_roll: f64,
    // Of this step, world axes.
    pub(super) arm: V3,
    pub(super) tangents: [V3; 2],
    pub(super) bend: V3,
    /// ∂hub/∂(the other wheel's travel), and the same of the axle's rotation.
    pub(super) cross: [V3; 2],
    pub(super) cross_tilt: [V3; 2],
    /// `[wheel][strut][travel]`.
    pub(super) strut_rates: [[[f64; 2]; 2]; 2],
}

/// What a unit adds to the equations of the chassis.
pub(super) struct Passed {
    pub(super) angular: M3,
    pub(super) coupling: M3,
    pub(super) linear: M3,
    pub(super) moment: V3,
    pub(super) force: V3,
}

/// What gives the travels' accelerations once the chassis' are known.
#[derive(Clone, Copy)]
pub(super) struct Remembered {
    inverse: Matrix2<f64>,
    /// Σ Gᵀ M T: angular and linear rows.
    angular: Matrix3x2<f64>,
    linear: Matrix3x2<f64>,
    rhs: Vector2<f64>,
}

impl Beam {
    pub(super) fn new(
        kinematics: Arc<BeamAxle>,
        beam: vb_vehicle::suspension::Beam,
        left: usize,
        mount: V3,
        linkage: &Linkage,
        anti_roll: f64,
    ) -> Self {
        let half_track = linkage.spindle()[1];
        let at_hub = 0.5 * beam.inertia / (half_track * half_track);
        Self {
            kinematics,
            left,
            mount,
            mass: beam.mass,
            at_hub,
            at_middle: beam.mass - 2.0 * at_hub,
            pivots: matches!(linkage, Linkage::PivotAxle(_)),
            anti_roll,
            arm: V3::zeros(),
            tangents: [V3::zeros(); 2],
            bend: V3::zeros(),
            cross: [V3::zeros(); 2],
            cross_tilt: [V3::zeros(); 2],
            strut_rates: [[[0.0; 2]; 2]; 2],
        }
    }

    /// The beam's middle in the design position relative to the axle's reference point, m.
    pub(super) fn middle(&self) -> V3 {
        self.kinematics.at([0.0; 2], [0.0; 2], 0.0).middle
    }

    /// What of the beam's mass is at each hub, kg.
    pub(super) fn hub_mass(&self) -> f64 {
        self.at_hub
    }

    /// What of the beam's mass is in its middle, kg.
    pub(super) fn middle_mass(&self) -> f64 {
        self.at_middle
    }

    /// Eliminates the travels of the two wheels; `w` is the chassis' angular velocity, `gravity` in world axes.
    pub(super) fn eliminate(
        &self,
        pair: &[Corner],
        forces: &[Forces],
        w: &V3,
        gravity: &V3,
        dt: f64,
    ) -> (Passed, Remembered) {
        let rates = Vector2::new(pair[0].travel_rate, pair[1].travel_rate);
        let mut d = Matrix2::zeros();
        let mut rhs = Vector2::zeros();
        let (mut h_angular, mut h_linear) = (Matrix3x2::zeros(), Matrix3x2::zeros());
        let mut p = Passed {
            angular: M3::zeros(),
            coupling: M3::zeros(),
            linear: M3::zeros(),
            moment: V3::zeros(),
            force: V3::zeros(),
        };
        let mut point = |arm: &V3, tangents: [V3; 2], bend: &V3, inertia: &M3, applied: &V3| {
            let t = Matrix3x2::from_columns(&tangents);
            let mt = inertia * t;
            let bias = w.cross(&w.cross(arm)) + w.cross(&(t * rates)) * 2.0 + bend;
            let rest = applied - inertia * bias;
            d += t.transpose() * mt;
            rhs += t.transpose() * rest;
            let s = skew(arm);
            let sm = s * inertia;
            p.angular -= sm * s;
            p.coupling += sm;
            p.linear += inertia;
            p.moment += arm.cross(&rest);
            p.force += rest;
            h_angular += s * mt;
            h_linear += mt;
        };
        let middle = M3::from_diagonal_element(self.at_middle);
        point(&self.arm, self.tangents, &self.bend, &middle, &(gravity * self.at_middle));
        for (i, (c, f)) in pair.iter().zip(forces).enumerate() {
            let mut tangents = [f.tangent; 2];
            tangents[1 - i] = self.cross[i];
            let inertia = f.inertia + M3::from_diagonal_element(self.at_hub);
            let applied = f.force + gravity * (c.mass + self.at_hub);
            point(&f.arm, tangents, &f.bend, &inertia, &applied);
        }
        for (i, (c, f)) in pair.iter().zip(forces).enumerate() {
            rhs[i] += f.tilt.dot(&f.moment);
            rhs[1 - i] += self.cross_tilt[i].dot(&f.moment);
            for (k, strut) in c.struts.iter().enumerate().take(2) {
                let [a, b] = self.strut_rates[i][k];
                let along = Vector2::new(a, b);
                let rate = along.dot(&rates);
                let damping = strut.resistance(rate);
                rhs += along * (strut.force(f.struts[k]) - damping * rate);
                d += along * along.transpose() * (dt * damping);
            }
            if let Some(stops) = &c.stops {
                rhs[i] -= stops.force(c.travel);
            }
        }
        let twist = self.anti_roll * (pair[0].travel - pair[1].travel);
        rhs += Vector2::new(-twist, twist);
        let det = d.m11 * d.m22 - d.m12 * d.m21;
        let inverse = if self.pivots {
            // One travel alone is left, along (1, −1).
            Matrix2::new(1.0, -1.0, -1.0, 1.0) / (d.m11 - d.m12 - d.m21 + d.m22)
        } else {
            Matrix2::new(d.m22, -d.m12, -d.m21, d.m11) / det
        };
        let (over_angular, over_linear) = (h_angular * inverse, h_linear * inverse);
        p.angular -= over_angular * h_angular.transpose();
        p.coupling -= over_angular * h_linear.transpose();
        p.linear -= over_linear * h_linear.transpose();
        p.moment -= over_angular * rhs;
        p.force -= over_linear * rhs;
        (p, Remembered { inverse, angular: h_angular, linear: h_linear, rhs })
    }
}

impl Remembered {
    /// Accelerations of the two travels under those of the chassis.
    pub(super) fn travels(&self, alpha: &V3, acceleration: &V3) -> Vector2<f64> {
        let chassis = self.angular.transpose() * alpha + self.linear.transpose() * acceleration;
        self.inverse * (self.rhs - chassis)
    }
}

#[cfg(test)]
mod tests {
    use crate::dynamics::tests::{build, on_beams};
    use crate::{M3, V3};

    #[test]
    fn forces_at_a_wheels_contact_do_their_virtual_work_on_both_travels() {
        let mut spec = on_beams(0.0);
        for axle in &mut spec.axles {
            axle.suspension.struts.iter_mut().for_each(|s| s.spring = None);
            axle.suspension.stops = None;
        }
        let mut v = build(&spec);
        let travels = [0.05, -0.03];
        (v.corners[0].travel, v.corners[1].travel) = (travels[0], travels[1]);
        v.place_wheels(&M3::identity(), 0.0);
        let rhs = |v: &crate::dynamics::Vehicle| {
            v.beams[0].eliminate(&v.corners[..2], &v.forces[..2], &V3::zeros(), &v.gravity, 1e-3).1.rhs
        };
        let before = rhs(&v);
        let (force, arm) = (V3::new(40.0, 300.0, 500.0), V3::new(0.05, 0.02, -0.4));
        let axis = v.forces[0].axis;
        let moment = arm.cross(&force);
        v.forces[0].force = force;
        v.forces[0].moment = moment - axis * axis.dot(&moment);
        let work = rhs(&v) - before;
        // The contact moves with the hub and with the axle's direction; about its axle the wheel is free.
        let h = 1e-6;
        for j in 0..2 {
            let at = |d: f64| {
                let mut q = travels;
                q[j] += d;
                v.beams[0].kinematics.at(q, [0.0; 2], 0.0).wheels[0]
            };
            let (a, b) = (at(-h), at(h));
            let tilt = axis.cross(&((b.axis - a.axis) / (2.0 * h)));
            let moves = (b.hub - a.hub) / (2.0 * h) + tilt.cross(&arm);
            let spun = axis * axis.dot(&moment);
            let expected = force.dot(&moves) - tilt.dot(&spun);
            assert!((work[j] - expected).abs() < 1e-3, "{j}: {} {expected}", work[j]);
            assert!(expected.abs() > 10.0, "{j}: both travels feel it: {expected}");
        }
    }
}
