//! Elevation data, a model learned from it, and surfaces drawn from the model.

pub mod data;
pub mod raster;
pub mod read;
pub mod repair;
pub mod tiles;

pub use raster::Raster;
