//! The seeded world generator: the same seed, rules and terrain model give the same bytes.
//!
//! Heights are drawn from a learned model of terrain (`vb-terrain`). Rules for ground, obstacles, starts and goals
//! follow the original's generator (envs/gen-VertiBench.py, envs/utils/asset_utils.py). All rules are data:
//! [`GeneratorParams`].

mod broken;
mod calibrate;
mod ends;
mod ground;
mod obstacles;
mod params;
mod surfaces;

pub(crate) use broken::Fields;
pub use broken::NoStarts;
pub use calibrate::{Evaluation, FACTORS, Search};
#[cfg(feature = "site")]
pub(crate) use ends::Starts;
pub(crate) use ends::millimetres;
pub(crate) use ground::drawn_friction;
#[cfg(feature = "site")]
pub(crate) use ground::friction;
#[cfg(feature = "site")]
pub(crate) use params::finest_path_grid;
pub use params::{
    ByDensity, ByElevation, ByGround, ElevationParams, FrictionParams, GeneratorParams, GridParams,
    GroundParams, Normal, ObstacleParams, StandParams, TaskParams,
};
pub(crate) use params::{check_clip, check_friction, check_model, check_path, check_stand};
pub(crate) use surfaces::Surfaces;

use crate::path::{PathError, PathParams, Planner};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use vb_math::rng::Stream;
use vb_terrain::Model;
use vb_world::{
    Density, Elevation, Flaw, Heightfield, Pose2, Provenance, Semantics, Suite, SuiteError, SuiteMeta,
    SuiteWriter, Task, World, WorldInfo,
};

#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    #[error("{grid} or elevation: {source}")]
    Surface {
        /// The rules' name for the nodes and the distance between them.
        grid: &'static str,
        source: vb_terrain::GenerateError,
    },
    #[error(
        "{world}: no start and goal at a distance of {distance:.0} m are on level, smooth terrain without obstacles: {why}"
    )]
    NoStart {
        world: String,
        /// The distance between start and goal, m.
        distance: f64,
        why: NoStarts,
    },
    #[error(
        "{world}: {clusters} clusters found no separate patches in {draws} samples: raise ground.centre_spread, or lower ground.clusters"
    )]
    NoPatch { world: String, clusters: usize, draws: usize },
    #[error(
        "{world}: obstacle {index} found no valid position in {attempts} samples: lower obstacles.boulders, obstacles.spacing or obstacles.task_clearance, or raise obstacles.attempts"
    )]
    NoRoom { world: String, index: usize, attempts: usize },
    /// The obstacles leave no way, however often they are drawn.
    #[error("{world}/{task}: {source} (obstacles were sampled {layouts} times)")]
    NoWay { world: String, task: String, layouts: usize, source: PathError },
    /// The rules contradict each other in a way that only the world shows.
    #[error("{world}: {flaw}: change the rule that causes it")]
    World { world: String, flaw: Flaw },
    /// The rules do not suit the terrain model.
    #[error(transparent)]
    Rules(#[from] vb_files::Flaw),
    /// The suite could not be written.
    #[error(transparent)]
    Suite(#[from] SuiteError),
}

/// Start and goal of each task, m.
type Pairs = Vec<[[f64; 2]; 2]>;

/// Obstacle layouts drawn before giving up on paths.
const LAYOUTS: usize = 20;

/// Between-world factors of the height spread lie within this many standard deviations of their logarithm.
const SPREAD_LIMIT: f64 = 1.5;
/// Version of the generator, which changes whenever the same inputs would give other worlds.
const VERSION: u32 = 5;
/// Step of the heights of generated worlds, m: far below what a wheel feels and below the original's (8 bits over up to 16 m, so
/// 63 mm), and coarse enough that elevation images compress to about two thirds.
const HEIGHT_STEP: f64 = 1e-3;
/// Distance between the windows of a surface in which starts and goals are looked for, m: heights farther apart than 3 m are hardly correlated.
const SHIFT: f64 = 4.0;
/// What the generator's rules call what surfaces follow from.
pub(crate) const FIELDS: Fields =
    Fields { grid: "grid", stand: "tasks.stand", distance: "tasks.radius", elsewhere: "" };

/// The seeds of training worlds, on which planners are trained and tuned. No suite that judges planners is made of one of
/// them.
pub const TRAINING_SEEDS: RangeInclusive<u64> = 7000..=7999;

/// The things that a suite of generated worlds follows from.
#[derive(Clone, Copy, Debug)]
pub struct Generator<'a> {
    pub rules: &'a GeneratorParams,
    /// The terrain model that [`ElevationParams::model`] names.
    pub model: &'a Model,
    pub seed: u64,
    pub worlds: usize,
}

impl Generator<'_> {
    #[must_use]
    pub fn meta(&self, name: &str, version: &str) -> SuiteMeta {
        let (rules, seed) = (self.rules, self.seed);
        SuiteMeta {
            name: name.into(),
            version: version.into(),
            description: format!("{} generated worlds with {} tasks each.", self.worlds, rules.tasks.count),
            provenance: provenance(
                format_args!("learned terrain {VERSION}"),
                &rules.name,
                &rules.elevation.model,
                seed,
            ),
        }
    }

    /// Generates the suite into `dir`, which must not exist or be empty. `progress` hears of each world once it is
    /// written. Worlds are made side by side on all processors and written in order.
    ///
    /// # Errors
    /// Returns an error if the rules leave no room or no way, or the suite cannot be written.
    pub fn write(
        &self,
        dir: impl AsRef<Path>,
        meta: SuiteMeta,
        progress: impl FnMut(usize, &WorldInfo),
    ) -> Result<Suite, GenerateError> {
        self.write_some(dir, meta, &(0..self.worlds).collect::<Vec<_>>(), progress)
    }

    /// Generates the worlds at these indices alone, under the names that they have in the whole suite.
    pub fn write_some(
        &self,
        dir: impl AsRef<Path>,
        meta: SuiteMeta,
        indices: &[usize],
        mut progress: impl FnMut(usize, &WorldInfo),
    ) -> Result<Suite, GenerateError> {
        let mut writer = SuiteWriter::create(dir, meta)?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(indices.len().max(1));
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            // A full channel holds the makers back, so that only a few worlds are in memory.
            let (sender, made) = mpsc::sync_channel(threads);
            for _ in 0..threads {
                let (sender, next) = (sender.clone(), &next);
                scope.spawn(move || {
                    loop {
                        let turn = next.fetch_add(1, Ordering::Relaxed);
                        let Some(&index) = indices.get(turn) else { break };
                        // Nobody listens any more once a world has failed.
                        if sender.send((turn, self.world(index))).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            let mut waiting = BTreeMap::new();
            let mut written = 0;
            for (turn, world) in made {
                waiting.insert(turn, world);
                while let Some(world) = waiting.remove(&written) {
                    progress(written, writer.add(&world?)?);
                    written += 1;
                }
            }
            Ok::<_, GenerateError>(())
        })?;
        Ok(writer.finish()?)
    }

    /// Generates the world at an index. It depends on rules, model, seed and index alone, so that a longer suite begins
    /// with the worlds of a shorter one.
    ///
    /// Labels are dealt out rather than drawn: nine consecutive worlds have all nine pairs of level and density, grounds
    /// follow each other in the order that the rules give, again and again, and so do levels of soil.
    ///
    /// # Errors
    /// Returns an error if the rules leave no room or no way.
    pub fn world(&self, index: usize) -> Result<World, GenerateError> {
        let rules = self.rules;
        let id = format!("w{:03}", index + 1);
        let stream = |part: &str| Stream::new(self.seed, &["generate", &id, part]);
        let elevation = Elevation::ALL[index % 3];
        let density = Density::ALL[(index + index / 3) % 3];
        let ground = rules.ground.order[index % rules.ground.order.len()];
        let levels = ground::soil_levels(&rules.ground.order, index);
        let semantics =
            ground::semantics(&rules.grid, &rules.ground, ground, levels, &mut stream("semantics")).map_err(
                |ground::NoPatch { clusters, draws }| GenerateError::NoPatch {
                    world: id.clone(),
                    clusters,
                    draws,
                },
            )?;
        let (heightfield, ends) =
            self.ground_with_ends(&id, elevation, &semantics, &mut stream("elevation"))?;
        let mut world = World {
            elevation,
            terrain: ground,
            density,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles: Vec::new(),
            tasks: Vec::new(),
            beds: Vec::new(),
            id: id.clone(),
        };
        furnish(&mut world, &rules.obstacles, &rules.path, &ends, &mut stream("obstacles"))?;
        Ok(world)
    }

    /// A surface of the level with starts and goals all around.
    fn ground_with_ends(
        &self,
        id: &str,
        level: Elevation,
        semantics: &Semantics,
        rng: &mut Stream,
    ) -> Result<(Heightfield, Pairs), GenerateError> {
        let (rules, grid) = (&self.rules.elevation, self.rules.grid);
        // Drawn before the surfaces: flat ones, which have more room for starts, must not make a level flatter.
        let spread = rng.normal(0.0, 1.0).clamp(-SPREAD_LIMIT, SPREAD_LIMIT);
        let std = rules.std.get(level) * vb_math::exp(rules.std_spread * spread);
        let shaping = rules.shaping(self.model)?;
        let surfaces = Surfaces {
            model: self.model,
            shaping: shaping.as_ref(),
            step: Some(HEIGHT_STEP),
            shift: [((SHIFT / grid.resolution).round() as usize).max(1), (grid.nodes - 1) / 4],
            nodes: grid.nodes,
            resolution: grid.resolution,
            std,
            semantics,
            tasks: &self.rules.tasks,
            fields: FIELDS,
        };
        surfaces.with_ends(id, rng)
    }
}

/// What a suite says of where its worlds come from: the builder with its version, and what it was given.
pub(crate) fn provenance(builder: impl Display, rules: &str, model: &str, seed: u64) -> Provenance {
    Provenance::Generated { generator: format!("{builder}, rules {rules}, model {model}"), seed }
}

/// Draws obstacles until there is a path from every start to its goal, and gives the world its tasks.
pub(crate) fn furnish(
    world: &mut World,
    params: &ObstacleParams,
    path: &PathParams,
    ends: &[[[f64; 2]; 2]],
    rng: &mut Stream,
) -> Result<(), GenerateError> {
    let id = world.id.clone();
    let mut layout = 1;
    world.tasks = loop {
        world.obstacles = obstacles::obstacles(params, world.density, ends, rng)
            .map_err(|index| GenerateError::NoRoom { world: id.clone(), index, attempts: params.attempts })?;
        match tasks(world, path, ends) {
            Ok(tasks) => break tasks,
            Err((task, source)) if layout == LAYOUTS => {
                return Err(GenerateError::NoWay { world: id, task, layouts: layout, source });
            }
            Err(_) => layout += 1,
        }
    };
    world.check().map_err(|flaw| GenerateError::World { world: id, flaw })
}

/// Gives a world with its obstacles tasks from every start to its goal.
pub(crate) fn plan_tasks(
    world: &mut World,
    path: &PathParams,
    ends: &[[[f64; 2]; 2]],
) -> Result<(), GenerateError> {
    let id = world.id.clone();
    world.tasks = tasks(world, path, ends).map_err(|(task, source)| GenerateError::NoWay {
        world: id.clone(),
        task,
        layouts: 1,
        source,
    })?;
    world.check().map_err(|flaw| GenerateError::World { world: id, flaw })
}

/// An error is the task without a path, and why.
fn tasks(world: &World, path: &PathParams, ends: &[[[f64; 2]; 2]]) -> Result<Vec<Task>, (String, PathError)> {
    let name = |k: usize| format!("t{k:02}");
    let planner = Planner::new(world, path).map_err(|e| (name(0), e))?;
    let task = |(k, &[start, goal]): (usize, &[[f64; 2]; 2])| {
        let path = planner.plan(start, goal).map_err(|e| (name(k), e))?;
        let yaw = vb_math::atan2(goal[1] - start[1], goal[0] - start[0]);
        Ok(Task { id: name(k), start: Pose2 { x: start[0], y: start[1], yaw }, goal, path })
    };
    ends.iter().enumerate().map(task).collect()
}
