//! The seeded world generator: same seed and rules, same bytes.
//!
//! Rules for ground, obstacles, starts and goals follow the original's generator (facts §3.3, §3.5); heights come
//! from spectral synthesis matched to its worlds (§2.3). All rules are data: [`GeneratorParams`].

mod ground;
mod params;
mod terrain;

pub(crate) use ground::friction;
pub use params::{
    ByDensity, ByElevation, ByGround, ElevationParams, FrictionParams, GeneratorParams, GridParams,
    GroundParams, Normal, ObstacleParams, ParamsError, PitParams, RoughnessParams, SpectrumParams,
    TaskParams,
};

use crate::path::{PathError, PathParams, Planner};
use std::path::Path;
use vb_math::rng::Stream;
use vb_world::{
    Density, Elevation, Flaw, Obstacle, ObstacleKind, Pose2, Provenance, Suite, SuiteError, SuiteMeta,
    SuiteWriter, Task, Terrain, World, WorldInfo,
};

/// Why no suite was generated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// The rules leave no room for the obstacles.
    #[error(
        "{world}: obstacle {index} found no place in {attempts} draws: lower obstacles.boulders, obstacles.spacing or obstacles.task_clearance, or raise obstacles.attempts"
    )]
    NoRoom {
        /// The world.
        world: String,
        /// Index of the obstacle.
        index: usize,
        /// Draws made.
        attempts: usize,
    },
    /// The obstacles leave no way, however often they are drawn.
    #[error("{world}/{task}: {source} (obstacles were drawn {layouts} times)")]
    NoWay {
        /// The world.
        world: String,
        /// The task.
        task: String,
        /// Layouts tried.
        layouts: usize,
        /// Why the last one failed.
        source: PathError,
    },
    /// The rules contradict each other in a way that only the world shows.
    #[error("{world}: {flaw}: change the rule that causes it")]
    World {
        /// The world.
        world: String,
        /// What is wrong with it.
        flaw: Flaw,
    },
    /// The suite could not be written.
    #[error(transparent)]
    Suite(#[from] SuiteError),
}

/// Obstacle layouts drawn before giving up on paths.
const LAYOUTS: usize = 20;

/// What a generated suite says about itself.
#[must_use]
pub fn meta(params: &GeneratorParams, seed: u64, worlds: usize, name: &str) -> SuiteMeta {
    SuiteMeta {
        name: name.into(),
        version: "1".into(),
        description: format!("{worlds} generated worlds with {} tasks each.", params.tasks.count),
        provenance: Provenance::Generated { generator: format!("spectral 1, rules {}", params.name), seed },
    }
}

/// Generates `worlds` worlds.
///
/// # Errors
/// If the rules leave no room or no way.
pub fn generate(params: &GeneratorParams, seed: u64, worlds: usize) -> Result<Vec<World>, GenerateError> {
    (0..worlds).map(|index| generate_world(params, seed, index, worlds)).collect()
}

/// Generates a suite into `dir`, which must not exist or be empty. `progress` hears of each world once it is written.
///
/// # Errors
/// If the rules leave no room or no way, or the suite cannot be written.
pub fn write_suite(
    dir: impl AsRef<Path>,
    params: &GeneratorParams,
    seed: u64,
    worlds: usize,
    name: &str,
    mut progress: impl FnMut(usize, &WorldInfo),
) -> Result<Suite, GenerateError> {
    let mut writer = SuiteWriter::create(dir, meta(params, seed, worlds, name))?;
    for index in 0..worlds {
        progress(index, writer.add(&generate_world(params, seed, index, worlds)?)?);
    }
    Ok(writer.finish()?)
}

/// Generates the world at `index` of a suite of `count` worlds. It depends on nothing but the arguments.
///
/// Levels and densities are dealt out evenly rather than drawn: nine consecutive worlds have all nine pairs.
/// Grounds follow each other in blocks, rigid first, as in the original.
///
/// # Errors
/// If the rules leave no room or no way.
pub fn generate_world(
    params: &GeneratorParams,
    seed: u64,
    index: usize,
    count: usize,
) -> Result<World, GenerateError> {
    let id = format!("w{:03}", index + 1);
    let stream = |part: &str| Stream::new(seed, &["generate", &id, part]);
    let elevation = Elevation::ALL[index % 3];
    let density = Density::ALL[(index + index / 3) % 3];
    let ground = ground_of(params, index, count);
    let ends = ends(&params.tasks);
    let mut world = World {
        elevation,
        terrain: ground,
        density,
        scale: 1.0,
        heightfield: terrain::surface(params, elevation, &ends, &mut stream("elevation")),
        semantics: ground::semantics(&params.grid, &params.ground, ground, &mut stream("semantics")),
        obstacles: Vec::new(),
        tasks: Vec::new(),
        id: id.clone(),
    };
    furnish(&mut world, &params.obstacles, &params.path, &ends, &mut stream("obstacles"))?;
    Ok(world)
}

/// Draws obstacles until there is a path from every start to its goal, and gives the world its tasks.
///
/// # Errors
/// If the rules leave no room or no way.
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
        world.obstacles = obstacles(params, world.density, ends, rng)
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
///
/// # Errors
/// If there is no way.
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

/// The ground of a world: the mix's shares of the count, cumulatively rounded, rigid first.
fn ground_of(params: &GeneratorParams, index: usize, count: usize) -> Terrain {
    let mix = params.ground.mix;
    let total = u128::from(mix.rigid) + u128::from(mix.deformable) + u128::from(mix.mixed);
    let mut share = 0u128;
    for ground in Terrain::ALL {
        share += u128::from(mix.get(ground));
        // index + ½ < count · share / total, in whole numbers.
        if (2 * index as u128 + 1) * total < 2 * count as u128 * share {
            return ground;
        }
    }
    // Only rounding at the very end comes here: the last kind that has a share.
    Terrain::ALL.into_iter().rev().find(|&g| mix.get(g) > 0).unwrap_or(Terrain::Rigid)
}

/// Start and goal of each task: opposite each other on the circle, in millimetres.
fn ends(t: &TaskParams) -> Vec<[[f64; 2]; 2]> {
    let millimetres = |v: f64| (v * 1000.0).round() / 1000.0 + 0.0;
    (0..t.count)
        .map(|k| {
            let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * k as f64 / t.count as f64);
            let p = [c, s].map(|v| millimetres(t.radius * v));
            [p, p.map(|v| 0.0 - v)]
        })
        .collect()
}

/// Boulders, then trees, each drawn uniformly and kept if it is far enough from the others and from every start and
/// goal. Distances are in plan. An error is the index of the obstacle that found no place.
fn obstacles(
    o: &ObstacleParams,
    density: Density,
    ends: &[[[f64; 2]; 2]],
    rng: &mut Stream,
) -> Result<Vec<Obstacle>, usize> {
    let millimetres = |v: f64| (v * 1000.0).round() / 1000.0;
    let boulders = o.boulders.get(density);
    let mut out: Vec<Obstacle> = Vec::new();
    for index in 0..boulders + o.trees.get(density) {
        let kind = if index < boulders {
            let scale = rng.uniform(o.boulder_scale[0], o.boulder_scale[1]);
            let size = o.boulder_size.map(|l| millimetres(l * scale));
            // A shape's name of at most ten digits is enough for shapes that differ, and can be read.
            ObstacleKind::Boulder { size, seed: rng.below(1 << 32) }
        } else {
            ObstacleKind::Trunk { radius: o.trunk_radius, height: o.trunk_height }
        };
        let yaw = millimetres(rng.uniform(-std::f64::consts::PI, std::f64::consts::PI));
        let free = |p: [f64; 2]| {
            let far = |q: [f64; 2], least| vb_math::hypot(p[0] - q[0], p[1] - q[1]) >= least;
            ends.iter().flatten().all(|&q| far(q, o.task_clearance))
                && out.iter().all(|other| far([other.x, other.y], o.spacing))
        };
        let place = (0..o.attempts)
            .map(|_| [0; 2].map(|_| millimetres(rng.uniform(-o.extent, o.extent))))
            .find(|&p| free(p))
            .ok_or(index)?;
        let mut obstacle = Obstacle { x: place[0], y: place[1], yaw, buried: 0.0, kind };
        obstacle.buried = millimetres(o.buried * obstacle.size()[2]);
        out.push(obstacle);
    }
    Ok(out)
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
