//! The figures of one world.

use super::summary::{Summary, Tally};
use crate::clearance::Footprints;
use crate::path;
use serde::Serialize;
use vb_math::{angle::degrees, atan, hypot};
use vb_world::{
    Density, Elevation, Heightfield, Obstacle, ObstacleKind, SoilLevel, Task, Terrain, TerrainClass, World,
};

/// Width of the bins that slopes are counted in, degrees.
const SLOPE_BIN: f64 = 0.01;
/// Width of the bins that heights are counted in, m.
const HEIGHT_BIN: f64 = 0.01;

/// The slopes of the ground over 1 m, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slopes {
    pub p50: f64,
    pub p95: f64,
    pub p99: f64,
    pub max: f64,
}

impl Slopes {
    pub(crate) fn of(tally: &Tally) -> Self {
        // The middle of a bin may lie beyond all values, which a level world would show.
        let at = |q| tally.quantile(q).min(tally.max());
        Self { p50: at(0.50), p95: at(0.95), p99: at(0.99), max: tally.max() }
    }
}

/// The part of a world's ground that is of one class.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClassShare {
    pub class: TerrainClass,
    /// The share of the area, 0 to 1.
    pub fraction: f64,
    /// The level of the soil, where it yields.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soil: Option<SoilLevel>,
}

/// The number of obstacles of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Kinds {
    pub boulders: usize,
    pub boxes: usize,
    pub trunks: usize,
}

impl Kinds {
    #[must_use]
    pub fn of(obstacles: &[Obstacle]) -> Self {
        let mut kinds = Self::default();
        for o in obstacles {
            match o.kind {
                ObstacleKind::Boulder { .. } => kinds.boulders += 1,
                ObstacleKind::Box { .. } => kinds.boxes += 1,
                ObstacleKind::Trunk { .. } => kinds.trunks += 1,
            }
        }
        kinds
    }

    #[must_use]
    pub fn total(&self) -> usize {
        self.boulders + self.boxes + self.trunks
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskStatistics {
    /// The id of the task within the world.
    pub id: String,
    /// The straight distance from start to goal, m.
    pub straight: f64,
    /// The length of the global path, m.
    pub length: f64,
    /// The length over the straight distance, 1 or more.
    pub ratio: f64,
    /// The least distance from the path to an obstacle, m; `None` in a world without obstacles.
    pub clearance: Option<f64>,
    /// The sum of all rises along the path, from waypoint to waypoint, m.
    pub ascent: f64,
    /// The greatest grade up or down between two waypoints, degrees.
    pub steepest: f64,
    /// Whether somebody has done the task; `None` where the suite has no proof.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proven: Option<bool>,
}

impl TaskStatistics {
    fn of(task: &Task, ground: &Heightfield, footprints: &Footprints) -> Self {
        let straight = hypot(task.goal[0] - task.start.x, task.goal[1] - task.start.y);
        let length = path::length(&task.path);
        let (mut ascent, mut steepest) = (0.0, 0.0f64);
        for w in task.path.windows(2) {
            let rise = ground.height(w[1][0], w[1][1]) - ground.height(w[0][0], w[0][1]);
            let run = hypot(w[1][0] - w[0][0], w[1][1] - w[0][1]);
            ascent += rise.max(0.0);
            if run > 0.0 {
                steepest = steepest.max(degrees(atan(rise.abs() / run)));
            }
        }
        Self {
            id: task.id.clone(),
            straight,
            length,
            ratio: length / straight,
            clearance: footprints.closest(&task.path).map(|(_, n)| n.distance),
            ascent,
            steepest,
            proven: None,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorldStatistics {
    /// The id of the world within the suite.
    pub id: String,
    pub elevation: Elevation,
    pub terrain: Terrain,
    pub density: Density,
    /// The extent from west to east and from south to north, m.
    pub extent: [f64; 2],
    /// The distance between nodes, m.
    pub resolution: f64,
    /// The mean height of the nodes, m.
    pub height_mean: f64,
    /// The standard deviation of the nodes' height, m.
    pub height_std: f64,
    /// The height of the highest node above the lowest, m.
    pub relief: f64,
    /// The slopes of the ground over 1 m, degrees.
    pub slopes: Slopes,
    /// The classes that occur, in label order.
    pub classes: Vec<ClassShare>,
    /// The friction of the rigid patches, each of which has the same area; `None` where all ground yields.
    pub friction: Option<Summary>,
    pub obstacles: Kinds,
    /// The share of the area under obstacles, 0 to 1; where footprints overlap, both count.
    pub covered: f64,
    pub tasks: Vec<TaskStatistics>,
}

/// What the figures of a suite need of a world beyond its own.
pub(crate) struct Samples {
    /// Slopes over 1 m, degrees.
    pub(crate) slopes: Tally,
    /// Heights of the nodes about their mean, m.
    pub(crate) heights: Tally,
}

impl WorldStatistics {
    #[must_use]
    pub fn of(world: &World) -> Self {
        Self::with_samples(world).0
    }

    pub(crate) fn with_samples(world: &World) -> (Self, Samples) {
        let h = &world.heightfield;
        let n = h.heights().len() as f64;
        let mean = h.heights().iter().sum::<f64>() / n;
        let variance = h.heights().iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / n;
        let mut samples = Samples { slopes: slopes(h), heights: Tally::new(HEIGHT_BIN) };
        h.heights().iter().for_each(|z| samples.heights.add(z - mean));
        let (low, high) = h.range();
        let s = &world.semantics;
        let patches = s.classes.len() as f64;
        let classes = TerrainClass::ALL.into_iter().filter_map(|class| {
            let count = s.classes.iter().filter(|c| **c == class).count();
            (count > 0).then(|| ClassShare {
                class,
                fraction: count as f64 / patches,
                soil: s.soil.of(class),
            })
        });
        let rigid = s.classes.iter().zip(&s.friction).filter(|(c, _)| !c.is_deformable());
        let extent = [2.0 * h.half_x(), 2.0 * h.half_y()];
        let footprints = Footprints::new(&world.obstacles);
        let tasks = world.tasks.iter().map(|t| TaskStatistics::of(t, h, &footprints)).collect();
        let statistics = Self {
            id: world.id.clone(),
            elevation: world.elevation,
            terrain: world.terrain,
            density: world.density,
            extent,
            resolution: h.resolution(),
            height_mean: mean,
            height_std: variance.sqrt(),
            relief: high - low,
            slopes: Slopes::of(&samples.slopes),
            classes: classes.collect(),
            friction: Summary::of(rigid.map(|(_, &mu)| mu)),
            obstacles: Kinds::of(&world.obstacles),
            // Not `sum`, which is -0 of nothing.
            covered: footprints.outlines().map(area).fold(0.0, |a, b| a + b) / (extent[0] * extent[1]),
            tasks,
        };
        (statistics, samples)
    }
}

/// Slopes in degrees by central differences over 1 m to each side, or over one node where nodes are farther apart, at
/// every node that has such neighbours.
fn slopes(h: &Heightfield) -> Tally {
    let mut tally = Tally::new(SLOPE_BIN);
    let k = vb_page::map::nodes_of_a_metre(h.resolution()).min((h.rows().min(h.cols()) - 1) / 2).max(1);
    let run = 2.0 * k as f64 * h.resolution();
    for row in k..h.rows().saturating_sub(k) {
        for col in k..h.cols().saturating_sub(k) {
            let gx = (h.node(row, col + k) - h.node(row, col - k)) / run;
            let gy = (h.node(row + k, col) - h.node(row - k, col)) / run;
            tally.add(degrees(atan(hypot(gx, gy))));
        }
    }
    tally
}

/// Area of a polygon, m² (the shoelace formula).
fn area(outline: &[[f64; 2]]) -> f64 {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}
