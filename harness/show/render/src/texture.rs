//! The ground as a picture from above: the colours of its classes in the light of the sun, computed once for a world.

use crate::V3;
use crate::light::{SKYLIGHT, Shadow, on_ground};
use crate::solid::{Face, sphere};
use vb_world::{Heightfield, World};

/// Texels along the longer side of a world at most, and for each cell of the ground.
const TEXELS: usize = 1024;
const TEXELS_OF_LARGE: usize = 2048;
const PER_CELL: usize = 8;
/// Slopes are so much exaggerated in the light, as on relief maps.
const EXAGGERATION: f64 = 1.25;

/// Colours at even distances, the first in the south-western corner and the last in the north-eastern one; red, green and
/// blue from the third byte down. The highest byte tells whether the ground yields there: 255 or 0.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    cols: usize,
    rows: usize,
    /// Half the extents of the world, m, 256ths of a texel's side a metre, and in the whole world.
    half: [f32; 2],
    density: [f32; 2],
    most: [f32; 2],
    texels: Vec<u32>,
}

impl Texture {
    /// The ground of a world with the shadows of the obstacles' faces.
    pub(crate) fn of(world: &World, obstacles: &[Vec<Face>]) -> Self {
        let field = &world.heightfield;
        let cells = [field.cols() - 1, field.rows() - 1];
        let longest = cells[0].max(cells[1]);
        let most = if longest > 2 * TEXELS / PER_CELL { TEXELS_OF_LARGE } else { TEXELS };
        let along = |n: usize| ((n * PER_CELL).min(most * n / longest)).max(1) + 1;
        let [cols, rows] = cells.map(along);
        let half = [field.half_x(), field.half_y()];
        let pitch = [2.0 * half[0] / (cols - 1) as f64, 2.0 * half[1] / (rows - 1) as f64];
        let light = node_light(field);
        let semantics = &world.semantics;
        // What the columns have in common: the cell of the ground, the place in it, the column of patches.
        let columns: Vec<(usize, f32, usize)> = (0..cols)
            .map(|col| {
                let x = col as f64 * pitch[0] - half[0];
                let (cell, u) = cell(x, half[0], field.resolution(), field.cols());
                (cell, u, semantics.patch_index(x, -half[1]) % semantics.cols)
            })
            .collect();
        let mut texels = Vec::with_capacity(rows * cols);
        for row in 0..rows {
            let y = row as f64 * pitch[1] - half[1];
            let (cell, v) = cell(y, half[1], field.resolution(), field.rows());
            let patches =
                &semantics.classes[semantics.patch_index(-half[0], y) / semantics.cols * semantics.cols..];
            let (south, north) = (&light[cell * field.cols()..], &light[(cell + 1) * field.cols()..]);
            for &(k, u, patch) in &columns {
                let class = patches[patch];
                // Linear between nodes, so that no facets show.
                let south = south[k] + u * (south[k + 1] - south[k]);
                let north = north[k] + u * (north[k + 1] - north[k]);
                let light = south + v * (north - south);
                let [r, g, b] = class.colour().map(|c| whole((f32::from(c) * light).min(255.0)));
                let soft = if class.is_deformable() { 255 } else { 0 };
                texels.push(soft << 24 | r << 16 | g << 8 | b);
            }
        }
        let density = pitch.map(|p| (256.0 / p) as f32);
        let most = [cols, rows].map(|n| (256 * (n - 1)) as f32);
        let mut texture = Self { cols, rows, half: half.map(|h| h as f32), density, most, texels };
        for obstacle in obstacles {
            texture.shade(field, obstacle, half, pitch);
        }
        texture
    }

    /// Darkens what an obstacle keeps the sun from.
    fn shade(&mut self, field: &Heightfield, obstacle: &[Face], half: [f64; 2], pitch: [f64; 2]) {
        // What is under the ground shades nothing.
        let raise = |p: &V3| V3::new(p.x, p.y, p.z.max(field.height(p.x, p.y)));
        let above: Vec<Face> =
            obstacle.iter().map(|f| Face { corners: f.corners.each_ref().map(raise), ..*f }).collect();
        let (centre, radius) = sphere(above.iter());
        let drop = centre.z - field.range().0;
        let shadow = Shadow::of(centre, radius, drop, above.iter().map(|f| &f.corners));
        let reach = shadow.reach();
        // Towards the south-east.
        let span = |low: f64, high: f64, axis: usize, n: usize| {
            let at = |v: f64| ((v + half[axis]) / pitch[axis]).clamp(0.0, n as f64);
            at(low) as usize..(at(high) as usize + 1).min(n)
        };
        for row in span(centre.y - reach, centre.y + radius, 1, self.rows) {
            let y = row as f64 * pitch[1] - half[1];
            for col in span(centre.x - radius, centre.x + reach, 0, self.cols) {
                let x = col as f64 * pitch[0] - half[0];
                let covered = shadow.at([x, y, field.height(x, y)].map(|v| v as f32));
                if covered > 0.0 {
                    let texel = &mut self.texels[row * self.cols + col];
                    let light = shaded(covered);
                    let part = |shift: u32| ((*texel >> shift & 255) as f32 * light) as u32;
                    *texel = *texel & 0xff00_0000 | part(16) << 16 | part(8) << 8 | part(0);
                }
            }
        }
    }

    /// Half the extents of the world, m, 256ths of a texel's side a metre, and in the whole world.
    #[inline]
    pub(crate) fn scale(&self) -> ([f32; 2], [f32; 2], [f32; 2]) {
        (self.half, self.density, self.most)
    }

    /// The texels at the corners of a square: south-west, south-east, north-west, north-east.
    #[inline]
    pub(crate) fn square(&self, col: usize, row: usize) -> [u32; 4] {
        let k = row * self.cols + col;
        let (south, north) = (&self.texels[k..k + 2], &self.texels[k + self.cols..k + self.cols + 2]);
        [south[0], south[1], north[0], north[1]]
    }

    /// The colour at a point, 0 to 255 each, and whether the ground yields there; beyond the edge, those at the edge.
    #[inline]
    pub(crate) fn at(&self, x: f32, y: f32) -> ([f32; 3], bool) {
        let cell = |v: f32, axis: usize, n: usize| {
            let at = ((v + self.half[axis]) * self.density[axis]).max(0.0).min(self.most[axis]);
            let at = whole(at) as usize;
            let k = (at >> 8).min(n - 2);
            (k, (at - (k << 8)) as u32)
        };
        let ((col, u), (row, v)) = (cell(x, 0, self.cols), cell(y, 1, self.rows));
        let [sw, se, nw, ne] = self.square(col, row);
        let c = mix(mix(sw, se, u), mix(nw, ne, u), v);
        let byte = |shift: u32| (c >> shift & 255) as i32 as f32;
        ([byte(16), byte(8), byte(0)], c >> 31 != 0)
    }
}

/// The nearest whole number, of which the lowest 22 bits are those of a negative number too, for numbers up to 2²¹: adding
/// this makes a float's last bits the number's. It takes fewer instructions than a conversion, which has to be right for
/// all numbers.
#[inline]
pub(crate) fn whole(v: f32) -> u32 {
    (v + 12_582_912.0).to_bits() & 0x003f_ffff
}

/// The share of light that is left of ground which is covered to this share.
#[inline]
pub(crate) fn shaded(covered: f32) -> f32 {
    1.0 - (1.0 - SKYLIGHT) as f32 * covered
}

/// Two packed colours mixed, with a share of the second from 0 to 256.
#[inline]
fn mix(a: u32, b: u32, share: u32) -> u32 {
    const EVEN: u32 = 0x00ff_00ff;
    let part = |a: u32, b: u32| ((a & EVEN) * (256 - share) + (b & EVEN) * share) >> 8 & EVEN;
    // Bytes 0 and 2 together, then bytes 1 and 3.
    part(a, b) | part(a >> 8, b >> 8) << 8
}

fn node_light(field: &Heightfield) -> Vec<f32> {
    let (rows, cols, resolution) = (field.rows(), field.cols(), field.resolution());
    let (_, high) = field.range();
    let mut light = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        let (south, north) = (row.saturating_sub(1), (row + 1).min(rows - 1));
        for col in 0..cols {
            let (west, east) = (col.saturating_sub(1), (col + 1).min(cols - 1));
            let gradient = [
                (field.node(row, east) - field.node(row, west)) / ((east - west) as f64 * resolution),
                (field.node(north, col) - field.node(south, col)) / ((north - south) as f64 * resolution),
            ];
            // The nodes towards the sun lie on the diagonal, and its ray rises as much as it goes along.
            let mut lit: f64 = 1.0;
            for k in 1..=col.min(rows - 1 - row) {
                let way = k as f64 * resolution * std::f64::consts::SQRT_2;
                let ray = field.node(row, col) + way;
                if ray > high {
                    break;
                }
                lit = lit.min(0.5 + (ray - field.node(row + k, col - k)) / (0.3 * way));
            }
            light.push(on_ground(gradient.map(|g| EXAGGERATION * g), lit.max(0.0)) as f32);
        }
    }
    light
}

/// The cell of the ground at a place along one axis, and where in it that is, from 0 to 1.
fn cell(v: f64, half: f64, resolution: f64, nodes: usize) -> (usize, f32) {
    let at = ((v + half) / resolution).clamp(0.0, (nodes - 1) as f64);
    let k = (at as usize).min(nodes - 2);
    (k, (at - k as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_world::{Semantics, SoilLevels, TerrainClass};

    #[test]
    fn level_ground_has_the_colour_of_its_class_and_tells_whether_it_yields() {
        for class in TerrainClass::ALL {
            let world = World::uniform("w", Heightfield::flat(17, 33, 0.5, 3.0), class, 0.5);
            let texture = Texture::of(&world, &[]);
            let (colour, soft) = texture.at(1.234, -2.345);
            assert_eq!(colour, class.colour().map(f32::from));
            assert_eq!(soft, class.is_deformable());
        }
    }

    #[test]
    fn each_patch_has_its_own_colour_where_it_lies() {
        let mut world = World::uniform("w", Heightfield::flat(9, 9, 1.0, 0.0), TerrainClass::Clay, 0.5);
        let classes = [TerrainClass::Clay, TerrainClass::Rock, TerrainClass::Grass, TerrainClass::Snow];
        world.semantics = Semantics {
            rows: 2,
            cols: 2,
            patch: 4.0,
            classes: classes.to_vec(),
            friction: vec![0.5, 0.5, 0.5, 0.0],
            soil: SoilLevels::default(),
        };
        let texture = Texture::of(&world, &[]);
        for (class, [x, y]) in classes.into_iter().zip([[-2.0, -2.0], [2.0, -2.0], [-2.0, 2.0], [2.0, 2.0]]) {
            assert_eq!(texture.at(x, y).0, class.colour().map(f32::from), "{class:?}");
        }
    }

    #[test]
    fn a_ridge_shades_the_ground_behind_it_and_not_the_ground_before_it() {
        // A wall of 6 m from the south-west to the north-east. The sun stands in the north-west.
        let n = 41;
        let heights = (0..n * n).map(|i| if i / n == i % n { 6.0 } else { 0.0 }).collect();
        let world = World::uniform("w", Heightfield::new(n, n, 1.0, heights), TerrainClass::Concrete, 0.5);
        let texture = Texture::of(&world, &[]);
        let full = f32::from(TerrainClass::Concrete.colour()[0]);
        // 3 √2 m behind the crest: the ray passes 1.8 m below it.
        let behind = texture.at(3.0, -3.0).0[0];
        assert!((behind - full * SKYLIGHT as f32).abs() < 1.5, "{behind}");
        // 7 √2 m behind it the ray passes 3.9 m above it.
        assert_eq!(texture.at(7.0, -7.0).0[0], full);
        assert_eq!(texture.at(-3.0, 3.0).0[0], full);
    }

    #[test]
    fn mixing_keeps_equal_colours_and_bytes_apart() {
        assert_eq!(mix(0xff12_fe34, 0xff12_fe34, 77), 0xff12_fe34);
        assert_eq!(mix(0x0000_0000, 0xff80_4020, 128), 0x7f40_2010);
        assert_eq!(mix(1, 0xff00_00ff, 256), 0xff00_00ff);
    }
}
