//! Suites of granular beds: level worlds with a bed in the gap of a wall, which two tasks cross.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use vb_files::document::within;
use vb_files::{Document, DocumentError, Flaw, Schema};
use vb_granular::MaterialFile;
use vb_math::rng::Stream;
use vb_world::{
    Density, Elevation, GranularBed, Heightfield, Obstacle, ObstacleKind, Provenance, Semantics, SoilLevels,
    SuiteMeta, Terrain, TerrainClass, World,
};

use crate::generate::{self, GenerateError, check_path, millimetres};
use crate::path::PathParams;
use crate::rules::{self, Square, flaw};

/// Version of this builder, which changes whenever the same inputs would give other worlds.
const VERSION: u32 = 1;
/// Clearance between an end of the wall and the bed or the edge of the world, m.
const APART: f64 = 0.1;

/// The rules of a suite of granular beds: `tasks/generator/granular.yaml` and files like it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GranularParams {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    pub name: String,
    pub ground: GroundParams,
    /// The beds, one for each world.
    pub beds: Vec<BedParams>,
    pub wall: WallParams,
    pub tasks: CrossingParams,
    pub path: PathParams,
}

/// The level, square, rigid ground around the beds.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundParams {
    /// The side of a world, m.
    pub side: f64,
    /// The node spacing, m.
    pub resolution: f64,
    /// The side of a patch, m.
    pub patch: f64,
    /// The rigid terrain class.
    pub class: TerrainClass,
    /// The friction coefficient.
    pub friction: f64,
}

/// A bed in the middle of a world.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BedParams {
    /// The granular material: the name of one in `tasks/soils/granular`, or a file.
    pub material: String,
    /// The size along x, m.
    pub length: f64,
    /// The size along y, m.
    pub width: f64,
    /// The height of the fill above the floor, m.
    pub depth: f64,
}

/// A wall along y, with a gap at the bed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallParams {
    /// The height of the wall, m.
    pub height: f64,
    /// The thickness of the wall, m.
    pub thickness: f64,
}

/// The tasks of a world, across the bed in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrossingParams {
    /// The distance between start and goal along x, m.
    pub distance: f64,
    /// The maximum offset of a start along y, m.
    pub offset: f64,
}

impl Default for GranularParams {
    /// `tasks/generator/granular.yaml`, which is part of the build.
    fn default() -> Self {
        rules::built_in(Self::DEFAULT_YAML)
    }
}

impl GranularParams {
    pub const DEFAULT_YAML: &'static str = include_str!("../../../../tasks/generator/granular.yaml");

    fn square(&self) -> Square {
        let GroundParams { side, resolution, patch, .. } = self.ground;
        Square { resolution, patch, side }
    }
}

impl Document for GranularParams {
    type File = Self;
    const KIND: &'static str = "rules";
    const FIELDS: &'static str = "docs/granular.md";

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.square().check("ground.")?;
        within("ground.side", rules.ground.side, 10.0, 500.0)?;
        let half = 0.5 * rules.ground.side;
        if rules.ground.class.is_deformable() {
            let problem = format!("{} is deformable: use a rigid class", rules.ground.class.name());
            return Err(flaw("ground.class", problem));
        }
        if !(1..=999).contains(&rules.beds.len()) {
            return Err(flaw("beds", "must have 1 to 999 entries"));
        }
        let GroundParams { side, .. } = rules.ground;
        for (k, bed) in rules.beds.iter().enumerate() {
            within(&format!("beds[{k}].length"), bed.length, 0.0, side)?;
            // The wall has to have two ends.
            within(&format!("beds[{k}].width"), bed.width, 0.0, 0.8 * side)?;
        }
        within("wall.height", rules.wall.height, 0.1, 100.0)?;
        within("wall.thickness", rules.wall.thickness, 0.1, 100.0)?;
        within("tasks.distance", rules.tasks.distance, 1.0, rules.ground.side)?;
        within("tasks.offset", rules.tasks.offset, 0.0, 0.25 * rules.ground.side)?;
        check_path("path", &rules.path, half)?;
        Ok(rules)
    }
}

vb_files::document!(GranularParams);

/// The things that a suite of granular beds follows from.
#[derive(Clone, Debug)]
pub struct GranularSuite<'a> {
    rules: &'a GranularParams,
    /// The material of each bed, in the order of the rules.
    materials: Vec<MaterialFile>,
    seed: u64,
}

impl<'a> GranularSuite<'a> {
    /// Reads the materials. `file` is that of the rules, beside which files of materials lie; `None` for the built-in rules.
    ///
    /// # Errors
    /// Returns an error if a material can't be read.
    pub fn new(rules: &'a GranularParams, file: Option<&Path>, seed: u64) -> Result<Self, DocumentError> {
        let materials = rules.beds.iter().map(|bed| {
            let beside = file.and_then(Path::parent).map(|folder| folder.join(&bed.material));
            match beside.filter(|path: &PathBuf| path.is_file()) {
                Some(path) => MaterialFile::load(&path),
                None => MaterialFile::resolve(&bed.material),
            }
        });
        Ok(Self { rules, materials: materials.collect::<Result<_, _>>()?, seed })
    }

    #[must_use]
    pub fn meta(&self, name: &str, version: &str) -> SuiteMeta {
        SuiteMeta {
            name: name.into(),
            version: version.into(),
            description: format!("{} granular beds, which two tasks each cross.", self.rules.beds.len()),
            provenance: Provenance::Generated {
                generator: format!("granular {VERSION}, rules {}", self.rules.name),
                seed: self.seed,
            },
        }
    }

    /// Makes the worlds in the order of the beds: `w001` and so on.
    ///
    /// # Errors
    /// Returns an error if a bed doesn't fit or the wall leaves no way.
    pub fn worlds(&self) -> Result<Vec<World>, GenerateError> {
        self.rules.beds.iter().zip(&self.materials).enumerate().map(|(k, bed)| self.world(k, bed)).collect()
    }

    fn world(
        &self,
        index: usize,
        (bed, material): (&BedParams, &MaterialFile),
    ) -> Result<World, GenerateError> {
        let rules = self.rules;
        let id = format!("w{:03}", index + 1);
        let mut rng = Stream::new(self.seed, &["granular", &id]);
        let half = 0.5 * rules.ground.side;
        let bed = GranularBed {
            name: material.name.clone(),
            material: material.grains.clone(),
            x: 0.0,
            y: 0.0,
            length: bed.length,
            width: bed.width,
            depth: bed.depth,
            seed: rng.below(1 << 32),
        };
        let nodes = rules.square().nodes();
        let reach = half - APART - (0.5 * bed.width + APART);
        let wall = |side: f64| {
            let WallParams { height, thickness } = rules.wall;
            let kind = ObstacleKind::Box { size: [thickness, millimetres(reach), height] };
            let y = millimetres(side * (half - APART - 0.5 * reach));
            Obstacle { x: 0.0, y, yaw: 0.0, buried: 0.0, kind }
        };
        let is_mixed = bed.material.class.is_deformable();
        let mut world = World {
            elevation: Elevation::Low,
            terrain: if is_mixed { Terrain::Mixed } else { Terrain::Rigid },
            density: Density::Sparse,
            scale: 1.0,
            heightfield: Heightfield::flat(nodes, nodes, rules.ground.resolution, 0.0),
            semantics: self.cover(&bed),
            obstacles: vec![wall(-1.0), wall(1.0)],
            tasks: Vec::new(),
            beds: vec![bed],
            id: id.clone(),
        };
        world.check().map_err(|flaw| GenerateError::World { world: id, flaw })?;
        let x = 0.5 * rules.tasks.distance;
        let mut offset = || millimetres(rng.uniform(-rules.tasks.offset, rules.tasks.offset));
        let ends = [[[-x, offset()], [x, 0.0]], [[x, offset()], [-x, 0.0]]];
        generate::plan_tasks(&mut world, &rules.path, &ends)?;
        Ok(world)
    }

    /// Patches of the material within the bed and of the ground around it. The friction of rigid patches within the bed is that between
    /// its grains, for planners; their forces come from the grains.
    fn cover(&self, bed: &GranularBed) -> Semantics {
        let GroundParams { patch, class, friction, .. } = self.rules.ground;
        let n = self.rules.square().patches();
        let centre = |k: usize| (k as f64 + 0.5 - 0.5 * n as f64) * patch;
        let within = |k: usize| bed.contains(centre(k % n), centre(k / n));
        let grip =
            if bed.material.class.is_deformable() { 0.0 } else { bed.material.friction.clamp(0.01, 2.0) };
        Semantics {
            rows: n,
            cols: n,
            patch,
            classes: (0..n * n).map(|k| if within(k) { bed.material.class } else { class }).collect(),
            friction: (0..n * n).map(|k| if within(k) { grip } else { friction }).collect(),
            soil: SoilLevels::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_suite_has_ten_tasks_over_beds_of_gravel_and_sand() {
        let rules = GranularParams::default();
        let suite = GranularSuite::new(&rules, None, 5).unwrap();
        let worlds = suite.worlds().unwrap();
        assert_eq!(worlds, GranularSuite::new(&rules, None, 5).unwrap().worlds().unwrap());
        assert_ne!(worlds, GranularSuite::new(&rules, None, 6).unwrap().worlds().unwrap());
        assert_eq!(worlds.iter().map(|w| w.tasks.len()).sum::<usize>(), 10);
        for world in &worlds {
            world.check().unwrap();
            // Every path leads over the bed, and both starts are on the ground around it.
            for task in &world.tasks {
                assert!(task.path.iter().any(|p| world.bed_at(p[0], p[1]).is_some()), "{}", world.id);
                assert_eq!(world.bed_at(task.start.x, task.start.y), None);
            }
        }
        let classes: Vec<_> = worlds.iter().map(|w| w.class_at(0.0, 0.0).name()).collect();
        assert_eq!(classes, ["gravel", "gravel", "gravel", "sand", "sand"]);
    }

    #[test]
    fn flaws_of_a_file_are_named() {
        let cases = [
            ("side: 48.0", "side: 48.5", "ground.side: 48.5 must be a multiple of ground.patch, 1"),
            ("class: dirt", "class: snow", "ground.class: snow is deformable: use a rigid class"),
            ("width: 8.0", "width: 47.0", "beds[0].width: 47 must lie in"),
            ("distance: 40.0", "distance: 60.0", "tasks.distance: 60 must lie in"),
            ("height: 1.5", "height: 0.0", "wall.height: 0 must lie in"),
            ("clearance: 3.5", "clearance: -2.0", "path.clearance: -2 must lie in"),
        ];
        for (from, to, expected) in cases {
            assert!(GranularParams::DEFAULT_YAML.contains(from), "{from}");
            let text = GranularParams::DEFAULT_YAML.replacen(from, to, 1);
            let message = GranularParams::parse(&text, "mine.yaml").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\nlacks {expected}");
        }
        let text = GranularParams::DEFAULT_YAML.replacen("material: gravel", "material: lava", 1);
        let rules = GranularParams::parse(&text, "mine.yaml").unwrap();
        let message = GranularSuite::new(&rules, None, 1).unwrap_err().to_string();
        assert!(message.contains("lava") && message.contains("gravel"), "{message}");
        let text = GranularParams::DEFAULT_YAML.replacen("length: 10.0", "length: 11.0", 1);
        let rules = GranularParams::parse(&text, "mine.yaml").unwrap();
        let message = GranularSuite::new(&rules, None, 1).unwrap().worlds().unwrap_err().to_string();
        assert!(message.contains("w001: beds.yaml: beds[0]: its edges"), "{message}");
    }
}
