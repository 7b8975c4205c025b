//! Courses: heights on a grid along a reference line, as OpenCRG ("curved regular grid") defines them.
//!
//! A place on a course has a coordinate u along the reference line and v across it, positive to the left, both in metres. The
//! reference line is a polyline with a corner every [`increment`](Course::increment); its lateral cuts bisect the corners (ASAM
//! OpenCRG 1.2, the evaluation of its reference implementation). Heights between grid points are bilinear. Beyond its borders a
//! course has the height of the border, which is OpenCRG's default (border mode 2).

use vb_math::{atan2, cos, hypot, sin};

/// The most points along the line among which the nearest one is looked for first.
const COARSE: usize = 256;

/// A course.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// The coordinate u of the first lateral cut, m.
    start: f64,
    /// The distance between lateral cuts, m.
    increment: f64,
    /// The coordinates v of the longitudinal sections, from right to left, m.
    sections: Vec<f64>,
    /// The height of each grid point above its lateral cut, m: the sections of the first cut, then those of the next one.
    grid: Vec<f64>,
    /// The corners of the reference line (x, y), m.
    line: Vec<[f64; 2]>,
    /// The height of the reference line at each cut, m.
    base: Vec<f64>,
    /// The lateral slope of each cut, rise to the left over distance.
    banking: Vec<f64>,
    /// The lengths at the start and at the end over which heights grow linearly from 0, m; 0 for none.
    fade: [f64; 2],
    /// Whether the reference line has no corner.
    straight: bool,
}

/// The parts of a course, as a file has them.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) start: f64,
    pub(crate) increment: f64,
    pub(crate) sections: Vec<f64>,
    pub(crate) grid: Vec<f64>,
    /// The heading of each segment of the reference line, rad from x to y; one less than there are cuts.
    pub(crate) headings: Vec<f64>,
    pub(crate) origin: [f64; 2],
    pub(crate) base: Vec<f64>,
    pub(crate) banking: Vec<f64>,
    pub(crate) fade: [f64; 2],
}

impl Course {
    /// A straight course along x whose height depends on u alone: `heights` are m, `increment` m apart from u = 0 on, over
    /// `half_width` metres to each side.
    ///
    /// # Panics
    /// If there are less than two heights, or a length is not positive.
    #[must_use]
    pub fn straight(increment: f64, half_width: f64, heights: &[f64]) -> Self {
        assert!(
            heights.len() > 1 && increment > 0.0 && half_width > 0.0,
            "a course has a length and a width"
        );
        Self::new(Parts {
            start: 0.0,
            increment,
            sections: vec![-half_width, half_width],
            grid: heights.iter().flat_map(|z| [*z; 2]).collect(),
            headings: vec![0.0; heights.len() - 1],
            origin: [0.0; 2],
            base: vec![0.0; heights.len()],
            banking: vec![0.0; heights.len()],
            fade: [0.0; 2],
        })
    }

    /// Parts that fit each other: at least two cuts and two sections.
    pub(crate) fn new(parts: Parts) -> Self {
        let Parts { start, increment, sections, grid, headings, origin, base, banking, fade } = parts;
        let straight = headings.windows(2).all(|h| h[0] == h[1]);
        let mut line = vec![origin];
        let mut at = origin;
        for heading in headings {
            at = [at[0] + increment * cos(heading), at[1] + increment * sin(heading)];
            line.push(at);
        }
        Self { start, increment, sections, grid, line, base, banking, fade, straight }
    }

    /// The number of lateral cuts.
    #[must_use]
    pub fn cuts(&self) -> usize {
        self.line.len()
    }

    /// The coordinates v of the longitudinal sections, from right to left, m.
    #[must_use]
    pub fn sections(&self) -> &[f64] {
        &self.sections
    }

    /// The distance between lateral cuts, m.
    #[must_use]
    pub fn increment(&self) -> f64 {
        self.increment
    }

    /// The coordinates u of the first and the last cut, m.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        [self.start, self.start + self.length()]
    }

    /// The length of the reference line, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        (self.cuts() - 1) as f64 * self.increment
    }

    /// The coordinates v of the right and the left border, m.
    #[must_use]
    pub fn borders(&self) -> [f64; 2] {
        [self.sections[0], self.sections[self.sections.len() - 1]]
    }

    /// The least distance between neighbouring longitudinal sections, m.
    #[must_use]
    pub fn finest_section(&self) -> f64 {
        self.sections.windows(2).map(|v| v[1] - v[0]).fold(f64::INFINITY, f64::min)
    }

    /// The lowest and the highest grid point, m.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for cut in 0..self.cuts() {
            let u = self.start + cut as f64 * self.increment;
            for v in &self.sections {
                let z = self.height(u, *v);
                range = [range[0].min(z), range[1].max(z)];
            }
        }
        range
    }

    /// The difference between the greatest and the least heading of the reference line, rad; more than π for one that winds.
    #[must_use]
    pub fn turn(&self) -> f64 {
        let headings = self.line.windows(2).map(|p| atan2(p[1][1] - p[0][1], p[1][0] - p[0][0]));
        let (mut last, mut sum, mut range) = (None, 0.0, [0.0_f64; 2]);
        for heading in headings {
            if let Some(before) = last {
                sum += vb_math::angle::wrap(heading - before);
                range = [range[0].min(sum), range[1].max(sum)];
            }
            last = Some(heading);
        }
        range[1] - range[0]
    }

    /// The cut before a coordinate u within the course, and how far the coordinate is from it to the next one, in [0, 1].
    fn cut(&self, u: f64) -> (usize, f64) {
        let along = ((u - self.start) / self.increment).clamp(0.0, (self.cuts() - 1) as f64);
        let cut = (along as usize).min(self.cuts() - 2);
        (cut, along - cut as f64)
    }

    /// The height at a place, m. Beyond the borders it is that of the border.
    #[must_use]
    pub fn height(&self, u: f64, v: f64) -> f64 {
        let (cut, t) = self.cut(u);
        let [right, left] = self.borders();
        let v = v.clamp(right, left);
        let next = self.sections.partition_point(|s| *s <= v).clamp(1, self.sections.len() - 1);
        let (low, high) = (self.sections[next - 1], self.sections[next]);
        let s = (v - low) / (high - low);
        let at = |cut: usize| {
            let row = &self.grid[cut * self.sections.len()..];
            row[next - 1] + s * (row[next] - row[next - 1]) + self.base[cut] + v * self.banking[cut]
        };
        // Bilinear, and exact at the grid points.
        let (z0, z1) = (at(cut), at(cut + 1));
        self.faded(u) * (z0 + t * (z1 - z0))
    }

    /// The factor of heights near the ends.
    fn faded(&self, u: f64) -> f64 {
        let [from, to] = self.span();
        let ramp =
            |distance: f64, over: f64| if over > 0.0 { (distance / over).clamp(0.0, 1.0) } else { 1.0 };
        ramp(u - from, self.fade[0]) * ramp(to - u, self.fade[1])
    }

    /// The point (x, y), m, of the reference line at a coordinate u, and the heading there, rad from x to y. Beyond its ends the
    /// line goes on straight.
    #[must_use]
    pub fn position(&self, u: f64) -> ([f64; 2], f64) {
        let (cut, _) = self.cut(u);
        let t = (u - self.start) / self.increment - cut as f64;
        let [a, b] = [self.line[cut], self.line[cut + 1]];
        let at = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        (at, atan2(b[1] - a[1], b[0] - a[0]))
    }

    /// The coordinates u and v of the point (x, y), m.
    #[must_use]
    pub fn coordinates(&self, at: [f64; 2]) -> [f64; 2] {
        let last = self.cuts() - 1;
        if self.straight {
            let (origin, heading) = self.position(self.start);
            let (s, c) = (sin(heading), cos(heading));
            let (x, y) = (at[0] - origin[0], at[1] - origin[1]);
            return [self.start + x * c + y * s, y * c - x * s];
        }
        let square = |i: usize| {
            let p = self.line[i];
            (at[0] - p[0]) * (at[0] - p[0]) + (at[1] - p[1]) * (at[1] - p[1])
        };
        // The nearest of some corners, then of those near it.
        let stride = last.div_ceil(COARSE);
        let nearest = |range: &mut dyn Iterator<Item = usize>| {
            range.map(|i| (i, square(i))).fold((0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a }).0
        };
        let about = nearest(&mut (0..=last).step_by(stride).chain([last]));
        let near = nearest(&mut (about.saturating_sub(stride)..=(about + stride).min(last)));
        // The segment from `k` to `k + 1` whose bisecting cuts the point lies between.
        let corner = |i: usize| self.line[i];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let across = |i: usize| minus(corner((i + 1).min(last)), corner(i.saturating_sub(1)));
        let beyond = |i: usize| dot(minus(at, corner(i)), across(i));
        let mut k = near.min(last - 1);
        while k + 1 < last && beyond(k + 1) > 0.0 {
            k += 1;
        }
        while k > 0 && beyond(k) < 0.0 {
            k -= 1;
        }
        let along = minus(corner(k + 1), corner(k));
        let from = minus(at, corner(k));
        let before = beyond(k) / dot(across(k), along);
        let after = -beyond(k + 1) / dot(across(k + 1), along);
        let [ax, ay] = along;
        let v = (ax * from[1] - ay * from[0]) / hypot(ax, ay);
        let t = if before + after == 0.0 { 0.0 } else { before / (before + after) };
        // Beyond its ends the line goes on straight, with lateral cuts at right angles to it.
        let t = if (k == 0 && t < 0.0) || (k + 1 == last && t > 1.0) {
            dot(from, along) / dot(along, along)
        } else {
            t
        };
        [self.start + (k as f64 + t) * self.increment, v]
    }

    /// The height under the point (x, y), m.
    #[must_use]
    pub fn height_at(&self, at: [f64; 2]) -> f64 {
        let [u, v] = self.coordinates(at);
        self.height(u, v)
    }

    /// The least x and y and the greatest x and y of the course between its borders, m.
    #[must_use]
    pub fn extents(&self) -> [[f64; 2]; 2] {
        let mut extents = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let last = self.cuts() - 1;
        for i in 0..=last {
            let (a, b) = (self.line[i.saturating_sub(1)], self.line[(i + 1).min(last)]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let length = hypot(dx, dy).max(f64::MIN_POSITIVE);
            for v in self.borders() {
                let p = [self.line[i][0] - v * dy / length, self.line[i][1] + v * dx / length];
                for k in 0..2 {
                    extents[0][k] = extents[0][k].min(p[k]);
                    extents[1][k] = extents[1][k].max(p[k]);
                }
            }
        }
        extents
    }

    /// One line: size, grid, heights and reference line.
    #[must_use]
    pub fn summary(&self) -> String {
        let [right, left] = self.borders();
        let [low, high] = self.range();
        let turn = self.turn().to_degrees();
        let line = if turn < 0.05 { "straight".to_owned() } else { format!("turns by {turn:.1} degrees") };
        format!(
            "course of {:.2} m by {:.2} m, {} cuts every {} m with {} sections, heights {low:.3} to {high:.3} m, {line}",
            self.length(),
            left - right,
            self.cuts(),
            self.increment,
            self.sections.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A quarter of a circle of radius 20 m to the left in segments of 0.1 m, with the height v²/10.
    fn bend() -> Course {
        let (radius, increment) = (20.0, 0.1);
        let segments = (radius * FRAC_PI_2 / increment) as usize;
        let sections: Vec<f64> = (-4..=4).map(|k| 0.5 * f64::from(k)).collect();
        Course::new(Parts {
            start: 5.0,
            increment,
            grid: (0..=segments).flat_map(|_| sections.iter().map(|v| 0.1 * v * v)).collect(),
            sections,
            headings: (0..segments).map(|k| (k as f64 + 0.5) * increment / radius).collect(),
            origin: [0.0; 2],
            base: vec![0.0; segments + 1],
            banking: vec![0.0; segments + 1],
            fade: [0.0; 2],
        })
    }

    #[test]
    fn coordinates_on_a_circle_are_arc_length_and_distance_from_it() {
        let course = bend();
        for (angle, radius) in [(0.3, 20.0), (0.7, 18.5), (1.2, 21.3), (0.01, 19.0)] {
            // The circle's centre is (0, 20): a point to the left of the line lies nearer to it.
            let at = [radius * sin(angle), 20.0 - radius * cos(angle)];
            let [u, v] = course.coordinates(at);
            assert!((u - 5.0 - 20.0 * angle).abs() < 2e-3 && (v - (20.0 - radius)).abs() < 2e-4, "{u} {v}");
        }
        // Beyond its end the line goes on straight, along y.
        let end = course.position(course.span()[1]).0;
        let [u, v] = course.coordinates([end[0] - 1.0, end[1] + 3.0]);
        assert!((u - course.span()[1] - 3.0).abs() < 0.02 && (v - 1.0).abs() < 0.03, "{u} {v}");
        assert!((course.turn() - FRAC_PI_2).abs() < 0.02);
    }

    #[test]
    fn heights_are_those_of_the_grid_between_its_points_linear_and_level_beyond_its_borders() {
        let course = bend();
        assert!((course.height(9.0, 1.5) - 0.225).abs() < 1e-12);
        assert!((course.height(9.03, 1.25) - 0.5 * (0.1 + 0.225)).abs() < 1e-12);
        assert_eq!([course.height(-3.0, -9.0), course.height(99.0, 2.0)], [0.4, 0.4]);
        let straight = Course::straight(0.5, 2.0, &[0.0, 1.0, 0.0]);
        assert_eq!(
            [0.25, 0.5, 0.9, 2.0].map(|u| straight.height(u, 0.3)),
            [0.5, 1.0, 0.19999999999999996, 0.0]
        );
        assert_eq!(straight.height_at([0.25, -7.0]), 0.5);
        assert_eq!(straight.extents(), [[0.0, -2.0], [1.0, 2.0]]);
    }
}
