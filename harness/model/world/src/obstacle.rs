//! Convex obstacles, most of which stand in the ground.

use crate::{Heightfield, geometry};
use vb_math::rng::Stream;

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum ObstacleKind {
    /// An irregular convex boulder with a flat base; `seed` fixes its vertices.
    Boulder {
        /// The full extents along the obstacle's own x, y and z axes, m.
        size: [f64; 3],
        /// The seed that chooses the vertices (see [`Obstacle::hull`]).
        seed: u64,
    },
    /// An upright box.
    Box {
        /// The full extents along the obstacle's own x, y and z axes, m.
        size: [f64; 3],
    },
    /// A tree trunk: an upright cylinder, represented by a regular prism.
    Trunk {
        /// The radius of the trunk, m.
        radius: f64,
        /// The length of the trunk, m.
        height: f64,
    },
}

/// One obstacle.
///
/// Its own frame has its origin at ground level under its centre (see [`Obstacle::base_z`]), z up and x along `yaw`;
/// the body reaches from z = −`buried` to z = height − `buried`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Obstacle {
    /// The position of the centre along x (east), m.
    pub x: f64,
    /// The position of the centre along y (north), m.
    pub y: f64,
    /// The heading of the obstacle's own x axis, rad, counter-clockwise from east.
    pub yaw: f64,
    /// The part of its height that is below the ground at its centre, m. If it is negative, the obstacle hangs that far
    /// above the ground; if it is more than the height, the obstacle lies wholly below the ground at its centre.
    pub buried: f64,
    /// The shape of the obstacle.
    pub kind: ObstacleKind,
}

/// Sides of the prism that stands for a trunk.
const TRUNK_SIDES: usize = 12;

impl Obstacle {
    /// The full extents along the obstacle's own axes, m.
    #[must_use]
    pub fn size(&self) -> [f64; 3] {
        match self.kind {
            ObstacleKind::Boulder { size, .. } | ObstacleKind::Box { size } => size,
            ObstacleKind::Trunk { radius, height } => [2.0 * radius, 2.0 * radius, height],
        }
    }

    /// The height of the ground under the obstacle's centre, m: the z of the origin of its own frame.
    #[must_use]
    pub fn base_z(&self, ground: &Heightfield) -> f64 {
        ground.height(self.x, self.y)
    }

    /// The vertices of the obstacle's convex hull in its own frame, m. Every one is an extreme point, and together they
    /// touch each side of the box of [`Obstacle::size`] that reaches from −`buried` upwards. The same fields always
    /// give the same vertices.
    ///
    /// A box has its 8 corners. A trunk is a regular prism of 12 sides with vertices on the cylinder. A boulder has
    /// 28 vertices on a superellipsoid |x|^p + |y|^p + |z|^p = 1, cut flat below its widest part, sheared a little
    /// and stretched to its box; the seed draws the exponent, the cut, the shear and the vertices.
    #[must_use]
    pub fn hull(&self) -> Vec<[f64; 3]> {
        let size = self.size();
        let unit = match self.kind {
            ObstacleKind::Boulder { seed, .. } => unit_boulder(seed),
            ObstacleKind::Box { .. } => unit_box(),
            ObstacleKind::Trunk { .. } => unit_prism(),
        };
        unit.into_iter().map(|v| [v[0] * size[0], v[1] * size[1], v[2] * size[2] - self.buried]).collect()
    }

    /// The outline of the obstacle seen from above, buried part included: a convex polygon in world coordinates (m),
    /// counter-clockwise.
    #[must_use]
    pub fn footprint(&self) -> Vec<[f64; 2]> {
        let (s, c) = vb_math::sin_cos(self.yaw);
        let seen: Vec<_> = self
            .hull()
            .iter()
            .map(|v| [self.x + c * v[0] - s * v[1], self.y + s * v[0] + c * v[1]])
            .collect();
        geometry::convex_hull(&seen)
    }

    /// The same obstacle with every length multiplied by `s`.
    #[must_use]
    pub fn scaled(&self, s: f64) -> Self {
        let kind = match self.kind {
            ObstacleKind::Boulder { size, seed } => ObstacleKind::Boulder { size: size.map(|l| l * s), seed },
            ObstacleKind::Box { size } => ObstacleKind::Box { size: size.map(|l| l * s) },
            ObstacleKind::Trunk { radius, height } => {
                ObstacleKind::Trunk { radius: radius * s, height: height * s }
            }
        };
        Self { x: self.x * s, y: self.y * s, yaw: self.yaw, buried: self.buried * s, kind }
    }
}

/// Corners of the box [-½, ½]² × [0, 1].
fn unit_box() -> Vec<[f64; 3]> {
    (0..8u8).map(|k| [0, 1, 2].map(|b| f64::from(k >> b & 1) - if b < 2 { 0.5 } else { 0.0 })).collect()
}

/// A regular prism inscribed in the cylinder of diameter 1 and height 1.
fn unit_prism() -> Vec<[f64; 3]> {
    let corner = |k: usize, z| {
        let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * k as f64 / TRUNK_SIDES as f64);
        [0.5 * c, 0.5 * s, z]
    };
    [0.0, 1.0].iter().flat_map(|&z| (0..TRUNK_SIDES).map(move |k| corner(k, z))).collect()
}

/// A boulder that touches every side of [-½, ½]² × [0, 1].
///
/// Points of a strictly convex surface, and of a plane cut through it with nothing below, are all extreme points
/// of their hull; affine maps keep that.
fn unit_boulder(seed: u64) -> Vec<[f64; 3]> {
    let mut rng = Stream::new(seed, &["boulder"]);
    let p = rng.uniform(2.1, 3.2);
    let cut = -rng.uniform(0.45, 0.65);
    let shear = [rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15)];
    let power = |v: f64| vb_math::pow(v.abs(), p);
    let mut points = Vec::with_capacity(28);
    // Lowest and highest z of each ring on the unit superellipsoid, and its number of vertices.
    let rings = [(cut, cut, 8), (0.6 * cut, 0.1, 8), (0.15, 0.5, 6), (0.55, 0.85, 4), (0.9, 0.98, 2)];
    for (low, high, count) in rings {
        let phase = rng.unit();
        for k in 0..count {
            let z = rng.uniform(low, high);
            let turn = (f64::from(k) + phase + rng.uniform(-0.35, 0.35)) / f64::from(count);
            let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * turn);
            let r = vb_math::pow((1.0 - power(z)) / (power(c) + power(s)), 1.0 / p);
            points.push([r * c + shear[0] * z, r * s + shear[1] * z, z]);
        }
    }
    for axis in 0..3 {
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v[axis]), h.max(v[axis])));
        let centre = if axis < 2 { 0.5 } else { 0.0 };
        for v in &mut points {
            v[axis] = (v[axis] - low) / (high - low) - centre;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boulder(seed: u64) -> Obstacle {
        let kind = ObstacleKind::Boulder { size: [4.4, 4.0, 3.8], seed };
        Obstacle { x: 3.0, y: -2.0, yaw: 0.4, buried: 1.9, kind }
    }

    #[test]
    fn a_hull_touches_its_box_on_every_side() {
        let cube = Obstacle { kind: ObstacleKind::Box { size: [2.0, 3.0, 4.0] }, ..boulder(0) };
        let trunk = Obstacle { kind: ObstacleKind::Trunk { radius: 0.5, height: 5.0 }, ..boulder(0) };
        let all = (0..40).map(boulder).chain([cube, trunk]);
        for o in all {
            let (size, hull) = (o.size(), o.hull());
            let expected = [
                [-0.5 * size[0], 0.5 * size[0]],
                [-0.5 * size[1], 0.5 * size[1]],
                [-o.buried, size[2] - o.buried],
            ];
            for axis in 0..3 {
                let low = hull.iter().map(|v| v[axis]).fold(f64::INFINITY, f64::min);
                let high = hull.iter().map(|v| v[axis]).fold(f64::NEG_INFINITY, f64::max);
                assert!((low - expected[axis][0]).abs() < 1e-12, "{o:?} axis {axis}: {low}");
                assert!((high - expected[axis][1]).abs() < 1e-12, "{o:?} axis {axis}: {high}");
            }
        }
    }

    #[test]
    fn every_vertex_of_a_boulder_is_extreme() {
        // A vertex is extreme if some direction has it as its strict maximum. The gradient of the superellipsoid
        // is such a direction, but the shape was sheared and stretched; search directions instead.
        for seed in 0..10 {
            let hull = boulder(seed).hull();
            let mut rng = Stream::new(seed, &["directions"]);
            let mut is_extreme = vec![false; hull.len()];
            for _ in 0..60_000 {
                let d = [rng.normal(0.0, 1.0), rng.normal(0.0, 1.0), rng.normal(0.0, 1.0)];
                let along = |v: &[f64; 3]| v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
                let best = (0..hull.len()).max_by(|&a, &b| along(&hull[a]).total_cmp(&along(&hull[b])));
                is_extreme[best.unwrap()] = true;
            }
            assert_eq!(hull.len(), 28);
            assert!(is_extreme.iter().all(|&e| e), "seed {seed}: {is_extreme:?}");
        }
    }

    #[test]
    fn a_boulder_stands_on_a_flat_base_and_differs_by_seed() {
        let hull = boulder(1).hull();
        let base: Vec<_> = hull.iter().filter(|v| v[2] == -1.9).map(|v| [v[0], v[1]]).collect();
        assert_eq!(base.len(), 8);
        let outline = geometry::convex_hull(&base);
        let area = 0.5
            * (0..outline.len())
                .map(|k| {
                    let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
                    a[0] * b[1] - a[1] * b[0]
                })
                .sum::<f64>();
        assert!(area > 0.35 * 4.4 * 4.0, "{area}");
        assert_ne!(hull, boulder(2).hull());
        assert_eq!(hull, boulder(1).hull());
    }

    #[test]
    fn a_footprint_is_the_turned_outline_about_the_centre() {
        let o = Obstacle {
            x: 1.0,
            y: 2.0,
            yaw: std::f64::consts::FRAC_PI_2,
            buried: 0.5,
            kind: ObstacleKind::Box { size: [4.0, 2.0, 1.0] },
        };
        let footprint = o.footprint();
        let expected = [[0.0, 0.0], [2.0, 0.0], [2.0, 4.0], [0.0, 4.0]];
        assert_eq!(footprint.len(), 4);
        for e in expected {
            assert!(
                footprint.iter().any(|v| vb_math::hypot(v[0] - e[0], v[1] - e[1]) < 1e-12),
                "{footprint:?}"
            );
        }
        assert!(geometry::contains(&footprint, [1.0, 2.0]));
    }
}
