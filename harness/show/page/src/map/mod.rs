//! A world seen from above as SVG in metres, north up: pictures of its ground, obstacles, tasks, and what others draw over them.
//!
//! [`pictures`] paints the ground, [`map`] draws the world, and [`STYLE`] is how both look in a page.

mod drawing;
mod picture;

pub use drawing::{bar_length, line, map, simplified};
pub use picture::{
    Colour, EXAGGERATION, FRICTION, GRIPS, HEIGHTS, LAYERS, Pictures, SLOPES, SPREADS, STEEP, Sources,
    data_uri, ground, nodes_of_a_metre, on_scale, pictures,
};

/// The style of maps. The element around one, or the body, has the ground that is shown in its attribute `data-ground`:
/// `classes`, `heights`, `slopes` or `friction`.
pub const STYLE: &str = include_str!("map.css");
