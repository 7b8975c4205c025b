//! The documents of a world's folder: their fields, how they are written, what they mean.

use super::{SCHEMA, error::SuiteError, text};
use crate::check::{Flaw, MAX_SIDE, Part};
use crate::{
    Density, Elevation, GranularBed, GranularMaterial, Obstacle, ObstacleKind, Semantics, SoilLevels, Task,
    Terrain, TerrainClass, World,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Only the version, read first: a document of another version need not have our fields.
#[derive(Deserialize)]
pub(crate) struct SchemaOnly {
    schema: u32,
}

/// Refuses a document of another version.
pub(crate) fn check_schema(file: &Path, yaml: &str) -> Result<(), SuiteError> {
    let found = text::parse::<SchemaOnly>(file, yaml)?.schema;
    if found == SCHEMA { Ok(()) } else { Err(SuiteError::Schema { file: file.into(), found }) }
}

/// The identity of a world and the grid of its elevation raster.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WorldDocument {
    #[serde(rename = "schema")]
    _schema: u32,
    /// The name of the world and of its folder.
    pub(crate) id: String,
    /// The elevation level.
    pub(crate) elevation: Elevation,
    /// The terrain type.
    pub(crate) terrain: Terrain,
    /// The obstacle density.
    pub(crate) density: Density,
    /// The units of the file, always m and rad.
    #[serde(rename = "units")]
    _units: Units,
    /// The elevation raster.
    pub(crate) grid: Grid,
}

/// The units of all numbers.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Units {
    /// Lengths are in metres.
    #[serde(rename = "length")]
    _length: Metre,
    /// Angles are in radians.
    #[serde(rename = "angle")]
    _angle: Radian,
}

/// The unit of length.
#[derive(Deserialize)]
enum Metre {
    /// The metre.
    #[serde(rename = "m")]
    Metre,
}

/// The unit of angles.
#[derive(Deserialize)]
enum Radian {
    /// The radian.
    #[serde(rename = "rad")]
    Radian,
}

/// The elevation raster.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Grid {
    /// Nodes along y (north), 2 to 8193.
    pub(crate) rows: usize,
    /// Nodes along x (east), 2 to 8193.
    pub(crate) cols: usize,
    /// Distance between nodes, m.
    #[serde(rename = "pitch")]
    pub(crate) resolution: f64,
    /// Heights of the levels 0 and 65535 of `elevation.png`, m.
    pub(crate) height_range: [f64; 2],
}

impl WorldDocument {
    pub(crate) fn write(world: &World, range: [f64; 2]) -> String {
        let h = &world.heightfield;
        format!(
            "schema: {SCHEMA}\nid: {}\nelevation: {}\nterrain: {}\ndensity: {}\nunits: {{length: m, angle: rad}}\n\
             # Nodes of the surface; height_range is what the levels 0 and 65535 of elevation.png stand for.\n\
             grid: {{rows: {}, cols: {}, pitch: {}, height_range: {}}}\n",
            world.id,
            world.elevation.name(),
            world.terrain.name(),
            world.density.name(),
            h.rows(),
            h.cols(),
            text::number(h.resolution()),
            text::numbers(&range),
        )
    }

    pub(crate) fn check(&self) -> Result<(), Flaw> {
        let flaw = |field: &str, problem| Err(Flaw::new(Part::World, field, problem));
        let grid = &self.grid;
        for (name, n) in [("grid.rows", grid.rows), ("grid.cols", grid.cols)] {
            if !(2..=MAX_SIDE).contains(&n) {
                return flaw(name, format!("{n} must lie in 2 to {MAX_SIDE}"));
            }
        }
        if !(grid.resolution.is_finite() && grid.resolution > 0.0) {
            return flaw("grid.pitch", format!("{} must be a positive length in metres", grid.resolution));
        }
        let [low, high] = grid.height_range;
        if !(low >= LOWEST && high <= HIGHEST && low <= high) {
            return flaw(
                "grid.height_range",
                format!(
                    "[{low}, {high}] must be two heights in metres from {LOWEST} to {HIGHEST}, lower first"
                ),
            );
        }
        Ok(())
    }
}

/// The deepest trench of the oceans and the highest mountain, with some room, m: what is beyond is no ground.
const LOWEST: f64 = -12_000.0;
const HIGHEST: f64 = 12_000.0;

/// The letter of each class in `semantics.yaml`, in label order; capitals yield under a wheel.
const LETTERS: [char; 10] = ['c', 'k', 'd', 'g', 'v', 'r', 'w', 'M', 'S', 'F'];

/// Terrain class, friction and soil level of every patch of a world.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SemanticsDocument {
    /// Side of a square patch, m.
    patch: f64,
    /// Patches along y (north).
    rows: usize,
    /// Patches along x (east).
    cols: usize,
    /// The terrain class of each letter in `classes`.
    legend: BTreeMap<char, TerrainClass>,
    /// A text per row of patches, northernmost first, with a letter per patch, westernmost first.
    classes: Vec<String>,
    /// Coulomb friction coefficient of each patch in the order of `classes`; 0 on deformable classes.
    friction: Vec<Vec<f64>>,
    /// Level of each deformable class of the world; none on rigid worlds.
    #[serde(default)]
    soil: SoilLevels,
}

impl SemanticsDocument {
    pub(crate) fn write(s: &Semantics) -> String {
        let legend: Vec<_> = TerrainClass::ALL
            .iter()
            .filter(|c| s.classes.contains(c))
            .map(|c| format!("{}: {}", LETTERS[usize::from(c.label())], c.name()))
            .collect();
        let mut out = format!("patch: {}\nrows: {}\ncols: {}\n", text::number(s.patch), s.rows, s.cols);
        let _ = write!(
            out,
            "legend: {{{}}}\n# As seen from above: north row first.\nclasses:\n",
            legend.join(", ")
        );
        for row in s.classes.chunks(s.cols).rev() {
            let letters: String = row.iter().map(|c| LETTERS[usize::from(c.label())]).collect();
            let _ = writeln!(out, "  - {}", text::quoted(&letters));
        }
        out.push_str(
            "# Coulomb coefficient of each patch, in the same order; 0 where the ground yields.\nfriction:\n",
        );
        for row in s.friction.chunks(s.cols).rev() {
            let _ = writeln!(out, "  - {}", text::numbers(row));
        }
        let levels: Vec<_> = TerrainClass::ALL
            .iter()
            .filter(|c| s.classes.contains(c))
            .filter_map(|c| Some(format!("{}: {}", c.name(), s.soil.of(*c)?.name())))
            .collect();
        if !levels.is_empty() {
            let _ = writeln!(
                out,
                "# Level of each deformable class: soft, medium or hard.\nsoil: {{{}}}",
                levels.join(", ")
            );
        }
        out
    }

    pub(crate) fn into_semantics(self) -> Result<Semantics, Flaw> {
        let flaw = |field: String, problem| Err(Flaw::new(Part::Semantics, field, problem));
        let (rows, cols) = (self.rows, self.cols);
        if !self.patch.is_finite() {
            return flaw("patch".into(), format!("{} is not a finite length in metres", self.patch));
        }
        for (name, found) in [("classes", self.classes.len()), ("friction", self.friction.len())] {
            if found != rows {
                return flaw(name.into(), format!("{found} rows, but rows is {rows}: they must agree"));
            }
        }
        let mut classes = Vec::new();
        let mut friction = Vec::new();
        for i in (0..rows).rev() {
            let letters = &self.classes[i];
            let found = letters.chars().count();
            if found != cols {
                return flaw(
                    format!("classes[{i}]"),
                    format!("{letters:?} has {found} letters, but cols is {cols}"),
                );
            }
            for c in letters.chars() {
                let Some(&class) = self.legend.get(&c) else {
                    return flaw(
                        format!("classes[{i}]"),
                        format!("letter {c:?} does not stand in the legend: add it there"),
                    );
                };
                classes.push(class);
            }
            let found = self.friction[i].len();
            if found != cols {
                return flaw(
                    format!("friction[{i}]"),
                    format!("{found} values, but cols is {cols}: they must agree"),
                );
            }
            friction.extend(&self.friction[i]);
        }
        Ok(Semantics { rows, cols, patch: self.patch, classes, friction, soil: self.soil })
    }
}

/// The obstacles of a world.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObstaclesDocument {
    /// The obstacles, in the order of their indices.
    obstacles: Vec<ObstacleEntry>,
}

/// An obstacle.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObstacleEntry {
    /// The shape.
    kind: KindName,
    /// East of the world's centre, m.
    x: f64,
    /// North of the world's centre, m.
    y: f64,
    /// Angle about z from east, rad.
    yaw: f64,
    /// Depth of the base below the ground at (x, y), m; negative above it.
    buried: f64,
    /// Extents along its own x, y and z, m (boulder and box).
    size: Option<[f64; 3]>,
    /// Random seed of the shape (boulder).
    seed: Option<u64>,
    /// Radius, m (trunk).
    radius: Option<f64>,
    /// Height, m (trunk).
    height: Option<f64>,
}

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindName {
    /// A convex boulder.
    Boulder,
    /// A cuboid.
    Box,
    /// An upright cylinder.
    Trunk,
}

impl ObstaclesDocument {
    pub(crate) fn write(obstacles: &[Obstacle]) -> String {
        if obstacles.is_empty() {
            return "obstacles: []\n".into();
        }
        let mut out = String::from("obstacles:\n");
        for o in obstacles {
            let (kind, shape) = match o.kind {
                ObstacleKind::Boulder { size, seed } => {
                    ("boulder", format!("size: {}, seed: {seed}", text::numbers(&size)))
                }
                ObstacleKind::Box { size } => ("box", format!("size: {}", text::numbers(&size))),
                ObstacleKind::Trunk { radius, height } => {
                    ("trunk", format!("radius: {}, height: {}", text::number(radius), text::number(height)))
                }
            };
            let [x, y, yaw, buried] = [o.x, o.y, o.yaw, o.buried].map(text::number);
            let _ =
                writeln!(out, "  - {{kind: {kind}, x: {x}, y: {y}, yaw: {yaw}, buried: {buried}, {shape}}}");
        }
        out
    }

    pub(crate) fn into_obstacles(self) -> Result<Vec<Obstacle>, Flaw> {
        self.obstacles.into_iter().enumerate().map(|(k, e)| e.into_obstacle(k)).collect()
    }
}

impl ObstacleEntry {
    fn into_obstacle(self, k: usize) -> Result<Obstacle, Flaw> {
        let name = match self.kind {
            KindName::Boulder => "boulder",
            KindName::Box => "box",
            KindName::Trunk => "trunk",
        };
        let flaw =
            |field: &str, problem| Flaw::new(Part::Obstacles, format!("obstacles[{k}].{field}"), problem);
        let missing = |field: &str| flaw(field, format!("is missing: a {name} needs it"));
        let (size, seed, radius, height) = (
            self.size.ok_or_else(|| missing("size")),
            self.seed.ok_or_else(|| missing("seed")),
            self.radius.ok_or_else(|| missing("radius")),
            self.height.ok_or_else(|| missing("height")),
        );
        let has = [
            ("size", size.is_ok()),
            ("seed", seed.is_ok()),
            ("radius", radius.is_ok()),
            ("height", height.is_ok()),
        ];
        let (kind, wanted): (_, &[&str]) = match self.kind {
            KindName::Boulder => (ObstacleKind::Boulder { size: size?, seed: seed? }, &["size", "seed"]),
            KindName::Box => (ObstacleKind::Box { size: size? }, &["size"]),
            KindName::Trunk => {
                (ObstacleKind::Trunk { radius: radius?, height: height? }, &["radius", "height"])
            }
        };
        if let Some((field, _)) = has.iter().find(|(field, given)| *given && !wanted.contains(field)) {
            return Err(flaw(field, format!("does not belong to a {name}: remove it")));
        }
        Ok(Obstacle { x: self.x, y: self.y, yaw: self.yaw, buried: self.buried, kind })
    }
}

/// The tasks of a world.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TasksDocument {
    /// The tasks, in the order in which they are run.
    pub(crate) tasks: Vec<Task>,
}

/// Waypoints on a line of `tasks.yaml`.
const WAYPOINTS_A_LINE: usize = 6;

impl TasksDocument {
    pub(crate) fn write(tasks: &[Task]) -> String {
        if tasks.is_empty() {
            return "tasks: []\n".into();
        }
        let mut out = String::from("tasks:\n");
        for t in tasks {
            let [x, y, yaw] = [t.start.x, t.start.y, t.start.yaw].map(text::number);
            let lines: Vec<_> = t
                .path
                .chunks(WAYPOINTS_A_LINE)
                .map(|line| line.iter().map(|p| text::numbers(p)).collect::<Vec<_>>().join(", "))
                .collect();
            let _ = writeln!(
                out,
                "  - id: {}\n    start: {{x: {x}, y: {y}, yaw: {yaw}}}\n    goal: {}\n    path: [\n      {}]",
                t.id,
                text::numbers(&t.goal),
                lines.join(",\n      "),
            );
        }
        out
    }
}

/// The granular beds of a world and their materials.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BedsDocument {
    /// Materials by the names that beds use.
    materials: BTreeMap<String, GranularMaterial>,
    /// The beds.
    beds: Vec<BedEntry>,
}

/// A bed: a pit with sides along x and y, filled with grains up to the ground.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BedEntry {
    /// The name of a material in `materials`.
    material: String,
    /// Centre, m east of the world's centre.
    x: f64,
    /// Centre, m north of the world's centre.
    y: f64,
    /// Extent along x, m.
    length: f64,
    /// Extent along y, m.
    width: f64,
    /// Depth of the pit, m.
    depth: f64,
    /// Random seed of the grains.
    seed: u64,
}

impl BedsDocument {
    /// The text; empty without beds, since such a world has no file of them.
    pub(crate) fn write(beds: &[GranularBed]) -> String {
        if beds.is_empty() {
            return String::new();
        }
        let materials: BTreeMap<&str, &GranularMaterial> =
            beds.iter().map(|bed| (bed.name.as_str(), &bed.material)).collect();
        let mut out = String::from("# Grains: radii in m, density in kg/m3, cohesion in Pa.\nmaterials:\n");
        for (name, m) in materials {
            let [density, friction, rolling, cohesion, compaction] =
                [m.density, m.friction, m.rolling_resistance, m.cohesion, m.compaction].map(text::number);
            let _ = writeln!(
                out,
                "  {name}: {{class: {}, radius: {}, density: {density}, friction: {friction}, rolling_resistance: {rolling}, \
                 cohesion: {cohesion}, compaction: {compaction}}}",
                m.class.name(),
                text::numbers(&m.radius),
            );
        }
        out.push_str("# Pits along the axes, around their centres, filled up to the ground.\nbeds:\n");
        for bed in beds {
            let [x, y, length, width, depth] =
                [bed.x, bed.y, bed.length, bed.width, bed.depth].map(text::number);
            let _ = writeln!(
                out,
                "  - {{material: {}, x: {x}, y: {y}, length: {length}, width: {width}, depth: {depth}, seed: {}}}",
                bed.name, bed.seed
            );
        }
        out
    }

    pub(crate) fn into_beds(self) -> Result<Vec<GranularBed>, Flaw> {
        for (name, material) in &self.materials {
            crate::check::check_id(name)
                .map_err(|problem| Flaw::new(Part::Beds, format!("materials.{name}"), problem))?;
            material.check().map_err(|flaw| {
                Flaw::new(Part::Beds, format!("materials.{name}.{}", flaw.field), flaw.problem)
            })?;
        }
        if self.beds.is_empty() {
            return Err(Flaw::new(Part::Beds, "beds", "is empty: remove the file of a world without beds"));
        }
        let names = || self.materials.keys().cloned().collect::<Vec<_>>().join(", ");
        let bed = |(k, entry): (usize, &BedEntry)| {
            let material = self.materials.get(&entry.material).ok_or_else(|| {
                let problem = format!("{:?} is none of the materials: {}", entry.material, names());
                Flaw::new(Part::Beds, format!("beds[{k}].material"), problem)
            })?;
            Ok(GranularBed {
                name: entry.material.clone(),
                material: material.clone(),
                x: entry.x,
                y: entry.y,
                length: entry.length,
                width: entry.width,
                depth: entry.depth,
                seed: entry.seed,
            })
        };
        self.beds.iter().enumerate().map(bed).collect()
    }
}
