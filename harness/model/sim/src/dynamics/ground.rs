//! What the wheels stand on.

use crate::collision::Obstacles;
use crate::granular::Beds;
use crate::soil::{SoilGround, Under};
use vb_world::{Heightfield, Semantics};

/// The ground and what stands on it. Of all this a step changes the soil, which remembers ruts, and the grains of beds.
pub(crate) struct Ground<'a> {
    pub(crate) soil: &'a mut SoilGround,
    pub(crate) heightfield: &'a Heightfield,
    pub(crate) semantics: &'a Semantics,
    pub(crate) obstacles: &'a Obstacles,
    pub(crate) beds: &'a mut Beds,
}

impl Ground<'_> {
    /// What kind of ground lies within `reach` (m) of a place.
    pub(super) fn under(&self, x: f64, y: f64, reach: f64) -> Under {
        if self.soil.is_empty() { Under::Rigid } else { self.soil.under(x, y, reach) }
    }
}
