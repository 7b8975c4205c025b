//! The stage of a step for tracks: a belt about the wheels of each side.
//!
//! A belt doesn't stretch along its way but for its tensioner, so one speed moves all of it, and the wheels of a side turn
//! with it. On hard ground each wheel with the belt around it meets the ground as a wheel does, and between two wheels the
//! belt does ([`span`]); on soil it presses as a whole ([`soil`]). What pushes the belt along its way goes by its tension to
//! the sprocket, what pushes it inwards goes to the wheels.
//!
//! Tension: a massless belt gains what the ground's thrust is from wheel to wheel, T_j = T_{j−1} + F_j from the front to the
//! rear; its mean follows from the length of its way ([`Course`]). Each wheel is pulled by T_j e_j − T_{j−1} e_{j−1}, where e
//! points along a span towards the rear. Taken at the wheels' centres together with the sprocket's reaction on the hull
//! these forces have the moment of the thrust about every point, which is what the equations of motion need.

mod granular;
mod soil;
mod span;

use super::contact::Forces;
use super::design::{Design, Track};
use super::granular::Wrench;
use super::ground::Ground;
use super::kinematics::{Kinematics, Placement};
use super::state::{Belt, Contacts};
use crate::soil::TRACK;
use crate::track::Course;
use crate::{M3, V3};

/// How a belt lies around its wheels in a step.
#[derive(Clone)]
pub(super) struct Laid {
    course: Course,
    /// Forward force of ground and obstacles along the belt at each wheel, N.
    thrust: Vec<f64>,
    /// To which wheels a station's force goes: the wheel in front, and the fraction of the one behind.
    fractions: [(usize, f64); TRACK],
    /// Force of grains on each span in a step, and its moment about the middle of the span.
    pub(super) grains: Vec<Wrench>,
}

impl Laid {
    /// At design height.
    pub(super) fn new(track: &Track) -> Self {
        Self {
            course: track.course.clone(),
            thrust: vec![0.0; track.count()],
            fractions: [(0, 0.0); TRACK],
            grains: vec![Wrench::default(); track.count() - 1],
        }
    }

    /// Lays the belt around the wheels where they are, with no force along it.
    fn lay(&mut self, track: &Track, turn: &M3, placements: &[Placement]) {
        for j in 0..track.count() {
            let hub = turn.tr_mul(&placements[track.wheel(j)].arm);
            self.course.move_to(j, [hub.x, hub.z]);
        }
        self.course.lay();
        self.thrust.fill(0.0);
    }

    /// Forward force of ground and obstacles along the whole belt, N.
    pub(super) fn total_thrust(&self) -> f64 {
        self.thrust.iter().sum()
    }
}

/// A vector in the plane of a track, in world axes.
fn in_world(turn: &M3, [forward, up]: [f64; 2]) -> V3 {
    turn.column(0) * forward + turn.column(2) * up
}

/// Takes what the pads are sheared along with each belt, from each wheel to the one over which they come next: pads stay on
/// the ground where they were laid down until the last wheel has gone over them. The tyre of a wheel sheds its shear at
/// that rate. This comes before the forces on the wheels.
pub(super) fn carry_shear(tracks: &[Track], belts: &[Belt], contacts: &mut [Contacts], dt: f64) {
    for (track, belt) in tracks.iter().zip(belts) {
        let part = dt * belt.speed.abs() / track.spacing;
        let last = track.count() - 2;
        for i in 1..last {
            let (from, to) = if belt.speed >= 0.0 { (last - i, last + 1 - i) } else { (i + 1, i) };
            let sheared = contacts[track.wheel(from)].ground.deflection;
            let patch = &mut contacts[track.wheel(to)].ground;
            for (deflection, more) in patch.deflection.iter_mut().zip(sheared) {
                *deflection += part * more;
            }
        }
    }
}

/// Adds the forces of ground, obstacles, grains and tension on the belts to those on their wheels. `laid` is a buffer for how the belts
/// lie.
pub(super) fn pull_tracks(
    design: &Design,
    kinematics: &Kinematics<'_>,
    ground: &mut Ground<'_>,
    belts: &mut [Belt],
    laid: &mut [Laid],
    forces: &mut [Forces],
    dt: f64,
) {
    let Kinematics { body, turn, placements, .. } = kinematics;
    for ((track, belt), laid) in design.tracks.iter().zip(belts).zip(laid) {
        laid.lay(track, turn, placements);
        let middle = V3::new(track.middle[0], track.aside, track.middle[1]);
        let at = body.x_world + turn * middle;
        let discs = laid.course.discs();
        let reach = 0.5 * (discs[0].centre[0] - discs[track.count() - 1].centre[0]) + 2.0 * track.radius;
        let under = ground.under(at.x, at.y, reach);
        let mut step = TrackStep { track, belt, laid, forces };
        step.touch_spans(kinematics, ground, under, dt);
        if ground.soil.has_soil() {
            step.press_soil(kinematics, ground, under, dt);
        }
        if !ground.beds.is_empty() {
            step.press_grains(kinematics);
        }
        step.pull(turn, dt);
    }
}

struct TrackStep<'a> {
    track: &'a Track,
    belt: &'a mut Belt,
    /// How it lies, and what pushes it along.
    laid: &'a mut Laid,
    /// Forces on all wheels of the vehicle, to which it adds.
    forces: &'a mut [Forces],
}

/// A force on a belt that its wheels take.
struct Push {
    /// Relative to the centre of mass, world axes.
    at: V3,
    force: V3,
    /// What its implicit treatment adds to the mass.
    inertia: M3,
    /// Normal force, N.
    load: f64,
}

impl TrackStep<'_> {
    /// Pulls the wheels with the belt's tension, once its contacts are known.
    fn pull(&mut self, turn: &M3, dt: f64) {
        let track = self.track;
        let count = track.count();
        for j in 0..count {
            self.laid.thrust[j] -= self.forces[track.wheel(j)].spin_moment / track.outer_radius(j);
        }
        let length = self.laid.course.length() + self.bent();
        let rate = (length - self.belt.length) / dt;
        self.belt.length = length;
        let stretch = track.spec.stiffness * (length - track.length) + track.spec.damping * rate;
        let mean = (track.spec.tension + stretch).max(0.0);
        let total = self.laid.total_thrust();
        // The slack side doesn't push.
        let slack = (mean - 0.5 * total).max(-total).max(0.0);
        let mut tension = slack;
        for j in 0..count {
            // Of the two sides of the sprocket the one whose tension is that of the first span, or of the last.
            let leads = track.sprocket == 0;
            let before = if j == 0 && leads { slack + total } else { tension };
            if j > 0 || !leads {
                tension += self.laid.thrust[j];
            }
            let after = if j + 1 == count && !leads { slack } else { tension };
            let spans = self.laid.course.spans();
            let e = [spans[(j + count - 1) % count].direction, spans[j].direction];
            let mut force = in_world(turn, e[1]) * after - in_world(turn, e[0]) * before;
            let turned = e[0][1] * e[1][0] - e[0][0] * e[1][1];
            if turned < 0.0 {
                // The belt bends over what lifts the wheel: it presses on that, and the wheel feels no more of it than
                // lies on it.
                let pressing = -turned * 0.5 * (before + after);
                let load = self.forces[track.wheel(j)].load;
                if pressing > load {
                    let inward = in_world(turn, spans[j].outward());
                    force -= inward * (force.dot(&inward) * (1.0 - load / pressing));
                }
            }
            self.forces[track.wheel(j)].force += force;
            if j + 1 < count {
                self.belt.spans[j].tension = after.max(0.0);
            }
        }
    }
}

/// Adds a force on a belt to two of its wheels, of which the second gets `fraction`; `axis` is the direction of their axles.
fn share_out(
    forces: &mut [Forces],
    placements: &[Placement],
    [a, b]: [usize; 2],
    fraction: f64,
    push: &Push,
    axis: &V3,
) {
    let middle = placements[a].arm * (1.0 - fraction) + placements[b].arm * fraction;
    let moment = (push.at - middle).cross(&push.force);
    // About the axles the wheels turn with the belt, to which the tension takes what acts along it.
    let moment = moment - axis * axis.dot(&moment);
    for (i, part) in [(a, 1.0 - fraction), (b, fraction)] {
        let f = &mut forces[i];
        f.force += push.force * part;
        f.moment += moment * part;
        f.inertia += push.inertia * part;
        f.load += push.load * part;
    }
}

/// Fraction of the second of two wheels in a force along `normal` at `at`, so that its moment about the axles is right.
fn lever(at: &V3, first: &V3, second: &V3, normal: &V3, axis: &V3) -> f64 {
    let about = |r: V3| axis.dot(&r.cross(normal));
    let whole = about(second - first);
    if whole.abs() < 1e-9 { 0.5 } else { (about(at - first) / whole).clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests;
