//! Path following.

use crate::{PlannerError, Point2, math};

/// A polyline in the plane of the world frame, parametrised by arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    points: Vec<Point2>,
    /// Arc length at each point, m.
    arc: Vec<f64>,
}

/// The point of a path closest to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The arc length from the start of the path, m.
    pub arc: f64,
    /// The point itself.
    pub point: Point2,
    /// The distance of the point from the position, m.
    pub distance: f64,
}

impl Path {
    /// Creates a path through these points. Repeated points are allowed.
    ///
    /// # Errors
    /// Returns an error if there are no points, or a point is not finite.
    pub fn new(points: &[Point2]) -> Result<Self, PlannerError> {
        if points.is_empty() {
            return Err("the global path has no points".into());
        }
        if let Some(i) = points.iter().position(|p| !p.x.is_finite() || !p.y.is_finite()) {
            return Err(format!("point {i} of the global path is not finite").into());
        }
        let mut arc = vec![0.0];
        for w in points.windows(2) {
            arc.push(arc[arc.len() - 1] + math::hypot(w[1].x - w[0].x, w[1].y - w[0].y));
        }
        Ok(Self { points: points.to_vec(), arc })
    }

    /// The total length of the path, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// The point at an arc length (m), clamped to the start and the end.
    #[must_use]
    pub fn point_at(&self, arc: f64) -> Point2 {
        // First point at or past `arc`.
        let i = self.arc.partition_point(|a| *a < arc);
        if i == 0 {
            return self.points[0];
        }
        if i == self.points.len() {
            return self.points[i - 1];
        }
        let (a, b) = (self.points[i - 1], self.points[i]);
        let t = (arc - self.arc[i - 1]) / (self.arc[i] - self.arc[i - 1]);
        Point2 { x: a.x + (b.x - a.x) * t, y: a.y + (b.y - a.y) * t }
    }

    /// The direction of the path at an arc length (m), rad, counter-clockwise from east; `None` for a path of length 0.
    #[must_use]
    pub fn heading_at(&self, arc: f64) -> Option<f64> {
        let last = self.points.len() - 1;
        // The segment that starts at or before `arc`; for repeated points, the one with a length.
        let mut i = self.arc.partition_point(|a| *a <= arc).clamp(1, last.max(1));
        while i > 1 && i <= last && self.arc[i] == self.arc[i - 1] {
            i -= 1;
        }
        while i <= last && self.arc[i] == self.arc[i - 1] {
            i += 1;
        }
        if i > last {
            return None;
        }
        let (a, b) = (self.points[i - 1], self.points[i]);
        Some(math::atan2(b.y - a.y, b.x - a.x))
    }

    /// The point of the path closest to (x, y), m; ties go to the first.
    #[must_use]
    pub fn closest(&self, x: f64, y: f64) -> Closest {
        self.closest_between(x, y, 0.0, self.length())
    }

    /// The point closest to (x, y) with an arc length in [from, to], all in m; ties go to the first.
    #[must_use]
    pub fn closest_between(&self, x: f64, y: f64, from: f64, to: f64) -> Closest {
        let from = from.clamp(0.0, self.length());
        let to = to.clamp(from, self.length());
        let at = |arc: f64| {
            let point = self.point_at(arc);
            Closest { arc, point, distance: math::hypot(x - point.x, y - point.y) }
        };
        let mut best = at(from);
        let first = self.arc.partition_point(|a| *a <= from).max(1);
        for i in first..self.points.len() {
            let (start, end) = (self.arc[i - 1], self.arc[i]);
            if start > to {
                break;
            }
            let length = end - start;
            if length == 0.0 {
                continue;
            }
            let (a, b) = (self.points[i - 1], self.points[i]);
            let along = ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y)) / length;
            let candidate = at((start + along.clamp(0.0, length)).clamp(from, to));
            if candidate.distance < best.distance {
                best = candidate;
            }
        }
        best
    }
}

/// A vehicle's progress along a path. It never decreases, and increases by at most `window` per call, so that it does
/// not jump to a later section of the path nearby.
#[derive(Clone, Debug, PartialEq)]
pub struct Follower {
    path: Path,
    window: f64,
    arc: f64,
}

impl Follower {
    /// A follower at the start of `path` that searches for the closest point up to `window` metres ahead.
    #[must_use]
    pub fn new(path: Path, window: f64) -> Self {
        Self { path, window, arc: 0.0 }
    }

    /// Advances to the closest point within the window and returns it.
    pub fn update(&mut self, x: f64, y: f64) -> Closest {
        let closest = self.path.closest_between(x, y, self.arc, self.arc + self.window);
        self.arc = closest.arc;
        closest
    }

    /// The point `distance` metres along the path after the vehicle's progress, or the end of the path if it is nearer.
    #[must_use]
    pub fn look_ahead(&self, distance: f64) -> Point2 {
        self.path.point_at(self.arc + distance)
    }

    /// The progress of the vehicle, m from the start of the path.
    #[must_use]
    pub fn arc(&self) -> f64 {
        self.arc
    }

    /// The remaining length of the path, m.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        self.path.length() - self.arc
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn path(points: &[(f64, f64)]) -> Path {
        Path::new(&points.iter().map(|&(x, y)| Point2 { x, y }).collect::<Vec<_>>()).unwrap()
    }

    /// An L: 10 m east, then 10 m north, with a repeated corner.
    fn corner() -> Path {
        path(&[(0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (10.0, 10.0)])
    }

    #[test]
    fn points_and_headings_by_arc_length() {
        let p = corner();
        assert_eq!(p.length(), 20.0);
        for (arc, x, y) in
            [(-1.0, 0.0, 0.0), (4.0, 4.0, 0.0), (10.0, 10.0, 0.0), (13.0, 10.0, 3.0), (99.0, 10.0, 10.0)]
        {
            assert_eq!(p.point_at(arc), Point2 { x, y });
        }
        assert_eq!(p.heading_at(3.0), Some(0.0));
        assert_eq!(p.heading_at(15.0), Some(FRAC_PI_2));
        assert_eq!(p.heading_at(20.0), Some(FRAC_PI_2));
        assert_eq!(path(&[(1.0, 1.0)]).heading_at(0.0), None);
        assert_eq!(path(&[(1.0, 1.0), (1.0, 1.0)]).heading_at(0.0), None);
    }

    #[test]
    fn the_closest_point_is_the_foot_of_the_perpendicular_or_an_end() {
        let p = corner();
        let c = p.closest(4.0, -3.0);
        assert_eq!((c.arc, c.point, c.distance), (4.0, Point2 { x: 4.0, y: 0.0 }, 3.0));
        assert_eq!(p.closest(12.0, 6.0).arc, 16.0);
        assert_eq!(p.closest(-3.0, -4.0).distance, 5.0);
        assert_eq!(p.closest(10.0, 30.0).arc, 20.0);
        // As close to both arms: the first.
        assert_eq!(p.closest(8.0, 2.0).arc, 8.0);
        assert_eq!(path(&[(1.0, 1.0)]).closest(1.0, 3.0).distance, 2.0);
    }

    #[test]
    fn progress_neither_goes_back_nor_jumps_to_a_later_stretch() {
        // Out and back, 1 m apart: halfway out, the way back is nearer than it should matter.
        let there_and_back = path(&[(0.0, 0.0), (50.0, 0.0), (50.0, 1.0), (0.0, 1.0)]);
        let mut f = Follower::new(there_and_back, 10.0);
        assert_eq!(f.update(5.0, 0.9).arc, 5.0);
        assert_eq!(f.update(2.0, 0.0).arc, 5.0);
        assert_eq!(f.look_ahead(10.0), Point2 { x: 15.0, y: 0.0 });
        // Far ahead: it advances by the window at most.
        assert_eq!(f.update(40.0, 0.0).arc, 15.0);
        assert_eq!((f.arc(), f.remaining()), (15.0, 86.0));
    }

    #[test]
    fn looking_past_the_end_gives_the_end() {
        let mut f = Follower::new(corner(), 100.0);
        f.update(10.0, 8.0);
        assert_eq!(f.look_ahead(10.0), Point2 { x: 10.0, y: 10.0 });
    }

    #[test]
    fn an_unusable_path_is_an_error() {
        assert!(Path::new(&[]).is_err());
        let bad = [Point2::default(), Point2 { x: f64::NAN, y: 0.0 }];
        assert!(Path::new(&bad).unwrap_err().to_string().contains("point 1"));
    }
}
