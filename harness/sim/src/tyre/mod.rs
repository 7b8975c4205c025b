//! Tyres: where a wheel meets the ground, and the forces in the contact plane.

mod brush;
mod envelope;

use crate::V3;
pub use brush::Brush;
pub(crate) use brush::BrushLaw;
pub use envelope::Envelope;

/// A wheel's contact with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Where the force acts, world, m.
    pub point: V3,
    /// Out of the ground.
    pub normal: V3,
    /// Radial deflection, m, > 0.
    pub depth: f64,
}
