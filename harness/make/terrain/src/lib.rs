//! Elevation data, a model learned from it, and surfaces drawn from the model.

pub mod bands;
pub mod crs;
pub mod data;
mod decoder;
pub mod elevation;
pub mod fit;
pub mod generate;
pub mod model;
pub mod read;
pub mod repair;
pub mod shape;
pub mod shaping;
pub mod stats;
pub mod tiles;
mod utm;
pub mod write;

pub use elevation::ElevationImage;
pub use generate::{GenerateError, Request, fraction};
pub use model::{Header, Model, ModelError};
pub use shaping::{ShapeParams, Shaping, Swell};
