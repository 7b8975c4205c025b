//! The linkage of a double wishbone and its solution.

use super::Row;
use crate::V3;
use crate::spec::Hardpoints;
use nalgebra::{Matrix6, UnitQuaternion, Vector6};

pub(super) struct Linkage {
    /// (chassis end, upright end relative to the spindle, whether the rack moves the chassis end).
    links: [(V3, V3, bool); 5],
    lengths: [f64; 5],
    pub(super) spindle: V3,
    strut_chassis: V3,
    strut_upright: V3,
}

impl Linkage {
    pub(super) fn new(h: &Hardpoints) -> Self {
        let v = |p: [f64; 3]| V3::new(p[0], p[1], p[2]);
        let spindle = v(h.spindle);
        let link =
            |chassis: [f64; 3], upright: [f64; 3], rack: bool| (v(chassis), v(upright) - spindle, rack);
        let links = [
            link(h.upper_arm_front, h.upper_ball_joint, false),
            link(h.upper_arm_rear, h.upper_ball_joint, false),
            link(h.lower_arm_front, h.lower_ball_joint, false),
            link(h.lower_arm_rear, h.lower_ball_joint, false),
            link(h.tie_rod_inner, h.tie_rod_outer, true),
        ];
        let lengths = links.map(|(c, u, _)| (u + spindle - c).norm());
        Self {
            links,
            lengths,
            spindle,
            strut_chassis: v(h.strut_chassis),
            strut_upright: v(h.strut_upright) - spindle,
        }
    }

    /// The upright's pose (position of the spindle, rotation) at a travel and a rack displacement, from a nearby one.
    pub(super) fn solve(
        &self,
        travel: f64,
        rack: f64,
        from: (V3, UnitQuaternion<f64>),
    ) -> Option<(V3, UnitQuaternion<f64>)> {
        let (mut p, mut q) = from;
        for _ in 0..40 {
            let mut residual = Vector6::zeros();
            let mut jacobian = Matrix6::zeros();
            for (k, &(chassis, upright, moved)) in self.links.iter().enumerate() {
                let r = q * upright;
                let d = p + r - chassis - if moved { V3::y() * rack } else { V3::zeros() };
                let length = d.norm();
                let n = d / length;
                residual[k] = length - self.lengths[k];
                jacobian.fixed_view_mut::<1, 3>(k, 0).copy_from(&n.transpose());
                jacobian.fixed_view_mut::<1, 3>(k, 3).copy_from(&r.cross(&n).transpose());
            }
            residual[5] = p.z - self.spindle.z - travel;
            jacobian[(5, 2)] = 1.0;
            if residual.amax() < 1e-13 {
                return Some((p, q));
            }
            let step = jacobian.lu().solve(&residual)?;
            p -= step.fixed_rows::<3>(0);
            q = UnitQuaternion::from_scaled_axis(-step.fixed_rows::<3>(3).into_owned()) * q;
            // The next position lies millimetres away: a larger step is a branch beyond a dead centre.
            if step.iter().any(|x| !x.is_finite() || x.abs() > 0.5) {
                return None;
            }
        }
        None
    }

    pub(super) fn row(&self, (p, q): (V3, UnitQuaternion<f64>)) -> Row {
        let axis = q * V3::y();
        let strut = (p + q * self.strut_upright - self.strut_chassis).norm();
        [p.x, p.y, axis.x, axis.z, strut]
    }
}
