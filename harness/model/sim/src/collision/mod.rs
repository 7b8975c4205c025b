//! Contacts of the chassis (rapier) and of the wheels with obstacles (parry), looked for only where something is near.

mod chassis;
mod facets;
mod footing;
#[cfg(test)]
mod footing_tests;
mod separation;
mod surroundings;

pub(crate) use chassis::ChassisContacts;
pub(crate) use facets::{Facets, HardWheel, MOST as MOST_FACETS};
pub(crate) use footing::Footing;
pub use surroundings::Surroundings;

use std::sync::Arc;

use crate::tyre::Contact;
use crate::{M3, Quat, V3};
use rapier3d_f64::parry::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use rapier3d_f64::parry::shape::{Cylinder, SupportMap};
use rapier3d_f64::prelude::*;
use surroundings::Solid;
use vb_vehicle::{TyreSpec, tyre::HardContact};

/// Friction of obstacles, combined with the tyre's or hull's by the minimum: Chrono's default material, which the
/// original gives its rocks and trees (Chrono's default contact material, ChContactMaterial.cpp).
pub(crate) const OBSTACLE_FRICTION: f64 = 0.6;

fn vector(v: &V3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_vector(v: Vector) -> V3 {
    V3::new(v.x, v.y, v.z)
}

fn rotation(q: &Quat) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w)
}

/// Points as rapier's vectors.
pub(crate) fn points(p: &[[f64; 3]]) -> Vec<Vector> {
    p.iter().map(|p| Vector::new(p[0], p[1], p[2])).collect()
}

/// A box in place.
#[derive(Clone)]
struct Cuboid {
    centre: V3,
    half: V3,
    axes: M3,
}

impl Cuboid {
    /// Whether the boxes may come within `margin` of each other, judged along the axes of both.
    fn may_touch(&self, other: &Self, margin: f64) -> bool {
        let d = other.centre - self.centre;
        let between = self.axes.transpose() * other.axes;
        let spread = between.abs();
        let (a, b) = (self.axes.transpose() * d, other.axes.transpose() * d);
        let (reach_a, reach_b) =
            (self.half + spread * other.half, other.half + spread.transpose() * self.half);
        (0..3).all(|k| a[k].abs() < reach_a[k] + margin && b[k].abs() < reach_b[k] + margin)
    }
}

/// Obstacles that a wheel can touch at a time: as it does in a wedge. Of more, the deepest count.
pub(crate) const MOST_OBSTACLES: usize = 2;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObstacleContact {
    /// The number of the obstacle in the world.
    pub(crate) obstacle: usize,
    pub(crate) contact: Contact,
}

impl ObstacleContact {
    /// Puts the contact behind those of obstacles with lower numbers, and lets the shallowest go if there is no room.
    fn keep(self, deepest: &mut [Option<Self>; MOST_OBSTACLES]) {
        if let Some(free) = deepest.iter_mut().find(|c| c.is_none()) {
            *free = Some(self);
            return;
        }
        let depth = |c: &Option<Self>| c.map_or(0.0, |c| c.contact.depth);
        let shallowest = (0..MOST_OBSTACLES)
            .fold(0, |least, k| if depth(&deepest[k]) < depth(&deepest[least]) { k } else { least });
        if self.contact.depth > depth(&deepest[shallowest]) {
            deepest[shallowest..].rotate_left(1);
            deepest[MOST_OBSTACLES - 1] = Some(self);
        }
    }
}

/// The obstacles of a world and the few that are near the vehicle.
#[derive(Clone)]
pub(crate) struct Obstacles {
    solids: Arc<[Solid]>,
    near: Vec<usize>,
}

impl Obstacles {
    pub(crate) fn new(surroundings: &Surroundings) -> Self {
        Self { solids: surroundings.solids().clone(), near: Vec::new() }
    }

    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self { solids: Arc::new([]), near: Vec::new() }
    }

    /// Notes which obstacles come within `reach` of `x`.
    pub(crate) fn look_around(&mut self, x: &V3, reach: f64) {
        self.near.clear();
        for (i, s) in self.solids.iter().enumerate() {
            let r = s.bound + reach;
            if (s.centre - x).norm_squared() < r * r {
                self.near.push(i);
            }
        }
    }

    pub(crate) fn any_near(&self) -> bool {
        !self.near.is_empty()
    }

    fn any_within(&self, hull: &Cuboid, margin: f64) -> bool {
        self.near.iter().any(|&i| self.solids[i].cuboid.may_touch(hull, margin))
    }

    /// The deepest contact of a plate with an obstacle. The plate lies along the columns of `axes`, with its size (m)
    /// along each; the edges along the last, its thickness, are round.
    pub(crate) fn plate_contact(&self, size: [f64; 3], middle: &V3, axes: &M3) -> Option<Contact> {
        let margin = 0.5 * size[2];
        let half = [0.5 * size[0], 0.5 * size[1] - margin, 1e-3 * margin];
        let core = rapier3d_f64::parry::shape::Cuboid::new(Vector::new(half[0], half[1], half[2]));
        let turn = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(*axes));
        let plate = Pose::from_parts(vector(middle), rotation(&turn));
        let bound = V3::new(half[0], half[1], half[2]).norm() + margin;
        let mut deepest: Option<Contact> = None;
        for &i in &self.near {
            let s = &self.solids[i];
            let reach = s.bound + bound;
            if (s.centre - middle).norm_squared() > reach * reach {
                continue;
            }
            if let Some(c) = s.contact(&core, margin, &plate)
                && deepest.is_none_or(|d| c.depth > d.depth)
            {
                deepest = Some(c);
            }
        }
        deepest
    }

    /// The deepest contacts of a wheel with obstacles, one for each obstacle, in the order of the obstacles' numbers. The
    /// order decides nothing but the order of sums.
    pub(crate) fn wheel_contacts(
        &self,
        wheel: &WheelShape,
        hub: &V3,
        axis: &V3,
    ) -> [Option<ObstacleContact>; MOST_OBSTACLES] {
        let mut deepest = [None; MOST_OBSTACLES];
        for &i in &self.near {
            let s = &self.solids[i];
            let reach = s.bound + wheel.bound;
            if (s.centre - hub).norm_squared() > reach * reach {
                continue;
            }
            if let Some(contact) = wheel.contact(s, hub, axis) {
                ObstacleContact { obstacle: i, contact }.keep(&mut deepest);
            }
        }
        deepest
    }
}

/// A wheel against convex solids: a slim core inflated by a margin, so that its shoulders are round and the distance
/// between core and solid stays positive, where GJK gives exact and steady normals.
#[derive(Clone)]
pub(crate) struct WheelShape {
    core: Cylinder,
    margin: f64,
    bound: f64,
    /// Of a tyre that meets the ground facet by facet.
    hard: Option<HardWheel>,
}

impl WheelShape {
    pub(crate) fn new(tyre: &TyreSpec) -> Self {
        let (radius, width) = (tyre.radius(), tyre.width());
        let margin = (0.4 * width).min(0.3 * radius);
        let core = Cylinder::new(0.5 * width - margin, radius - margin);
        let by_facets = matches!(tyre, TyreSpec::Rigid(t) if t.contact == HardContact::Facets);
        let hard = by_facets.then(|| HardWheel::new(radius, width));
        Self { core, margin, bound: vb_math::hypot(radius, 0.5 * width), hard }
    }

    /// The distance from the hub within which the wheel lies, m.
    pub(crate) fn bound(&self) -> f64 {
        self.bound
    }

    pub(crate) fn hard(&self) -> Option<&HardWheel> {
        self.hard.as_ref()
    }

    fn contact(&self, solid: &Solid, hub: &V3, axis: &V3) -> Option<Contact> {
        // parry's cylinders stand along y.
        let wheel = Pose::from_parts(vector(hub), rotation(&crate::turn_to_axle(axis)));
        solid.contact(&self.core, self.margin, &wheel)
    }
}

impl Solid {
    /// Contact with a body that is a core inflated by a margin.
    fn contact(&self, core: &impl SupportMap, margin: f64, pose: &Pose) -> Option<Contact> {
        let relative = self.pose.inverse() * *pose;
        let start = relative.translation.try_normalize().unwrap_or(Vector::Z);
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(&relative, &*self.shape, core, start));
        let found = gjk::closest_points(&relative, &*self.shape, core, margin, true, &mut simplex);
        let (on_solid, out, depth) = match found {
            GJKResult::ClosestPoints(p1, p2, n) => (p1, n, margin - (p2 - p1).dot(n)),
            GJKResult::Intersection => {
                // The core itself is inside: deeper than any tyre deflects. Push it out the shortest way.
                let (p1, p2, n) = rapier3d_f64::parry::query::epa::EPA::new().closest_points(
                    &relative,
                    &*self.shape,
                    core,
                    &simplex,
                )?;
                (p1, n, margin - (p2 - p1).dot(n))
            }
            _ => return None,
        };
        if depth <= 0.0 {
            return None;
        }
        let normal = from_vector(self.pose.rotation * out);
        Some(Contact { point: from_vector(self.pose * on_solid), normal, depth })
    }
}

/// Lowest and highest coordinates of some points.
fn extents(points: impl Iterator<Item = V3>) -> (V3, V3) {
    let start = (V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY));
    points.fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)))
}
