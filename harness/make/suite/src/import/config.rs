//! The original's `config{id}_{difficulty}.yaml`. Fields that mean nothing to us are passed over.

use serde::Deserialize;
use vb_world::{Density, Elevation, Terrain, TerrainClass};

#[derive(Deserialize)]
pub(crate) struct Config {
    pub(crate) obstacle_density: Density,
    pub(crate) obstacles: Obstacles,
    pub(crate) positions: Vec<Pair>,
    pub(crate) terrain: TerrainBlock,
    pub(crate) terrain_type: Terrain,
    pub(crate) textures: Vec<Texture>,
}

#[derive(Deserialize)]
pub(crate) struct Obstacles {
    pub(crate) rocks: Vec<Rock>,
    pub(crate) trees: Vec<Tree>,
}

#[derive(Deserialize)]
pub(crate) struct Rock {
    pub(crate) position: Position,
    pub(crate) scale: f64,
}

#[derive(Deserialize)]
pub(crate) struct Tree {
    pub(crate) position: Position,
}

#[derive(Deserialize)]
pub(crate) struct Position {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Where the original's simulator centres the collision box. It was looked up at a wrong place: up to 2.8 m above
    /// or below the ground (envs/utils/asset_utils.py).
    pub(crate) z: f64,
}

#[derive(Deserialize)]
pub(crate) struct Pair {
    pub(crate) start: [f64; 3],
    pub(crate) goal: [f64; 3],
}

#[derive(Deserialize)]
pub(crate) struct TerrainBlock {
    pub(crate) difficulty: Difficulty,
    /// Half the number of pixels along x and y.
    pub(crate) length: f64,
    pub(crate) width: f64,
    pub(crate) min_height: f64,
    pub(crate) max_height: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Difficulty {
    Low,
    Mid,
    High,
}

impl Difficulty {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Mid => "mid",
            Self::High => "high",
        }
    }

    pub(crate) fn elevation(self) -> Elevation {
        match self {
            Self::Low => Elevation::Low,
            Self::Mid => Elevation::Medium,
            Self::High => Elevation::High,
        }
    }
}

#[derive(Deserialize)]
pub(crate) struct Texture {
    /// Patch row from the north and column from the west.
    pub(crate) index: [usize; 2],
    pub(crate) is_deformable: bool,
    pub(crate) terrain_type: TerrainClass,
    pub(crate) friction: Option<f64>,
}
