//! World model: heightfield, semantics, obstacles, tasks, and their on-disk format.
//!
//! The world frame has its origin at the world's centre, x east, y north and z up; lengths are in metres, angles in
//! radians. Rasters are row-major with **row 0 in the south** (smallest y) and column 0 in the west, so that indices
//! grow with coordinates; image files have row 0 in the north, as one looks at them, and are flipped on reading and
//! writing.

#![deny(missing_docs)]

mod check;
mod format;
pub mod geometry;
mod granular;
mod heightfield;
mod obstacle;
mod raster;
mod selector;
mod semantics;
mod shard;
mod task;
mod task_id;
mod world;

pub use check::{Flaw, Part};
pub use format::{
    Georeference, Provenance, SCHEMA, Suite, SuiteError, SuiteMeta, SuiteWriter, WorldInfo, read_obstacles,
};
pub use granular::{GranularBed, GranularMaterial};
pub use heightfield::{Facet, Heightfield, Nearby, SurfacePoint};
pub use obstacle::{Obstacle, ObstacleKind};
pub use raster::Raster;
pub use selector::{Selector, SelectorError};
pub use semantics::{Semantics, SoilLevel, SoilLevels, TerrainClass};
pub use shard::{SHARDS_VAR, Shard, ShardError};
pub use task::{Pose2, Task};
pub use task_id::{TaskId, TaskIdError};
pub use world::{Density, Elevation, Terrain, World};

/// The acceleration of gravity as the original has it, m/s² (Chrono's default, ChSystem.cpp).
pub const GRAVITY: f64 = 9.81;
