//! Ground of eight pixels beside each other, whose colours are computed together: nearly all of a picture is ground, and most of a
//! picture's time is that of its colours.
//!
//! The arithmetic is that of single pixels but for rounding: shares of texels and squares are not cut to 256ths here. Where connected ground
//! fills sixteen pixels in a view from the vehicle, whose texels and squares of noise are larger than a pixel nearby, every second place is
//! looked up, and the colours between follow from their neighbours.

use wide::{f32x8, u32x8};

use crate::canvas::{GROUND, SKY, Seen, Strip, seen};
use crate::light::{HAZE, SKY_RISE, Shadow, ZENITH};
use crate::pixel::{APART, Developer, Grain, OPACITY, Place, ROUGHNESS, trodden};
use crate::texture::{Texture, shaded};

pub(crate) const EIGHT: usize = 8;

/// A number for each of the pixels.
pub(crate) type Each = f32x8;

/// Their places beside the first.
const COUNT: Each = Each::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);

/// What the samples of eight pixels show.
pub(crate) struct Samples {
    near: Each,
    /// The colours of marks, and how much of them is seen: nothing where there is no mark.
    marks: [[f32; EIGHT]; 3],
    opacity: [f32; EIGHT],
    marked: bool,
    /// The pixels that show ground alone; the others must be drawn one by one.
    ground: [bool; EIGHT],
}

impl Samples {
    /// The samples of eight pixels with four samples each, of which `upper` and `lower` are the first ones of both rows. None if too few
    /// of the pixels show ground alone.
    #[inline]
    pub(crate) fn of(strip: &Strip, upper: usize, lower: usize, pinhole: bool) -> Option<Self> {
        const ROW: usize = 2 * EIGHT;
        let (a, b) = (&strip.paint[upper..upper + ROW], &strip.paint[lower..lower + ROW]);
        let (p, q) = (&strip.near[upper..upper + ROW], &strip.near[lower..lower + ROW]);
        let differ = a.iter().chain(b).fold(0, |all, paint| all | (paint ^ GROUND));
        let (mut ground, mut marked) = ([true; EIGHT], false);
        let (mut marks, mut opacity) = ([[0.0; EIGHT]; 3], [0.0; EIGHT]);
        if differ != 0 {
            for k in 0..EIGHT {
                let own = a[2 * k];
                ground[k] = own == a[2 * k + 1] && own == b[2 * k] && own == b[2 * k + 1];
                match seen(own) {
                    Seen::Ground => {}
                    Seen::Mark(colour) => {
                        marked = true;
                        opacity[k] = OPACITY;
                        for (mark, c) in marks.iter_mut().zip(colour) {
                            mark[k] = f32::from(c);
                        }
                    }
                    _ => ground[k] = false,
                }
            }
        }
        let every = |row: &[f32], from: usize| -> Each {
            let row: &[f32; ROW] = row.try_into().unwrap_or(&[0.0; ROW]);
            Each::new(std::array::from_fn(|k| row[2 * k + from]))
        };
        let four = [every(p, 0), every(p, 1), every(q, 0), every(q, 1)];
        let mean = (four[0] + four[1] + four[2] + four[3]) * Each::splat(0.25);
        if pinhole {
            let least = four[0].fast_min(four[1]).fast_min(four[2].fast_min(four[3])).to_array();
            let most = four[0].fast_max(four[1]).fast_max(four[2].fast_max(four[3])).to_array();
            for k in 0..EIGHT {
                // Marks lie on one surface with the ground below them, as single pixels have it.
                ground[k] &= opacity[k] > 0.0 || most[k] <= APART * least[k];
            }
        }
        if ground.iter().filter(|g| **g).count() < EIGHT / 2 {
            return None;
        }
        let mut near = mean.to_array();
        // A place on the ground for those that have none, whose colours nobody uses.
        let some = ground.iter().position(|g| *g).map_or(1.0, |k| near[k]);
        for (near, ground) in near.iter_mut().zip(ground) {
            if !ground {
                *near = some;
            }
        }
        Some(Self { near: Each::new(near), marks, opacity, marked, ground })
    }

    /// The samples of eight pairs of pixels in a view from the vehicle, of which `upper` and `lower` are the first ones of both rows. None
    /// unless all of them show nothing but connected ground.
    #[inline]
    pub(crate) fn of_pairs(strip: &Strip, upper: usize, lower: usize) -> Option<Self> {
        const ROW: usize = 4 * EIGHT;
        let (a, b) = (&strip.paint[upper..upper + ROW], &strip.paint[lower..lower + ROW]);
        if a.iter().chain(b).fold(0, |all, paint| all | (paint ^ GROUND)) != 0 {
            return None;
        }
        let (p, q) = (&strip.near[upper..upper + ROW], &strip.near[lower..lower + ROW]);
        let every = |row: &[f32], from: usize| -> Each {
            let row: &[f32; ROW] = row.try_into().unwrap_or(&[0.0; ROW]);
            Each::new(std::array::from_fn(|k| row[4 * k + from]))
        };
        let first = every(p, 0);
        let (mut sum, mut least, mut most) = (first, first, first);
        for near in (1..4).map(|k| every(p, k)).chain((0..4).map(|k| every(q, k))) {
            sum += near;
            (least, most) = (least.fast_min(near), most.fast_max(near));
        }
        // Nothing of the difference is below zero where all is connected.
        let apart = (most - Each::splat(APART) * least).fast_max(Each::splat(0.0)).reduce_add();
        (apart <= 0.0).then(|| Self {
            near: sum * Each::splat(0.125),
            marks: [[0.0; EIGHT]; 3],
            opacity: [0.0; EIGHT],
            marked: false,
            ground: [true; EIGHT],
        })
    }

    /// Whether this pixel shows ground alone.
    #[inline]
    pub(crate) fn is_ground(&self, k: usize) -> bool {
        self.ground[k]
    }
}

/// Whether eight pixels with four samples each, of which `upper` and `lower` are the first ones of both rows, show nothing but sky.
#[inline]
pub(crate) fn is_sky(strip: &Strip, upper: usize, lower: usize) -> bool {
    const ROW: usize = 2 * EIGHT;
    let (a, b) = (&strip.paint[upper..upper + ROW], &strip.paint[lower..lower + ROW]);
    a.iter().chain(b).fold(0, |all, paint| all | (paint ^ SKY)) == 0
}

impl Place {
    /// The colours of the sky of eight pixels, red, green and blue of each, as a pinhole sees it; `next` leads to the ray of a pixel's
    /// neighbour.
    #[inline]
    pub(crate) fn sky_of_eight(&self, next: [f32; 3]) -> [[f32; EIGHT]; 3] {
        let [x, y, z] = [0, 1, 2].map(|k| Each::splat(self.ray[k]) + COUNT * Each::splat(next[k]));
        let rise = (z / (x * x + y * y + z * z).sqrt()).fast_max(Each::splat(0.0));
        let share = (Each::splat(SKY_RISE) * rise).fast_min(Each::splat(1.0));
        [0, 1, 2].map(|k| {
            let [haze, zenith] = [HAZE[k], ZENITH[k]].map(|c| Each::splat(f32::from(c)));
            mix(haze, zenith, share).to_array()
        })
    }
}

/// Adding it makes a float's last bits those of the nearest whole number, for numbers up to 2²¹: fewer instructions than a conversion.
const WHOLE: f32 = 12_582_912.0;

/// A whole number near below, of which the lowest 22 bits are right, and what is above it, in [0, 1]: of a whole number it may be the one
/// before, with 1 above it.
#[inline]
fn parts(v: Each) -> ([u32; EIGHT], Each) {
    let shifted = v - Each::splat(0.5) + Each::splat(WHOLE);
    (shifted.to_array().map(|s| s.to_bits() & 0x003f_ffff), v - (shifted - Each::splat(WHOLE)))
}

/// A byte of each number as a float.
#[inline]
fn byte(of: u32x8, shift: u32) -> Each {
    // The bits of 2²³ and the byte.
    const BASE: f32 = 8_388_608.0;
    let bits = (of.unbounded_shr_scalar(shift) & u32x8::splat(255)) | u32x8::splat(BASE.to_bits());
    bytemuck::cast::<u32x8, Each>(bits) - Each::splat(BASE)
}

#[inline]
fn mix(a: Each, b: Each, share: Each) -> Each {
    a + share * (b - a)
}

impl Texture {
    /// The colours at eight points, 0 to 255 each, and how much of the ground about each yields, 0 to 255; beyond the edge, those at
    /// the edge.
    #[inline]
    fn at_eight(&self, x: Each, y: Each) -> ([Each; 3], Each) {
        let ([half_x, half_y], [across, along], [east, north]) = self.scale();
        // Not the last texel, which has none behind it.
        let place = |v: Each, half: f32, density: f32, most: f32| {
            ((v + Each::splat(half)) * Each::splat(density / 256.0))
                .fast_max(Each::splat(0.0))
                .fast_min(Each::splat((most / 256.0 - 1e-3).max(0.0)))
        };
        let (cols, u) = parts(place(x, half_x, across, east));
        let (rows, v) = parts(place(y, half_y, along, north));
        let mut corners = [[0; EIGHT]; 4];
        for k in 0..EIGHT {
            let square = self.square(cols[k] as usize, rows[k] as usize);
            for (corner, texel) in corners.iter_mut().zip(square) {
                corner[k] = texel;
            }
        }
        let corners = corners.map(u32x8::new);
        let channel = |shift: u32| {
            let [sw, se, nw, ne] = corners.map(|c| byte(c, shift));
            mix(mix(sw, se, u), mix(nw, ne, u), v)
        };
        ([channel(16), channel(8), channel(0)], channel(24))
    }
}

impl Grain {
    /// The change of the brightness at eight places in finest squares, where a pixel covers so many of them.
    #[inline]
    fn at_eight(&self, x: Each, y: Each, covered: f32) -> Each {
        let (values, level, shift) = self.level(covered);
        let scale = Each::splat(1.0 / (1_u32 << level) as f32);
        let ((cols, u), (rows, v)) = (parts(x * scale), parts(y * scale));
        let mask = (1 << shift) - 1;
        let mut corners = [[0.0; EIGHT]; 4];
        for k in 0..EIGHT {
            let (left, right) = (cols[k] & mask, (cols[k] + 1) & mask);
            let (lower, upper) = ((rows[k] & mask) << shift, ((rows[k] + 1) & mask) << shift);
            for (corner, place) in
                corners.iter_mut().zip([lower | left, lower | right, upper | left, upper | right])
            {
                corner[k] = f32::from(values[place as usize]);
            }
        }
        let [sw, se, nw, ne] = corners.map(Each::new);
        mix(mix(sw, se, u), mix(nw, ne, u), v) * Each::splat(1.0 / 127.0) - Each::splat(128.0 / 127.0)
    }
}

impl Shadow {
    /// Whether one of eight points may lie in the shadow.
    #[inline]
    fn may_cover(&self, [x, y, _]: [Each; 3]) -> bool {
        let ([cx, cy], radius, reach) = self.bounds();
        let (dx, dy) = (x - Each::splat(cx), y - Each::splat(cy));
        let diagonal = Each::splat(std::f32::consts::FRAC_1_SQRT_2);
        let (along, across) = (diagonal * (dx - dy), diagonal * (dx + dy));
        let inside = (Each::splat(1.1 * radius) - across.abs())
            .fast_min(Each::splat(reach) - along)
            .fast_min(along + Each::splat(2.0 * radius));
        inside.fast_max(Each::splat(0.0)).reduce_add() > 0.0
    }
}

impl Developer<'_> {
    /// Writes the colours of the pixels of eight pairs, from those in the middles of pairs: across a pair they change as from the pair before
    /// to the one behind. `first` is the place of the middle of the first pair, and `next` leads to its neighbour's ray.
    #[inline]
    pub(crate) fn pairs(
        &self,
        samples: &Samples,
        first: &Place,
        next: [f32; 3],
        pixels: &mut [u8; 6 * EIGHT],
    ) {
        const QUARTERS: [f32; EIGHT] = [0.25, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.25];
        let (least, most) = (Each::splat(0.0), Each::splat(255.0));
        let sides = self.eight(samples, first, next, 2.0).map(|m| {
            let before = Each::new([m[0], m[0], m[1], m[2], m[3], m[4], m[5], m[6]]);
            let behind = Each::new([m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[7]]);
            let (middle, change) = (Each::new(m), Each::new(QUARTERS) * (behind - before));
            // As `whole` does for each of them.
            [middle - change, middle + change]
                .map(|side| (side.fast_max(least).fast_min(most) + Each::splat(WHOLE)).to_array())
        });
        for (k, pair) in pixels.chunks_exact_mut(6).enumerate() {
            for (c, channel) in sides.iter().enumerate() {
                pair[c] = channel[0][k].to_bits() as u8;
                pair[3 + c] = channel[1][k].to_bits() as u8;
            }
        }
    }

    /// The colours of eight pixels of ground, red, green and blue of each; `first` is the place of the first of them, and `next` leads to
    /// its neighbour's ray. Each stands for so many pixels beside each other.
    #[inline]
    pub(crate) fn eight(
        &self,
        samples: &Samples,
        first: &Place,
        next: [f32; 3],
        wide: f32,
    ) -> [[f32; EIGHT]; 3] {
        let near = samples.near;
        let ray = [0, 1, 2].map(|k| Each::splat(first.ray[k]) + COUNT * Each::splat(next[k]));
        let far = Each::splat(1.0) / near;
        let point = [0, 1, 2].map(|k| {
            let eye = Each::splat(first.eye[k]);
            if first.pinhole {
                eye + far * ray[k]
            } else {
                eye + ray[k] - near * Each::splat(first.forward[k])
            }
        });
        let (mut colour, soft) = self.look.texture.at_eight(point[0], point[1]);
        let mut light = Each::splat(1.0);
        if first.pinhole {
            let fade = (Each::splat(1.0) - far * Each::splat(self.smooth)).fast_max(Each::splat(0.0));
            if fade.reduce_add() > 0.0 {
                let squares = Each::splat(self.fine / 256.0);
                let covered = wide * far.to_array()[EIGHT / 2] * self.footprint;
                let grain = self.look.grain.at_eight(point[0] * squares, point[1] * squares, covered);
                light += Each::splat(ROUGHNESS) * fade * grain;
            }
        }
        if let Some(change) = self.look.change {
            let soft = soft.to_array();
            // As much of a texel's weight as makes a single pixel's highest bit.
            if soft.iter().any(|s| *s >= 128.0) {
                let ([x, y], mut own) = ([point[0].to_array(), point[1].to_array()], light.to_array());
                for k in (0..EIGHT).filter(|k| soft[*k] >= 128.0) {
                    if let Some(change) = change(f64::from(x[k]), f64::from(y[k])) {
                        own[k] *= trodden(change as f32 / self.look.unit);
                    }
                }
                light = Each::new(own);
            }
        }
        if self.look.shadow.may_cover(point) {
            let ([x, y, z], mut own) = (point.map(Each::to_array), light.to_array());
            for k in 0..EIGHT {
                let covered = self.look.shadow.at([x[k], y[k], z[k]]);
                if covered > 0.0 {
                    own[k] *= shaded(covered);
                }
            }
            light = Each::new(own);
        }
        for c in &mut colour {
            *c *= light;
        }
        if samples.marked {
            let opacity = Each::new(samples.opacity);
            for (c, mark) in colour.iter_mut().zip(samples.marks) {
                *c = mix(*c, Each::new(mark), opacity);
            }
        }
        if first.pinhole {
            let a = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
            let share = a / (a + Each::splat(self.fog) * near * near);
            for (c, haze) in colour.iter_mut().zip(HAZE) {
                *c = mix(*c, Each::splat(f32::from(haze)), share);
            }
        }
        colour.map(|c| c.fast_min(Each::splat(255.0)).to_array())
    }
}
