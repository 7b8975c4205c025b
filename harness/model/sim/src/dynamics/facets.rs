//! What the contacts of a hard wheel with single facets remember from step to step.

use crate::V3;
use crate::collision::MOST_FACETS;
use crate::tyre::Patch;

#[derive(Clone, Copy, Debug, Default)]
struct FacetPatch {
    facet: usize,
    normal: V3,
    patch: Patch,
}

/// Those of a wheel's last step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FacetPatches {
    count: usize,
    patches: [FacetPatch; MOST_FACETS],
}

/// Cosine of the angle up to which a contact that comes takes over what one that goes has been dragged by: a wheel
/// that rolls over an edge keeps its grip.
const ALIKE: f64 = 0.9;

impl FacetPatches {
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    fn known(&self) -> &[FacetPatch] {
        &self.patches[..self.count]
    }

    /// What the contact with a facet starts from: its own state; else that of the contact of the last step whose normal
    /// was most alike; else nothing.
    pub(super) fn before(&self, facet: usize, normal: &V3) -> Patch {
        if let Some(own) = self.known().iter().find(|p| p.facet == facet) {
            return own.patch;
        }
        let alike = self.known().iter().filter(|p| p.normal.dot(normal) > ALIKE);
        alike
            .max_by(|a, b| a.normal.dot(normal).total_cmp(&b.normal.dot(normal)))
            .map_or_else(Patch::default, |p| p.patch)
    }

    pub(super) fn push(&mut self, facet: usize, normal: V3, patch: Patch) {
        if let Some(place) = self.patches.get_mut(self.count) {
            *place = FacetPatch { facet, normal, patch };
            self.count += 1;
        }
    }

    /// The numbers that the next step depends on.
    pub(super) fn digest(&self) -> impl Iterator<Item = f64> + '_ {
        self.known().iter().flat_map(|p| [p.facet as f64, p.patch.deflection[0], p.patch.deflection[1]])
    }
}
