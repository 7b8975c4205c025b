//! What the contacts of a wheel with obstacles remember from step to step.

use crate::collision::{MOST_OBSTACLES, ObstacleContact};
use crate::tyre::Patch;

/// What the contact with one obstacle remembers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObstaclePatch {
    obstacle: usize,
    pub(super) patch: Patch,
    /// How deep the wheel was in the obstacle a step ago, m.
    pub(super) depth: f64,
}

/// The contacts of a wheel's last step, one for each obstacle that it touched.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObstaclePatches {
    count: usize,
    patches: [ObstaclePatch; MOST_OBSTACLES],
    /// The depth (m) that a contact without memory starts from: 0, unless the wheel was put where it is.
    unknown: f64,
}

impl ObstaclePatches {
    /// Contacts of a wheel that was put where it is, however deep it is in an obstacle there.
    #[cfg(feature = "rig")]
    pub(super) fn at_any_depth() -> Self {
        Self { unknown: f64::MAX, ..Self::default() }
    }

    /// The memory of the contact with an obstacle in the last step; a fresh one if the wheel didn't touch it.
    pub(super) fn before(&self, contact: &ObstacleContact) -> ObstaclePatch {
        let known = self.patches[..self.count].iter().find(|p| p.obstacle == contact.obstacle);
        known.copied().unwrap_or(ObstaclePatch {
            obstacle: contact.obstacle,
            patch: Patch::default(),
            depth: self.unknown,
        })
    }

    pub(super) fn push(&mut self, patch: ObstaclePatch) {
        if let Some(place) = self.patches.get_mut(self.count) {
            *place = patch;
            self.count += 1;
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0 && self.unknown == 0.0
    }

    /// The numbers that the next step depends on.
    pub(super) fn digest(&self) -> impl Iterator<Item = f64> + '_ {
        let [x, y] = [0, 1].map(|k| move |p: &ObstaclePatch| p.patch.deflection[k]);
        self.patches[..self.count].iter().flat_map(move |p| [p.obstacle as f64, x(p), y(p), p.depth])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::V3;
    use crate::tyre::Contact;

    fn contact(obstacle: usize) -> ObstacleContact {
        let contact = Contact { point: V3::zeros(), normal: V3::z(), depth: 0.01 };
        ObstacleContact { obstacle, contact }
    }

    #[test]
    fn each_obstacle_has_its_own_memory_in_whatever_order_they_are_found() {
        let mut last = ObstaclePatches::default();
        for (obstacle, deflection) in [(7, 0.1), (3, 0.2)] {
            let mut own = last.before(&contact(obstacle));
            own.patch.deflection = [deflection, 0.0];
            own.depth = 0.5 * deflection;
            last.push(own);
        }
        for (obstacle, deflection) in [(3, 0.2), (7, 0.1), (5, 0.0)] {
            let own = last.before(&contact(obstacle));
            assert_eq!((own.patch.deflection[0], own.depth), (deflection, 0.5 * deflection), "{obstacle}");
        }
        assert_eq!(last.digest().count(), 8);
    }
}
