//! The distances of paths from obstacles, and whether outlines meet.

use vb_math::hypot;
use vb_world::{Obstacle, geometry};

/// The footprints of a world's obstacles, ready for many questions.
#[derive(Clone, Debug)]
pub(crate) struct Footprints {
    bodies: Vec<Body>,
}

#[derive(Clone, Debug)]
struct Body {
    outline: Vec<[f64; 2]>,
    centre: [f64; 2],
    radius: f64,
}

/// A distance to an obstacle, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    pub(crate) obstacle: usize,
    /// m; 0 where they touch.
    pub(crate) distance: f64,
}

impl Footprints {
    pub(crate) fn new(obstacles: &[Obstacle]) -> Self {
        let body = |o: &Obstacle| {
            let (outline, centre) = (o.footprint(), [o.x, o.y]);
            let radius = outline.iter().map(|p| hypot(p[0] - o.x, p[1] - o.y)).fold(0.0, f64::max);
            Body { outline, centre, radius }
        };
        Self { bodies: obstacles.iter().map(body).collect() }
    }

    /// The outlines, in the obstacles' order.
    pub(crate) fn outlines(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        self.bodies.iter().map(|b| b.outline.as_slice())
    }

    /// The obstacle nearest to a segment; none without obstacles.
    pub(crate) fn nearest(&self, a: [f64; 2], b: [f64; 2]) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for (obstacle, body) in self.bodies.iter().enumerate() {
            // The circle about the outline tells for most obstacles that another one is nearer.
            let at_least = geometry::point_to_segment(body.centre, a, b) - body.radius;
            if best.is_some_and(|n| at_least >= n.distance) {
                continue;
            }
            let distance = geometry::segment_to_polygon(a, b, &body.outline);
            if best.is_none_or(|n| distance < n.distance) {
                best = Some(Nearest { obstacle, distance });
            }
        }
        best
    }

    /// Where a path comes closest to an obstacle: the index of the segment and the obstacle; none without obstacles
    /// or path.
    pub(crate) fn closest(&self, path: &[[f64; 2]]) -> Option<(usize, Nearest)> {
        let mut best: Option<(usize, Nearest)> = None;
        for (k, w) in path.windows(2).enumerate() {
            if let Some(n) = self.nearest(w[0], w[1])
                && best.is_none_or(|(_, b)| n.distance < b.distance)
            {
                best = Some((k, n));
            }
        }
        best
    }

    /// The first obstacle that meets a convex outline.
    pub(crate) fn hit(&self, outline: &[[f64; 2]]) -> Option<usize> {
        self.bodies.iter().position(|b| meet(outline, &b.outline))
    }

    /// Pairs of obstacles whose footprints meet, each once.
    pub(crate) fn overlaps(&self) -> Vec<[usize; 2]> {
        let mut pairs = Vec::new();
        for (i, a) in self.bodies.iter().enumerate() {
            for (j, b) in self.bodies.iter().enumerate().skip(i + 1) {
                let apart = hypot(a.centre[0] - b.centre[0], a.centre[1] - b.centre[1]) > a.radius + b.radius;
                if !apart && meet(&a.outline, &b.outline) {
                    pairs.push([i, j]);
                }
            }
        }
        pairs
    }
}

/// Whether two convex polygons share a point: an edge meets the other polygon, or one lies inside the other.
fn meet(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    let edges = a.iter().zip(a.iter().cycle().skip(1));
    edges.into_iter().any(|(&p, &q)| geometry::segment_to_polygon(p, q, b) == 0.0)
        || b.first().is_some_and(|&p| geometry::contains(a, p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_world::ObstacleKind;

    fn cube(x: f64, y: f64, side: f64) -> Obstacle {
        Obstacle { x, y, yaw: 0.0, buried: 0.0, kind: ObstacleKind::Box { size: [side; 3] } }
    }

    #[test]
    fn the_nearest_obstacle_is_found_though_another_has_the_nearer_centre() {
        // A 2 m cube at (0, 3) ends at y = 2; a 10 m cube at (0, -6.5) ends at y = -1.5: it is nearer to the x axis.
        let f = Footprints::new(&[cube(0.0, 3.0, 2.0), cube(0.0, -6.5, 10.0), cube(40.0, 9.0, 1.0)]);
        let n = f.nearest([-2.0, 0.0], [2.0, 0.0]).unwrap();
        assert_eq!((n.obstacle, n.distance), (1, 1.5));
        let path = [[-20.0, 0.0], [20.0, 0.0], [40.0, 0.0], [40.0, 8.0]];
        let (segment, n) = f.closest(&path).unwrap();
        assert_eq!((segment, n.obstacle, n.distance), (2, 2, 0.5));
        assert_eq!(Footprints::new(&[]).closest(&path), None);
    }

    #[test]
    fn outlines_meet_if_they_cross_or_one_holds_the_other() {
        let f = Footprints::new(&[
            cube(0.0, 0.0, 4.0),
            cube(0.5, 0.5, 1.0),
            cube(3.0, 0.0, 3.0),
            cube(9.0, 0.0, 1.0),
        ]);
        assert_eq!(f.overlaps(), [[0, 1], [0, 2]]);
        assert_eq!(f.hit(&[[8.0, -0.2], [8.8, -0.2], [8.8, 0.2], [8.0, 0.2]]), Some(3));
        assert_eq!(f.hit(&[[-9.0, -9.0], [9.9, -9.0], [9.9, 9.0], [-9.0, 9.0]]), Some(0));
        assert_eq!(f.hit(&[[20.0, 0.0], [21.0, 0.0], [21.0, 1.0]]), None);
    }
}
