//! The generator's rules as data: `tasks/generator/default.yaml` and files like it.

use crate::path::PathParams;
use crate::rules::{self, MOST_NODES, flaw};
use serde::Deserialize;
use vb_files::document::{pair_within, within};
use vb_files::{Document, Flaw, Schema};
use vb_terrain::{Model, ShapeParams, Shaping};
use vb_world::{Density, Elevation, Terrain, TerrainClass};

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByElevation {
    /// The value at low elevation.
    pub low: f64,
    /// The value at medium elevation.
    pub medium: f64,
    /// The value at high elevation.
    pub high: f64,
}

impl ByElevation {
    #[must_use]
    pub fn get(&self, level: Elevation) -> f64 {
        match level {
            Elevation::Low => self.low,
            Elevation::Medium => self.medium,
            Elevation::High => self.high,
        }
    }
}

impl ByElevation {
    pub fn set(&mut self, level: Elevation, value: f64) {
        match level {
            Elevation::Low => self.low = value,
            Elevation::Medium => self.medium = value,
            Elevation::High => self.high = value,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByDensity {
    /// The number in sparse worlds.
    pub sparse: usize,
    /// The number in medium worlds.
    pub medium: usize,
    /// The number in dense worlds.
    pub dense: usize,
}

impl ByDensity {
    /// The numbers for an area that is larger or smaller by a factor.
    #[cfg(feature = "site")]
    fn times(self, factor: f64) -> Self {
        let times = |n: usize| (n as f64 * factor).round() as usize;
        Self { sparse: times(self.sparse), medium: times(self.medium), dense: times(self.dense) }
    }

    #[must_use]
    pub fn get(&self, density: Density) -> usize {
        match density {
            Density::Sparse => self.sparse,
            Density::Medium => self.medium,
            Density::Dense => self.dense,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByGround<T> {
    /// The value in rigid worlds.
    pub rigid: T,
    /// The value in deformable worlds.
    pub deformable: T,
    /// The value in mixed worlds.
    pub mixed: T,
}

impl<T: Copy> ByGround<T> {
    #[must_use]
    pub fn get(&self, ground: Terrain) -> T {
        match ground {
            Terrain::Rigid => self.rigid,
            Terrain::Deformable => self.deformable,
            Terrain::Mixed => self.mixed,
        }
    }
}

/// The elevation grid.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridParams {
    /// The number of nodes along each side.
    pub nodes: usize,
    /// The node spacing, m.
    pub resolution: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElevationParams {
    /// The terrain model: the name of one in `tasks/terrain`, or a file.
    pub model: String,
    /// The standard deviation of the height, m; the mean over many worlds of a level.
    pub std: ByElevation,
    /// The standard deviation of the logarithm of `std` between worlds, in addition to the variation of the model's
    /// samples.
    pub std_spread: f64,
    /// Spectral shaping of the surfaces; `None` uses the model's samples unchanged.
    #[serde(default)]
    pub shape: Option<ShapeParams>,
}

impl ElevationParams {
    /// The shaping for a model.
    ///
    /// # Errors
    /// Returns the flaw if the shape does not suit the model's resolution.
    pub fn shaping(&self, model: &Model) -> Result<Option<Shaping>, Flaw> {
        let shaping = |p| Shaping::new(p, model.header().resolution, model.metre()).map_err(shape_flaw);
        self.shape.as_ref().map(shaping).transpose()
    }
}

fn shape_flaw((field, problem): (String, String)) -> Flaw {
    flaw(format!("elevation.shape.{field}"), problem)
}

/// A normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// The mean.
    pub mean: f64,
    /// The standard deviation.
    pub std: f64,
}

/// The Coulomb friction of the rigid classes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionParams {
    /// The minimum and the maximum value.
    pub clip: [f64; 2],
    pub clay: Normal,
    pub concrete: Normal,
    pub dirt: Normal,
    pub grass: Normal,
    pub gravel: Normal,
    pub rock: Normal,
    pub wood: Normal,
}

impl FrictionParams {
    /// The distribution of a class; `None` for deformable classes.
    #[must_use]
    pub fn get(&self, class: TerrainClass) -> Option<Normal> {
        Some(match class {
            TerrainClass::Clay => self.clay,
            TerrainClass::Concrete => self.concrete,
            TerrainClass::Dirt => self.dirt,
            TerrainClass::Grass => self.grass,
            TerrainClass::Gravel => self.gravel,
            TerrainClass::Rock => self.rock,
            TerrainClass::Wood => self.wood,
            TerrainClass::Mud | TerrainClass::Sand | TerrainClass::Snow => return None,
        })
    }
}

/// The semantic patches of the ground.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundParams {
    /// The terrain types of consecutive worlds, repeated cyclically.
    pub order: Vec<Terrain>,
    /// The number of patches along each side.
    pub patches: usize,
    /// The minimum and the maximum number of clusters.
    pub clusters: ByGround<[usize; 2]>,
    /// The standard deviation of a cluster's centre about the middle, as a fraction of the side.
    pub centre_spread: f64,
    pub friction: FrictionParams,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleParams {
    /// The number of boulders.
    pub boulders: ByDensity,
    /// The number of trees.
    pub trees: ByDensity,
    /// The extents of a boulder of scale 1, m.
    pub boulder_size: [f64; 3],
    /// The minimum and the maximum scale of a boulder.
    pub boulder_scale: [f64; 2],
    /// The minimum and the maximum random factor on each extent of a boulder.
    pub boulder_stretch: [f64; 2],
    /// The minimum and the maximum radius of a trunk, m.
    pub trunk_radius: [f64; 2],
    /// The minimum and the maximum length of a trunk, m.
    pub trunk_height: [f64; 2],
    /// The fraction of the height that is below the ground.
    pub buried: f64,
    /// The maximum distance of a centre from the middle along x and y, m.
    pub extent: f64,
    /// The minimum distance between two centres, m.
    pub spacing: f64,
    /// The minimum distance of a centre from every start and goal, m.
    pub task_clearance: f64,
    /// The maximum number of samples for one obstacle.
    pub attempts: usize,
}

impl ObstacleParams {
    /// The number of obstacles that the area has room for, if they stand as closely as discs can.
    fn room(&self) -> f64 {
        // A disc of this diameter about each centre takes up at least a hexagon, and may reach over the edge by half of it.
        let hexagon = 0.5 * 3.0_f64.sqrt() * self.spacing * self.spacing;
        let side = 2.0 * self.extent + self.spacing;
        if hexagon > 0.0 { (side * side / hexagon).floor() } else { f64::INFINITY }
    }

    /// The same for an area that is larger or smaller by a factor.
    #[cfg(feature = "site")]
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { boulders: self.boulders.times(factor), trees: self.trees.times(factor), ..self }
    }
}

/// The starts and goals of a world.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskParams {
    /// The number of tasks in a world.
    pub count: usize,
    /// The radius of the circle of starts and goals, m.
    pub radius: f64,
    pub stand: StandParams,
}

/// Terrain conditions at starts and goals: on a disc around them, and under the wheels at a start.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandParams {
    /// The radius of the disc, m.
    pub reach: f64,
    /// The maximum tilt of the best-fit plane, degrees.
    pub tilt: f64,
    /// The maximum deviation of the terrain from that plane, m.
    pub unevenness: f64,
    /// The length and the width of the rectangle of wheels, which faces the goal, m.
    pub wheels: [f64; 2],
    /// The maximum slope at a start from the rear wheels to the front wheels, degrees.
    pub climb: f64,
    /// The maximum height difference at a start between the diagonal pairs of wheels, m.
    pub twist: f64,
    /// The maximum fraction of the friction that the slope under the wheels requires at a start.
    pub grip: f64,
}

/// The rules of the generator.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeneratorParams {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    pub name: String,
    pub grid: GridParams,
    /// The heights.
    pub elevation: ElevationParams,
    pub ground: GroundParams,
    /// The boulders and trees.
    pub obstacles: ObstacleParams,
    pub tasks: TaskParams,
    pub path: PathParams,
}

impl Default for GeneratorParams {
    /// The rules in `tasks/generator/default.yaml`, which is part of the program.
    fn default() -> Self {
        rules::built_in(Self::DEFAULT_YAML)
    }
}

impl GeneratorParams {
    /// The text of `tasks/generator/default.yaml`, a starting point for custom rules.
    pub const DEFAULT_YAML: &str = include_str!("../../../../../tasks/generator/default.yaml");

    pub const PAPER_YAML: &str = include_str!("../../../../../tasks/generator/paper.yaml");

    /// The rules in `tasks/generator/paper.yaml`: the paper's recipe, with 30, 60 and 100 % of the relief.
    #[must_use]
    pub fn paper() -> Self {
        rules::built_in(Self::PAPER_YAML)
    }

    /// Half the side of the world, m.
    pub(crate) fn half(&self) -> f64 {
        0.5 * (self.grid.nodes - 1) as f64 * self.grid.resolution
    }

    fn check_surface(&self) -> Result<(), Flaw> {
        let (grid, e) = (&self.grid, &self.elevation);
        within("grid.nodes", grid.nodes, 3, MOST_NODES)?;
        within("grid.resolution", grid.resolution, 1e-3, 1e3)?;
        for level in Elevation::ALL {
            within(&format!("elevation.std.{}", level.name()), e.std.get(level), 1e-3, 100.0)?;
        }
        within("elevation.std_spread", e.std_spread, 0.0, 1.0)?;
        if let Some(shape) = &e.shape {
            shape.check().map_err(shape_flaw)?;
        }
        check_model("elevation.model", &e.model)
    }

    fn check_ground(&self) -> Result<(), Flaw> {
        let g = &self.ground;
        if g.patches == 0 || !(self.grid.nodes - 1).is_multiple_of(g.patches) {
            let cells = self.grid.nodes - 1;
            return Err(flaw(
                "ground.patches",
                format!("{} does not divide the {cells} cells of a side", g.patches),
            ));
        }
        for ground in Terrain::ALL {
            let (least, most) = match ground {
                Terrain::Rigid => (1, 7),
                Terrain::Deformable => (1, 3),
                Terrain::Mixed => (2, 10),
            };
            let [low, high] = g.clusters.get(ground);
            let most = most.min(g.patches * g.patches);
            if low < least || high > most || low > high {
                let problem =
                    format!("[{low}, {high}] must be two numbers in {least} to {most}, lower first");
                return Err(flaw(format!("ground.clusters.{}", ground.name()), problem));
            }
        }
        if g.order.is_empty() {
            return Err(flaw("ground.order", "is empty: at least one terrain class is needed"));
        }
        within("ground.centre_spread", g.centre_spread, 1e-3, 10.0)?;
        check_clip("ground.friction.clip", g.friction.clip)?;
        for class in TerrainClass::ALL {
            if let Some(normal) = g.friction.get(class) {
                check_friction(&format!("ground.friction.{}", class.name()), normal)?;
            }
        }
        Ok(())
    }

    fn check_obstacles(&self) -> Result<(), Flaw> {
        let o = &self.obstacles;
        for density in Density::ALL {
            for (name, n) in [("boulders", o.boulders.get(density)), ("trees", o.trees.get(density))] {
                if n > 10_000 {
                    let field = format!("obstacles.{name}.{}", density.name());
                    return Err(flaw(field, format!("{n} must not exceed 10000")));
                }
            }
        }
        for (k, &length) in o.boulder_size.iter().enumerate() {
            within(&format!("obstacles.boulder_size[{k}]"), length, 1e-2, 100.0)?;
        }
        let ranges = [
            ("boulder_scale", o.boulder_scale),
            ("boulder_stretch", o.boulder_stretch),
            ("trunk_radius", o.trunk_radius),
            ("trunk_height", o.trunk_height),
        ];
        for (name, range) in ranges {
            pair_within(&format!("obstacles.{name}"), range, 1e-2, 100.0)?;
        }
        within("obstacles.buried", o.buried, 0.0, 0.99)?;
        within("obstacles.extent", o.extent, 0.0, self.half())?;
        within("obstacles.spacing", o.spacing, 0.0, 1e4)?;
        for density in Density::ALL {
            let (wanted, most) = (o.boulders.get(density) + o.trees.get(density), o.room());
            if wanted as f64 > most {
                let problem = format!(
                    "{} leaves room for at most {most} obstacles, and {} worlds have {wanted}: lower it or their number, or raise \
                     obstacles.extent",
                    o.spacing,
                    density.name()
                );
                return Err(flaw("obstacles.spacing", problem));
            }
        }
        within("obstacles.task_clearance", o.task_clearance, 0.0, 1e4)?;
        within("obstacles.attempts", o.attempts, 1, 1_000_000)
    }
}

impl Document for GeneratorParams {
    type File = Self;
    const KIND: &'static str = "rules";
    const FIELDS: &'static str = "docs/making-suites.md";

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.check()?;
        Ok(rules)
    }
}

vb_files::document!(GeneratorParams);

impl GeneratorParams {
    fn check(&self) -> Result<(), Flaw> {
        self.check_surface()?;
        self.check_ground()?;
        self.check_obstacles()?;
        within("tasks.count", self.tasks.count, 1, 1000)?;
        within("tasks.radius", self.tasks.radius, f64::MIN_POSITIVE, self.half())?;
        check_stand("tasks.stand", &self.tasks.stand, self.half())?;
        check_path("path", &self.path, self.half())
    }
}

/// Whether a terrain model is named.
pub(crate) fn check_model(field: &str, name: &str) -> Result<(), Flaw> {
    if name.is_empty() { Err(flaw(field, "is empty: give a terrain model")) } else { Ok(()) }
}

/// Whether the friction of every patch can lie in a range.
pub(crate) fn check_clip(field: &str, clip: [f64; 2]) -> Result<(), Flaw> {
    pair_within(field, clip, 0.01, 2.0)
}

/// Whether friction can be distributed so.
pub(crate) fn check_friction(field: &str, friction: Normal) -> Result<(), Flaw> {
    within(&format!("{field}.mean"), friction.mean, 0.0, 2.0)?;
    within(&format!("{field}.std"), friction.std, 0.0, 2.0)
}

/// Whether ground to stand on is described in a way that a world of that half side, m, can have.
pub(crate) fn check_stand(field: &str, stand: &StandParams, half: f64) -> Result<(), Flaw> {
    let within = |name: &str, value, low, high| within(&format!("{field}.{name}"), value, low, high);
    within("reach", stand.reach, 0.01, half)?;
    within("tilt", stand.tilt, 0.0, 90.0)?;
    within("unevenness", stand.unevenness, 0.0, 100.0)?;
    within("wheels[0]", stand.wheels[0], 0.01, 2.0 * stand.reach)?;
    within("wheels[1]", stand.wheels[1], 0.01, 2.0 * stand.reach)?;
    within("climb", stand.climb, 0.0, 90.0)?;
    within("twist", stand.twist, 0.0, 100.0)?;
    within("grip", stand.grip, 0.0, 1.0)
}

/// Most cells along a side of the grid on which paths are searched.
const MOST_CELLS: f64 = 8192.0;

/// The finest grid on which paths are searched in a world of that half side, m: its cells must fit into memory.
pub(crate) fn finest_path_grid(half: f64) -> f64 {
    (2.0 * half / MOST_CELLS).max(0.01)
}

/// Whether the global planner's rules suit a world of that half side, m.
pub(crate) fn check_path(field: &str, path: &PathParams, half: f64) -> Result<(), Flaw> {
    within(&format!("{field}.clearance"), path.clearance, 0.0, half)?;
    within(&format!("{field}.grid"), path.grid, finest_path_grid(half), half)?;
    within(&format!("{field}.spacing"), path.spacing, 0.01, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_rules_are_those_of_the_original() {
        // Counts and distances of the original's asset_utils.py, friction and shares of the relief of its
        // gen-VertiBench.py.
        let p = GeneratorParams::default();
        assert_eq!(
            [p.obstacles.boulders.sparse, p.obstacles.boulders.medium, p.obstacles.boulders.dense],
            [10, 20, 40]
        );
        assert_eq!([p.obstacles.trees.sparse, p.obstacles.trees.medium, p.obstacles.trees.dense], [1, 2, 3]);
        assert_eq!(p.ground.friction.get(TerrainClass::Grass), Some(Normal { mean: 0.36, std: 0.07 }));
        assert_eq!(p.ground.friction.get(TerrainClass::Snow), None);
        assert_eq!(p.path, PathParams::default());
        // The paper's recipe has 30, 60 and 100 % of the relief; the rest of its rules are the built-in ones.
        let mut paper = GeneratorParams::paper();
        let relief = paper.elevation.shape.as_ref().unwrap().std;
        for (level, fraction) in [(Elevation::Low, 0.3), (Elevation::Medium, 0.6), (Elevation::High, 1.0)] {
            assert!((paper.elevation.std.get(level) - relief * fraction).abs() < 1e-3);
        }
        paper.name.clone_from(&p.name);
        paper.elevation.std = p.elevation.std;
        paper.tasks.stand = p.tasks.stand;
        assert_eq!(paper, p);
    }

    #[test]
    fn flaws_of_a_parameter_file_are_named() {
        let cases = [
            ("schema: 1", "schema: 2", "version 2 is not supported"),
            ("nodes: 129", "nodes: 2", "grid.nodes: 2 must lie in 3 to 4097"),
            ("resolution: 1.0", "resolution: .nan", "grid.resolution: NaN must lie in"),
            ("medium: 0.555", "medium: steep", "elevation.std.medium: \"steep\""),
            ("medium: 0.555", "medium: -0.3", "elevation.std.medium: -0.3 must lie in 0.001 to 100"),
            ("model: rocks", "model: ''", "elevation.model: is empty"),
            ("tilt: 20.0", "tilt: -1.0", "tasks.stand.tilt: -1 must lie in 0 to 90"),
            (
                "trunk_radius: [0.3, 0.6]",
                "trunk_radius: [0.3, 0.2]",
                "obstacles.trunk_radius[1]: 0.2 must lie in 0.3",
            ),
            ("patches: 16", "patches: 15", "ground.patches: 15 does not divide the 128 cells"),
            ("rigid: [1, 7]", "rigid: [1, 8]", "ground.clusters.rigid: [1, 8] must be two numbers in 1 to 7"),
            ("  order: [rigid, rigid,", "  order: [] #", "ground.order: is empty"),
            ("  order: [rigid, rigid,", "  order: [rigid, frozen,", "ground.order[1]"),
            ("spacing: 10.0", "spacings: 10.0", "spacings"),
            (
                "boulder_scale: [0.7, 1.2]",
                "boulder_scale: [1.3, 1.2]",
                "obstacles.boulder_scale[1]: 1.2 must lie in 1.3",
            ),
            ("radius: 60.0", "radius: 65.0", "tasks.radius: 65 must lie in"),
            ("count: 10", "count: 0", "tasks.count: 0 must lie in 1 to 1000"),
            ("grid: 0.5", "grid: 0.012", "path.grid: 0.012 must lie in 0.015625 to 64"),
            (
                "spacing: 10.0",
                "spacing: 30.0",
                "obstacles.spacing: 30 leaves room for at most 27 obstacles, and dense worlds have 43",
            ),
        ];
        for (from, to, expected) in cases {
            assert!(GeneratorParams::DEFAULT_YAML.contains(from), "{from}");
            let text = GeneratorParams::DEFAULT_YAML.replacen(from, to, 1);
            let message = GeneratorParams::parse(&text, "mine.yaml").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\nlacks {expected}");
        }
    }
}
