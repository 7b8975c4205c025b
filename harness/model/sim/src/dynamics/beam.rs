//! Solid axles in the equations of motion.
//!
//! A beam with its wheels is a set of point masses on one line that move with two travels q: the two hubs, each with its
//! wheel's mass, and the beam's middle ([`Beam`](super::design::Beam) says what stands for the beam). With
//! a = G ẍ + T q̈ + b for the acceleration of a point, G = [−r×, 1] and ẍ that of the chassis, the travels follow from
//! (Σ Tᵀ M T) q̈ = Q − Σ Tᵀ M (G ẍ + b) and are eliminated.

use super::contact::Forces;
use super::design::Design;
use super::kinematics::Kinematics;
use crate::{M3, V3};
use nalgebra::{Matrix2, Matrix3x2, Vector2};

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

/// Eliminates the travels of the two wheels on the beam of this number; `gravity` is in world axes.
pub(super) fn eliminate(
    design: &Design,
    number: usize,
    kinematics: &Kinematics<'_>,
    forces: &[Forces],
    gravity: &V3,
    dt: f64,
) -> (Passed, Remembered) {
    let (beam, place) = (&design.beams[number], &kinematics.beams[number]);
    let pair = beam.left..beam.left + 2;
    let wheels = &kinematics.wheels[pair.clone()];
    let corners =
        design.corners[pair.clone()].iter().zip(&kinematics.placements[pair.clone()]).zip(&forces[pair]);
    let w = &kinematics.body.w_world;
    let rates = Vector2::new(wheels[0].travel_rate, wheels[1].travel_rate);
    let mut d = Matrix2::zeros();
    let mut rhs = Vector2::zeros();
    let (mut h_angular, mut h_linear) = (Matrix3x2::zeros(), Matrix3x2::zeros());
    let mut passed = Passed {
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
        let s = arm.cross_matrix();
        let sm = s * inertia;
        passed.angular -= sm * s;
        passed.coupling += sm;
        passed.linear += inertia;
        passed.moment += arm.cross(&rest);
        passed.force += rest;
        h_angular += s * mt;
        h_linear += mt;
    };
    let middle = M3::from_diagonal_element(beam.at_middle);
    point(&place.arm, place.tangents, &place.bend, &middle, &(gravity * beam.at_middle));
    for (i, ((c, p), f)) in corners.clone().enumerate() {
        let mut tangents = [p.tangent; 2];
        tangents[1 - i] = place.cross[i];
        let inertia = f.inertia + M3::from_diagonal_element(beam.at_hub);
        let applied = f.force + gravity * (c.mass + beam.at_hub);
        point(&p.arm, tangents, &p.bend, &inertia, &applied);
    }
    for (i, ((c, p), f)) in corners.enumerate() {
        rhs[i] += p.tilt.dot(&f.moment);
        rhs[1 - i] += place.cross_tilt[i].dot(&f.moment);
        for (k, strut) in c.struts.iter().enumerate().take(2) {
            let [a, b] = place.strut_rates[i][k];
            let along = Vector2::new(a, b);
            let rate = along.dot(&rates);
            let damping = strut.resistance(rate);
            rhs += along * (strut.force(p.struts[k]) - damping * rate);
            d += along * along.transpose() * (dt * damping);
        }
        if let Some(stops) = &c.stops {
            rhs[i] -= stops.force(wheels[i].travel);
        }
    }
    let twist = beam.anti_roll * (wheels[0].travel - wheels[1].travel);
    rhs += Vector2::new(-twist, twist);
    let det = d.m11 * d.m22 - d.m12 * d.m21;
    let inverse = if beam.pivots {
        // One travel alone is left, along (1, −1).
        Matrix2::new(1.0, -1.0, -1.0, 1.0) / (d.m11 - d.m12 - d.m21 + d.m22)
    } else {
        Matrix2::new(d.m22, -d.m12, -d.m21, d.m11) / det
    };
    let (over_angular, over_linear) = (h_angular * inverse, h_linear * inverse);
    passed.angular -= over_angular * h_angular.transpose();
    passed.coupling -= over_angular * h_linear.transpose();
    passed.linear -= over_linear * h_linear.transpose();
    passed.moment -= over_angular * rhs;
    passed.force -= over_linear * rhs;
    (passed, Remembered { inverse, angular: h_angular, linear: h_linear, rhs })
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
    use super::{Forces, eliminate};
    use crate::V3;
    use crate::dynamics::tests::{build, on_beams};

    #[test]
    fn forces_at_a_wheels_contact_do_their_virtual_work_on_both_travels() {
        let mut spec = on_beams(0.0);
        for axle in &mut spec.axles {
            axle.suspension.struts.iter_mut().for_each(|s| s.spring = None);
            axle.suspension.stops = None;
        }
        let mut v = build(&spec);
        let travels = [0.05, -0.03];
        (v.state.wheels[0].travel, v.state.wheels[1].travel) = (travels[0], travels[1]);
        let beam = v.design.beams[0].clone();
        let (design, gravity) = (v.design.clone(), v.gravity_world);
        let kinematics = v.placed();
        let axis = kinematics.placements[0].motion.axis;
        let mut forces: Vec<_> = design.corners.iter().map(|c| Forces::none(c.mass)).collect();
        let rhs = |forces: &[Forces]| eliminate(&design, 0, &kinematics, forces, &gravity, 1e-3).1.rhs;
        let before = rhs(&forces);
        let (force, arm) = (V3::new(40.0, 300.0, 500.0), V3::new(0.05, 0.02, -0.4));
        let moment = arm.cross(&force);
        forces[0].force = force;
        forces[0].moment = moment - axis * axis.dot(&moment);
        let work = rhs(&forces) - before;
        // The contact moves with the hub and with the axle's direction; about its axle the wheel is free.
        let h = 1e-6;
        for j in 0..2 {
            let at = |d: f64| {
                let mut q = travels;
                q[j] += d;
                beam.kinematics.at(q, [0.0; 2], 0.0).wheels[0]
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
