//! What a world with a vehicle in it looks like, as a picture in red, green and blue, computed without a GPU.
//!
//! A [`Painter`] prepares what stays as it is in a trial: the colours of the ground with light and shadow, the solids of
//! obstacles and vehicle. [`Painter::picture`] then draws a [`Moment`] as seen by a [`View`]. The same arguments give
//! the same bytes on every machine.
//!
//! A picture is made in two steps. Triangles are drawn on a canvas (`canvas`) of 2 × 2 samples a pixel, which keeps for
//! each sample how near the nearest surface is and what it belongs to. Then each pixel is coloured (`develop`): where
//! the camera sees the ground, its place in the world follows from that nearness, and colour, shadow, ruts and marks
//! are looked up there. Pixels whose samples all show the same surface are coloured once.

mod camera;
mod canvas;
mod develop;
mod eight;
mod error;
mod grains;
mod ground;
mod light;
mod marks;
mod painter;
mod pixel;
mod solid;
mod texture;
mod tracks;
mod vehicle;

pub use camera::{Sight, View};
pub use error::RenderError;
pub use painter::{Moment, Painter, Size};
pub use pixel::Change;

type V3 = nalgebra::Vector3<f64>;

/// Red, green and blue in sRGB.
type Colour = [u8; 3];
