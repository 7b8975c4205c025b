//! A world: all that a task happens in.

use crate::{Heightfield, Obstacle, Semantics, Task};

/// Elevation level of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Elevation {
    /// 30 % of the full relief.
    Low,
    /// 60 % of the full relief.
    Medium,
    /// The full relief.
    High,
}

/// What kind of ground a world has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ground {
    /// Rigid classes only.
    Rigid,
    /// Deformable classes only.
    Deformable,
    /// Both.
    Mixed,
}

/// Obstacle density of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Density {
    /// 10 boulders.
    Sparse,
    /// 20 boulders.
    Medium,
    /// 40 boulders.
    Dense,
}

/// A world at its own scale (see [`World::scaled`]).
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Name within the suite, e.g. `w001`.
    pub id: String,
    /// Elevation level.
    pub elevation: Elevation,
    /// Kind of ground.
    pub ground: Ground,
    /// Obstacle density.
    pub density: Density,
    /// The factor by which all lengths were multiplied: 1 for a world as stored.
    pub scale: f64,
    /// The ground surface.
    pub heightfield: Heightfield,
    /// Classes and friction.
    pub semantics: Semantics,
    /// Obstacles.
    pub obstacles: Vec<Obstacle>,
    /// Tasks in order.
    pub tasks: Vec<Task>,
}
