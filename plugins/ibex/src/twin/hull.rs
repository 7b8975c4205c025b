//! Contact of the hull with the terrain.
//!
//! The hull is convex, and so are most ridges: contacts are between a corner of one and a face of the other. The nodes
//! of the map are checked against the planes of the hull's underside, and points of the hull against the map's
//! triangles.

use wide::f32x8;

use super::body::{Body, Push};
use super::vector::{V3, all};
use super::{GRAVITY, Twin};

/// Maximum number of contacts.
const MOST: usize = 48;
/// Maximum depth of a contact, in wheel radii: limits the force on an overturned vehicle.
const DEPTH: f32 = 0.7;
/// Maximum total load of all contacts, as a multiple of one contact's load.
const SHARED: f32 = 2.0;
/// Maximum friction coefficient of the hull.
const FRICTION: f32 = 0.4;
/// Maximum fraction of the vehicle's velocity that a contact's friction removes per step.
const HELD: f32 = 0.35;

#[derive(Clone, Copy)]
struct Touch {
    depth: f32x8,
    /// Relative to the centre of mass.
    at: V3,
    normal: V3,
}

/// The contacts of a step.
struct Touches {
    all: [Touch; MOST],
    count: usize,
    sum: f32x8,
    deepest: f32x8,
}

impl Touches {
    fn add(&mut self, depth: f32x8, at: V3, normal: V3) {
        if let Some(touch) = self.all.get_mut(self.count) {
            *touch = Touch { depth, at, normal };
            self.count += 1;
            self.sum += depth;
            self.deepest = self.deepest.max(depth);
        }
    }
}

impl Twin {
    /// Adds the forces of the terrain on the hull with this friction; `before` is the hull load of the previous step,
    /// N. Returns the new hull load.
    pub(super) fn scrape(
        &self,
        body: &Body,
        (friction, before): (f32x8, f32x8),
        (push, dt): (&mut Push, f32),
    ) -> f32x8 {
        let shape = &self.shape;
        let Body { place, axes, velocity, turning } = *body;
        let friction = friction.min(all(FRICTION));
        let bottom = all(shape.under[0].height);
        let [ahead, behind, aside] = shape.reach.map(all);
        // The hull is usually clear of the terrain around it.
        let tilt = axes.forward.z.abs() * ahead.max(-behind) + axes.left.z.abs() * aside;
        let lowest = place.z + bottom * axes.up.z - tilt;
        if !self.ground.highest(place.x, place.y).simd_gt(lowest).any() {
            return all(0.0);
        }
        let none = Touch { depth: all(0.0), at: V3::all([0.0; 3]), normal: axes.up };
        let mut touches = Touches { all: [none; MOST], count: 0, sum: all(0.0), deepest: all(0.0) };
        let most = all(DEPTH * shape.radius);
        for point in shape.hull {
            let at = axes.out(V3::all(point));
            let p = place + at;
            let [z, east, north] = self.ground.surface(p.x, p.y);
            let depth = (z - p.z).max(all(0.0)).min(most);
            if depth.simd_gt(all(0.0)).any() {
                let unit = all(1.0) / (all(1.0) + east * east + north * north).sqrt();
                touches.add(depth * unit, at, V3::new(-east * unit, -north * unit, unit));
            }
        }
        self.ground.nodes(place.x, place.y, |[x, y, z]| {
            let at = V3::new(x, y, z) - place;
            let up = at.dot(axes.up);
            if !up.simd_gt(bottom).any() {
                return;
            }
            let (u, v) = (at.dot(axes.forward), at.dot(axes.left));
            let (mut height, mut normal) = (bottom, V3::all(shape.under[0].normal));
            for plane in &shape.under[1..] {
                let own = u * all(plane.slopes[0]) + v * all(plane.slopes[1]) + all(plane.height);
                let higher = own.simd_gt(height);
                height = height.max(own);
                let [x, y, z] = plane.normal.map(all);
                normal = V3::new(
                    higher.select(x, normal.x),
                    higher.select(y, normal.y),
                    higher.select(z, normal.z),
                );
            }
            let under = u.simd_lt(ahead) & u.simd_gt(behind) & v.abs().simd_lt(aside);
            let depth = under.select((up - height).max(all(0.0)).min(most), all(0.0));
            if depth.simd_gt(all(0.0)).any() {
                touches.add(depth * normal.z, at, axes.out(normal));
            }
        });
        let share = (all(SHARED) * touches.deepest / touches.sum.max(all(1e-6))).min(all(1.0));
        let stiffness = share * all(shape.hard);
        let mut borne = all(0.0);
        for Touch { depth, at, normal } in touches.all.into_iter().take(touches.count) {
            let v = velocity + turning.cross(at);
            let away = v.dot(normal);
            // Loading is stiffer than unloading: little rebound.
            let load = stiffness * depth * (all(1.0) - away).max(all(0.0)).min(all(2.0));
            borne += load;
            let slide = v + normal * -away;
            let speed = slide.dot(slide).sqrt().max(all(1e-3));
            let part = load / (before.max(load) + all(1e-3 * GRAVITY * shape.mass));
            let hold = (friction * load / speed).min(all(HELD * shape.mass / dt) * part);
            push.add(at, normal * load + slide * -hold);
        }
        borne
    }
}
