//! The canvas: samples with the nearness of the nearest surface and what it belongs to, and how triangles get there.

use crate::camera::{Camera, Lens, Spot};
use crate::{Colour, V3};

/// What a sample shows: its kind in the highest byte, a colour below it.
pub(crate) type Paint = u32;

/// Nothing but sky.
pub(crate) const SKY: Paint = 0;
/// The ground, coloured by its place.
pub(crate) const GROUND: Paint = 1 << 24;
/// A surface of one colour, which is lit already.
const SOLID: Paint = 2 << 24;
/// A surface that is as bright in the distance as nearby.
const BEACON: Paint = 3 << 24;
/// The ground with a colour laid over it.
const MARK: Paint = 4 << 24;

fn rgb(colour: Colour) -> Paint {
    u32::from(colour[0]) << 16 | u32::from(colour[1]) << 8 | u32::from(colour[2])
}

/// The paint of a solid's face.
pub(crate) fn solid(colour: Colour) -> Paint {
    SOLID | rgb(colour)
}

/// The paint of a beacon.
pub(crate) fn beacon(colour: Colour) -> Paint {
    BEACON | rgb(colour)
}

/// The paint of a mark on the ground.
pub(crate) fn mark(colour: Colour) -> Paint {
    MARK | rgb(colour)
}

/// What a paint stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Seen {
    Sky,
    Ground,
    Solid(Colour),
    Beacon(Colour),
    Mark(Colour),
}

/// Tells what a paint stands for.
#[inline]
pub(crate) fn seen(paint: Paint) -> Seen {
    let colour = [(paint >> 16) as u8, (paint >> 8) as u8, paint as u8];
    match paint & 0xff00_0000 {
        SKY => Seen::Sky,
        GROUND => Seen::Ground,
        SOLID => Seen::Solid(colour),
        BEACON => Seen::Beacon(colour),
        _ => Seen::Mark(colour),
    }
}

/// Samples of a picture, row by row from the top.
pub(crate) struct Canvas {
    pub(crate) camera: Camera,
    pub(crate) near: Vec<f32>,
    pub(crate) paint: Vec<Paint>,
}

/// The faces of a surface that are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Faces {
    /// Those that look at the camera.
    Front,
    Both,
}

/// A run of samples in one row: the first one's index, their number, the nearness of the first, its change a sample.
struct Run {
    first: usize,
    count: usize,
    near: f32,
    slope: f32,
}

impl Canvas {
    /// An empty canvas.
    pub(crate) fn new(camera: Camera) -> Self {
        let count = camera.samples[0] * camera.samples[1];
        let far = match camera.lens {
            Lens::Pinhole { .. } => 0.0,
            Lens::Parallel { .. } => f32::NEG_INFINITY,
        };
        Self { camera, near: vec![far; count], paint: vec![SKY; count] }
    }

    /// Draws a triangle of the world, counter-clockwise as seen from the side of its face.
    pub(crate) fn face(&mut self, corners: &[V3; 3], faces: Faces, paint: Paint) {
        let own = corners.each_ref().map(|p| self.camera.own(p));
        self.face_of_own(&own, faces, paint);
    }

    /// The same for corners in the camera's own axes.
    pub(crate) fn face_of_own(&mut self, own: &[V3; 3], faces: Faces, paint: Paint) {
        let mut polygon = Polygon::clipped(own, self.camera.nearest());
        polygon.project(&self.camera);
        polygon.fan(|spots| self.fill(spots, faces, paint));
    }

    /// Draws a triangle whose places on the canvas are known.
    pub(crate) fn fill(&mut self, spots: &[Spot; 3], faces: Faces, paint: Paint) {
        let (near, paints) = (&mut self.near, &mut self.paint);
        runs(self.camera.samples, spots, faces, |run| {
            let near = &mut near[run.first..run.first + run.count];
            let paints = &mut paints[run.first..run.first + run.count];
            for (i, (n, p)) in near.iter_mut().zip(paints).enumerate() {
                let here = run.near + i as i32 as f32 * run.slope;
                let nearer = here > *n;
                *n = if nearer { here } else { *n };
                *p = if nearer { paint } else { *p };
            }
        });
    }

    /// Lays the colour of a mark over the ground where a triangle is not hidden; one that lies a little below the ground
    /// isn't.
    pub(crate) fn lay(&mut self, corners: &[V3; 3], paint: Paint, tolerance: f64) {
        let own = corners.each_ref().map(|p| self.camera.own(p));
        let mut polygon = Polygon::clipped(&own, self.camera.nearest());
        polygon.project(&self.camera);
        // The tolerance is a length in the view from above, a share of the distance in the other.
        let (share, more) = match self.camera.lens {
            Lens::Pinhole { .. } => (1.012, 0.0),
            Lens::Parallel { .. } => (1.0, tolerance as f32),
        };
        let (near, paints) = (&self.near, &mut self.paint);
        polygon.fan(|spots| {
            runs(self.camera.samples, spots, Faces::Both, |run| {
                for i in 0..run.count {
                    let here = run.near + i as i32 as f32 * run.slope;
                    let k = run.first + i;
                    let on_ground = matches!(paints[k] & 0xff00_0000, GROUND | MARK);
                    if on_ground && here * share + more > near[k] {
                        paints[k] = paint;
                    }
                }
            });
        });
    }
}

/// A triangle before the camera: at most four corners are left of it.
struct Polygon {
    own: [V3; 4],
    spots: [Spot; 4],
    count: usize,
}

impl Polygon {
    /// What of a triangle is at least `nearest` away.
    fn clipped(own: &[V3; 3], nearest: f64) -> Self {
        let mut out = Self { own: [V3::zeros(); 4], spots: [Spot::default(); 4], count: 0 };
        for k in 0..3 {
            let (a, b) = (&own[k], &own[(k + 1) % 3]);
            if a.z >= nearest {
                out.push(*a);
            }
            if (a.z >= nearest) != (b.z >= nearest) {
                out.push(a + (b - a) * ((nearest - a.z) / (b.z - a.z)));
            }
        }
        out
    }

    fn push(&mut self, p: V3) {
        if self.count < 4 {
            self.own[self.count] = p;
            self.count += 1;
        }
    }

    fn project(&mut self, camera: &Camera) {
        for (spot, own) in self.spots.iter_mut().zip(&self.own).take(self.count) {
            *spot = camera.spot(own);
        }
    }

    fn fan(&self, mut each: impl FnMut(&[Spot; 3])) {
        for k in 2..self.count {
            each(&[self.spots[0], self.spots[k - 1], self.spots[k]]);
        }
    }
}

/// The samples whose middles lie in a triangle. Those on an edge that two triangles share belong to one of them: the
/// places of an edge are computed in the same way for both.
fn runs(samples: [usize; 2], spots: &[Spot; 3], faces: Faces, mut each: impl FnMut(Run)) {
    let [a, b, c] = spots;
    // Twice the area; negative for a triangle that is counter-clockwise to the eye, since y goes down.
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if !(area < 0.0 || faces == Faces::Both && area > 0.0) {
        return;
    }
    let (width, height) = (samples[0] as f64, samples[1] as f64);
    let (left, right) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
    let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
    // Rows and columns whose middles can lie inside.
    let first = |v: f64, n: f64| (v - 0.5).ceil().clamp(0.0, n) as usize;
    let rows = first(top, height)..first(bottom, height);
    if rows.is_empty() || first(left, width) >= first(right, width) {
        return;
    }
    let dx = ((b.near - a.near) * (c.y - a.y) - (c.near - a.near) * (b.y - a.y)) / area;
    let dy = ((c.near - a.near) * (b.x - a.x) - (b.near - a.near) * (c.x - a.x)) / area;
    let mut sorted = [a, b, c];
    sorted.sort_by(|p, q| p.y.total_cmp(&q.y).then(p.x.total_cmp(&q.x)));
    let [high, middle, low] = sorted;
    let slope = |p: &Spot, q: &Spot| (q.x - p.x) / (q.y - p.y);
    let (long, upper, lower) = (slope(high, low), slope(high, middle), slope(middle, low));
    let at = |p: &Spot, slope: f64, y: f64| p.x + (y - p.y) * slope;
    for row in rows {
        let y = row as f64 + 0.5;
        let one = at(high, long, y);
        let other = if y < middle.y { at(high, upper, y) } else { at(middle, lower, y) };
        let (from, to) = (first(one.min(other), width), first(one.max(other), width));
        if from < to {
            let near = a.near + (from as f64 + 0.5 - a.x) * dx + (y - a.y) * dy;
            each(Run {
                first: row * samples[0] + from,
                count: to - from,
                near: near as f32,
                slope: dx as f32,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn canvas() -> Canvas {
        // One sample a metre, 10 × 10 of them; z = 0 is 5 m below the eye.
        Canvas::new(Camera::above(V3::new(5.0, 5.0, 5.0), 1.0, [10, 10]))
    }

    fn square(low: [f64; 2], high: [f64; 2], z: f64) -> [[V3; 3]; 2] {
        let p = |x: f64, y: f64| V3::new(x, y, z);
        let [a, b] = [p(low[0], low[1]), p(high[0], low[1])];
        let [c, d] = [p(high[0], high[1]), p(low[0], high[1])];
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn a_square_covers_the_samples_whose_middles_are_in_it_and_each_once() {
        let mut canvas = canvas();
        let mut covered = [0; 100];
        for t in square([2.2, 1.0], [7.5, 4.0], 0.0) {
            let own = t.map(|p| canvas.camera.own(&p));
            let spots = own.map(|p| canvas.camera.spot(&p));
            runs([10, 10], &spots, Faces::Front, |run| {
                for k in run.first..run.first + run.count {
                    covered[k] += 1;
                }
            });
            canvas.face(&t, Faces::Front, solid([1, 2, 3]));
        }
        for (k, count) in covered.into_iter().enumerate() {
            // x from 2.5 to 6.5 (7.5 is on the right edge), y from 1.5 to 3.5: rows 6 to 8 from the top.
            let (row, col) = (k / 10, k % 10);
            let inside = (2..7).contains(&col) && (6..9).contains(&row);
            assert_eq!(count, u32::from(inside), "{row} {col}");
            assert_eq!(seen(canvas.paint[k]), if inside { Seen::Solid([1, 2, 3]) } else { Seen::Sky });
        }
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind_it_in_whatever_order_they_come() {
        let (low, high) = (square([0.0, 0.0], [10.0, 10.0], 0.0), square([3.0, 3.0], [6.0, 6.0], 1.0));
        for order in [[0, 1], [1, 0]] {
            let mut canvas = canvas();
            for which in order {
                for t in [&low, &high][which] {
                    canvas.face(t, Faces::Front, solid([which as u8; 3]));
                }
            }
            assert_eq!(seen(canvas.paint[5 * 10 + 4]), Seen::Solid([1; 3]));
            assert_eq!(seen(canvas.paint[5 * 10 + 8]), Seen::Solid([0; 3]));
            assert!((canvas.near[5 * 10 + 4] + 4.0).abs() < 1e-5, "4 m below the eye");
        }
    }

    #[test]
    fn faces_that_look_away_are_not_drawn() {
        let mut canvas = canvas();
        for [a, b, c] in square([0.0, 0.0], [10.0, 10.0], 0.0) {
            canvas.face(&[a, c, b], Faces::Front, solid([9; 3]));
        }
        assert!(canvas.paint.iter().all(|&p| p == SKY));
    }

    #[test]
    fn a_triangle_that_passes_the_camera_is_cut_before_it() {
        // A floor 1 m below an eye that looks north, from behind the eye to far ahead.
        let camera = Camera::looking(V3::zeros(), V3::y(), std::f64::consts::FRAC_PI_2, 0.5, [100, 100]);
        let mut canvas = Canvas::new(camera);
        for t in square([-1000.0, -10.0], [1000.0, 1e6], -1.0) {
            canvas.face(&t, Faces::Front, solid([7; 3]));
        }
        for row in 0..100 {
            let expected = if row >= 50 { Seen::Solid([7; 3]) } else { Seen::Sky };
            assert_eq!(seen(canvas.paint[row * 100 + 50]), expected, "{row}");
        }
        // 25 samples below the horizon with a focal length of 50: the floor is 2 m away there.
        let near = canvas.near[74 * 100 + 50];
        assert!((1.0 / near - 50.0 / 24.5).abs() < 1e-4, "{near}");
    }

    #[test]
    fn marks_lie_on_ground_alone_and_only_where_it_is_not_hidden() {
        let mut canvas = canvas();
        for t in square([0.0, 0.0], [8.0, 10.0], 0.0) {
            canvas.face(&t, Faces::Front, GROUND);
        }
        for t in square([3.0, 0.0], [6.0, 10.0], 1.0) {
            canvas.face(&t, Faces::Front, solid([1; 3]));
        }
        for t in square([0.0, 4.0], [10.0, 5.0], 0.01) {
            canvas.lay(&t, mark([2; 3]), 0.1);
        }
        let row: Vec<Seen> = (0..10).map(|k| seen(canvas.paint[5 * 10 + k])).collect();
        let (m, s) = (Seen::Mark([2; 3]), Seen::Solid([1; 3]));
        assert_eq!(row, [m, m, m, s, s, s, m, m, Seen::Sky, Seen::Sky]);
    }
}
