//! Pictures of a world's ground as PNG: the relief under a fixed sun, and thin coloured layers to lay over it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vb_math::{angle::degrees, atan, hypot};
use vb_world::{Heightfield, TerrainClass, World};

/// Direction to the sun: from the north-west, 45° high, as maps have it.
const SUN: [f64; 3] = [-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2];
/// Heights are so much exaggerated in the shading, in every world alike: low ones would show nothing else.
pub const EXAGGERATION: f64 = 2.0;
/// Slope at the end of the colour scale, degrees.
pub const STEEP: f64 = 45.0;
/// Heights at the ends of the colour scale lie so many standard deviations from the mean: a few pits would press all
/// others together.
pub const SPREADS: f64 = 2.5;
/// Friction at the ends of the colour scale: the clip of the original's generator (envs/gen-VertiBench.py).
pub const FRICTION: [f64; 2] = [0.1, 1.0];
/// Colours of a scale.
const STEPS: usize = 32;

/// A colour: red, green, blue.
pub type Colour = [u8; 3];

/// From low to high ground: marsh, meadow, heath, scree.
pub const HEIGHTS: [Colour; 5] =
    [[74, 128, 132], [128, 176, 118], [224, 212, 140], [201, 148, 92], [244, 236, 226]];
/// From level to steep.
pub const SLOPES: [Colour; 5] =
    [[252, 252, 240], [250, 225, 130], [240, 145, 70], [205, 55, 70], [90, 20, 90]];
/// From slippery to grippy.
pub const GRIPS: [Colour; 4] = [[60, 90, 180], [110, 180, 200], [215, 225, 150], [250, 245, 215]];

/// A colour on a scale, `at` from 0 to 1.
#[must_use]
pub fn on_scale(scale: &[Colour], at: f64) -> Colour {
    let at = at.clamp(0.0, 1.0) * (scale.len() - 1) as f64;
    let k = (at as usize).min(scale.len() - 2);
    let t = at - k as f64;
    [0, 1, 2].map(|c| {
        let (a, b) = (f64::from(scale[k][c]), f64::from(scale[k + 1][c]));
        (a + t * (b - a)).round() as u8
    })
}

/// The pictures of a world's ground: the relief in grey, and what is laid over it. That is the class of each patch, heights about
/// the mean, slopes over 1 m up to [`STEEP`], or the friction of each patch, transparent where the ground yields.
pub const LAYERS: [&str; 5] = ["shade", "classes", "heights", "slopes", "friction"];

/// The pictures of a world as PNG, north up, in the order of [`LAYERS`].
#[derive(Clone, Debug)]
pub struct Pictures(pub [Vec<u8>; LAYERS.len()]);

/// Where a page has the pictures of a world from, in the order of [`LAYERS`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources([String; LAYERS.len()]);

impl Sources {
    #[must_use]
    pub fn inline(pictures: &Pictures) -> Self {
        Self(pictures.0.each_ref().map(|png| data_uri(png)))
    }

    /// In files beside the page, whose addresses begin with `prefix` and end with the layer: `PREFIX-shade.png`.
    #[must_use]
    pub fn files(prefix: &str) -> Self {
        Self(LAYERS.map(|layer| format!("{prefix}-{layer}.png")))
    }

    /// Each layer with its address.
    pub(crate) fn each(&self) -> impl Iterator<Item = (&'static str, &str)> {
        LAYERS.into_iter().zip(self.0.iter().map(String::as_str))
    }
}

/// A picture in PNG as the address of itself.
#[must_use]
pub fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// Makes a world's pictures: the relief with at most `side` pixels along the longer side, layers with half of that.
#[must_use]
pub fn pictures(world: &World, side: usize) -> Pictures {
    let h = &world.heightfield;
    let (mean, spread) = mean_and_spread(h.heights());
    let relief = Frame::new(h, side.min(4 * h.rows().max(h.cols())));
    let layer = Frame::new(h, (side / 2).max(2));
    let gradients = gradients(h, 1);
    let shade = |x, y| brightness(interpolate(h, &gradients, x, y));
    let span = (2.0 * SPREADS * spread).max(1e-9);
    let height = |x, y| (h.height(x, y) - mean) / span + 0.5;
    let wide = self::gradients(h, nodes_of_a_metre(h.resolution()));
    let slope = |x, y| {
        let g = interpolate(h, &wide, x, y);
        degrees(atan(hypot(g[0], g[1]))) / STEEP
    };
    let s = &world.semantics;
    // Patches need no more pixels than there are patches, but a raster of a million is drawn coarser.
    let patches = Frame::new(h, s.rows.max(s.cols).min(side));
    let class = |x, y| s.class_at(x, y).label();
    let grip = |x, y| {
        let mu = (s.friction_at(x, y) - FRICTION[0]) / (FRICTION[1] - FRICTION[0]);
        if s.class_at(x, y).is_deformable() { STEPS as u8 } else { step(mu) }
    };
    let palette = |scale: &[Colour]| -> Vec<Colour> {
        (0..STEPS).map(|k| on_scale(scale, k as f64 / (STEPS - 1) as f64)).collect()
    };
    let mut grips = palette(&GRIPS);
    grips.push([255; 3]);
    Pictures([
        relief.grey(shade),
        patches.indexed(&TerrainClass::ALL.map(TerrainClass::colour), None, class),
        layer.indexed(&palette(&HEIGHTS), None, |x, y| step(height(x, y))),
        layer.indexed(&palette(&SLOPES), None, |x, y| step(slope(x, y))),
        patches.indexed(&grips, Some(STEPS as u8), grip),
    ])
}

/// Greys of the ground in one picture.
const GREYS: usize = 24;

/// The ground in one picture as PNG, with `side` pixels along the longer side, north up: the relief in the colours of the classes.
#[must_use]
pub fn ground(world: &World, side: usize) -> Vec<u8> {
    let h = &world.heightfield;
    let frame = Frame::new(h, side);
    // A pixel is wider than the distance between nodes: its slope is that over its own width.
    let wide = (2.0 * h.half_x().max(h.half_y()) / side.max(1) as f64 / h.resolution()).ceil() as usize;
    let gradients = gradients(h, wide.div_ceil(2).max(1));
    let shade = |x, y| f64::from(brightness(interpolate(h, &gradients, x, y))) / 255.0;
    let tinted = |class: TerrainClass| {
        let tint = class.colour().map(f64::from);
        (0..GREYS).map(move |grey| {
            let light = grey as f64 / (GREYS - 1) as f64;
            tint.map(|c| (c * light).round() as u8)
        })
    };
    let palette: Vec<Colour> = TerrainClass::ALL.into_iter().flat_map(tinted).collect();
    frame.indexed(&palette, None, |x, y| {
        let class = usize::from(world.semantics.class_at(x, y).label());
        let grey = (shade(x, y) * (GREYS - 1) as f64).round() as usize;
        (class * GREYS + grey).min(palette.len() - 1) as u8
    })
}

/// The mean and the standard deviation of values.
fn mean_and_spread(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

/// The number of nodes of a grid that make 1 m, at least one. `resolution` is the distance between them, m.
#[must_use]
pub fn nodes_of_a_metre(resolution: f64) -> usize {
    ((1.0 / resolution).round() as usize).max(1)
}

/// Index of a colour in a palette of [`STEPS`].
fn step(at: f64) -> u8 {
    (at.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as u8
}

/// The pixels of a picture over a world, row 0 in the north.
struct Frame {
    rows: usize,
    cols: usize,
    half: [f64; 2],
}

impl Frame {
    fn new(h: &Heightfield, side: usize) -> Self {
        let (x, y) = (h.half_x(), h.half_y());
        let along = |half: f64| ((side as f64 * half / x.max(y)).round() as usize).max(1);
        Self { rows: along(y), cols: along(x), half: [x, y] }
    }

    fn map(&self, value: impl Fn(f64, f64) -> u8) -> Vec<u8> {
        let mut data = Vec::with_capacity(self.rows * self.cols);
        for row in 0..self.rows {
            let y = self.half[1] * (1.0 - (2 * row + 1) as f64 / self.rows as f64);
            for col in 0..self.cols {
                data.push(value(self.half[0] * ((2 * col + 1) as f64 / self.cols as f64 - 1.0), y));
            }
        }
        data
    }

    fn grey(&self, value: impl Fn(f64, f64) -> u8) -> Vec<u8> {
        self.encode(png::ColorType::Grayscale, &[], None, &self.map(value))
    }

    /// A picture in the colours of a palette, of which one may be transparent.
    fn indexed(&self, palette: &[Colour], clear: Option<u8>, index: impl Fn(f64, f64) -> u8) -> Vec<u8> {
        self.encode(png::ColorType::Indexed, palette, clear, &self.map(index))
    }

    fn encode(&self, kind: png::ColorType, palette: &[Colour], clear: Option<u8>, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.cols as u32, self.rows as u32);
        encoder.set_color(kind);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        if kind == png::ColorType::Indexed {
            encoder.set_palette(palette.concat());
            encoder.set_filter(png::Filter::NoFilter);
            if let Some(index) = clear {
                encoder.set_trns((0..=index).map(|k| if k == index { 0 } else { 255 }).collect::<Vec<u8>>());
            }
        } else {
            encoder.set_filter(png::Filter::Adaptive);
        }
        let written = encoder.write_header().and_then(|mut w| {
            w.write_image_data(data)?;
            w.finish()
        });
        written.expect("writing a whole image into memory does not fail");
        out
    }
}

/// Gradient at every node by differences over `k` nodes to each side, as far as there are so many.
fn gradients(h: &Heightfield, k: usize) -> Vec<[f64; 2]> {
    let mut out = Vec::with_capacity(h.rows() * h.cols());
    for row in 0..h.rows() {
        let (south, north) = (row.saturating_sub(k), (row + k).min(h.rows() - 1));
        for col in 0..h.cols() {
            let (west, east) = (col.saturating_sub(k), (col + k).min(h.cols() - 1));
            out.push([
                (h.node(row, east) - h.node(row, west)) / ((east - west) as f64 * h.resolution()),
                (h.node(north, col) - h.node(south, col)) / ((north - south) as f64 * h.resolution()),
            ]);
        }
    }
    out
}

/// The nodes' gradients at a point of the world, linear between them: the shading shows no facets.
fn interpolate(h: &Heightfield, gradients: &[[f64; 2]], x: f64, y: f64) -> [f64; 2] {
    let at = |v: f64, half: f64, n: usize| {
        let f = ((v + half) / h.resolution()).clamp(0.0, (n - 1) as f64);
        let k = (f as usize).min(n - 2);
        (k, f - k as f64)
    };
    let ((col, u), (row, v)) = (at(x, h.half_x(), h.cols()), at(y, h.half_y(), h.rows()));
    let i = row * h.cols() + col;
    let g = |k: usize| gradients[k];
    [0, 1].map(|axis| {
        let south = g(i)[axis] * (1.0 - u) + g(i + 1)[axis] * u;
        let north = g(i + h.cols())[axis] * (1.0 - u) + g(i + h.cols() + 1)[axis] * u;
        south * (1.0 - v) + north * v
    })
}

/// Lambert's law for the exaggerated surface, with some light from everywhere: level ground gets 200.
fn brightness(gradient: [f64; 2]) -> u8 {
    let [gx, gy] = gradient.map(|g| EXAGGERATION * g);
    let cosine = (SUN[2] - gx * SUN[0] - gy * SUN[1]) / (1.0 + gx * gx + gy * gy).sqrt();
    let light = 0.12 + 0.88 * cosine.max(0.0);
    // Quantised to 64 greys, which the eye does not tell apart on rough ground and which halves the picture.
    let grey = (200.0 * light / (0.12 + 0.88 * SUN[2])).min(255.0);
    ((grey / 4.0).round() * 4.0).min(255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_towards_the_sun_are_bright_and_those_away_from_it_dark() {
        let level = brightness([0.0, 0.0]);
        assert_eq!(level, 200);
        // The sun stands in the north-west: ground that falls north-westwards faces it.
        assert!(brightness([0.2, -0.2]) > level + 20 && brightness([-0.2, 0.2]) < level - 20);
        assert!(brightness([-3.0, 3.0]) > 0, "what the sun does not reach has light from the sky");
    }

    /// Rock in the south, and snow in the north.
    fn two_patches() -> World {
        let mut world = World::uniform("w001", Heightfield::flat(9, 5, 1.0, 0.0), TerrainClass::Clay, 0.5);
        world.semantics = vb_world::Semantics {
            rows: 2,
            cols: 1,
            patch: 4.0,
            classes: vec![TerrainClass::Rock, TerrainClass::Snow],
            friction: vec![0.5, 0.0],
            soil: vb_world::SoilLevels::default(),
        };
        world
    }

    #[test]
    fn pictures_have_the_north_in_their_first_row_and_the_west_in_their_first_column() {
        let Pictures([_, png, ..]) = pictures(&two_patches(), 64);
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut data = vec![0; 2];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!((info.height, info.width), (2, 1), "one pixel a patch");
        assert_eq!(data, [TerrainClass::Snow.label(), TerrainClass::Rock.label()]);
    }

    #[test]
    fn the_ground_has_the_colour_of_each_class_as_bright_as_level_ground_is() {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(ground(&two_patches(), 2)));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut data = vec![0; 6];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!((info.height, info.width), (2, 1));
        // Level ground has 200 of 255, which is 18.04 of 23 greys, and so 18.
        let lit = |class: TerrainClass| class.colour().map(|c| (f64::from(c) * 18.0 / 23.0).round() as u8);
        assert_eq!(data, [lit(TerrainClass::Snow), lit(TerrainClass::Rock)].concat());
    }

    #[test]
    fn a_scale_passes_through_its_colours() {
        assert_eq!(on_scale(&SLOPES, 0.0), SLOPES[0]);
        assert_eq!(on_scale(&SLOPES, 0.25), SLOPES[1]);
        assert_eq!(on_scale(&SLOPES, 7.0), SLOPES[4]);
        assert_eq!(on_scale(&[[0, 0, 0], [200, 100, 50]], 0.5), [100, 50, 25]);
    }
}
