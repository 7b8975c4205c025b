//! The sun, what it does not reach, and the air.

use crate::camera::{Camera, Lens};
use crate::canvas::{Canvas, Faces, SKY, solid};
use crate::{Colour, V3};

/// Direction to the sun: from the north-west, 45° high, as maps have it; a unit vector.
pub(crate) const SUN: [f64; 3] = [-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2];
/// Share of the light of level ground that comes from all of the sky.
pub(crate) const SKYLIGHT: f64 = 0.48;
/// The same for the faces of solids, whose dark sides would else be black.
const SKYLIGHT_ON_SOLIDS: f64 = 0.6;

/// The air at the horizon, and the sky straight up.
pub(crate) const HAZE: Colour = [212, 222, 230];
pub(crate) const ZENITH: Colour = [110, 160, 214];
/// The sky is as at the zenith where a ray's sine of elevation is one over this, or more.
pub(crate) const SKY_RISE: f32 = 2.6;
/// What lies around the world in the view from above.
pub(crate) const BEYOND: Colour = [226, 230, 233];
/// The distance at which half of what is seen is air, m in a world of full size.
pub(crate) const FOG: f64 = 150.0;

/// The direction to the sun.
pub(crate) fn sun() -> V3 {
    V3::from(SUN)
}

/// The brightness of ground with this gradient, of which a share `lit` sees the sun: 1 for level ground in the sun.
pub(crate) fn on_ground(gradient: [f64; 2], lit: f64) -> f64 {
    let [gx, gy] = gradient;
    let length = (1.0 + gx * gx + gy * gy).sqrt();
    let cosine = (SUN[2] - gx * SUN[0] - gy * SUN[1]) / length;
    // The sky above a slope is smaller: as much as its normal leans.
    let sky = 0.5 + 0.5 / length;
    SKYLIGHT * sky + (1.0 - SKYLIGHT) * lit * (cosine.max(0.0) / SUN[2])
}

/// The colour of a solid's face with this unit normal.
pub(crate) fn on_solid(colour: Colour, normal: &V3) -> Colour {
    let cosine = sun().dot(normal).max(0.0);
    let sky = 0.6 + 0.4 * normal.z;
    let light = SKYLIGHT_ON_SOLIDS * sky + (1.0 - SKYLIGHT_ON_SOLIDS) * 1.25 * cosine;
    colour.map(|c| (f64::from(c) * light).min(255.0) as u8)
}

/// Samples along a side of a shadow's canvas.
const SHADOW: usize = 160;

/// The shadow of solids near one place: what the sun sees of them, which is what it does not see of the ground below.
pub(crate) struct Shadow {
    /// The middle of the solids, m.
    centre: [f32; 3],
    /// Half its breadth across the sun's rays, and how far it reaches along the ground in their direction, m.
    radius: f32,
    reach: f32,
    /// Samples for a metre along the axes, to the right and down, as the sun sees them.
    axes: [[f32; 3]; 2],
    /// How much of each sample's surroundings is covered, 0 to 255.
    cover: Vec<u8>,
}

impl Shadow {
    /// The shadow of triangles that lie in a sphere, on ground which is nowhere more than `drop` below its centre, m.
    pub(crate) fn of<'a>(
        centre: V3,
        radius: f64,
        drop: f64,
        faces: impl Iterator<Item = &'a [V3; 3]>,
    ) -> Self {
        let right = V3::z().cross(&sun()).normalize();
        let up = sun().cross(&right);
        // A margin for the softened edge.
        let scale = 0.47 * SHADOW as f64 / radius.max(1e-6);
        let lens = Lens::Parallel { scale };
        let camera = Camera { eye: centre, right, up, forward: -sun(), lens, samples: [SHADOW; 2] };
        let mut canvas = Canvas::new(camera);
        for face in faces {
            canvas.face(face, Faces::Both, solid([0; 3]));
        }
        let seen = canvas.exposed();
        let covered = |row: usize, col: usize| u32::from(seen.paint[row * SHADOW + col] != SKY);
        let mut cover = vec![0; SHADOW * SHADOW];
        for row in 1..SHADOW - 1 {
            for col in 1..SHADOW - 1 {
                let around: u32 =
                    (row - 1..=row + 1).flat_map(|r| (col - 1..=col + 1).map(move |c| covered(r, c))).sum();
                cover[row * SHADOW + col] = (around * 255 / 9) as u8;
            }
        }
        let narrow = |v: V3| [v.x as f32, v.y as f32, v.z as f32];
        // The sun stands 45° high.
        let reach = radius * std::f64::consts::SQRT_2 + drop.max(0.0);
        Self {
            centre: narrow(centre),
            radius: radius as f32,
            reach: reach as f32,
            axes: [narrow(scale * right), narrow(-scale * up)],
            cover,
        }
    }

    /// How far from its centre the shadow can reach, m.
    pub(crate) fn reach(&self) -> f64 {
        f64::from(self.reach)
    }

    /// The middle of the solids along x and y, half their breadth across the sun's rays, and how far the shadow reaches, m.
    #[inline]
    pub(crate) fn bounds(&self) -> ([f32; 2], f32, f32) {
        ([self.centre[0], self.centre[1]], self.radius, self.reach)
    }

    /// The share of the sun that a point of the ground does not see, 0 to 1.
    #[inline]
    pub(crate) fn at(&self, p: [f32; 3]) -> f32 {
        let d = [0, 1, 2].map(|k| p[k] - self.centre[k]);
        // Along the ground in the direction of the sun's rays, and across.
        const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let (along, across) = (DIAGONAL * (d[0] - d[1]), DIAGONAL * (d[0] + d[1]));
        let margin = 1.1 * self.radius;
        if across.abs() > margin || along > self.reach || along < -2.0 * self.radius {
            return 0.0;
        }
        self.looked_up(d)
    }

    fn looked_up(&self, d: [f32; 3]) -> f32 {
        let [u, v] = self.axes.map(|a| a[0] * d[0] + a[1] * d[1] + a[2] * d[2] + 0.5 * (SHADOW - 1) as f32);
        let most = (SHADOW - 2) as f32;
        if !(u >= 0.0 && v >= 0.0 && u < most && v < most) {
            return 0.0;
        }
        let (col, row) = (u as u32 as usize, v as u32 as usize);
        let (fu, fv) = (u - col as f32, v - row as f32);
        let at = |k: usize| f32::from(self.cover[row * SHADOW + col + k]);
        let upper = at(0) + fu * (at(1) - at(0));
        let lower = at(SHADOW) + fu * (at(SHADOW + 1) - at(SHADOW));
        (upper + fv * (lower - upper)) * (1.0 / 255.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_ground_in_the_sun_has_its_own_colour_and_slopes_follow_lambert() {
        assert!((on_ground([0.0; 2], 1.0) - 1.0).abs() < 1e-12);
        assert!((on_ground([0.0; 2], 0.0) - SKYLIGHT).abs() < 1e-12);
        // The slope that looks straight at the sun: normal (-1, 1, √2) / 2, so z falls to the north-west. The sun's
        // part is 1 / sin 45° of that on level ground, the sky's (1 + cos 45°) / 2.
        let towards = on_ground([std::f64::consts::FRAC_1_SQRT_2, -std::f64::consts::FRAC_1_SQRT_2], 1.0);
        let expected = SKYLIGHT * (0.5 + 0.5 * std::f64::consts::FRAC_1_SQRT_2)
            + (1.0 - SKYLIGHT) * std::f64::consts::SQRT_2;
        assert!((towards - expected).abs() < 1e-12, "{towards} {expected}");
    }

    #[test]
    fn a_shadow_lies_on_the_side_away_from_the_sun_as_far_as_its_caster_is_high() {
        // A level square of 1 m, 2 m above the ground. With the sun 45° high in the north-west its shadow is displaced
        // by 2 m to the south-east.
        let p = |x: f64, y: f64| V3::new(x, y, 2.0);
        let [a, b, c, d] = [p(-0.5, -0.5), p(0.5, -0.5), p(0.5, 0.5), p(-0.5, 0.5)];
        let shadow = Shadow::of(V3::new(0.0, 0.0, 2.0), 0.8, 2.0, [[a, b, c], [a, c, d]].iter());
        let off = std::f64::consts::SQRT_2 as f32;
        assert!((shadow.at([off, -off, 0.0]) - 1.0).abs() < 1e-6, "{}", shadow.at([off, -off, 0.0]));
        assert!((shadow.at([off + 0.4, -off + 0.4, 0.0]) - 1.0).abs() < 1e-6);
        assert_eq!(shadow.at([off + 0.6, -off, 0.0]), 0.0);
        assert_eq!(shadow.at([0.0, 0.0, 0.0]), 0.0);
        assert_eq!(shadow.at([-off, off, 0.0]), 0.0);
        // The half of it in the south-east alone.
        let half = Shadow::of(V3::new(0.0, 0.0, 2.0), 0.8, 2.0, [[a, b, c]].iter());
        assert!((half.at([off + 0.25, -off - 0.25, 0.0]) - 1.0).abs() < 1e-6);
        assert_eq!(half.at([off - 0.25, -off + 0.25, 0.0]), 0.0);
    }
}
