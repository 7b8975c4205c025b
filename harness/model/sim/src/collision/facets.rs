//! A hard wheel on the facets of the ground: one contact with each that it touches.
//!
//! A wheel in a corner stands on the floor and leans on the wall, each with a force and friction of its own; an average
//! of both can neither hold it nor lift it as they do. A facet is touched where the wheel's lowest point along the
//! facet's normal lies over it; else at an edge or a corner, where the ground falls away on its other side.

use super::{from_vector, rotation, vector};
use crate::tyre::Contact;
use crate::{Quat, V3};
use rapier3d_f64::parry::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use rapier3d_f64::parry::shape::{Cylinder, Triangle};
use rapier3d_f64::prelude::*;
use vb_world::Heightfield;

/// Greatest number of contacts of a wheel with the ground; what a corner between four walls would have.
pub(crate) const MOST: usize = 6;

/// Margin around the core of a hard wheel over its radius, by which its shoulders are round: more than they are pressed into
/// the ground, so that GJK finds core and ground apart, and little enough that they are sharp. Edges under the tread don't
/// need it.
const MARGIN: f64 = 0.06;
/// Inclination of a wheel to a facet over which its contact moves from the middle of its width to its edge, rad: less than
/// what a hard tyre's deflection takes, and enough that it doesn't jump.
const UPRIGHT: f64 = 0.02;
/// Tolerance for rounding errors of the reach test of a triangle, m.
const ROUNDING: f64 = 1e-6;
/// How far beyond an edge the ground is looked at to see whether it falls away there, over the wheel's radius.
const BEYOND: f64 = 0.02;

/// The contacts of a wheel with the ground, and of which facet each is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets {
    count: usize,
    found: [(usize, Contact); MOST],
}

impl Facets {
    fn none() -> Self {
        let nothing = Contact { point: V3::zeros(), normal: V3::zeros(), depth: 0.0 };
        Self { count: 0, found: [(0, nothing); MOST] }
    }

    /// Number of the facet, and the contact; the depth is negative where the wheel is yet that far from the ground.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &(usize, Contact)> {
        self.found[..self.count].iter()
    }

    /// Keeps a contact unless it is one that a neighbour has at their common edge; the deepest where there is no room.
    fn keep(&mut self, facet: usize, contact: Contact, alike: f64) {
        let same =
            |c: &Contact| (c.point - contact.point).norm() < alike && c.normal.dot(&contact.normal) > 0.9999;
        if self.found[..self.count].iter().any(|(_, c)| same(c)) {
            return;
        }
        if self.count < MOST {
            self.found[self.count] = (facet, contact);
            self.count += 1;
            return;
        }
        let shallowest = self.found.iter_mut().min_by(|a, b| a.1.depth.total_cmp(&b.1.depth));
        if let Some(place) = shallowest.filter(|place| place.1.depth < contact.depth) {
            *place = (facet, contact);
        }
    }
}

/// A hard cylinder: a core inflated by a margin.
#[derive(Clone)]
pub(crate) struct HardWheel {
    core: Cylinder,
    margin: f64,
    bound: f64,
}

/// A wheel in place.
struct Wheel<'a> {
    shape: &'a HardWheel,
    hub: V3,
    axis: V3,
    pose: Pose,
    /// Farthest distance at which a contact is reported, m.
    reach: f64,
}

impl HardWheel {
    /// For a wheel's radius and width, m.
    pub(crate) fn new(radius: f64, width: f64) -> Self {
        let margin = (MARGIN * radius).min(0.25 * width);
        let core = Cylinder::new(0.5 * width - margin, radius - margin);
        Self { core, margin, bound: vb_math::hypot(radius, 0.5 * width) }
    }

    /// The contacts with the ground of the wheel with centre `hub` and axle direction `axis` (unit, to the left), and
    /// where it is within `reach` (m) of the ground. None where the wheel is not wholly over the grid.
    pub(crate) fn facets(&self, ground: &Heightfield, hub: &V3, axis: &V3, reach: f64) -> Option<Facets> {
        let bound = self.bound + reach;
        if !ground.contains(hub.x.abs() + bound, hub.y.abs() + bound) {
            return None;
        }
        // parry's cylinders stand along y.
        let turn = Quat::rotation_between(&V3::y(), axis)
            .unwrap_or_else(|| Quat::from_axis_angle(&V3::x_axis(), std::f64::consts::PI));
        let pose = Pose::from_parts(vector(hub), rotation(&turn));
        let wheel = Wheel { shape: self, hub: *hub, axis: *axis, pose, reach };
        let index =
            |v: f64, half: f64, count: usize| (((v + half) / ground.resolution()) as usize).min(count - 2);
        let (half_x, half_y) = (ground.half_x(), ground.half_y());
        let mut found = Facets::none();
        for row in index(hub.y - bound, half_y, ground.rows())..=index(hub.y + bound, half_y, ground.rows()) {
            for col in
                index(hub.x - bound, half_x, ground.cols())..=index(hub.x + bound, half_x, ground.cols())
            {
                let node = |row: usize, col: usize| {
                    let (x, y) = (col as f64 * ground.resolution(), row as f64 * ground.resolution());
                    V3::new(x - half_x, y - half_y, ground.node(row, col))
                };
                let corners =
                    [node(row, col), node(row, col + 1), node(row + 1, col + 1), node(row + 1, col)];
                if corners.iter().all(|c| c.z < hub.z - bound) {
                    continue;
                }
                let [south_west, south_east, north_east, north_west] = corners;
                let halves = [[south_west, south_east, north_east], [south_west, north_east, north_west]];
                for (half, triangle) in halves.iter().enumerate() {
                    if let Some(contact) = wheel.touches(triangle, ground) {
                        let facet = 2 * (row * ground.cols() + col) + half;
                        found.keep(facet, contact, 0.02 * self.radius());
                    }
                }
            }
        }
        Some(found)
    }

    /// Of the whole wheel, m.
    fn radius(&self) -> f64 {
        self.core.radius + self.margin
    }
}

impl Wheel<'_> {
    /// The contact with one triangle, counter-clockwise from above.
    fn touches(&self, corners: &[V3; 3], ground: &Heightfield) -> Option<Contact> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a)).normalize();
        let height = normal.dot(&(self.hub - a));
        let core = &self.shape.core;
        let lean = normal.dot(&self.axis);
        let level = (1.0 - lean * lean).max(0.0).sqrt();
        let lowest = height - core.radius * level - core.half_height * lean.abs() - self.shape.margin;
        // Out of reach; or the hub is behind the facet, which then isn't the one that is touched.
        if lowest > self.reach || height <= 0.0 {
            return None;
        }
        if level > 1e-3 {
            let down = (self.axis * lean - normal) / level;
            let aside = -core.half_height * (lean / UPRIGHT).clamp(-1.0, 1.0);
            let under = self.hub + down * core.radius + self.axis * aside;
            let away = normal.dot(&(under - a));
            let foot = under - normal * away;
            if is_over(&foot, [a, b, c]) {
                return Some(Contact { point: foot, normal, depth: self.shape.margin - away });
            }
        }
        self.touches_edge(corners, &normal, ground)
    }

    /// Whether planes across or along the axle show that a triangle is farther than a contact reaches, which is how most triangles near a
    /// wheel lie. Then there is no contact at an edge, and no need to look for one.
    fn is_out_of_reach(&self, corners: &[V3; 3]) -> bool {
        let core = &self.shape.core;
        let farthest = self.shape.margin + self.reach + ROUNDING;
        let from = corners.map(|c| c - self.hub);
        let aside = from.map(|f| f.dot(&self.axis));
        let beside = |sign: f64| aside.iter().all(|a| sign * a > core.half_height + farthest);
        if beside(1.0) || beside(-1.0) {
            return true;
        }
        let across: [V3; 3] = std::array::from_fn(|k| from[k] - self.axis * aside[k]);
        let towards = across[0] + across[1] + across[2];
        let radius = core.radius + farthest;
        let limit = radius * radius * towards.norm_squared();
        across.iter().all(|c| {
            let along = c.dot(&towards);
            along > 0.0 && along * along > limit
        })
    }

    /// The contact with an edge or a corner of a triangle beside the wheel's lowest point.
    fn touches_edge(&self, corners: &[V3; 3], facet: &V3, ground: &Heightfield) -> Option<Contact> {
        if self.is_out_of_reach(corners) {
            return None;
        }
        let (point, normal, depth) = match self.treads(corners) {
            Some(found) => found,
            None => self.shoulders(corners)?,
        };
        if depth <= -self.reach {
            return None;
        }
        // Beyond the edge the ground must fall away from the contact's plane: where it doesn't, another facet is nearer.
        let outward = (normal - facet * normal.dot(facet)).try_normalize(1e-6)?;
        let step = BEYOND * self.shape.radius();
        let there = point + outward * step;
        let beyond = V3::new(there.x, there.y, ground.height(there.x, there.y)) - point;
        (beyond.dot(&normal) <= 1e-6 * step).then_some(Contact { point, normal, depth })
    }

    /// The point of a triangle's edges that is nearest to the axle, with the normal towards the axle and the depth (m), if
    /// the tread is over it, however deep it is: a blow at a wall presses it in by centimetres.
    fn treads(&self, corners: &[V3; 3]) -> Option<(V3, V3, f64)> {
        let half = self.shape.core.half_height + self.shape.margin;
        let mut nearest: Option<(f64, V3, V3, f64)> = None;
        for k in 0..3 {
            let (from, edge) = (corners[k] - self.hub, corners[(k + 1) % 3] - corners[k]);
            // Along the axle, and what is left across it, at the edge's start and along it.
            let (aside, turn) = (from.dot(&self.axis), edge.dot(&self.axis));
            let (start, way) = (from - self.axis * aside, edge - self.axis * turn);
            let (mut low, mut high) = (0.0_f64, 1.0_f64);
            if turn.abs() > 1e-12 {
                let (a, b) = ((-half - aside) / turn, (half - aside) / turn);
                (low, high) = (low.max(a.min(b)), high.min(a.max(b)));
            } else if aside.abs() > half {
                continue;
            }
            if low > high {
                continue;
            }
            // An edge along the axle is as near all along: its middle under the wheel.
            let level = way.norm_squared() < 1e-12 * edge.norm_squared();
            let part = if level { 0.5 * (low + high) } else { -start.dot(&way) / way.norm_squared() };
            let part = vb_math::clamp(part, low, high);
            let arm = start + way * part;
            let distance = arm.norm();
            if nearest.as_ref().is_none_or(|n| distance < n.0) {
                nearest = Some((distance, corners[k] + edge * part, arm, aside + turn * part));
            }
        }
        let (distance, point, arm, aside) = nearest.filter(|n| n.0 > 0.0)?;
        let depth = self.shape.radius() - distance;
        // Near its faces the wheel is round, unless that is far from where it is pressed in.
        let rounded = aside.abs() > self.shape.core.half_height && depth < self.shape.margin;
        (!rounded).then(|| (point, -arm / distance, depth))
    }

    /// The point of a triangle that is nearest to the wheel, with the normal and the depth (m), where that isn't under the
    /// tread but at a shoulder or a face.
    fn shoulders(&self, corners: &[V3; 3]) -> Option<(V3, V3, f64)> {
        let [a, b, c] = corners.each_ref().map(vector);
        let triangle = Triangle::new(a, b, c);
        let inverse = self.pose.inverse();
        let start = inverse.translation.try_normalize().unwrap_or(Vector::Z);
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(&self.pose, &triangle, &self.shape.core, start));
        let farthest = self.shape.margin + self.reach;
        let found =
            gjk::closest_points(&self.pose, &triangle, &self.shape.core, farthest, true, &mut simplex);
        let GJKResult::ClosestPoints(on_ground, on_core, out) = found else { return None };
        let depth = self.shape.margin - (on_core - on_ground).dot(out);
        Some((from_vector(on_ground), from_vector(out), depth))
    }
}

/// Whether a point in the plane of a triangle lies on it.
fn is_over(p: &V3, [a, b, c]: [&V3; 3]) -> bool {
    // Seen from above, which no facet of a heightfield is edge on.
    let side =
        |from: &V3, to: &V3| (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x) >= 0.0;
    side(a, b) && side(b, c) && side(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::{acos, cos, sin, tan};

    const RADIUS: f64 = 0.467;

    fn wheel() -> HardWheel {
        HardWheel::new(RADIUS, 0.254)
    }

    /// Ground whose height depends on x alone: straight between nodes 1 m apart from x = −4 on.
    fn profile(heights: [f64; 9]) -> Heightfield {
        Heightfield::new(9, 9, 1.0, (0..81).map(|i| heights[i % 9]).collect())
    }

    fn contacts(ground: &Heightfield, hub: V3, axis: V3, reach: f64) -> Vec<Contact> {
        let found = wheel().facets(ground, &hub, &axis, reach).expect("the wheel is over the grid");
        found.iter().map(|(_, c)| *c).collect()
    }

    #[test]
    fn on_a_plane_there_is_one_contact_wherever_the_wheel_stands() {
        let slope = 0.3;
        let ground = profile(std::array::from_fn(|k| slope * k as f64));
        let n = V3::new(-slope, 0.0, 1.0).normalize();
        for k in 0..200 {
            // Over edges of cells, over diagonals, on nodes.
            let (x, y) = (-1.0 + 0.01 * f64::from(k), -0.5 + 0.01 * f64::from(k));
            let foot = V3::new(x, y, ground.height(x, y));
            let hub = foot + n * (RADIUS - 0.002);
            let found = contacts(&ground, hub, V3::y(), 0.0);
            assert_eq!(found.len(), 1, "({x}, {y}): {found:?}");
            assert!((found[0].normal - n).norm() < 1e-9 && (found[0].depth - 0.002).abs() < 1e-9);
            assert!((found[0].point - foot).norm() < 1e-6, "{} {foot}", found[0].point);
        }
    }

    #[test]
    fn in_a_corner_a_wheel_touches_the_floor_and_the_wall() {
        // A floor, and from x = 0 on a wall of 60°.
        let angle = std::f64::consts::FRAC_PI_3;
        let ground = profile([0.0, 0.0, 0.0, 0.0, 0.0, tan(angle), tan(angle), tan(angle), tan(angle)]);
        let wall = V3::new(-sin(angle), 0.0, cos(angle));
        // The centre of the circle that touches both lies on the corner's bisector.
        let radius = RADIUS - 0.001;
        let hub = V3::new(-radius * tan(0.5 * angle), 0.2, radius);
        let found = contacts(&ground, hub, V3::y(), 0.0);
        assert_eq!(found.len(), 2, "{found:?}");
        for expected in [V3::z(), wall] {
            let contact = found.iter().find(|c| (c.normal - expected).norm() < 1e-9);
            let contact = contact.unwrap_or_else(|| panic!("no contact along {expected}: {found:?}"));
            assert!((contact.depth - 0.001).abs() < 1e-9, "{contact:?}");
            assert!((contact.point - (hub - expected * radius)).norm() < 1e-6, "{contact:?}");
        }
    }

    #[test]
    fn over_a_ridge_the_normal_turns_with_the_wheel() {
        // Faces of ±30° that meet at x = 0.
        let slope = tan(std::f64::consts::FRAC_PI_6);
        let ground = profile(std::array::from_fn(|k| -slope * (k as f64 - 4.0).abs()));
        for k in -5..=5 {
            let lean = 0.1 * f64::from(k);
            // The hub straight over the edge along a direction within the faces' normals.
            let n = V3::new(sin(lean), 0.0, cos(lean));
            let found = contacts(&ground, n * (RADIUS - 0.002), V3::y(), 0.0);
            // A wheel along the edge touches it with its whole width, over the ends of several facets.
            assert!(!found.is_empty(), "{lean}");
            for contact in found {
                assert!((contact.normal - n).norm() < 1e-3, "{lean}: {}", contact.normal);
                assert!((contact.depth - 0.002).abs() < 1e-6, "{lean}: {}", contact.depth);
            }
        }
    }

    #[test]
    fn the_edge_of_a_step_is_touched_at_the_angle_that_geometry_says() {
        // A step as high as a third of the radius, between the nodes at x = 0 and 0.01 m.
        let height = RADIUS / 3.0;
        let (rows, cols) = (121, 401);
        let heights = (0..rows * cols).map(|i| if i % cols > 200 { height } else { 0.0 }).collect();
        let ground = Heightfield::new(rows, cols, 0.01, heights);
        // cos θ = 1 − h/r between the vertical and the line from the edge to the hub of a wheel that stands before it.
        let theta = acos(1.0 - height / RADIUS);
        let narrow = HardWheel::new(RADIUS, 0.03);
        let hub = V3::new(0.01 - (RADIUS - 1e-4) * sin(theta), 0.0, height + (RADIUS - 1e-4) * cos(theta));
        let found = narrow.facets(&ground, &hub, &V3::y(), 0.0).unwrap();
        let edge =
            found.iter().find(|(_, c)| c.normal.x < -0.3).map(|(_, c)| *c).expect("the edge is touched");
        assert!((acos(edge.normal.z) - theta).abs() < 1e-3, "{} {theta}", acos(edge.normal.z));
        assert!((edge.depth - 1e-4).abs() < 1e-6, "{}", edge.depth);
    }

    #[test]
    fn pressed_deep_into_an_edge_a_wheel_still_feels_it() {
        // A crest between faces of 60° at x = 0, and the hub beside it, nearer than the radius by far more than the margin.
        let slope = tan(std::f64::consts::FRAC_PI_3);
        let ground = profile(std::array::from_fn(|k| -slope * (k as f64 - 4.0).abs()));
        for depth in [0.001, 0.02, 0.05, 0.1, 0.2] {
            for lean in [0.0, 0.3, -0.6] {
                let n = V3::new(sin(lean), 0.0, cos(lean));
                let found = contacts(&ground, n * (RADIUS - depth), V3::y(), 0.0);
                assert!(!found.is_empty(), "{depth} {lean}");
                for contact in found {
                    assert!((contact.normal - n).norm() < 1e-9, "{depth} {lean}: {}", contact.normal);
                    assert!((contact.depth - depth).abs() < 1e-9, "{depth} {lean}: {}", contact.depth);
                }
            }
        }
    }

    #[test]
    fn within_reach_a_contact_is_reported_before_it_is_one() {
        let ground = profile([0.0; 9]);
        let above = |gap: f64, reach: f64| contacts(&ground, V3::new(0.3, 0.2, RADIUS + gap), V3::y(), reach);
        assert!(above(0.02, 0.0).is_empty() && above(0.02, 0.01).is_empty());
        let found = above(0.02, 0.06);
        assert!(found.len() == 1 && (found[0].depth + 0.02).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_wheel_that_leans_stands_on_its_lower_edge() {
        let ground = profile([0.0; 9]);
        let lean = 0.1_f64;
        // Up to the left: the right edge is the lower one.
        let axis = V3::new(0.0, cos(lean), sin(lean));
        let found = contacts(&ground, V3::new(0.3, 0.2, 0.47), axis, 0.0);
        assert_eq!(found.len(), 1, "{found:?}");
        let aside = (found[0].point - V3::new(0.3, 0.2, 0.47)).dot(&axis);
        assert!((-0.13..-0.08).contains(&aside), "{aside}");
    }
}
