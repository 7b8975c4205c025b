//! Elevation data, a model learned from it, and surfaces drawn from the model.

pub mod bands;
pub mod course;
#[cfg(feature = "files")]
pub mod crs;
#[cfg(feature = "files")]
pub mod data;
mod decoder;
pub mod elevation;
pub mod fit;
pub mod generate;
pub mod model;
#[cfg(feature = "files")]
pub mod read;
pub mod repair;
pub mod shape;
pub mod shaping;
pub mod stats;
#[cfg(feature = "files")]
pub mod tiles;
#[cfg(feature = "files")]
mod utm;
#[cfg(feature = "files")]
pub mod write;

pub use course::Course;
pub use elevation::ElevationImage;
pub use generate::{GenerateError, Request, fraction};
pub use model::{Header, Model, ModelError};
pub use shaping::{ShapeParams, Shaping, Swell};
