//! The content of a suite in figures: by world, and over all worlds of a level, a class or a density.

mod roughness;
mod summary;
pub mod tables;
#[cfg(test)]
mod tests;
mod world;

pub use roughness::{Angles, CLEARANCE, OCTAVES, Roughness};
pub use summary::{Histogram, Summary};
pub use tables::Table;
pub use world::{ClassShare, Kinds, Slopes, TaskStatistics, WorldStatistics};

use crate::proof::Proof;
use serde::Serialize;
use std::collections::BTreeMap;
use summary::Tally;
use vb_world::{
    Density, Elevation, Provenance, SoilLevel, Suite, SuiteError, TaskId, Terrain, TerrainClass, World,
};

/// The number of worlds with one choice of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Cell {
    pub elevation: Elevation,
    pub terrain: Terrain,
    pub density: Density,
    pub worlds: usize,
}

/// The surfaces of an elevation level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    pub elevation: Elevation,
    /// The standard deviation of the height within a world, over worlds, m.
    pub height_std: Summary,
    /// The height of the highest above the lowest node of a world, over worlds, m.
    pub relief: Summary,
    /// The slopes of all worlds together, degrees.
    pub slopes: Slopes,
    /// The roughness of all worlds together.
    pub roughness: Roughness,
    /// The heights about their world's mean, all worlds together, with bins in m.
    pub heights: Histogram,
    /// The slopes of all worlds together, with bins in degrees.
    pub slope_histogram: Histogram,
}

/// One class over all worlds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassFigures {
    pub class: TerrainClass,
    /// The share of the area of all worlds, 0 to 1.
    pub fraction: f64,
    /// The number of worlds in which the class occurs.
    pub worlds: usize,
    /// The friction, weighted by area; `None` where the ground yields.
    pub friction: Option<Weighted>,
    /// The numbers of worlds in which the class is soft, medium and hard; `None` where it is rigid.
    pub soil: Option<[usize; 3]>,
}

/// A value over an area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weighted {
    pub mean: f64,
    pub std: f64,
    pub min: f64,
    pub max: f64,
}

/// The obstacles of a density.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObstacleFigures {
    pub density: Density,
    pub worlds: usize,
    /// The numbers of all obstacles in these worlds, by kind.
    pub kinds: Kinds,
    pub per_world: Summary,
    /// The greater horizontal extent of a boulder or box, m; `None` if there are none.
    pub width: Option<Summary>,
    /// The height of a boulder or box above the ground at its centre, m; `None` if there are none.
    pub height: Option<Summary>,
    /// The share of the area under obstacles, over worlds, 0 to 1.
    pub covered: Summary,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskFigures {
    /// The straight distance from start to goal, m.
    pub straight: Summary,
    /// The length of the path, m.
    pub length: Summary,
    /// The length over the straight distance.
    pub ratio: Summary,
    /// The least distance from a path to an obstacle, m; `None` if there are no obstacles.
    pub clearance: Option<Summary>,
    /// The sum of all rises along a path, m.
    pub ascent: Summary,
    /// The greatest grade along a path, degrees.
    pub steepest: Summary,
    /// The lengths of the paths, with bins in m.
    pub lengths: Histogram,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SuiteStatistics {
    pub name: String,
    /// The version of the suite, as free text.
    pub version: String,
    pub description: String,
    pub provenance: String,
    pub hash: String,
    pub world_count: usize,
    pub task_count: usize,
    /// Every choice of labels, those without a world included: by elevation, then terrain, then density.
    pub cells: Vec<Cell>,
    /// The reliefs of the elevation levels that occur.
    pub relief: Vec<Relief>,
    /// The classes that occur, in label order.
    pub classes: Vec<ClassFigures>,
    /// The obstacles of the densities that occur.
    pub obstacles: Vec<ObstacleFigures>,
    /// The figures over all tasks; `None` without tasks.
    pub tasks: Option<TaskFigures>,
    /// The figures of tasks by density, for the densities that occur and have tasks.
    pub tasks_by_density: Vec<(Density, TaskFigures)>,
    /// A text on who has proven tasks, for people; `None` without a proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proof: Option<String>,
    /// The figures of each world, in the suite's order.
    #[serde(skip)]
    pub worlds: Vec<WorldStatistics>,
}

impl SuiteStatistics {
    /// Reads every world of a suite and measures it.
    ///
    /// # Errors
    /// Returns an error if a world cannot be read, has a flaw, or has another hash than the index states.
    pub fn of(suite: &Suite) -> Result<Self, SuiteError> {
        let mut survey = Survey::default();
        for info in suite.worlds() {
            survey.add(&suite.load_world(&info.id)?);
        }
        Ok(survey.finish(suite, None))
    }
}

/// A collector of the figures of a suite, world by world, so that only one need be in memory.
#[derive(Debug, Default)]
pub struct Survey {
    worlds: Vec<WorldStatistics>,
    slopes: BTreeMap<Elevation, Tally>,
    heights: BTreeMap<Elevation, Tally>,
    roughness: BTreeMap<Elevation, roughness::Sums>,
    /// Area (m²), sum and sum of squares of friction over it, least and greatest friction.
    friction: BTreeMap<TerrainClass, [f64; 5]>,
    /// Width and height above ground of each boulder and box.
    bodies: BTreeMap<Density, Vec<[f64; 2]>>,
}

impl Survey {
    /// Measures a world, takes its figures into those of the suite and returns them.
    pub fn add(&mut self, world: &World) -> &WorldStatistics {
        let (statistics, samples) = WorldStatistics::with_samples(world);
        merge(&mut self.slopes, world.elevation, samples.slopes);
        merge(&mut self.heights, world.elevation, samples.heights);
        let rough = roughness::Sums::of(&world.heightfield);
        self.roughness.entry(world.elevation).and_modify(|all| all.merge(&rough)).or_insert(rough);
        let s = &world.semantics;
        let area = s.patch * s.patch;
        for (&class, &mu) in s.classes.iter().zip(&s.friction) {
            let f = self.friction.entry(class).or_insert([0.0, 0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY]);
            *f = [f[0] + area, f[1] + area * mu, f[2] + area * mu * mu, f[3].min(mu), f[4].max(mu)];
        }
        let bodies = self.bodies.entry(world.density).or_default();
        for o in &world.obstacles {
            if !matches!(o.kind, vb_world::ObstacleKind::Trunk { .. }) {
                let [x, y, z] = o.size();
                bodies.push([x.max(y), z - o.buried]);
            }
        }
        self.worlds.push(statistics);
        &self.worlds[self.worlds.len() - 1]
    }

    /// The figures of all worlds that were added, which are those of `suite`, with its proof if there is one.
    #[must_use]
    pub fn finish(mut self, suite: &Suite, proof: Option<&Proof>) -> SuiteStatistics {
        for world in &mut self.worlds {
            for task in &mut world.tasks {
                task.proven =
                    proof.map(|p| TaskId::new(&world.id, &task.id).is_ok_and(|id| p.tasks.contains_key(&id)));
            }
        }
        let meta = suite.meta();
        let tasks = |of: &dyn Fn(&WorldStatistics) -> bool| {
            let tasks: Vec<_> = self.worlds.iter().filter(|w| of(w)).flat_map(|w| &w.tasks).collect();
            task_figures(&tasks)
        };
        SuiteStatistics {
            name: meta.name.clone(),
            version: meta.version.clone(),
            description: meta.description.clone(),
            provenance: provenance(&meta.provenance),
            hash: suite.hash(),
            world_count: self.worlds.len(),
            task_count: self.worlds.iter().map(|w| w.tasks.len()).sum(),
            cells: cells(&self.worlds),
            relief: Elevation::ALL.into_iter().filter_map(|e| self.relief(e)).collect(),
            classes: self.classes(),
            obstacles: Density::ALL.into_iter().filter_map(|d| self.obstacles(d)).collect(),
            tasks: tasks(&|_| true),
            tasks_by_density: Density::ALL
                .into_iter()
                .filter_map(|d| tasks(&|w| w.density == d).map(|t| (d, t)))
                .collect(),
            proof: proof.map(|p| {
                let mut planners: Vec<_> =
                    p.provers.iter().map(|w| format!("{} {}", w.planner, w.version)).collect();
                planners.dedup();
                let (vehicle, rules) = (&p.conditions.vehicle.name, &p.conditions.rules.name);
                format!("solved by {} with the vehicle {vehicle} and the rules {rules}", planners.join(", "))
            }),
            worlds: self.worlds,
        }
    }

    fn relief(&self, elevation: Elevation) -> Option<Relief> {
        let of = |value: fn(&WorldStatistics) -> f64| {
            Summary::of(self.worlds.iter().filter(|w| w.elevation == elevation).map(value))
        };
        let (slopes, heights) = (self.slopes.get(&elevation)?, self.heights.get(&elevation)?);
        Some(Relief {
            elevation,
            height_std: of(|w| w.height_std)?,
            relief: of(|w| w.relief)?,
            slopes: Slopes::of(slopes),
            roughness: self.roughness.get(&elevation)?.finish(),
            // Bins that hold several levels of an 8-bit elevation raster, between which single levels show no comb: a third
            // of the spread, and 2°.
            heights: heights.histogram(((of(|w| w.height_std)?.mean / 0.03).round() as i64).max(1)),
            slope_histogram: slopes.histogram(200),
        })
    }

    fn classes(&self) -> Vec<ClassFigures> {
        let total: f64 = self.friction.values().map(|f| f[0]).sum();
        let figures = |(&class, f): (&TerrainClass, &[f64; 5])| {
            let with: Vec<_> =
                self.worlds.iter().filter_map(|w| w.classes.iter().find(|c| c.class == class)).collect();
            let levels = SoilLevel::ALL.map(|level| with.iter().filter(|c| c.soil == Some(level)).count());
            let mean = f[1] / f[0];
            let variance = (f[2] / f[0] - mean * mean).max(0.0);
            let friction = Weighted { mean, std: variance.sqrt(), min: f[3], max: f[4] };
            let soft = class.is_deformable();
            ClassFigures {
                class,
                fraction: f[0] / total,
                worlds: with.len(),
                friction: (!soft).then_some(friction),
                soil: soft.then_some(levels),
            }
        };
        self.friction.iter().map(figures).collect()
    }

    fn obstacles(&self, density: Density) -> Option<ObstacleFigures> {
        let worlds: Vec<_> = self.worlds.iter().filter(|w| w.density == density).collect();
        let bodies = self.bodies.get(&density).map_or(&[][..], Vec::as_slice);
        let sum = |kind: fn(&Kinds) -> usize| worlds.iter().map(|w| kind(&w.obstacles)).sum();
        Some(ObstacleFigures {
            density,
            worlds: worlds.len(),
            kinds: Kinds {
                boulders: sum(|k| k.boulders),
                boxes: sum(|k| k.boxes),
                trunks: sum(|k| k.trunks),
            },
            per_world: Summary::of(worlds.iter().map(|w| w.obstacles.total() as f64))?,
            width: Summary::of(bodies.iter().map(|b| b[0])),
            height: Summary::of(bodies.iter().map(|b| b[1])),
            covered: Summary::of(worlds.iter().map(|w| w.covered))?,
        })
    }
}

fn merge(into: &mut BTreeMap<Elevation, Tally>, elevation: Elevation, tally: Tally) {
    match into.get_mut(&elevation) {
        Some(all) => all.merge(&tally),
        None => {
            into.insert(elevation, tally);
        }
    }
}

fn cells(worlds: &[WorldStatistics]) -> Vec<Cell> {
    let mut cells = Vec::with_capacity(27);
    for elevation in Elevation::ALL {
        for terrain in Terrain::ALL {
            for density in Density::ALL {
                let labels = (elevation, terrain, density);
                let worlds = worlds.iter().filter(|w| (w.elevation, w.terrain, w.density) == labels).count();
                cells.push(Cell { elevation, terrain, density, worlds });
            }
        }
    }
    cells
}

fn task_figures(tasks: &[&TaskStatistics]) -> Option<TaskFigures> {
    let of = |value: fn(&TaskStatistics) -> f64| Summary::of(tasks.iter().map(|t| value(t)));
    let mut lengths = Tally::new(1.0);
    // In whole millimetres, as paths are stored: a straight one of 120 m is in the bin that begins there.
    tasks.iter().for_each(|t| lengths.add((t.length * 1000.0).round() / 1000.0));
    let longest = lengths.max() - tasks.iter().map(|t| t.length).fold(f64::INFINITY, f64::min);
    Some(TaskFigures {
        straight: of(|t| t.straight)?,
        length: of(|t| t.length)?,
        ratio: of(|t| t.ratio)?,
        clearance: Summary::of(tasks.iter().filter_map(|t| t.clearance)),
        ascent: of(|t| t.ascent)?,
        steepest: of(|t| t.steepest)?,
        lengths: lengths.histogram(((longest / 40.0).ceil() as i64).max(1)),
    })
}

/// Where a suite comes from, as one says it.
fn provenance(p: &Provenance) -> String {
    match p {
        Provenance::Generated { generator, seed } => format!("generated by {generator}, seed {seed}"),
        Provenance::Imported { source, place: None } => format!("imported from {source}"),
        Provenance::Imported { source, place: Some(place) } => {
            format!("imported from {source} ({})", place.crs)
        }
        Provenance::Authored { by } => format!("authored by {by}"),
    }
}
