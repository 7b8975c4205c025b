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

pub(crate) fn solid(colour: Colour) -> Paint {
    SOLID | rgb(colour)
}

pub(crate) fn beacon(colour: Colour) -> Paint {
    BEACON | rgb(colour)
}

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
pub(crate) struct Drawn {
    spots: [Spot; 3],
    paint: Paint,
    /// For what is laid over the ground: how much farther than the ground it may be, as a factor of its nearness and what
    /// is added to it.
    over: Option<[f32; 2]>,
}

/// The triangles of a picture. They take megabytes, which one picture after another uses.
pub(crate) type Triangles = Vec<Drawn>;

/// What is to be drawn for a camera, in order. Its samples are computed a strip at a time, which stays in the processor's
/// cache.
pub(crate) struct Canvas {
    pub(crate) camera: Camera,
    drawn: Triangles,
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
    pub(crate) fn new(camera: Camera) -> Self {
        Self::reusing(Triangles::new(), camera)
    }

    /// An empty canvas in the memory of another.
    pub(crate) fn reusing(mut drawn: Triangles, camera: Camera) -> Self {
        drawn.clear();
        let [width, height] = camera.samples;
        // An even number, since a pixel may have two rows.
        let rows = 2 * (STRIP / (2 * width)).max(1);
        let strips = vec![Vec::new(); height.div_ceil(rows)];
        Self { camera, drawn, strips, rows }
    }

    /// The memory, for another canvas.
    pub(crate) fn into_triangles(self) -> Triangles {
        self.drawn
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

    /// The number of triangles that are to be drawn.
    #[cfg(test)]
    pub(crate) fn count(&self) -> usize {
        self.drawn.len()
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
mod tests;
