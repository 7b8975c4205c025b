//! The way of a belt around its wheels, in the plane of a track.

use vb_math::atan2;

/// A wheel of a track: its centre, and the radius of the belt's way around it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disc {
    /// The centre in the plane of the track (forward, up), m.
    pub centre: [f64; 2],
    /// The radius of the belt's way around the wheel, m.
    pub radius: f64,
}

/// A part of a belt between two wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// The point (forward, up) at which the belt leaves the first wheel, m.
    pub start: [f64; 2],
    /// The unit vector (forward, up) towards the point at which the belt meets the second wheel.
    pub direction: [f64; 2],
    /// The length of the span, m.
    pub length: f64,
}

impl Span {
    /// The point (forward, up) that lies a part of the way along the span, from 0 to 1, m.
    #[must_use]
    pub fn at(&self, part: f64) -> [f64; 2] {
        [0, 1].map(|k| self.start[k] + self.direction[k] * (self.length * part))
    }

    /// The unit vector (forward, up) away from the wheels: it points down where the belt runs on the ground.
    #[must_use]
    pub fn outward(&self) -> [f64; 2] {
        [-self.direction[1], self.direction[0]]
    }
}

/// A taut belt around wheels: from the first, which is the foremost, below the others to the rear, and back above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    discs: Vec<Disc>,
    spans: Vec<Span>,
}

impl Course {
    /// The course of a belt around wheels from front to rear, none of which lies within the next.
    #[must_use]
    pub fn around(discs: &[Disc]) -> Self {
        let mut course = Self { discs: discs.to_vec(), spans: vec![Span::default(); discs.len()] };
        course.lay();
        course
    }

    /// The wheels, front to rear.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// The spans between each wheel and the next, and from the last to the first.
    #[must_use]
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Moves the centre of a wheel; [`Self::lay`] then lays the belt again.
    pub(crate) fn move_to(&mut self, disc: usize, centre: [f64; 2]) {
        self.discs[disc].centre = centre;
    }

    /// Lays the belt around the wheels where they are: its spans are the outer common tangents of neighbours.
    pub(crate) fn lay(&mut self) {
        let count = self.discs.len();
        for (j, span) in self.spans.iter_mut().enumerate() {
            let (a, b) = (self.discs[j], self.discs[(j + 1) % count]);
            let [dx, dz] = [b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]];
            let apart = (dx * dx + dz * dz).sqrt();
            let (ux, uz) = (dx / apart, dz / apart);
            let sin = (a.radius - b.radius) / apart;
            let cos = (1.0 - sin * sin).max(0.0).sqrt();
            let outward = [ux * sin - uz * cos, uz * sin + ux * cos];
            span.direction = [outward[1], -outward[0]];
            span.length = apart * cos;
            span.start = [0, 1].map(|k| a.centre[k] + outward[k] * a.radius);
        }
    }

    /// The length of the belt, m. A wheel that stands above the line of its neighbours is taken to be wrapped too: it
    /// stands on something that lifts it.
    #[must_use]
    pub fn length(&self) -> f64 {
        let count = self.spans.len();
        (0..count)
            .map(|j| {
                let (before, after) = (&self.spans[(j + count - 1) % count], &self.spans[j]);
                let ([ax, az], [bx, bz]) = (before.direction, after.direction);
                let mut turn = atan2(az * bx - ax * bz, ax * bx + az * bz);
                // At the ends the belt may turn by more than half a turn.
                if turn < -std::f64::consts::FRAC_PI_2 {
                    turn += std::f64::consts::TAU;
                }
                after.length + self.discs[j].radius * turn
            })
            .sum()
    }

    /// The closed outline of the belt's face that lies `outside` (m) of its way, as points (forward, up), m, with `arc`
    /// pieces on each wheel.
    #[must_use]
    pub fn outline(&self, outside: f64, arc: usize) -> Vec<[f64; 2]> {
        let count = self.spans.len();
        let mut points = Vec::with_capacity(count * (arc + 1));
        for (j, disc) in self.discs.iter().enumerate() {
            let (before, after) = (self.spans[(j + count - 1) % count].outward(), self.spans[j].outward());
            let from = atan2(before[1], before[0]);
            let mut turn = atan2(
                before[0] * after[1] - before[1] * after[0],
                before[0] * after[0] + before[1] * after[1],
            );
            if turn > std::f64::consts::FRAC_PI_2 {
                turn -= std::f64::consts::TAU;
            }
            for i in 0..=arc {
                let angle = from + turn * i as f64 / arc.max(1) as f64;
                let (sin, cos) = vb_math::sin_cos(angle);
                let r = disc.radius + outside;
                points.push([disc.centre[0] + r * cos, disc.centre[1] + r * sin]);
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn discs(of: &[(f64, f64, f64)]) -> Vec<Disc> {
        of.iter().map(|&(x, z, radius)| Disc { centre: [x, z], radius }).collect()
    }

    /// Open-belt formula: L = 2 √(D² − (R − r)²) + (R + r) π + 2 (R − r) asin((R − r)/D).
    #[test]
    fn a_belt_about_two_pulleys_has_the_length_of_the_open_belt() {
        for (r1, r2, d) in [(0.3, 0.3, 2.0), (0.5, 0.2, 1.5), (0.2, 0.6, 1.0)] {
            let belt = Course::around(&discs(&[(0.0, 0.0, r1), (-d, 0.0, r2)]));
            let (big, small) = (f64::max(r1, r2), f64::min(r1, r2));
            let lean = big - small;
            let expected = 2.0 * (d * d - lean * lean).sqrt()
                + (big + small) * PI
                + 2.0 * lean * vb_math::asin(lean / d);
            assert!((belt.length() - expected).abs() < 1e-12, "{} {expected}", belt.length());
            assert!(belt.spans()[0].outward()[1] < 0.0, "the first span runs below");
            assert!(belt.spans()[1].outward()[1] > 0.0, "and back above");
        }
    }

    #[test]
    fn wheels_of_one_size_on_the_corners_of_a_polygon_add_their_circumference_to_its_perimeter() {
        let belt =
            Course::around(&discs(&[(1.0, 1.0, 0.2), (0.5, 0.0, 0.2), (-1.0, 0.0, 0.2), (-2.0, 1.0, 0.2)]));
        let side = |a: (f64, f64), b: (f64, f64)| vb_math::hypot(a.0 - b.0, a.1 - b.1);
        let perimeter = side((1.0, 1.0), (0.5, 0.0))
            + side((0.5, 0.0), (-1.0, 0.0))
            + side((-1.0, 0.0), (-2.0, 1.0))
            + side((-2.0, 1.0), (1.0, 1.0));
        assert!((belt.length() - perimeter - TAU * 0.2).abs() < 1e-12);
    }

    /// Virtual work: the belt's tension T on a wheel is −T ∂L/∂centre.
    #[test]
    fn the_length_changes_with_a_wheels_place_as_its_two_spans_pull() {
        let mut belt = Course::around(&discs(&[
            (0.0, 0.0, 0.25),
            (-0.7, -0.3, 0.335),
            (-1.4, -0.25, 0.335),
            (-2.1, 0.0, 0.28),
        ]));
        for j in 0..4 {
            let before = belt.spans()[(j + 3) % 4].direction;
            let after = belt.spans()[j].direction;
            for k in 0..2 {
                let centre = belt.discs()[j].centre;
                let h = 1e-6;
                let mut at = |by: f64| {
                    let mut moved = centre;
                    moved[k] += by;
                    belt.move_to(j, moved);
                    belt.lay();
                    belt.length()
                };
                let slope = (at(h) - at(-h)) / (2.0 * h);
                at(0.0);
                assert!((slope - (before[k] - after[k])).abs() < 1e-7, "{j} {k}: {slope}");
            }
        }
    }

    #[test]
    fn the_outline_lies_outside_the_way_by_what_is_asked() {
        let belt = Course::around(&discs(&[(0.0, 0.0, 0.25), (-0.7, -0.3, 0.335), (-2.1, 0.0, 0.28)]));
        for p in belt.outline(0.03, 16) {
            let nearest = belt
                .discs()
                .iter()
                .map(|d| vb_math::hypot(p[0] - d.centre[0], p[1] - d.centre[1]) - d.radius)
                .fold(f64::INFINITY, f64::min);
            assert!((nearest - 0.03).abs() < 1e-12, "{nearest}");
        }
    }
}
