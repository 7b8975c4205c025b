//! The spans of a belt among the grains of a bed.

use super::super::design::Track;
use super::super::kinematics::Kinematics;
use super::super::state::Belt;
use super::{Laid, Push, TrackStep, in_world, share_out};
use crate::{M3, Quat, V3};
use vb_granular::Motion;

impl Laid {
    /// The motion of a span's plate, whose surface moves with the belt.
    pub(in super::super) fn span_motion(
        &self,
        track: &Track,
        belt: &Belt,
        kinematics: &Kinematics<'_>,
        j: usize,
    ) -> Motion {
        let Kinematics { body, turn, wheels, placements, .. } = kinematics;
        let span = &self.course.spans()[j];
        let [x, z] = span.at(0.5);
        let arm = turn * V3::new(x, track.aside, z);
        let backward = in_world(turn, span.direction);
        let axes =
            M3::from_columns(&[-backward, turn.column(1).into_owned(), -in_world(turn, span.outward())]);
        let follows = |i: usize| placements[i].tangent * (0.5 * wheels[i].travel_rate);
        Motion {
            position: body.x_world + arm,
            rotation: Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes)),
            velocity: body.v_world
                + body.w_world.cross(&arm)
                + follows(track.wheel(j))
                + follows(track.wheel(j + 1))
                + backward * belt.speed,
            spin: body.w_world,
        }
    }
}

impl TrackStep<'_> {
    /// Takes the forces of grains on the spans to the wheels and along the belt.
    pub(super) fn press_grains(&mut self, kinematics: &Kinematics<'_>) {
        let Kinematics { turn, placements, .. } = kinematics;
        let axis = turn.column(1).into_owned();
        for j in 0..self.laid.grains.len() {
            let on_span = self.laid.grains[j];
            if on_span.force == V3::zeros() {
                continue;
            }
            let (length, backward, [x, z]) = {
                let span = &self.laid.course.spans()[j];
                (span.length, in_world(turn, span.direction), span.at(0.5))
            };
            // Where on the span the force has its moment about the axles.
            let lever = axis.dot(&backward.cross(&on_span.force));
            let about = axis.dot(&on_span.moment);
            let behind = if lever.abs() * length > about.abs() { about / lever } else { 0.0 };
            let behind = vb_math::clamp(behind, -0.5 * length, 0.5 * length);
            let fraction = 0.5 + behind / length;
            let at = turn * V3::new(x, self.track.aside, z) + backward * behind;
            let thrust = -on_span.force.dot(&backward);
            self.laid.thrust[j] += thrust * (1.0 - fraction);
            self.laid.thrust[j + 1] += thrust * fraction;
            let load = on_span.force.dot(&turn.column(2)).max(0.0);
            let push = Push { at, force: on_span.force, inertia: M3::zeros(), load };
            let pair = [self.track.wheel(j), self.track.wheel(j + 1)];
            share_out(self.forces, placements, pair, fraction, &push, &axis);
        }
    }
}
