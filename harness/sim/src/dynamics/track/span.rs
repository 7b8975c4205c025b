//! The belt between two wheels on hard ground and on obstacles: a string under tension.
//!
//! A string of length L under the tension T yields to a force at its middle by T·4/L, and the more it gives way the tighter
//! it gets: by 2 δ²/L it is longer, which the tensioner answers with its stiffness. The force goes to the two wheels by the
//! law of the lever.

use super::super::{Ground, Vehicle};
use super::{STRIP, Track};
use crate::collision::OBSTACLE_FRICTION;
use crate::soil::Under;
use crate::tyre::{Contact, Patch, WheelMotion};
use crate::{M3, V3};

/// Where something touches a span.
struct Touch {
    /// World, m.
    point: V3,
    /// Towards the belt.
    normal: V3,
    /// How far the belt gives way, m.
    depth: f64,
    /// Part of the way from the wheel in front to the one behind.
    part: f64,
    friction: f64,
}

impl Track {
    /// Force of a span that gives way by `depth` at a part of its way, N.
    pub(super) fn string_force(&self, j: usize, part: f64, depth: f64) -> f64 {
        let length = self.course.spans()[j].length;
        let tension = self.spans[j].tension + self.data.spec.stiffness * 2.0 * depth * depth / length;
        // Nearer to a wheel it is the stiffer, up to four times.
        let lever = (4.0 * part * (1.0 - part)).clamp(0.25, 1.0);
        4.0 * tension / (length * lever) * depth
    }

    /// Where hard ground pushes a span in.
    fn ground_touch(&self, j: usize, ground: &Ground<'_>, under: Under, x: &V3, turn: &M3) -> Option<Touch> {
        let span = &self.course.spans()[j];
        let out = span.outward();
        let outward = Self::in_world(turn, out);
        if outward.z > -0.1 {
            return None;
        }
        let face = 0.5 * self.data.spec.thickness;
        let count = self.spans[j].points;
        let strip = STRIP * self.width;
        // Both ends clear of all ground nearby: so is all between them.
        let ends = [0.0, 1.0].map(|part| {
            let [px, pz] = span.at(part);
            x + turn * V3::new(px + face * out[0], self.aside, pz + face * out[1])
        });
        let middle = (ends[0] + ends[1]) * 0.5;
        let reach = 0.5 * span.length + strip;
        if let Some(top) = ground.heightfield.ceiling(middle.x, middle.y, reach)
            && ends[0].z.min(ends[1].z) - strip > top
        {
            return None;
        }
        let (mut sum, mut depth, mut place, mut aside) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..count {
            let part = (i as f64 + 0.5) / count as f64;
            let weight = 4.0 * part * (1.0 - part);
            let [px, pz] = span.at(part);
            for side in [-strip, strip] {
                let at = x + turn * V3::new(px + face * out[0], self.aside + side, pz + face * out[1]);
                let over = (ground.heightfield.height(at.x, at.y) - at.z) * -outward.z;
                if over <= 0.0 {
                    continue;
                }
                let mut w = weight * over;
                if under == Under::Mixed {
                    w *= 1.0 - ground.soil.fraction(at.x, at.y, ground.soil.blend);
                }
                sum += w;
                depth += w * over;
                place += w * part;
                aside += w * side;
            }
        }
        if sum <= 0.0 {
            return None;
        }
        let (part, aside) = (place / sum, aside / sum);
        let [px, pz] = span.at(part);
        let point = x + turn * V3::new(px + face * out[0], self.aside + aside, pz + face * out[1]);
        let friction = match under {
            Under::Mixed => ground.semantics.rigid_friction_around(point.x, point.y, self.data.radius),
            _ => ground.semantics.friction_at(point.x, point.y),
        };
        Some(Touch { point, normal: -outward, depth: depth / sum, part, friction })
    }

    /// Where an obstacle pushes a span in.
    fn obstacle_touch(&self, j: usize, ground: &Ground<'_>, x: &V3, turn: &M3) -> Option<Touch> {
        let span = &self.course.spans()[j];
        let [mx, mz] = span.at(0.5);
        let middle = x + turn * V3::new(mx, self.aside, mz);
        let axes = M3::from_columns(&[
            -Self::in_world(turn, span.direction),
            turn.column(1).into_owned(),
            -Self::in_world(turn, span.outward()),
        ]);
        let size = [span.length, self.width, self.data.spec.thickness];
        let contact = ground.obstacles.plate_contact(size, &middle, &axes)?;
        let along = (contact.point - middle).dot(&axes.column(0));
        let part = (0.5 - along / span.length).clamp(0.0, 1.0);
        let Contact { point, normal, depth } = contact;
        Some(Touch { point, normal, depth, part, friction: OBSTACLE_FRICTION })
    }
}

impl Vehicle {
    /// Forces of hard ground and of obstacles on the spans of a track.
    pub(super) fn touch_spans(
        &mut self,
        t: &mut Track,
        ground: &Ground<'_>,
        under: Under,
        turn: &M3,
        dt: f64,
    ) {
        let look = ground.obstacles.any_near();
        for j in 0..t.spans.len() {
            let touch = match under {
                Under::Soil(_) => None,
                _ => t.ground_touch(j, ground, under, &self.x, turn),
            };
            let mut patch = t.spans[j].ground;
            self.push_span(t, j, touch, &mut patch, turn, dt);
            t.spans[j].ground = patch;
            let touch = if look { t.obstacle_touch(j, ground, &self.x, turn) } else { None };
            let mut patch = t.spans[j].obstacle;
            self.push_span(t, j, touch, &mut patch, turn, dt);
            t.spans[j].obstacle = patch;
        }
    }

    /// Takes a contact of a span to its wheels.
    fn push_span(
        &mut self,
        t: &mut Track,
        j: usize,
        touch: Option<Touch>,
        patch: &mut Patch,
        turn: &M3,
        dt: f64,
    ) {
        let Some(touch) = touch else {
            *patch = Patch::default();
            return;
        };
        // As the contact of a wheel that presses as hard and whose rim has the belt's speed.
        let depth = t.string_force(j, touch.part, touch.depth) / t.data.hardness;
        let (a, b) = (t.wheel(j), t.wheel(j + 1));
        let axis = turn.column(1).into_owned();
        let hub = touch.point + touch.normal * t.data.radius;
        let moves = |i: usize| self.forces[i].tangent * self.corners[i].travel_rate;
        let velocity =
            self.v + self.w.cross(&(hub - self.x)) + moves(a) * (1.0 - touch.part) + moves(b) * touch.part;
        let spin = t.speed / (t.data.radius + depth);
        let motion = WheelMotion { hub, velocity, rotation: self.w + axis * spin, axis, spin };
        let contact = Contact { point: touch.point, normal: touch.normal, depth };
        let Some(r) = t.belt.react(&motion, &contact, touch.friction, patch, dt) else { return };
        t.thrust[j] -= (1.0 - touch.part) * r.spin_moment / (t.data.radius + depth);
        t.thrust[j + 1] -= touch.part * r.spin_moment / (t.data.radius + depth);
        let inertia = touch.normal * touch.normal.transpose() * (dt * t.belt.damping());
        let at = touch.point - self.x;
        let fraction = lever(&at, &self.forces[a].arm, &self.forces[b].arm, &touch.normal, &axis);
        self.share_out(a, b, fraction, &at, &r.force, &inertia, r.load, &axis);
    }

    /// Adds a force at `at` (relative to the centre of mass, world axes) to two wheels of a track, of which the second gets
    /// `fraction`.
    #[allow(clippy::too_many_arguments, reason = "two wheels and what they get")]
    pub(super) fn share_out(
        &mut self,
        a: usize,
        b: usize,
        fraction: f64,
        at: &V3,
        force: &V3,
        inertia: &M3,
        load: f64,
        axis: &V3,
    ) {
        let parts = [(a, 1.0 - fraction), (b, fraction)];
        let middle = self.forces[a].arm * (1.0 - fraction) + self.forces[b].arm * fraction;
        let moment = (at - middle).cross(force);
        // About the axles the wheels turn with the belt, to which the tension takes what acts along it.
        let moment = moment - axis * axis.dot(&moment);
        for (i, part) in parts {
            let f = &mut self.forces[i];
            f.force += force * part;
            f.moment += moment * part;
            f.inertia += inertia * part;
            self.corners[i].load += load * part;
        }
    }
}

/// Share of the second of two wheels in a force along `normal` at `at`, so that its moment about the axles is right.
pub(super) fn lever(at: &V3, first: &V3, second: &V3, normal: &V3, axis: &V3) -> f64 {
    let about = |r: V3| axis.dot(&r.cross(normal));
    let whole = about(second - first);
    if whole.abs() < 1e-9 { 0.5 } else { (about(at - first) / whole).clamp(0.0, 1.0) }
}
