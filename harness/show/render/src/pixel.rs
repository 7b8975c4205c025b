//! The colour of a single pixel: ground with its noise, shadow, ruts and marks, surfaces in air, and the sky.

use crate::canvas::{GROUND, Seen, Strip, seen};
use crate::light::{BEYOND, HAZE, SKY_RISE, Shadow, ZENITH};
use crate::texture::{Texture, shaded, whole};
use vb_math::rng::Stream;

/// The share of its own colour that a mark on the ground has.
pub(crate) const OPACITY: f32 = 0.85;
/// Samples of one surface whose distances differ by more than this share belong to different parts of it.
pub(crate) const APART: f32 = 1.06;

/// Noise on squares that repeats itself, by which one sees the ground move by. There is one for the finest squares, and
/// one for each of the sides that are twice as long, with the means of the former.
#[derive(Clone, Debug)]
pub(crate) struct Grain {
    /// Row by row, 128 for no change of the brightness.
    levels: Vec<Vec<u8>>,
}

/// Squares along a side of the finest noise, a power of two; the side of one, m in a world of full size.
const GRAINS: usize = 512;
pub(crate) const FINE: f32 = 0.05;
const LEVELS: usize = 5;
/// Squares of coarser noise are so many times as long.
const COARSE: usize = 8;
/// The greatest change of the brightness by all noise together.
pub(crate) const ROUGHNESS: f32 = 0.16;
/// The distance beyond which the ground is smooth, m in a world of full size.
pub(crate) const SMOOTH: f32 = 90.0;

impl Grain {
    pub(crate) fn new() -> Self {
        let mut stream = Stream::new(1, &["grain"]);
        let wide = GRAINS / COARSE;
        let coarse: Vec<f64> = (0..wide * wide).map(|_| stream.uniform(-1.0, 1.0)).collect();
        let mut level: Vec<f64> = (0..GRAINS * GRAINS)
            .map(|k| {
                // The coarse noise, linear between the corners of its squares.
                let at = |k: usize| (k / COARSE, (k % COARSE) as f64 / COARSE as f64);
                let ((row, v), (col, u)) = (at(k / GRAINS), at(k % GRAINS));
                let corner = |i: usize, j: usize| coarse[(row + i) % wide * wide + (col + j) % wide];
                let south = corner(0, 0) * (1.0 - u) + corner(0, 1) * u;
                let north = corner(1, 0) * (1.0 - u) + corner(1, 1) * u;
                0.5 * stream.uniform(-1.0, 1.0) + 0.5 * (south * (1.0 - v) + north * v)
            })
            .collect();
        let mut levels = Vec::with_capacity(LEVELS);
        for k in 0..LEVELS {
            levels.push(level.iter().map(|v| (128.0 + 127.0 * v).round() as u8).collect());
            let n = GRAINS >> k;
            level = (0..n * n / 4)
                .map(|i| {
                    let first = 2 * (i / (n / 2)) * n + 2 * (i % (n / 2));
                    0.25 * (level[first] + level[first + 1] + level[first + n] + level[first + n + 1])
                })
                .collect();
        }
        Self { levels }
    }

    /// The values of the level at which a pixel covers so many finest squares, the level's number, and the logarithm to base 2 of the
    /// number of its squares along a side.
    #[inline]
    pub(crate) fn level(&self, covered: f32) -> (&[u8], u32, u32) {
        // The exponent of two, from the number's own bits.
        let level = ((covered.max(1.0).to_bits() >> 23) - 127).min(LEVELS as u32 - 1);
        (&self.levels[level as usize], level, GRAINS.trailing_zeros() - level)
    }

    /// The change of the brightness at a place in 256ths of finest squares, where a pixel covers so many squares: linear
    /// between the squares' middles.
    #[inline]
    fn at(&self, x: f32, y: f32, covered: f32) -> f32 {
        let (values, level, shift) = self.level(covered);
        let (x, y) = (whole(x) >> level, whole(y) >> level);
        let (u, v) = (x & 255, y & 255);
        let mask = (1 << shift) - 1;
        let (left, right) = (x >> 8 & mask, ((x >> 8) + 1) & mask);
        let (lower, upper) = ((y >> 8 & mask) << shift, (((y >> 8) + 1) & mask) << shift);
        let value = |k: u32| u32::from(values[k as usize]);
        let south = value(lower | left) * (256 - u) + value(lower | right) * u;
        let north = value(upper | left) * (256 - u) + value(upper | right) * u;
        let sum = south * (256 - v) + north * v;
        sum as i32 as f32 * (1.0 / (127.0 * 65536.0)) - 128.0 / 127.0
    }
}

/// Change of the ground's height at (x, y) since the start, m: negative in a rut, positive on a heap, `None` where the ground is
/// undisturbed (`Simulation::soil_change`).
pub type Change<'a> = dyn Fn(f64, f64) -> Option<f64> + 'a;

/// Inputs of colours in addition to the canvas.
pub(crate) struct Look<'a> {
    pub(crate) texture: &'a Texture,
    pub(crate) grain: &'a Grain,
    /// A metre of the world of full size, m.
    pub(crate) unit: f32,
    pub(crate) shadow: &'a Shadow,
    pub(crate) change: Option<&'a Change<'a>>,
}

/// The same with what is the same for all pixels.
pub(crate) struct Developer<'a> {
    pub(crate) look: &'a Look<'a>,
    /// 256ths of finest squares of noise a metre, finest squares that a pixel covers at a distance of 1 m, one over the distance at
    /// which noise ends, all for metres of the world as it is.
    pub(crate) fine: f32,
    pub(crate) footprint: f32,
    pub(crate) smooth: f32,
    /// The square of the distance at which half of what is seen is air, m².
    pub(crate) fog: f32,
}

/// The direction from the eye to what a pixel shows, of depth 1, or in a view of parallel rays its place beside the eye.
pub(crate) type Ray = [f32; 3];

impl Developer<'_> {
    /// The colour of a pixel with four samples.
    #[inline]
    pub(crate) fn average(&self, strip: &Strip, samples: [usize; 4], place: &Place) -> [f32; 3] {
        let paint = samples.map(|k| strip.paint[k]);
        let near = samples.map(|k| strip.near[k]);
        let one = paint[0] == paint[1] && paint[0] == paint[2] && paint[0] == paint[3];
        let (least, most) =
            (near[0].min(near[1]).min(near[2].min(near[3])), near[0].max(near[1]).max(near[2].max(near[3])));
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
    pub(crate) fn colour(&self, paint: u32, near: f32, place: &Place) -> [f32; 3] {
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
        let (mut colour, soft) = self.look.texture.at(x, y);
        let mut light = 1.0;
        if place.pinhole {
            let far = 1.0 / near;
            let fade = 1.0 - far * self.smooth;
            if fade > 0.0 {
                light +=
                    ROUGHNESS * fade * self.look.grain.at(x * self.fine, y * self.fine, far * self.footprint);
            }
        }
        if soft && let Some(change) = self.look.change.and_then(|c| c(f64::from(x), f64::from(y))) {
            light *= trodden(change as f32 / self.look.unit);
        }
        let covered = self.look.shadow.at([x, y, z]);
        if covered > 0.0 {
            light *= shaded(covered);
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
        // The square of the distance over that and the fog's.
        let a = x * x + y * y + z * z;
        mix(colour, HAZE.map(f32::from), a / (a + self.fog * near * near))
    }
}

/// The brightness of soil that a wheel has lowered (negative) or heaped up, m in a world of full size.
pub(crate) fn trodden(change: f32) -> f32 {
    // From nothing to the full effect over two centimetres.
    let some = (change.abs() / 0.02).min(1.0);
    if change < 0.0 { 1.0 - some * (0.22 + (-1.8 * change).min(0.3)) } else { 1.0 + some * 0.1 }
}

/// A pixel's line of sight.
pub(crate) struct Place {
    pub(crate) eye: [f32; 3],
    pub(crate) ray: Ray,
    pub(crate) forward: [f32; 3],
    pub(crate) pinhole: bool,
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
        mix(HAZE.map(f32::from), ZENITH.map(f32::from), (SKY_RISE * rise).min(1.0))
    }
}

#[inline]
fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
}
