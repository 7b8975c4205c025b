//! From samples to pixels: what the camera sees gets its colour.

use crate::camera::Lens;
use crate::canvas::{Canvas, Strip};
use crate::eight::{EIGHT, Samples, is_sky};
use crate::light::FOG;
use crate::pixel::{Developer, FINE, Look, Place, SMOOTH};
use crate::texture::whole;

impl Look<'_> {
    /// The picture of a canvas with `per` × `per` samples a pixel, 1 or 2: red, green and blue of each pixel, row by row
    /// from the top. Ground is coloured eight pixels at a time, or each pixel by itself, which is the same but for rounding.
    pub(crate) fn develop(&self, canvas: &Canvas, per: usize, together: bool) -> Vec<u8> {
        let camera = &canvas.camera;
        let [width, height] = camera.samples.map(|n| n / per);
        let (scale, pinhole) = match camera.lens {
            Lens::Pinhole { focal, .. } => (focal / per as f64, true),
            Lens::Parallel { scale } => (scale / per as f64, false),
        };
        let narrow = |v: &crate::V3| [v.x as f32, v.y as f32, v.z as f32];
        let (right, up, forward) = (narrow(&camera.right), narrow(&camera.up), narrow(&camera.forward));
        let eye = narrow(&camera.eye);
        let base = if pinhole { forward } else { [0.0; 3] };
        let step = (1.0 / scale) as f32;
        let fine = 1.0 / (FINE * self.unit);
        let developer = Developer {
            look: self,
            fine: 256.0 * fine,
            footprint: fine * step,
            smooth: 1.0 / (SMOOTH * self.unit),
            fog: (FOG as f32 * self.unit) * (FOG as f32 * self.unit),
        };
        let next = right.map(|r| step * r);
        let mut out = vec![0; 3 * width * height];
        let mut strip = Strip { near: Vec::new(), paint: Vec::new() };
        let mut lines = out.chunks_exact_mut(3 * width).enumerate();
        for rows in canvas.strips() {
            canvas.expose(rows.clone(), &mut strip);
            for (row, line_out) in lines.by_ref().take(rows.len() / per) {
                let first_row = row * per - rows.start;
                let v = (0.5 * height as f32 - row as f32 - 0.5) * step;
                let line = [0, 1, 2].map(|k| base[k] + v * up[k]);
                // The column in pixels, whole numbers at their left edges.
                let place_at = |across: f32| {
                    let u = (across - 0.5 * width as f32) * step;
                    Place { eye, ray: [0, 1, 2].map(|k| line[k] + u * right[k]), forward, pinhole }
                };
                let place = |col: usize| place_at(col as f32 + 0.5);
                let single = |col: usize, pixel: &mut [u8]| {
                    let place = place(col);
                    let first = (first_row * width + col) * per;
                    let colour = if per == 1 {
                        developer.colour(strip.paint[first], strip.near[first], &place)
                    } else {
                        let below = first + 2 * width;
                        developer.average(&strip, [first, first + 1, below, below + 1], &place)
                    };
                    for (p, c) in pixel.iter_mut().zip(colour) {
                        *p = whole(c.min(255.0)) as u8;
                    }
                };
                let together = together && per == 2;
                let mut col = 0;
                while col < width {
                    let upper = 2 * (first_row * width + col);
                    let rest = &mut line_out[3 * col..];
                    if let Some(pixels) = rest.first_chunk_mut::<{ 6 * EIGHT }>()
                        && together
                        && pinhole
                        && col % (2 * EIGHT) == 0
                        && let Some(samples) = Samples::of_pairs(&strip, upper, upper + 2 * width)
                    {
                        let across = place_at(col as f32 + 1.0);
                        developer.pairs(&samples, &across, next.map(|n| 2.0 * n), pixels);
                        col += 2 * EIGHT;
                        continue;
                    }
                    let count = (width - col).min(EIGHT);
                    let whole_group = together && count == EIGHT;
                    if whole_group && pinhole && is_sky(&strip, upper, upper + 2 * width) {
                        let colours = place(col).sky_of_eight(next);
                        for (k, pixel) in rest.chunks_exact_mut(3).take(EIGHT).enumerate() {
                            for (p, c) in pixel.iter_mut().zip(&colours) {
                                *p = whole(c[k]) as u8;
                            }
                        }
                        col += EIGHT;
                        continue;
                    }
                    let samples =
                        whole_group.then(|| Samples::of(&strip, upper, upper + 2 * width, pinhole)).flatten();
                    let colours = samples.as_ref().map(|s| developer.eight(s, &place(col), next, 1.0));
                    for (k, pixel) in rest.chunks_exact_mut(3).take(count).enumerate() {
                        match (&samples, &colours) {
                            (Some(samples), Some(colours)) if samples.is_ground(k) => {
                                for (p, c) in pixel.iter_mut().zip(colours) {
                                    *p = whole(c[k]) as u8;
                                }
                            }
                            _ => single(col + k, pixel),
                        }
                    }
                    col += count;
                }
            }
        }
        out
    }
}
