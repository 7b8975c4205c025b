//! Granular beds: pits that are filled with grains up to the ground around them.

use crate::{Flaw, Part, TerrainClass, World, geometry};
use std::f64::consts::PI;
use vb_files::document::{pair_within, within};

/// A granular material: the parameters of its grains.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GranularMaterial {
    /// The terrain class that planners and sensors see.
    pub class: TerrainClass,
    /// The minimum and maximum radius of the grains, m. Radii are distributed uniformly between them.
    pub radius: [f64; 2],
    /// The density of a grain, kg/m³.
    pub density: f64,
    /// The friction coefficient between grains.
    pub friction: f64,
    /// The maximum moment of rolling resistance, over normal force and reduced radius of the contact: by it spheres resist rolling as
    /// angular grains do.
    pub rolling_resistance: f64,
    /// The attraction of two grains that touch, over the cross-section of the smaller one, Pa.
    #[serde(default)]
    pub cohesion: f64,
    /// Reduction of friction and rolling resistance while the bed is filled, from 0 (loose) to 1 (as dense as without friction).
    #[serde(default)]
    pub compaction: f64,
}

impl GranularMaterial {
    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// Returns the first flaw.
    pub fn check(&self) -> Result<(), vb_files::Flaw> {
        // Smaller grains need smaller steps and far more of them than memory holds.
        pair_within("radius", self.radius, 0.005, 0.5)?;
        within("radius[1]", self.radius[1], self.radius[0], 3.0 * self.radius[0])?;
        within("density", self.density, 100.0, 20_000.0)?;
        within("friction", self.friction, 0.0, 2.0)?;
        within("rolling_resistance", self.rolling_resistance, 0.0, 2.0)?;
        within("cohesion", self.cohesion, 0.0, 1e5)?;
        within("compaction", self.compaction, 0.0, 1.0)
    }

    /// The mass of a grain of a radius (m), kg.
    #[must_use]
    pub fn mass(&self, radius: f64) -> f64 {
        self.density * 4.0 / 3.0 * PI * radius * radius * radius
    }

    /// The mean volume of a grain, m³: radii are uniform between the minimum a and the maximum b, so the mean cube is
    /// (a + b)(a² + b²)/4.
    #[must_use]
    pub fn mean_volume(&self) -> f64 {
        let [a, b] = self.radius;
        4.0 / 3.0 * PI * (a + b) * (a * a + b * b) / 4.0
    }

    /// The mean radius, m.
    #[must_use]
    pub fn mean_radius(&self) -> f64 {
        0.5 * (self.radius[0] + self.radius[1])
    }
}

/// A granular bed: a rectangular pit with a rough floor and smooth vertical walls, filled to the level of the ground around it.
#[derive(Clone, Debug, PartialEq)]
pub struct GranularBed {
    /// The name of the material in the world's files.
    pub name: String,
    /// The material.
    pub material: GranularMaterial,
    /// The position of the centre along x (east), m.
    pub x: f64,
    /// The position of the centre along y (north), m.
    pub y: f64,
    /// The size along x, m.
    pub length: f64,
    /// The size along y, m.
    pub width: f64,
    /// The height of the fill above the floor, m.
    pub depth: f64,
    /// The seed of the grains' sizes and places.
    pub seed: u64,
}

/// Fraction of the volume that grains fill, at most: random packings of spheres lie between 0.55 (Jerkins et al., Phys. Rev. Lett. 101,
/// 2008) and 0.64 (Scott and Kilgour, J. Phys. D 2, 1969).
const FILLED: f64 = 0.64;
/// Maximum difference between the heights of the ground over a bed, m at scale 1.
const LEVEL: f64 = 0.01;
/// Tolerance of the edges of a bed on the borders of patches, in patches.
const ALIGNED: f64 = 1e-6;
/// Minimum sides of a bed, in maximum radii of its grains: fewer grains are no bulk material.
const SIDES: f64 = 8.0;
/// Minimum depth of a bed, in maximum radii of its grains.
const DEEP: f64 = 4.0;

impl GranularBed {
    /// The maximum number of grains in all beds of a world, which limits the memory of a simulation.
    pub const MOST_GRAINS: u64 = 200_000;

    /// About how many grains fill the bed.
    #[must_use]
    pub fn grains(&self) -> f64 {
        FILLED * self.length * self.width * self.depth / self.material.mean_volume()
    }

    /// Its south-west and north-east corners, m.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 2] {
        let (a, b) = (0.5 * self.length, 0.5 * self.width);
        [[self.x - a, self.y - b], [self.x + a, self.y + b]]
    }

    /// Tells whether a place lies in the bed.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        (x - self.x).abs() <= 0.5 * self.length && (y - self.y).abs() <= 0.5 * self.width
    }

    /// The same bed with every length multiplied by `s`, that of the grains included. Attraction keeps its proportion to weight.
    #[must_use]
    pub(crate) fn scaled(&self, s: f64) -> Self {
        let material = &self.material;
        Self {
            name: self.name.clone(),
            material: GranularMaterial {
                radius: material.radius.map(|r| r * s),
                cohesion: material.cohesion * s,
                ..material.clone()
            },
            x: self.x * s,
            y: self.y * s,
            length: self.length * s,
            width: self.width * s,
            depth: self.depth * s,
            seed: self.seed,
        }
    }
}

impl World {
    /// Checks all granular beds.
    pub(crate) fn check_beds(&self) -> Result<(), Flaw> {
        for (k, bed) in self.beds.iter().enumerate() {
            self.check_bed(k, bed)?;
        }
        let grains: f64 = self.beds.iter().map(GranularBed::grains).sum();
        if grains > GranularBed::MOST_GRAINS as f64 {
            return Err(Flaw::new(
                Part::Beds,
                "beds",
                format!(
                    "about {grains:.0} grains fill them; {} are possible (larger grains or smaller beds)",
                    GranularBed::MOST_GRAINS
                ),
            ));
        }
        Ok(())
    }

    fn check_bed(&self, k: usize, bed: &GranularBed) -> Result<(), Flaw> {
        let flaw = |field: &str, problem| Err(Flaw::new(Part::Beds, format!("beds[{k}]{field}"), problem));
        crate::check::check_id(&bed.name)
            .map_err(|problem| Flaw::new(Part::Beds, format!("beds[{k}].material"), problem))?;
        let largest = bed.material.radius[1];
        for (field, side, least) in
            [(".length", bed.length, SIDES), (".width", bed.width, SIDES), (".depth", bed.depth, DEEP)]
        {
            let least = least * largest;
            if !(side.is_finite() && side >= least) {
                let diameter = 2.0 * largest;
                let problem = format!("{side} m must be at least {least} m for grains of up to {diameter} m");
                return flaw(field, problem);
            }
        }
        let corners = bed.corners();
        if !corners.iter().all(|[x, y]| x.is_finite() && y.is_finite() && self.heightfield.contains(*x, *y)) {
            let [low, high] = corners;
            return flaw("", format!("the bed from {low:?} to {high:?} {}", self.outside()));
        }
        self.check_patches_of_bed(k, bed)?;
        let (low, high) = self.heights_over(bed);
        if high - low > LEVEL * self.scale {
            let problem = format!(
                "the ground over the bed rises from {low} to {high} m: it must be level within {LEVEL} m"
            );
            return flaw("", problem);
        }
        let [[west, south], [east, north]] = corners;
        let overlaps = |other: &GranularBed| {
            let [[w, s], [e, n]] = other.corners();
            west < e && w < east && south < n && s < north
        };
        if let Some(other) = self.beds[..k].iter().position(overlaps) {
            return flaw("", format!("overlaps beds[{other}]: each place has one fill"));
        }
        let outline = [[west, south], [east, south], [east, north], [west, north]];
        let stands = |o: &crate::Obstacle| {
            let footprint = o.footprint();
            let crosses =
                |k: usize| geometry::segment_to_polygon(outline[k], outline[(k + 1) % 4], &footprint) <= 0.0;
            footprint.iter().any(|p| bed.contains(p[0], p[1])) || (0..4).any(crosses)
        };
        if let Some(obstacle) = self.obstacles.iter().position(stands) {
            return flaw("", format!("obstacles[{obstacle}] stands in it: move one of them"));
        }
        Ok(())
    }

    /// The lowest and the highest ground over a bed, m.
    fn heights_over(&self, bed: &GranularBed) -> (f64, f64) {
        let [low, high] = bed.corners();
        let step = 0.5 * self.heightfield.resolution();
        let places = |from: f64, to: f64| {
            let count = ((to - from) / step).ceil().max(1.0) as usize;
            (0..=count).map(move |k| from + (to - from) * k as f64 / count as f64)
        };
        let heights = places(low[1], high[1])
            .flat_map(|y| places(low[0], high[0]).map(move |x| self.heightfield.height(x, y)));
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)))
    }

    /// The edges of a bed lie on borders of patches, and all its patches are of its material's class.
    fn check_patches_of_bed(&self, k: usize, bed: &GranularBed) -> Result<(), Flaw> {
        let s = &self.semantics;
        let [low, high] = bed.corners();
        let column = |x: f64| x / s.patch + 0.5 * s.cols as f64;
        let row = |y: f64| y / s.patch + 0.5 * s.rows as f64;
        let edges = [column(low[0]), column(high[0]), row(low[1]), row(high[1])];
        if edges.iter().any(|edge| (edge - edge.round()).abs() > ALIGNED) {
            return Err(Flaw::new(
                Part::Beds,
                format!("beds[{k}]"),
                format!(
                    "its edges, from {low:?} to {high:?}, must lie on borders of the patches of semantics.yaml, of {} m",
                    s.patch
                ),
            ));
        }
        let [left, right, bottom, top] = edges.map(|edge| edge.round() as usize);
        for row in bottom..top {
            for col in left..right {
                let class = s.classes[row * s.cols + col];
                if class != bed.material.class {
                    let problem = format!(
                        "the patch in row {row}, column {col} from the south-west is {}, but the material {} has the class {}",
                        class.name(),
                        bed.name,
                        bed.material.class.name()
                    );
                    return Err(Flaw::new(Part::Beds, format!("beds[{k}].material"), problem));
                }
            }
        }
        Ok(())
    }
}
