//! From samples to pixels: what the camera sees gets its colour.

use crate::camera::Lens;
use crate::canvas::{Canvas, GROUND, Seen, seen};
use crate::light::{BEYOND, FOG, HAZE, Shadow, ZENITH};
use crate::painter::Change;
use crate::texture::{Texture, shaded};
use vb_math::rng::Stream;

/// The share of its own colour that a mark on the ground has.
const OPACITY: f32 = 0.85;
/// Samples of one surface whose distances differ by more than this share belong to different parts of it.
const APART: f32 = 1.06;

/// Noise on squares that repeats itself, by which one sees the ground move by.
#[derive(Clone, Debug)]
pub(crate) struct Grain {
    /// From −1 to 1.
    values: Vec<f32>,
}

/// Squares along a side of the noise, a power of two.
const GRAINS: usize = 256;
/// The sides of the squares, m in a world of full size, and how much they change the brightness.
const FINE: (f32, f32) = (0.05, 0.09);
const COARSE: (f32, f32) = (0.4, 0.07);

impl Grain {
    pub(crate) fn new() -> Self {
        let mut stream = Stream::new(1, &["grain"]);
        Self { values: (0..GRAINS * GRAINS).map(|_| stream.uniform(-1.0, 1.0) as f32).collect() }
    }

    #[inline]
    fn square(&self, col: i32, row: i32) -> f32 {
        let mask = GRAINS as i32 - 1;
        self.values[(row & mask) as usize * GRAINS + (col & mask) as usize]
    }

    /// The noise at a point in squares, linear between their middles.
    #[inline]
    fn at(&self, x: f32, y: f32) -> f32 {
        let (fx, fy) = (x.floor(), y.floor());
        let (u, v) = (x - fx, y - fy);
        let (col, row) = (fx as i32, fy as i32);
        let south = self.square(col, row) * (1.0 - u) + self.square(col + 1, row) * u;
        let north = self.square(col, row + 1) * (1.0 - u) + self.square(col + 1, row + 1) * u;
        south * (1.0 - v) + north * v
    }
}

/// What colours depend on beside the canvas.
pub(crate) struct Look<'a> {
    pub(crate) texture: &'a Texture,
    pub(crate) grain: &'a Grain,
    /// A metre of the world of full size, m.
    pub(crate) unit: f32,
    /// The vehicle's shadow, and the square of its reach, m².
    pub(crate) shadow: &'a Shadow,
    pub(crate) reach: f32,
    pub(crate) change: Option<&'a Change<'a>>,
}

/// The direction from the eye to what a pixel shows, of depth 1, or in a view of parallel rays its place beside the eye.
type Ray = [f32; 3];

impl Look<'_> {
    /// The picture of a canvas with `per` × `per` samples a pixel, 1 or 2: red, green and blue of each pixel, row by row
    /// from the top.
    pub(crate) fn develop(&self, canvas: &Canvas, per: usize) -> Vec<u8> {
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
        let mut out = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            let v = (0.5 * height as f32 - row as f32 - 0.5) * step;
            let line = [0, 1, 2].map(|k| base[k] + v * up[k]);
            for col in 0..width {
                let u = (col as f32 + 0.5 - 0.5 * width as f32) * step;
                let ray = [0, 1, 2].map(|k| line[k] + u * right[k]);
                let place = Place { eye, ray, forward, pinhole };
                let colour = if per == 1 {
                    let k = row * width + col;
                    self.colour(canvas.paint[k], canvas.near[k], &place)
                } else {
                    let upper = 2 * (row * 2 * width + col);
                    let lower = upper + 2 * width;
                    self.smooth(canvas, [upper, upper + 1, lower, lower + 1], &place)
                };
                out.extend(colour.map(|c| (c + 0.5).clamp(0.0, 255.0) as u8));
            }
        }
        out
    }

    /// The colour of a pixel with four samples.
    #[inline]
    fn smooth(&self, canvas: &Canvas, samples: [usize; 4], place: &Place) -> [f32; 3] {
        let paint = samples.map(|k| canvas.paint[k]);
        let near = samples.map(|k| canvas.near[k]);
        let one = paint[0] == paint[1] && paint[0] == paint[2] && paint[0] == paint[3];
        let (least, most) = (
            near[0].min(near[1]).min(near[2].min(near[3])),
            near[0].max(near[1]).max(near[2].max(near[3])),
        );
        if one && (paint[0] != GROUND || !place.pinhole || most <= APART * least) {
            return self.colour(paint[0], 0.25 * (near[0] + near[1] + near[2] + near[3]), place);
        }
        let mut sum = [0.0; 3];
        for k in 0..4 {
            let colour = self.colour(paint[k], near[k], place);
            for (s, c) in sum.iter_mut().zip(colour) {
                *s += 0.25 * c;
            }
        }
        sum
    }

    /// The colour of what has this paint and nearness.
    #[inline]
    fn colour(&self, paint: u32, near: f32, place: &Place) -> [f32; 3] {
        match seen(paint) {
            Seen::Sky => place.sky(),
            Seen::Beacon(colour) => colour.map(f32::from),
            Seen::Solid(colour) => self.in_air(colour.map(f32::from), near, place),
            Seen::Ground => self.in_air(self.ground(near, place), near, place),
            Seen::Mark(colour) => {
                let ground = self.ground(near, place);
                self.in_air(mix(ground, colour.map(f32::from), OPACITY), near, place)
            }
        }
    }

    fn ground(&self, near: f32, place: &Place) -> [f32; 3] {
        let [x, y, z] = place.of(near);
        let (mut colour, soft) = self.texture.at(x, y);
        let mut light = 1.0;
        if place.pinhole {
            let far = 1.0 / (near * self.unit);
            let (fine, coarse) = (FINE.1 * (1.0 - far / 35.0), COARSE.1 * (1.0 - far / 140.0));
            let by = |side: f32| 1.0 / (side * self.unit);
            if coarse > 0.0 {
                light += coarse * self.grain.at(x * by(COARSE.0), y * by(COARSE.0));
            }
            if fine > 0.0 {
                light += fine * self.grain.at(x * by(FINE.0), y * by(FINE.0));
            }
        }
        if soft && let Some(change) = self.change.and_then(|c| c(f64::from(x), f64::from(y))) {
            light *= trodden(change as f32 / self.unit);
        }
        let c = self.shadow.centre();
        let (dx, dy) = (x - c.x as f32, y - c.y as f32);
        if dx * dx + dy * dy < self.reach {
            light *= shaded(self.shadow.at(x, y, z));
        }
        for c in &mut colour {
            *c *= light;
        }
        colour
    }

    /// What is left of a colour at a distance.
    #[inline]
    fn in_air(&self, colour: [f32; 3], near: f32, place: &Place) -> [f32; 3] {
        if !place.pinhole {
            return colour;
        }
        let [x, y, z] = place.ray;
        let (a, b) = ((x * x + y * y + z * z) / (near * near), (FOG as f32 * self.unit) * (FOG as f32 * self.unit));
        mix(colour, HAZE.map(f32::from), a / (a + b))
    }
}

/// The brightness of soil that a wheel has lowered (negative) or heaped up, m in a world of full size.
fn trodden(change: f32) -> f32 {
    // From nothing to the full effect over two centimetres.
    let some = (change.abs() / 0.02).min(1.0);
    if change < 0.0 { 1.0 - some * (0.22 + (-1.8 * change).min(0.3)) } else { 1.0 + some * 0.1 }
}

/// A pixel's line of sight.
struct Place {
    eye: [f32; 3],
    ray: Ray,
    forward: [f32; 3],
    pinhole: bool,
}

impl Place {
    /// The point of the world at this nearness.
    #[inline]
    fn of(&self, near: f32) -> [f32; 3] {
        if self.pinhole {
            let depth = 1.0 / near;
            [0, 1, 2].map(|k| self.eye[k] + depth * self.ray[k])
        } else {
            [0, 1, 2].map(|k| self.eye[k] + self.ray[k] - near * self.forward[k])
        }
    }

    fn sky(&self) -> [f32; 3] {
        if !self.pinhole {
            return BEYOND.map(f32::from);
        }
        let [x, y, z] = self.ray;
        let rise = (z / (x * x + y * y + z * z).sqrt()).max(0.0);
        mix(HAZE.map(f32::from), ZENITH.map(f32::from), (2.6 * rise).min(1.0))
    }
}

#[inline]
fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
}
