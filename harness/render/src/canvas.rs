//! The canvas: samples with the nearness of the nearest surface and what it belongs to, and how triangles get there.

use crate::camera::{Camera, Lens, Spot};
use crate::{Colour, V3};
use std::ops::Range;

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

/// The faces of a surface that are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Faces {
    /// Those that look at the camera.
    Front,
    Both,
}

/// A triangle with its place on the canvas.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    spots: [Spot; 3],
    paint: Paint,
    /// For what is laid over the ground: how much farther than the ground it may be, as a factor of its nearness and what
    /// is added to it.
    over: Option<[f32; 2]>,
}

/// What is to be drawn for a camera, in order. Its samples are computed a strip at a time, which stays in the processor's
/// cache.
pub(crate) struct Canvas {
    pub(crate) camera: Camera,
    drawn: Vec<Drawn>,
    /// The indices of what reaches into each strip.
    strips: Vec<Vec<u32>>,
    /// The number of sample rows of a strip.
    rows: usize,
}

/// Samples of some rows, row by row from the top.
pub(crate) struct Strip {
    pub(crate) near: Vec<f32>,
    pub(crate) paint: Vec<Paint>,
}

/// Samples of a strip, about.
const STRIP: usize = 40_000;

/// A run of samples in one row of a strip: the first one's index, their number, the nearness of the first, its change a
/// sample.
struct Run {
    first: usize,
    count: usize,
    near: f32,
    slope: f32,
}

impl Canvas {
    /// An empty canvas.
    pub(crate) fn new(camera: Camera) -> Self {
        let [width, height] = camera.samples;
        // An even number, since a pixel may have two rows.
        let rows = 2 * (STRIP / (2 * width)).max(1);
        let strips = vec![Vec::new(); height.div_ceil(rows)];
        Self { camera, drawn: Vec::new(), strips, rows }
    }

    /// Draws a triangle of the world, counter-clockwise as seen from the side of its face.
    pub(crate) fn face(&mut self, corners: &[V3; 3], faces: Faces, paint: Paint) {
        let own = corners.each_ref().map(|p| self.camera.own(p));
        self.face_of_own(&own, faces, paint);
    }

    /// The same for corners in the camera's own axes.
    pub(crate) fn face_of_own(&mut self, own: &[V3; 3], faces: Faces, paint: Paint) {
        Polygon::clipped(own, &self.camera).fan(|spots| self.push(spots, faces, paint, None));
    }

    /// Draws a triangle whose places on the canvas are known.
    #[inline]
    pub(crate) fn fill(&mut self, spots: [Spot; 3], faces: Faces, paint: Paint) {
        self.push(spots, faces, paint, None);
    }

    /// Lays the colour of a mark over the ground where a triangle is not hidden; one that lies a little below the ground
    /// isn't.
    pub(crate) fn lay(&mut self, corners: &[V3; 3], paint: Paint, tolerance: f64) {
        let own = corners.each_ref().map(|p| self.camera.own(p));
        // The tolerance is a length in the view from above, a share of the distance in the other.
        let over = match self.camera.lens {
            Lens::Pinhole { .. } => [1.012, 0.0],
            Lens::Parallel { .. } => [1.0, tolerance as f32],
        };
        Polygon::clipped(&own, &self.camera).fan(|spots| self.push(spots, Faces::Both, paint, Some(over)));
    }

    fn push(&mut self, spots: [Spot; 3], faces: Faces, paint: Paint, over: Option<[f32; 2]>) {
        let [a, b, c] = &spots;
        // Twice the area; negative for a triangle that is counter-clockwise to the eye, since y goes down.
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if !(area < 0.0 || faces == Faces::Both && area > 0.0) {
            return;
        }
        let [width, height] = self.camera.samples.map(|n| n as f64);
        let columns = first(a.x.min(b.x).min(c.x), width)..first(a.x.max(b.x).max(c.x), width);
        let rows = first(a.y.min(b.y).min(c.y), height)..first(a.y.max(b.y).max(c.y), height);
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let index = self.drawn.len() as u32;
        self.drawn.push(Drawn { spots, paint, over });
        for strip in &mut self.strips[rows.start / self.rows..=(rows.end - 1) / self.rows] {
            strip.push(index);
        }
    }

    /// The rows of samples of each strip.
    pub(crate) fn strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let (rows, height) = (self.rows, self.camera.samples[1]);
        (0..height).step_by(rows).map(move |k| k..(k + rows).min(height))
    }

    /// Computes the samples of one of the strips.
    pub(crate) fn expose(&self, rows: Range<usize>, strip: &mut Strip) {
        let width = self.camera.samples[0];
        let far = match self.camera.lens {
            Lens::Pinhole { .. } => 0.0,
            Lens::Parallel { .. } => f32::NEG_INFINITY,
        };
        strip.near.clear();
        strip.near.resize(width * rows.len(), far);
        strip.paint.clear();
        strip.paint.resize(width * rows.len(), SKY);
        for &k in &self.strips[rows.start / self.rows] {
            let Drawn { spots, paint, over } = &self.drawn[k as usize];
            runs(width, rows.clone(), spots, |run| {
                let here = run.first..run.first + run.count;
                let (near, paints) = (&mut strip.near[here.clone()], &mut strip.paint[here]);
                match over {
                    None => fill(&run, near, paints, *paint),
                    Some(over) => lay(&run, near, paints, *paint, *over),
                }
            });
        }
    }

    /// All samples at once.
    pub(crate) fn exposed(&mut self) -> Strip {
        let mut all = Strip { near: Vec::new(), paint: Vec::new() };
        self.rows = self.camera.samples[1].max(1);
        self.strips = vec![(0..self.drawn.len() as u32).collect()];
        self.expose(0..self.camera.samples[1], &mut all);
        all
    }
}

/// The first column or row whose middle lies at `v` or beyond it, from 0 to n.
#[inline]
fn first(v: f64, n: f64) -> usize {
    let v = (v - 0.5).max(0.0).min(n);
    let below = v as u32;
    below as usize + usize::from(f64::from(below) < v)
}

fn fill(run: &Run, near: &mut [f32], paints: &mut [Paint], paint: Paint) {
    for (i, (n, p)) in near.iter_mut().zip(paints).enumerate() {
        // Without branches, so that several samples are done at a time.
        let here = run.near + i as i32 as f32 * run.slope;
        let nearer = 0_u32.wrapping_sub(u32::from(here > *n));
        *n = if here > *n { here } else { *n };
        *p = paint & nearer | *p & !nearer;
    }
}

fn lay(run: &Run, near: &[f32], paints: &mut [Paint], paint: Paint, [share, more]: [f32; 2]) {
    for (i, (n, p)) in near.iter().zip(paints).enumerate() {
        let here = run.near + i as i32 as f32 * run.slope;
        if matches!(*p & 0xff00_0000, GROUND | MARK) && here * share + more > *n {
            *p = paint;
        }
    }
}

/// A triangle before the camera: at most four corners are left of it.
struct Polygon {
    spots: [Spot; 4],
    count: usize,
}

impl Polygon {
    /// What of a triangle, given in the camera's own axes, is far enough away to be seen.
    fn clipped(own: &[V3; 3], camera: &Camera) -> Self {
        let nearest = camera.nearest();
        let mut out = Self { spots: [Spot::default(); 4], count: 0 };
        for k in 0..3 {
            let (a, b) = (&own[k], &own[(k + 1) % 3]);
            if a.z >= nearest {
                out.push(camera.spot(a));
            }
            if (a.z >= nearest) != (b.z >= nearest) {
                out.push(camera.spot(&(a + (b - a) * ((nearest - a.z) / (b.z - a.z)))));
            }
        }
        out
    }

    fn push(&mut self, spot: Spot) {
        if self.count < 4 {
            self.spots[self.count] = spot;
            self.count += 1;
        }
    }

    fn fan(&self, mut each: impl FnMut([Spot; 3])) {
        for k in 2..self.count {
            each([self.spots[0], self.spots[k - 1], self.spots[k]]);
        }
    }
}

/// The samples of a strip whose middles lie in a triangle. Those on an edge that two triangles share belong to one of
/// them: the places of an edge are computed in the same way for both.
fn runs(width: usize, strip: Range<usize>, spots: &[Spot; 3], mut each: impl FnMut(Run)) {
    let [a, b, c] = spots;
    let inverse = 1.0 / ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
    let dx = ((b.near - a.near) * (c.y - a.y) - (c.near - a.near) * (b.y - a.y)) * inverse;
    let dy = ((c.near - a.near) * (b.x - a.x) - (b.near - a.near) * (c.x - a.x)) * inverse;
    let after = |p: &Spot, q: &Spot| p.y > q.y || p.y == q.y && p.x > q.x;
    let (mut high, mut middle, mut low) = (a, b, c);
    if after(high, middle) {
        std::mem::swap(&mut high, &mut middle);
    }
    if after(middle, low) {
        std::mem::swap(&mut middle, &mut low);
    }
    if after(high, middle) {
        std::mem::swap(&mut high, &mut middle);
    }
    let slope = |p: &Spot, q: &Spot| (q.x - p.x) / (q.y - p.y);
    let (long, upper, lower) = (slope(high, low), slope(high, middle), slope(middle, low));
    let at = |p: &Spot, slope: f64, y: f64| p.x + (y - p.y) * slope;
    let end = strip.end as f64;
    for row in first(high.y, end).max(strip.start)..first(low.y, end) {
        let y = row as f64 + 0.5;
        let one = at(high, long, y);
        let other = if y < middle.y { at(high, upper, y) } else { at(middle, lower, y) };
        let (from, to) = (first(one.min(other), width as f64), first(one.max(other), width as f64));
        if from < to {
            let near = a.near + (from as f64 + 0.5 - a.x) * dx + (y - a.y) * dy;
            each(Run {
                first: (row - strip.start) * width + from,
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
            runs(10, 0..10, &spots, |run| {
                for k in run.first..run.first + run.count {
                    covered[k] += 1;
                }
            });
            canvas.face(&t, Faces::Front, solid([1, 2, 3]));
        }
        let samples = canvas.exposed();
        for (k, count) in covered.into_iter().enumerate() {
            // x from 2.5 to 6.5 (7.5 is on the right edge), y from 1.5 to 3.5: rows 6 to 8 from the top.
            let (row, col) = (k / 10, k % 10);
            let inside = (2..7).contains(&col) && (6..9).contains(&row);
            assert_eq!(count, u32::from(inside), "{row} {col}");
            assert_eq!(seen(samples.paint[k]), if inside { Seen::Solid([1, 2, 3]) } else { Seen::Sky });
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
            let canvas = canvas.exposed();
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
        assert!(canvas.exposed().paint.iter().all(|&p| p == SKY));
    }

    #[test]
    fn a_triangle_that_passes_the_camera_is_cut_before_it() {
        // A floor 1 m below an eye that looks north, from behind the eye to far ahead.
        let camera = Camera::looking(V3::zeros(), V3::y(), std::f64::consts::FRAC_PI_2, 0.5, [100, 100]);
        let mut canvas = Canvas::new(camera);
        for t in square([-1000.0, -10.0], [1000.0, 1e6], -1.0) {
            canvas.face(&t, Faces::Front, solid([7; 3]));
        }
        let canvas = canvas.exposed();
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
        let canvas = canvas.exposed();
        let row: Vec<Seen> = (0..10).map(|k| seen(canvas.paint[5 * 10 + k])).collect();
        let (m, s) = (Seen::Mark([2; 3]), Seen::Solid([1; 3]));
        assert_eq!(row, [m, m, m, s, s, s, m, m, Seen::Sky, Seen::Sky]);
    }

    #[test]
    fn strips_together_have_the_samples_of_the_whole() {
        // Two strips of 40 rows and one of 21.
        let camera = Camera::looking(V3::zeros(), V3::y(), 1.0, 0.1, [1000, 101]);
        let mut canvas = Canvas::new(camera);
        for k in 0..40_u8 {
            let x = f64::from(k) - 20.0;
            let corners = [V3::new(x, 9.0, -3.0), V3::new(x + 5.0, 11.0, -1.0), V3::new(x + 1.0, 10.0, 4.0)];
            canvas.face(&corners, Faces::Both, solid([k; 3]));
        }
        let (mut near, mut paint) = (Vec::new(), Vec::new());
        let mut strip = Strip { near: Vec::new(), paint: Vec::new() };
        let rows: Vec<_> = canvas.strips().collect();
        assert_eq!(rows, [0..40, 40..80, 80..101]);
        for rows in rows {
            canvas.expose(rows, &mut strip);
            near.extend_from_slice(&strip.near);
            paint.extend_from_slice(&strip.paint);
        }
        let whole = canvas.exposed();
        assert!(whole.near == near && whole.paint == paint);
        assert!(paint.iter().any(|p| *p != SKY));
    }
}
