//! Rays against convex solids.

use crate::V3;
use parry3d_f64::math::Vector;
use vb_world::{Heightfield, Obstacle};

/// A convex solid in the frame of its rays: the space below all its faces' planes.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    /// Outward unit normals, and how far the planes lie along them from the origin, m.
    planes: Vec<(V3, f64)>,
    /// A sphere around it.
    pub(crate) centre: V3,
    pub(crate) radius: f64,
}

/// How much two normals differ at least that belong to faces, and not to triangles of one face.
const SAME_FACE: f64 = 1e-9;

impl Solid {
    /// The convex hull of points, which are not all in one plane: whoever reads obstacles and vehicles checks that.
    pub(crate) fn hull(points: &[V3]) -> Self {
        let least = points.iter().fold(V3::repeat(f64::INFINITY), |a, b| a.inf(b));
        let most = points.iter().fold(V3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
        let centre = 0.5 * (least + most);
        // About the middle, so that the places of planes are small numbers.
        let about: Vec<Vector> =
            points.iter().map(|p| p - centre).map(|p| Vector::new(p.x, p.y, p.z)).collect();
        let (corners, triangles) = parry3d_f64::transformation::convex_hull(&about);
        let mut planes: Vec<(V3, f64)> = Vec::new();
        for t in triangles {
            let [a, b, c] =
                t.map(|k| V3::new(corners[k as usize].x, corners[k as usize].y, corners[k as usize].z));
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            if planes.iter().all(|(n, _)| (n - normal).norm() > SAME_FACE) {
                // No point may lie outside, so the farthest decides.
                let along = corners.iter().map(|p| normal.x * p.x + normal.y * p.y + normal.z * p.z);
                planes.push((normal, along.fold(f64::NEG_INFINITY, f64::max)));
            }
        }
        let radius = about.iter().map(|p| p.length()).fold(0.0, f64::max);
        Self { planes, centre, radius }
    }

    /// An obstacle where it stands in the world.
    pub(crate) fn of(obstacle: &Obstacle, ground: &Heightfield) -> Self {
        let (s, c) = vb_math::sin_cos(obstacle.yaw);
        let base = obstacle.base_z(ground);
        let place = |v: &[f64; 3]| {
            V3::new(obstacle.x + c * v[0] - s * v[1], obstacle.y + s * v[0] + c * v[1], base + v[2])
        };
        Self::hull(&obstacle.hull().iter().map(place).collect::<Vec<_>>())
    }

    /// The distance at which a ray meets the surface within `reach`, m. From inside it is where the ray leaves.
    #[inline]
    pub(crate) fn cast(&self, origin: &V3, direction: &V3, reach: f64) -> Option<f64> {
        let to = origin - self.centre;
        let along = to.dot(direction);
        // Past it, or too far beside it.
        let across = to.norm_squared() - along * along;
        let outside = across > self.radius * self.radius * (1.0 + 1e-9);
        if outside || along > self.radius || -along - self.radius > reach {
            return None;
        }
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for (normal, offset) in &self.planes {
            let (gap, rate) = (normal.dot(&to) - offset, normal.dot(direction));
            if rate < 0.0 {
                enter = enter.max(-gap / rate);
            } else if rate > 0.0 {
                leave = leave.min(-gap / rate);
            } else if gap > 0.0 {
                return None;
            }
            if enter > leave || enter > reach {
                return None;
            }
        }
        let hit = if enter >= 0.0 { enter } else { leave };
        (enter <= leave && hit >= 0.0 && hit <= reach).then_some(hit)
    }
}
