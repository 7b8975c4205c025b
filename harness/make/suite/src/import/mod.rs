//! Import of the original's released data: bitmaps, YAML, NumPy labels (docs/making-suites.md).
//!
//! The files leave open what a vehicle drives on, as the original's simulator does not build what they describe;
//! [`Ground`] chooses. Paths come from our global planner either way. `docs/making-suites.md` has the whole mapping.

mod config;
mod files;
mod sections;
mod simulated;

use crate::path::{PathError, PathParams, Planner};
use config::Config;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vb_files::yaml;
use vb_world::{
    Flaw, Heightfield, Obstacle, ObstacleKind, Pose2, Provenance, Semantics, SoilLevels, SuiteMeta, Task,
    Terrain, TerrainClass, World,
};

/// The reason why data could not be imported. Each message names the place and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    #[error("{}: no world found: give the original's BenchMaps folder, which contains sampled_maps/Worlds and sampled_maps/Configs/Final", dir.display())]
    NothingFound { dir: PathBuf },
    #[error("{}: cannot read: {source}; each world needs Worlds/ID.bmp, Configs/Final/configID_LEVEL.yaml and labelsID_LEVEL.npy", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: {field}: {problem}", file.display())]
    Invalid {
        file: PathBuf,
        field: String,
        /// The value, and what would be right.
        problem: String,
    },
    #[error("{}: positions[{index}]: {source}", file.display())]
    Path { file: PathBuf, index: usize, source: PathError },
    #[error("{}: the imported world is not valid: {flaw}", file.display())]
    World {
        file: PathBuf,
        /// The flaw, in the terms of our format.
        flaw: Flaw,
    },
}

fn invalid(file: &Path, field: impl Into<String>, problem: impl Into<String>) -> ImportError {
    ImportError::Invalid { file: file.into(), field: field.into(), problem: problem.into() }
}

/// The ground and obstacles that are made of the original's files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ground {
    /// The ground is as paper and labels describe it: each patch has its own class and friction, obstacles stand on the
    /// ground (their stored z was looked up at a wrong place), and trees are round trunks.
    #[default]
    AsDescribed,
    /// The ground is as the original's simulator builds it: rigid patches are merged into sections with the friction of
    /// one of their patches, soil lies in bands (deformable worlds) or in one rectangle for each class (mixed worlds),
    /// and obstacles are boxes centred at their stored z, which may leave them in the air or under the ground
    /// (envs/utils/asset_utils.py looks heights up in a raster of the wrong width).
    AsSimulated,
}

impl Ground {
    /// All choices, in order.
    pub const ALL: [Self; 2] = [Self::AsDescribed, Self::AsSimulated];

    /// The name of the choice on the command line and in the suite.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AsDescribed => "as-described",
            Self::AsSimulated => "as-simulated",
        }
    }
}

/// The original's data, with the list of the worlds that there are. Worlds are read one by one, so that a caller can
/// show progress.
#[derive(Clone, Debug)]
pub struct Source {
    maps: PathBuf,
    configs: BTreeMap<u32, PathBuf>,
    ground: Ground,
}

/// Where `sampled_maps` may lie below the directory that people name.
const PLACES: [&str; 5] = [
    "sampled_maps",
    "BenchMaps/sampled_maps",
    "data/BenchMaps/sampled_maps",
    "envs/data/BenchMaps/sampled_maps",
    "",
];

impl Source {
    /// Finds the worlds below `dir`: the original's `BenchMaps` folder, one of its parents, or `sampled_maps`.
    ///
    /// # Errors
    /// Returns an error if there is no such world, or if two configs claim the same one.
    pub fn find(dir: impl AsRef<Path>) -> Result<Self, ImportError> {
        let dir = dir.as_ref();
        let nothing = || ImportError::NothingFound { dir: dir.into() };
        let maps = PLACES
            .iter()
            .map(|p| dir.join(p))
            .find(|p| p.join("Configs/Final").is_dir())
            .ok_or_else(nothing)?;
        let folder = maps.join("Configs/Final");
        let read = |source| ImportError::Read { path: folder.clone(), source };
        let mut configs = BTreeMap::new();
        for entry in std::fs::read_dir(&folder).map_err(read)? {
            let path = entry.map_err(read)?.path();
            let Some(id) = config_id(&path) else { continue };
            if let Some(other) = configs.insert(id, path.clone()) {
                let other = other.file_name().unwrap_or_default().to_string_lossy().into_owned();
                return Err(invalid(
                    &path,
                    "file name",
                    format!("{other} is also a config of world {id}: remove one"),
                ));
            }
        }
        if configs.is_empty() {
            Err(nothing())
        } else {
            Ok(Self { maps, configs, ground: Ground::default() })
        }
    }

    /// The same data, to be made into worlds with this ground.
    #[must_use]
    pub fn ground(self, ground: Ground) -> Self {
        Self { ground, ..self }
    }

    /// The original's ids of the worlds that are there, ascending (the full release has 1 to 100).
    pub fn ids(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.configs.keys().copied()
    }

    #[must_use]
    pub fn meta(&self) -> SuiteMeta {
        let count = self.configs.len();
        let (name, ground) = match self.ground {
            Ground::AsDescribed => {
                ("verti-bench", "Ground as described: obstacles stand on the ground, friction is per patch.")
            }
            Ground::AsSimulated => (
                "verti-bench-as-simulated",
                "Ground as the original simulates it: friction per merged section, soil in bands and rectangles, \
                 obstacles as boxes at their stored z.",
            ),
        };
        SuiteMeta {
            name: name.into(),
            version: "release".into(),
            description: format!(
                "{count} worlds of the original Verti-Bench release. {ground} Paths are re-planned."
            ),
            provenance: Provenance::Imported {
                source: format!("Verti-Bench release, {count} of 100 worlds, ground {}", self.ground.name()),
                place: None,
            },
        }
    }

    /// Imports one world and plans the paths of its tasks.
    ///
    /// # Errors
    /// Returns an error if a file is missing or not as the original's are, or a task has no path.
    ///
    /// # Panics
    /// Panics if `id` is not one of [`Source::ids`].
    pub fn world(&self, id: u32) -> Result<World, ImportError> {
        let file = &self.configs[&id];
        let text = vb_files::read_text(file, vb_files::DOCUMENT)
            .map_err(|source| ImportError::Read { path: file.clone(), source })?;
        let config: Config = yaml::parse(&text).map_err(|e| invalid(file, e.field, e.problem))?;
        let side = check_terrain(file, &config)?;
        let image_file = self.maps.join("Worlds").join(format!("{id}.bmp"));
        let greys = files::elevation(&bytes(&image_file)?, side, side)
            .map_err(|(f, p)| invalid(&image_file, f, p))?;
        let semantics = semantics(file, &config, side)?;
        let labels_file = file.with_file_name(format!("labels{id}_{}.npy", config.terrain.difficulty.name()));
        let labels =
            files::labels(&bytes(&labels_file)?, side, side).map_err(|(f, p)| invalid(&labels_file, f, p))?;
        check_labels(&labels_file, &labels, side, &semantics, config.terrain_type)?;
        let (semantics, obstacles) = match self.ground {
            Ground::AsDescribed => (semantics, described_obstacles(file, &config)?),
            Ground::AsSimulated => {
                let heightfield = heightfield(&greys, side, &config);
                (
                    simulated::semantics(file, config.terrain_type, &semantics, side)?,
                    simulated::obstacles(file, &config, &heightfield)?,
                )
            }
        };
        let mut world = World {
            id: format!("w{id:03}"),
            elevation: config.terrain.difficulty.elevation(),
            terrain: config.terrain_type,
            density: config.obstacle_density,
            scale: 1.0,
            heightfield: heightfield(&greys, side, &config),
            semantics,
            obstacles,
            tasks: Vec::new(),
            beds: Vec::new(),
        };
        world.check().map_err(|flaw| ImportError::World { file: file.clone(), flaw })?;
        world.tasks = tasks(file, &config, &world)?;
        world.check().map_err(|flaw| ImportError::World { file: file.clone(), flaw })?;
        Ok(world)
    }
}

/// Imports all worlds that are there; see [`Source`] for one at a time.
pub fn import(dir: impl AsRef<Path>) -> Result<(SuiteMeta, Vec<World>), ImportError> {
    let source = Source::find(dir)?;
    let worlds = source.ids().map(|id| source.world(id)).collect::<Result<_, _>>()?;
    Ok((source.meta(), worlds))
}

fn bytes(path: &Path) -> Result<Vec<u8>, ImportError> {
    vb_files::read(path, vb_files::DATA).map_err(|source| ImportError::Read { path: path.into(), source })
}

/// The id in `config{id}_{difficulty}.yaml`; none for any other name.
fn config_id(path: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("config")?.strip_suffix(".yaml")?.split_once('_')?.0.parse().ok()
}

/// Checks the terrain block and the file's name; the number of pixels along a side.
fn check_terrain(file: &Path, config: &Config) -> Result<usize, ImportError> {
    let t = &config.terrain;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    if !name.ends_with(&format!("_{}", t.difficulty.name())) {
        let found = t.difficulty.name();
        return Err(invalid(
            file,
            "terrain.difficulty",
            format!("{found} does not agree with the file's name"),
        ));
    }
    if t.length != t.width {
        let problem =
            format!("{} differs from terrain.length, {}: the world must be square", t.width, t.length);
        return Err(invalid(file, "terrain.width", problem));
    }
    let side = 2.0 * t.length;
    if !(side.fract() == 0.0 && (3.0..=8193.0).contains(&side)) {
        let problem = format!("{} is not half of a whole number of pixels (64.5 in the release)", t.length);
        return Err(invalid(file, "terrain.length", problem));
    }
    if !(t.min_height.is_finite() && t.max_height.is_finite() && t.min_height < t.max_height) {
        let problem =
            format!("{} must be finite and above terrain.min_height, {}", t.max_height, t.min_height);
        return Err(invalid(file, "terrain.max_height", problem));
    }
    Ok(side as usize)
}

/// The physical surface: one node a pixel at 1 m, grey 0…255 from min_height to max_height (Chrono's RigidTerrain.cpp).
fn heightfield(greys: &[u8], side: usize, config: &Config) -> Heightfield {
    let levels: Vec<u16> = greys.chunks(side).rev().flatten().map(|&g| 257 * u16::from(g)).collect();
    let range = [config.terrain.min_height, config.terrain.max_height];
    Heightfield::from_levels(side, side, 1.0, range, &levels)
}

fn semantics(file: &Path, config: &Config, side: usize) -> Result<Semantics, ImportError> {
    let count = config.textures.len();
    let n = (1..=count).find(|n| n * n >= count).unwrap_or(0);
    if n == 0 || n * n != count || !(side - 1).is_multiple_of(n) {
        let problem = format!("{count} entries do not tile the world in equal squares (256 in the release)");
        return Err(invalid(file, "textures", problem));
    }
    let mut classes = vec![None; count];
    let mut friction = vec![0.0; count];
    for (k, t) in config.textures.iter().enumerate() {
        let flaw = |field: &str, problem| Err(invalid(file, format!("textures[{k}].{field}"), problem));
        let [i, j] = t.index;
        if i >= n || j >= n {
            return flaw("index", format!("[{i}, {j}] lies outside the {n} x {n} patches"));
        }
        // Rows are counted from the north there, from the south here.
        let patch = (n - 1 - i) * n + j;
        if classes[patch].replace(t.terrain_type).is_some() {
            return flaw("index", format!("[{i}, {j}] was given before: each patch must be given once"));
        }
        if t.is_deformable != t.terrain_type.is_deformable() {
            return flaw(
                "is_deformable",
                format!("{} does not fit {}", t.is_deformable, t.terrain_type.name()),
            );
        }
        friction[patch] = match t.friction {
            Some(mu) if !t.is_deformable => mu,
            None if !t.is_deformable => return flaw("friction", "is missing: a rigid patch needs it".into()),
            _ => 0.0,
        };
    }
    // As many entries as patches, none given twice: every patch has its class.
    let classes: Vec<TerrainClass> = classes.into_iter().flatten().collect();
    Ok(Semantics {
        rows: n,
        cols: n,
        patch: ((side - 1) / n) as f64,
        classes,
        friction,
        soil: SoilLevels::default(),
    })
}

/// Compares the label raster with the patches it was made from: pixel (r, c) belongs to patch (min(r / 8, 15),
/// min(c / 8, 15)). In mixed worlds the original turned deformable patches into rigid ones without repainting
/// their share of the last row and column, where the old label stays (envs/gen-VertiBench.py); nothing else may differ.
fn check_labels(
    file: &Path,
    labels: &[i32],
    side: usize,
    semantics: &Semantics,
    ground: Terrain,
) -> Result<(), ImportError> {
    let n = semantics.rows;
    let pixels = (side - 1) / n;
    for (k, &label) in labels.iter().enumerate() {
        let (r, c) = (k / side, k % side);
        let (i, j) = ((r / pixels).min(n - 1), (c / pixels).min(n - 1));
        let class = semantics.classes[(n - 1 - i) * n + j];
        let found = u8::try_from(label).ok().and_then(TerrainClass::from_label);
        let Some(found) = found else {
            return Err(invalid(file, format!("[{r}, {c}]"), format!("label {label} must lie in 0 to 9")));
        };
        let leftover = ground == Terrain::Mixed
            && (r == side - 1 || c == side - 1)
            && found.is_deformable()
            && !class.is_deformable();
        if found != class && !leftover {
            return Err(invalid(
                file,
                format!("[{r}, {c}]"),
                format!(
                    "label {label} ({}) differs from textures index [{i}, {j}] of the config, {}: they must agree",
                    found.name(),
                    class.name()
                ),
            ));
        }
    }
    Ok(())
}

/// Extents of the collision box of a rock of scale 1, m (envs/utils/asset_utils.py).
const ROCK_SIZE: [f64; 3] = [4.4, 4.4, 3.8];
/// Extents of the collision box of a tree, m (envs/utils/asset_utils.py).
const TREE_SIZE: [f64; 3] = [1.0, 1.0, 5.0];

/// Extents of the collision box of each rock, m.
fn rock_sizes(file: &Path, config: &Config) -> Result<Vec<[f64; 3]>, ImportError> {
    let size = |(k, rock): (usize, &config::Rock)| {
        let s = rock.scale;
        if !(s > 0.0 && s <= 10.0) {
            let problem = format!("{s} must lie in (0, 10] (0.7 to 1.2 in the release)");
            return Err(invalid(file, format!("obstacles.rocks[{k}].scale"), problem));
        }
        Ok(ROCK_SIZE.map(|l| l * s))
    };
    config.obstacles.rocks.iter().enumerate().map(size).collect()
}

/// Obstacles on the true ground, half buried, as the original means it: it centres their boxes at ground level. A
/// tree becomes a trunk as wide as its box.
fn described_obstacles(file: &Path, config: &Config) -> Result<Vec<Obstacle>, ImportError> {
    let rocks = rock_sizes(file, config)?.into_iter().zip(&config.obstacles.rocks).map(|(size, rock)| {
        let (x, y) = (rock.position.x, rock.position.y);
        Obstacle { x, y, yaw: 0.0, buried: 0.5 * size[2], kind: ObstacleKind::Box { size } }
    });
    let [width, _, height] = TREE_SIZE;
    let kind = ObstacleKind::Trunk { radius: 0.5 * width, height };
    let trees = config.obstacles.trees.iter().map(|tree| {
        let (x, y) = (tree.position.x, tree.position.y);
        Obstacle { x, y, yaw: 0.0, buried: 0.5 * height, kind }
    });
    Ok(rocks.chain(trees).collect())
}

fn tasks(file: &Path, config: &Config, world: &World) -> Result<Vec<Task>, ImportError> {
    let no_path = |index| move |source| ImportError::Path { file: file.into(), index, source };
    let planner = Planner::new(world, &PathParams::default()).map_err(no_path(0))?;
    let task = |(index, pair): (usize, &config::Pair)| {
        let ([x, y, _], [gx, gy, _]) = (pair.start, pair.goal);
        let path = planner.plan([x, y], [gx, gy]).map_err(no_path(index))?;
        let start = Pose2 { x, y, yaw: vb_math::atan2(gy - y, gx - x) };
        Ok(Task { id: format!("t{index:02}"), start, goal: [gx, gy], path })
    };
    config.positions.iter().enumerate().map(task).collect()
}
