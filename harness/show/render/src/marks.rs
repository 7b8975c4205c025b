//! What is laid over the world for people: the planned path, the trail, the goal.

use crate::canvas::{Canvas, mark};
use crate::solid::{Face, turned};
use crate::{Colour, V3};
use nalgebra::UnitQuaternion;
use std::f64::consts::{FRAC_PI_2, TAU};
use vb_math::{hypot, sin_cos};
use vb_world::Heightfield;

pub(crate) const PATH: Colour = [255, 255, 255];
pub(crate) const TRAIL: Colour = [24, 68, 168];
/// Around the path, which is white: some ground is too.
const OUTLINE: Colour = [58, 62, 70];
pub(crate) const GOAL: Colour = [255, 206, 40];
pub(crate) const VEHICLE: Colour = [40, 92, 178];

/// The widths of path, trail and ring, m in a world of full size, and in pixels at least from above.
const WIDTHS: [f64; 3] = [0.18, 0.28, 0.4];
const LEAST: [f64; 3] = [1.6, 1.8, 2.2];
/// How high marks lie above the ground, m in a world of full size.
const LIFT: f64 = 0.04;

pub(crate) struct Marks<'a> {
    pub(crate) field: &'a Heightfield,
    /// A metre of the world of full size, m.
    pub(crate) unit: f64,
    /// The side of a pixel in the view from above, m.
    pub(crate) pixel: Option<f64>,
}

impl Marks<'_> {
    fn width(&self, which: usize) -> f64 {
        (WIDTHS[which] * self.unit).max(self.pixel.map_or(0.0, |p| LEAST[which] * p))
    }

    pub(crate) fn path(&self, canvas: &mut Canvas, points: &[[f64; 2]]) {
        self.band(canvas, points.iter().copied(), 1.9 * self.width(0), OUTLINE);
        self.band(canvas, points.iter().copied(), self.width(0), PATH);
    }

    pub(crate) fn trail(&self, canvas: &mut Canvas, points: &[[f64; 3]], colour: Option<Colour>) {
        self.band(canvas, points.iter().map(|p| [p[0], p[1]]), self.width(1), colour.unwrap_or(TRAIL));
    }

    pub(crate) fn ring(&self, canvas: &mut Canvas, goal: [f64; 2], radius: f64) {
        const STEPS: usize = 72;
        if radius.is_finite() && radius > 0.0 {
            let points = (0..=STEPS).map(|k| {
                let (s, c) = sin_cos(TAU * (k % STEPS) as f64 / STEPS as f64);
                [goal[0] + radius * c, goal[1] + radius * s]
            });
            self.band(canvas, points, self.width(2), GOAL);
        }
    }

    /// A band on the ground along points; those that are too near to the last one are left out.
    fn band(&self, canvas: &mut Canvas, points: impl Iterator<Item = [f64; 2]>, width: f64, colour: Colour) {
        let step = (0.5 * self.unit).max(self.pixel.unwrap_or(0.0));
        let mut line: Vec<[f64; 2]> = Vec::new();
        let mut points = points.filter(|p| p.iter().all(|v| v.is_finite())).peekable();
        while let Some(p) = points.next() {
            let Some(&[x, y]) = line.last() else {
                line.push(p);
                continue;
            };
            let apart = hypot(p[0] - x, p[1] - y);
            let last = points.peek().is_none();
            if apart >= 0.6 * step || last && apart > 0.0 {
                // Finer where the ground may bend between.
                let parts = ((apart / step).ceil() as usize).clamp(1, 4096);
                for k in 1..=parts {
                    let share = k as f64 / parts as f64;
                    line.push([x + share * (p[0] - x), y + share * (p[1] - y)]);
                }
            }
        }
        let lift = LIFT * self.unit;
        let edges: Vec<[V3; 2]> = (0..line.len())
            .map(|k| {
                let ([ax, ay], [bx, by]) = (line[k.saturating_sub(1)], line[(k + 1).min(line.len() - 1)]);
                let length = hypot(bx - ax, by - ay).max(1e-12);
                let (nx, ny) = (0.5 * width * (ay - by) / length, 0.5 * width * (bx - ax) / length);
                let [x, y] = line[k];
                let at = |x: f64, y: f64| V3::new(x, y, self.field.height(x, y) + lift);
                [at(x + nx, y + ny), at(x - nx, y - ny)]
            })
            .collect();
        let paint = mark(colour);
        for pair in edges.windows(2) {
            let [[a, b], [c, d]] = [pair[0], pair[1]];
            let (middle, reach) = (0.25 * (a + b + c + d), 0.5 * ((a - d).norm() + (b - c).norm()));
            if !canvas.camera.misses(&middle, reach) {
                canvas.lay(&[a, b, c], paint, 2.0 * self.unit);
                canvas.lay(&[b, d, c], paint, 2.0 * self.unit);
            }
        }
    }

    /// The pole at the goal with a jewel on top, which is not smaller than a few samples.
    pub(crate) fn beacon(&self, canvas: &mut Canvas, goal: [f64; 2]) {
        if !goal.iter().all(|v| v.is_finite()) {
            return;
        }
        let foot = V3::new(goal[0], goal[1], self.field.height(goal[0], goal[1]));
        let density = canvas.camera.samples_a_metre(canvas.camera.own(&foot).z);
        let jewel = (0.55 * self.unit).max(9.0 / density);
        let pole = (0.07 * self.unit).max(1.2 / density);
        let height = 4.5 * self.unit + 2.0 * jewel;
        // Bodies of revolution about y, set upright.
        let upright = UnitQuaternion::from_axis_angle(&V3::x_axis(), FRAC_PI_2);
        let shaft = turned(&[[pole, height - jewel], [pole, -self.unit]], 8, |_, _| PATH);
        let top = height - 0.75 * jewel;
        let stone =
            turned(&[[0.0, top + 1.3 * jewel], [jewel, top], [0.0, top - 1.3 * jewel]], 6, |_, _| GOAL);
        for face in shaft.iter().chain(&stone) {
            face.placed(&upright, &foot).draw_as_beacon(canvas);
        }
    }

    /// An arrow in the place of a vehicle that is too small to be seen from above.
    pub(crate) fn arrow(&self, canvas: &mut Canvas, at: &V3, heading: f64, size: f64, own: Option<Colour>) {
        let (s, c) = sin_cos(heading);
        let high = V3::new(0.0, 0.0, 0.9);
        let arrow = |grow: f64, lift: f64, colour: Colour| {
            let p = |x: f64, y: f64| {
                let (x, y) = (grow * size * x, grow * size * y);
                at + V3::new(c * x - s * y, s * x + c * y, 0.0) + high * lift
            };
            let (tip, left, right, tail) = (p(0.6, 0.0), p(-0.5, 0.4), p(-0.5, -0.4), p(-0.25, 0.0));
            [[tip, left, tail], [tip, tail, right]].map(|corners| Face { corners, colour })
        };
        for face in arrow(1.5, 0.5, [255; 3]).into_iter().chain(arrow(1.0, 1.0, own.unwrap_or(VEHICLE))) {
            face.draw_as_beacon(canvas);
        }
    }
}
