//! The belt between two wheels on hard ground and on obstacles: a string under tension.
//!
//! A string of length L under the tension T yields to a force at its middle by T·4/L, and the more it gives way the tighter
//! it gets: by 2 δ²/L it is longer, which the tensioner answers with its stiffness. The force goes to the two wheels by the
//! law of the lever.

use super::super::ground::Ground;
use super::super::kinematics::Kinematics;
use super::{Push, TrackStep, in_world, lever, share_out};
use crate::collision::OBSTACLE_FRICTION;
use crate::soil::Under;
use crate::tyre::{Contact, Patch, WheelMotion};
use crate::{M3, V3};

/// Width of the belt's contact with the ground that stands for it, over the belt's: strips at its radius of gyration.
const STRIP: f64 = 0.288_675_134_594_812_9;

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

impl TrackStep<'_> {
    /// Force of a span that gives way by `depth` at a part of its way, N.
    pub(super) fn string_force(&self, j: usize, part: f64, depth: f64) -> f64 {
        let length = self.laid.course.spans()[j].length;
        let tension = self.belt.spans[j].tension + self.track.spec.stiffness * 2.0 * depth * depth / length;
        // Nearer to a wheel it is the stiffer, up to four times.
        let lever = (4.0 * part * (1.0 - part)).clamp(0.25, 1.0);
        4.0 * tension / (length * lever) * depth
    }

    /// Where hard ground pushes a span in.
    fn ground_touch(
        &self,
        j: usize,
        kinematics: &Kinematics<'_>,
        ground: &Ground<'_>,
        under: Under,
    ) -> Option<Touch> {
        let (x, turn, aside) = (kinematics.body.x_world, &kinematics.turn, self.track.aside);
        let span = &self.laid.course.spans()[j];
        let out = span.outward();
        let outward = in_world(turn, out);
        if outward.z > -0.1 {
            return None;
        }
        let face = 0.5 * self.track.spec.thickness;
        let count = self.track.points[j];
        let strip = STRIP * self.track.width;
        // Both ends clear of all ground nearby: so is all between them.
        let ends = [0.0, 1.0].map(|part| {
            let [px, pz] = span.at(part);
            x + turn * V3::new(px + face * out[0], aside, pz + face * out[1])
        });
        let middle = (ends[0] + ends[1]) * 0.5;
        let reach = 0.5 * span.length + strip;
        if let Some(top) = ground.heightfield.ceiling(middle.x, middle.y, reach)
            && ends[0].z.min(ends[1].z) - strip > top
        {
            return None;
        }
        let (mut sum, mut depth, mut place, mut lateral) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..count {
            let part = (i as f64 + 0.5) / count as f64;
            let weight = 4.0 * part * (1.0 - part);
            let [px, pz] = span.at(part);
            for side in [-strip, strip] {
                let at = x + turn * V3::new(px + face * out[0], aside + side, pz + face * out[1]);
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
                lateral += w * side;
            }
        }
        if sum <= 0.0 {
            return None;
        }
        let (part, lateral) = (place / sum, lateral / sum);
        let [px, pz] = span.at(part);
        let point = x + turn * V3::new(px + face * out[0], aside + lateral, pz + face * out[1]);
        let friction = match under {
            Under::Mixed => ground.semantics.rigid_friction_around(point.x, point.y, self.track.radius),
            _ => ground.semantics.friction_at(point.x, point.y),
        };
        Some(Touch { point, normal: -outward, depth: depth / sum, part, friction })
    }

    /// Where an obstacle pushes a span in.
    fn obstacle_touch(&self, j: usize, kinematics: &Kinematics<'_>, ground: &Ground<'_>) -> Option<Touch> {
        let (x, turn) = (kinematics.body.x_world, &kinematics.turn);
        let span = &self.laid.course.spans()[j];
        let [mx, mz] = span.at(0.5);
        let middle = x + turn * V3::new(mx, self.track.aside, mz);
        let axes = M3::from_columns(&[
            -in_world(turn, span.direction),
            turn.column(1).into_owned(),
            -in_world(turn, span.outward()),
        ]);
        let size = [span.length, self.track.width, self.track.spec.thickness];
        let contact = ground.obstacles.plate_contact(size, &middle, &axes)?;
        let along = (contact.point - middle).dot(&axes.column(0));
        let part = (0.5 - along / span.length).clamp(0.0, 1.0);
        let Contact { point, normal, depth } = contact;
        Some(Touch { point, normal, depth, part, friction: OBSTACLE_FRICTION })
    }

    /// Forces of hard ground and of obstacles on the spans.
    pub(super) fn touch_spans(
        &mut self,
        kinematics: &Kinematics<'_>,
        ground: &Ground<'_>,
        under: Under,
        dt: f64,
    ) {
        let look = ground.obstacles.any_near();
        for j in 0..self.belt.spans.len() {
            let touch = match under {
                Under::Soil(_) | Under::Granular => None,
                _ => self.ground_touch(j, kinematics, ground, under),
            };
            let before = self.belt.spans[j].ground;
            self.belt.spans[j].ground = self.push_span(j, touch, before, kinematics, dt);
            let touch = if look { self.obstacle_touch(j, kinematics, ground) } else { None };
            let before = self.belt.spans[j].obstacle;
            self.belt.spans[j].obstacle = self.push_span(j, touch, before, kinematics, dt);
        }
    }

    /// Takes a contact of a span to its wheels; returns what the contact remembers.
    fn push_span(
        &mut self,
        j: usize,
        touch: Option<Touch>,
        mut patch: Patch,
        kinematics: &Kinematics<'_>,
        dt: f64,
    ) -> Patch {
        let Some(touch) = touch else { return Patch::default() };
        let Kinematics { body, turn, wheels, placements, .. } = kinematics;
        let track = self.track;
        // As the contact of a wheel that presses as hard and whose rim has the belt's speed.
        let depth = self.string_force(j, touch.part, touch.depth) / track.hardness;
        let (a, b) = (track.wheel(j), track.wheel(j + 1));
        let axis = turn.column(1).into_owned();
        let hub = touch.point + touch.normal * track.radius;
        let moves = |i: usize| placements[i].tangent * wheels[i].travel_rate;
        let velocity = body.v_world
            + body.w_world.cross(&(hub - body.x_world))
            + moves(a) * (1.0 - touch.part)
            + moves(b) * touch.part;
        let spin = self.belt.speed / (track.radius + depth);
        let motion = WheelMotion { hub, velocity, rotation: body.w_world + axis * spin, axis, spin };
        let contact = Contact { point: touch.point, normal: touch.normal, depth };
        let Some(r) = track.belt.react(&motion, &contact, touch.friction, &mut patch, dt) else {
            return patch;
        };
        self.laid.thrust[j] -= (1.0 - touch.part) * r.spin_moment / (track.radius + depth);
        self.laid.thrust[j + 1] -= touch.part * r.spin_moment / (track.radius + depth);
        let push = Push {
            at: touch.point - body.x_world,
            force: r.force,
            inertia: touch.normal * touch.normal.transpose() * (dt * track.belt.damping()),
            load: r.load,
        };
        let fraction = lever(&push.at, &placements[a].arm, &placements[b].arm, &touch.normal, &axis);
        share_out(self.forces, placements, [a, b], fraction, &push, &axis);
        patch
    }
}
