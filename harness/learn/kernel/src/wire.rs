//! What is sent to the GPU to be simulated there: vehicle, soils, worlds, as bytes.

use serde::{Deserialize, Serialize};
use vb_sim::{SimOptions, SoilSet};
use vb_vehicle::VehicleSpec;
use vb_world::{Density, Elevation, Heightfield, Obstacle, Semantics, Terrain, World};

/// All that simulations need beside their starts.
#[derive(Debug, Serialize, Deserialize)]
pub struct Setting {
    /// The vehicle, which was checked.
    pub vehicle: VehicleSpec,
    pub soils: SoilSet,
    pub options: SimOptions,
    /// The worlds, at the vehicle's scale.
    pub worlds: Vec<Place>,
}

/// A world without its tasks.
#[derive(Debug, Serialize, Deserialize)]
pub struct Place {
    elevation: Elevation,
    terrain: Terrain,
    density: Density,
    scale: f64,
    rows: usize,
    cols: usize,
    resolution: f64,
    heights: Vec<f64>,
    semantics: Semantics,
    obstacles: Vec<Obstacle>,
}

impl From<&World> for Place {
    fn from(world: &World) -> Self {
        let ground = &world.heightfield;
        Self {
            elevation: world.elevation,
            terrain: world.terrain,
            density: world.density,
            scale: world.scale,
            rows: ground.rows(),
            cols: ground.cols(),
            resolution: ground.resolution(),
            heights: ground.heights().to_vec(),
            semantics: world.semantics.clone(),
            obstacles: world.obstacles.clone(),
        }
    }
}

impl From<Place> for World {
    fn from(place: Place) -> Self {
        Self {
            id: String::new(),
            elevation: place.elevation,
            terrain: place.terrain,
            density: place.density,
            scale: place.scale,
            heightfield: Heightfield::new(place.rows, place.cols, place.resolution, place.heights),
            semantics: place.semantics,
            obstacles: place.obstacles,
            tasks: Vec::new(),
            beds: Vec::new(),
        }
    }
}

impl Setting {
    /// The bytes that are sent. Numbers keep all their bits.
    pub fn to_bytes(&self) -> Result<Vec<u8>, rmp_serde::encode::Error> {
        rmp_serde::to_vec_named(self)
    }

    /// What was sent; `None` for other bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        rmp_serde::from_slice(bytes).ok()
    }
}
