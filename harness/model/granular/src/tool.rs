//! Bodies that move among the grains.

use crate::contact::{Law, Surface};
use crate::{Quat, V3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::ConvexPolyhedron;

/// The shape of a tool in its own axes.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A wheel about its y axis, with round shoulders.
    Wheel {
        /// m.
        radius: f64,
        /// From face to face, m.
        width: f64,
        /// Radius of the shoulders, m; less than the radius and half the width.
        shoulder: f64,
    },
    /// A box.
    Box {
        /// Half of its size along each axis, m.
        half: V3,
    },
    /// A convex solid.
    Convex(Box<Convex>),
}

/// A convex solid and the box around it along its own axes.
#[derive(Clone, Debug)]
pub struct Convex {
    solid: ConvexPolyhedron,
    low: V3,
    high: V3,
}

/// A body that moves among the grains, see the crate's documentation.
#[derive(Clone, Debug)]
pub struct Tool {
    pub shape: Shape,
    /// Friction coefficient of its surface on the grains.
    pub friction: f64,
    /// Stiffness of its surface under a grain, N/m: infinite for a rigid one.
    pub stiffness: f64,
}

/// The motion of a tool at the start of a step, world frame.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// The centre, m.
    pub position: V3,
    pub rotation: Quat,
    /// Of the centre, m/s.
    pub velocity: V3,
    /// rad/s.
    pub spin: V3,
}

/// What the grains do to a tool in a step, world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// N s.
    pub impulse: V3,
    /// About the centre of the tool, N m s.
    pub moment: V3,
}

impl Tool {
    /// Its surface as a point near it meets it.
    pub(crate) fn surface(&self, motion: &Motion, x: &V3, law: &Law) -> Surface {
        let way = x - motion.position;
        let (distance, normal) = self.shape.distance(&(motion.rotation.inverse() * way));
        let normal = motion.rotation * normal;
        let velocity = motion.velocity + motion.spin.cross(&(way - normal * distance));
        // Two springs in series.
        let stiffness = 1.0 / (1.0 / law.stiffness + 1.0 / self.stiffness);
        let law = Law { stiffness, friction: self.friction, cohesion: 0.0, ..*law };
        Surface { distance, normal, velocity, spin: motion.spin, law }
    }
}

impl Shape {
    /// The convex hull of points, m; `None` if they span no volume.
    #[must_use]
    pub fn convex(points: &[[f64; 3]]) -> Option<Self> {
        let points: Vec<Vector> = points.iter().map(|p| Vector::new(p[0], p[1], p[2])).collect();
        let solid = ConvexPolyhedron::from_convex_hull(&points)?;
        let corner = |from: f64, pick: fn(f64, f64) -> f64| {
            let of = |k: usize| points.iter().fold(from, |best, p| pick(best, p[k]));
            V3::new(of(0), of(1), of(2))
        };
        let (low, high) = (corner(f64::INFINITY, f64::min), corner(f64::NEG_INFINITY, f64::max));
        Some(Self::Convex(Box::new(Convex { solid, low, high })))
    }

    /// Lowest and highest coordinates of the body, and of what is within a distance of it, m.
    pub(crate) fn extent(&self, motion: &Motion, distance: f64) -> [V3; 2] {
        let sphere = V3::repeat(self.bound());
        let (low, high) = match self {
            Self::Wheel { .. } => (-sphere, sphere),
            Self::Box { half } => (-half, *half),
            Self::Convex(convex) => (convex.low, convex.high),
        };
        let turn = motion.rotation.to_rotation_matrix();
        let middle = motion.position + turn * (0.5 * (low + high));
        let half = turn.matrix().abs() * (0.5 * (high - low)) + V3::repeat(distance);
        [middle - half, middle + half]
    }

    /// Whether a point may be within a distance of the surface, m; whatever is farther away than its box is not.
    pub(crate) fn may_reach(&self, x: &V3, motion: &Motion, distance: f64) -> bool {
        let way = x - motion.position;
        let bound = self.bound() + distance;
        if way.norm_squared() >= bound * bound {
            return false;
        }
        let within = |low: &V3, high: &V3| {
            let p = motion.rotation.inverse() * way;
            (0..3).all(|k| p[k] > low[k] - distance && p[k] < high[k] + distance)
        };
        match self {
            Self::Wheel { .. } => true,
            Self::Box { half } => within(&-half, half),
            Self::Convex(convex) => within(&convex.low, &convex.high),
        }
    }

    /// Distance of a point from the surface, m, negative within, and the unit normal out of it; own axes.
    pub(crate) fn distance(&self, p: &V3) -> (f64, V3) {
        match self {
            Self::Wheel { radius, width, shoulder } => {
                let r = (p.x * p.x + p.z * p.z).sqrt();
                let out = if r > 0.0 { V3::new(p.x / r, 0.0, p.z / r) } else { V3::z() };
                let side = V3::new(0.0, p.y.signum(), 0.0);
                let (a, b) = (r - (radius - shoulder), p.y.abs() - (0.5 * width - shoulder));
                rounded(&[(a, out), (b, side)], *shoulder)
            }
            Self::Box { half } => {
                let face = |k: usize| {
                    let mut n = V3::zeros();
                    n[k] = p[k].signum();
                    (p[k].abs() - half[k], n)
                };
                rounded(&[face(0), face(1), face(2)], 0.0)
            }
            Self::Convex(convex) => {
                let point = Vector::new(p.x, p.y, p.z);
                let found = convex.solid.project_local_point(point, false);
                let way = point - found.point;
                let way = V3::new(way.x, way.y, way.z);
                let distance = way.norm();
                let sign = if found.is_inside { -1.0 } else { 1.0 };
                if distance > 0.0 { (sign * distance, way * (sign / distance)) } else { (0.0, V3::z()) }
            }
        }
    }

    /// Radius of a sphere about the centre that contains it, m.
    #[must_use]
    pub fn bound(&self) -> f64 {
        match self {
            Self::Wheel { radius, width, .. } => (radius * radius + 0.25 * width * width).sqrt(),
            Self::Box { half } => half.norm(),
            Self::Convex(convex) => convex.low.abs().sup(&convex.high.abs()).norm(),
        }
    }
}

/// Distance from a solid with round edges: of each pair of faces, how far the point is beyond the core's, and its normal.
fn rounded(faces: &[(f64, V3)], edge: f64) -> (f64, V3) {
    let deepest = faces.iter().fold(f64::NEG_INFINITY, |most, face| most.max(face.0));
    if deepest <= 0.0 {
        let face = faces.iter().find(|face| face.0 == deepest).map_or(V3::z(), |face| face.1);
        return (deepest - edge, face);
    }
    let way: V3 = faces.iter().map(|(beyond, normal)| normal * beyond.max(0.0)).sum();
    let distance = way.norm();
    (distance - edge, way / distance)
}
