//! Packings of grains in a bin: poured, settled and levelled.

use crate::{Bed, GRAVITY, Settings, V3};
use vb_math::rng::Stream;
use vb_world::GranularMaterial;

/// A bin with a rough floor at z = 0 and four smooth walls; its centre is above the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Along x, m.
    pub length: f64,
    /// Along y, m.
    pub width: f64,
    /// To which it is filled, m.
    pub depth: f64,
}

/// A grain at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// The centre, m.
    pub position: V3,
    /// m.
    pub radius: f64,
}

/// Grains that fill a bin to its depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    pub bin: Bin,
    pub grains: Vec<Grain>,
}

/// Why a bin can't be filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PackingError {
    #[error(
        "a bin of {length} m × {width} m × {depth} m has no room for grains of radius {radius} m: each side needs at least four radii"
    )]
    Small { length: f64, width: f64, depth: f64, radius: f64 },
    #[error(
        "about {grains} grains fill the bin; at most {} are possible (choose larger grains or a smaller bin)",
        Packing::MOST
    )]
    Many { grains: u64 },
}

/// Fraction of the volume that is expected to be filled, to know how many grains to pour: random packings of spheres lie between 0.55
/// (Jerkins et al., Phys. Rev. Lett. 101, 2008) and 0.64 (Scott, Nature 188, 1960).
const FILLED: f64 = 0.64;
/// More is poured than fits, and struck off.
const HEAPED: f64 = 1.1;
/// Least side of the tiles of which a large bin is filled, in mean diameters of the grains: in half of it the places of grains forget each
/// other (the radial distribution function of a random packing is flat beyond five diameters).
const TILE: f64 = 14.0;
/// Longest time in which grains come to rest, s: they fall from at most twice the depth.
const SETTLE: f64 = 3.0;
/// Kinetic energy of a grain at which it counts as at rest, over the energy that lifts it by its radius.
const REST: f64 = 1e-4;

impl Packing {
    /// Maximum number of grains of a bin.
    pub const MOST: u64 = 200_000;

    /// Pours grains into a bin, lets them come to rest, and strikes off what stands above the depth. A function of its arguments.
    ///
    /// # Errors
    /// Returns an error if the bin is too small or too large for the grains.
    pub fn poured(material: &GranularMaterial, bin: Bin, seed: u64) -> Result<Self, PackingError> {
        Self::filled(material, bin, seed, Settings::default(), false)
    }

    /// Fills a large bin with copies of a small tile, which is poured and repeats itself without a seam; grains that a wall
    /// would cut are left out. It takes no longer than the tile does. A function of its arguments; `settings` tells step and stiffness.
    /// [`Packing::MOST`] limits the grains of the tile, not of the bin.
    ///
    /// # Errors
    /// Returns an error if the tile is too small or too large for the grains.
    pub fn tiled(
        material: &GranularMaterial,
        bin: Bin,
        seed: u64,
        settings: Settings,
    ) -> Result<Self, PackingError> {
        let side = TILE * 2.0 * material.mean_radius();
        let count = |length: f64| (length / side).floor().max(1.0);
        let (columns, rows) = (count(bin.length), count(bin.width));
        let tile = Bin { length: bin.length / columns, width: bin.width / rows, depth: bin.depth };
        let poured = Self::filled(material, tile, seed, settings, true)?;
        let place = |k: f64, tile: f64, whole: f64| (k + 0.5) * tile - 0.5 * whole;
        let mut grains = Vec::new();
        for row in 0..rows as usize {
            for column in 0..columns as usize {
                let x = place(column as f64, tile.length, bin.length);
                let y = place(row as f64, tile.width, bin.width);
                let offset = V3::new(x, y, 0.0);
                grains.extend(
                    poured.grains.iter().map(|grain| Grain { position: grain.position + offset, ..*grain }),
                );
            }
        }
        grains.retain(|g| {
            g.position.x.abs() + g.radius <= 0.5 * bin.length
                && g.position.y.abs() + g.radius <= 0.5 * bin.width
        });
        Ok(Self { bin, grains })
    }

    /// Number of grains to pour into a bin, if it has room for them.
    fn room(material: &GranularMaterial, bin: Bin) -> Result<usize, PackingError> {
        let radius = material.radius[1];
        if [bin.length, bin.width, bin.depth].iter().any(|side| side.is_nan() || *side < 4.0 * radius) {
            return Err(PackingError::Small {
                length: bin.length,
                width: bin.width,
                depth: bin.depth,
                radius,
            });
        }
        let wanted = HEAPED * FILLED * bin.length * bin.width * bin.depth / material.mean_volume();
        if wanted > Self::MOST as f64 {
            return Err(PackingError::Many { grains: wanted as u64 });
        }
        Ok(wanted.ceil() as usize)
    }

    fn filled(
        material: &GranularMaterial,
        bin: Bin,
        seed: u64,
        settings: Settings,
        repeats: bool,
    ) -> Result<Self, PackingError> {
        let wanted = Self::room(material, bin)?;
        let loose = Self { bin, grains: lattice(material, bin, wanted, seed) };
        let left = 1.0 - material.compaction;
        let slippery = GranularMaterial {
            friction: material.friction * left,
            rolling_resistance: material.rolling_resistance * left,
            ..material.clone()
        };
        let mut poured = loose.settled(&slippery, settings, repeats);
        poured.grains.retain(|grain| grain.position.z + grain.radius <= bin.depth);
        Ok(poured.settled(&slippery, settings, repeats))
    }

    /// The grains at rest.
    fn settled(&self, material: &GranularMaterial, settings: Settings, repeats: bool) -> Self {
        let settings = Settings { reach: f64::INFINITY, ..settings };
        let mut bed = Bed::new(self, material, Vec::new(), settings);
        if repeats {
            bed = bed.periodic(self.bin);
        }
        let weight = material.density * material.mean_volume() * GRAVITY;
        let rest = REST * weight * material.mean_radius() * self.grains.len() as f64;
        let steps = (SETTLE / settings.step) as usize;
        // Grains that have just been let go don't move yet.
        let first = (0.1 / settings.step) as usize;
        for step in 0..steps {
            bed.step(&[]);
            if step > first && bed.kinetic_energy() < rest {
                break;
            }
        }
        Self { bin: self.bin, grains: bed.grains().collect() }
    }

    /// Volume of the grains below a height, over the volume of the bin up to it.
    #[must_use]
    pub fn fraction_below(&self, height: f64) -> f64 {
        let volume: f64 = self.grains.iter().map(|grain| volume_below(grain, height)).sum();
        volume / (self.bin.length * self.bin.width * height)
    }
}

/// Volume of the part of a sphere below a height, m³: a cap's, π h² (3 r − h)/3.
fn volume_below(grain: &Grain, height: f64) -> f64 {
    let r = grain.radius;
    let h = (height - (grain.position.z - r)).clamp(0.0, 2.0 * r);
    std::f64::consts::PI * h * h * (3.0 * r - h) / 3.0
}

/// Grains in the air, in layers, a little out of their places.
fn lattice(material: &GranularMaterial, bin: Bin, count: usize, seed: u64) -> Vec<Grain> {
    let mut stream = Stream::new(seed, &["granular", "packing"]);
    let [least, most] = material.radius;
    let along = |side: f64| ((side / (2.0 * most)) as usize).max(1);
    let (columns, rows) = (along(bin.length), along(bin.width));
    let (dx, dy, dz) = (bin.length / columns as f64, bin.width / rows as f64, 2.0 * most);
    (0..count)
        .map(|k| {
            let radius = least + (most - least) * stream.unit();
            let (layer, place) = (k / (columns * rows), k % (columns * rows));
            let (row, column) = (place / columns, place % columns);
            // Within its cell.
            let mut shift = |room: f64| (room - 2.0 * radius) * (stream.unit() - 0.5);
            let x = (column as f64 + 0.5) * dx - 0.5 * bin.length + shift(dx);
            let y = (row as f64 + 0.5) * dy - 0.5 * bin.width + shift(dy);
            let z = (layer as f64 + 0.5) * dz + shift(dz);
            Grain { position: V3::new(x, y, z), radius }
        })
        .collect()
}
