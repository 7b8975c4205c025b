//! Worlds that are there twice.

use super::{Findings, Rule};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use vb_world::{Heightfield, Part, World};

/// What worlds are told apart by; of each world only hashes are kept.
#[derive(Default)]
pub(super) struct Fingerprints {
    seen: Vec<Fingerprint>,
}

struct Fingerprint {
    id: String,
    /// Ground, obstacles, beds and tasks.
    rest: u64,
    heights: u64,
    /// The same for heights that are turned or mirrored.
    shape: u64,
}

impl Fingerprints {
    /// Takes a world in, and says of which earlier one it is a double.
    pub(super) fn add(&mut self, world: &World, findings: &mut Findings<'_>) {
        let [heights, shape] = fingerprint(&world.heightfield);
        let rest =
            hash(&format!("{:?} {:?} {:?} {:?}", world.semantics, world.obstacles, world.tasks, world.beds));
        let new = Fingerprint { id: world.id.clone(), rest, heights, shape };
        // All level surfaces are equal.
        let (low, high) = world.heightfield.range();
        let is_level = low == high;
        let twin = |same: &dyn Fn(&Fingerprint) -> bool| self.seen.iter().find(|f| same(f)).map(|f| &f.id);
        if let Some(id) = twin(&|f| (f.heights, f.rest) == (heights, rest)) {
            let problem = format!(
                "heights, terrain, obstacles, beds and tasks equal those of {id}: remove one of the two"
            );
            findings.error(Rule::Content, Part::World, "id", &problem);
        } else if let Some(id) = twin(&|f| f.heights == heights && !is_level) {
            let problem = format!("has the heights of {id}: use another surface, or remove one of the two");
            findings.warn(Rule::Content, Part::Elevation, "heights", &problem);
        } else if let Some(id) = twin(&|f| f.shape == shape && !is_level) {
            let problem = format!(
                "has the heights of {id}, rotated or mirrored: use another surface, or remove one of the two"
            );
            findings.warn(Rule::Content, Part::Elevation, "heights", &problem);
        }
        self.seen.push(new);
    }
}

fn hash(text: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}

/// Hash of the heights as they are, and the least one over their eight turns and mirror images.
fn fingerprint(h: &Heightfield) -> [u64; 2] {
    let all: Vec<u64> = (0..8).map(|k| turned(h, k)).collect();
    [all[0], all.iter().copied().min().unwrap_or(all[0])]
}

/// Hash of the heights read along other axes: bit 0 exchanges rows and columns, bits 1 and 2 reverse them.
fn turned(h: &Heightfield, turn: u8) -> u64 {
    let swap = turn & 1 != 0;
    let (outer, inner) = if swap { (h.cols(), h.rows()) } else { (h.rows(), h.cols()) };
    let mut hasher = DefaultHasher::new();
    (outer, inner, h.resolution().to_bits()).hash(&mut hasher);
    for i in 0..outer {
        let i = if turn & 2 != 0 { outer - 1 - i } else { i };
        for j in 0..inner {
            let j = if turn & 4 != 0 { inner - 1 - j } else { j };
            let z = if swap { h.node(j, i) } else { h.node(i, j) };
            // 0 and −0 are one height.
            (z + 0.0).to_bits().hash(&mut hasher);
        }
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_that_is_turned_or_mirrored_has_the_same_shape_and_another_has_not() {
        let field = |z: [f64; 6], rows, cols| Heightfield::new(rows, cols, 1.0, z.to_vec());
        let [own, shape] = fingerprint(&field([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2, 3));
        // Mirrored from west to east; turned by a quarter.
        for other in
            [field([3.0, 2.0, 1.0, 6.0, 5.0, 4.0], 2, 3), field([3.0, 6.0, 2.0, 5.0, 1.0, 4.0], 3, 2)]
        {
            let [o, s] = fingerprint(&other);
            assert!(o != own && s == shape);
        }
        assert_ne!(fingerprint(&field([1.0, 2.0, 3.0, 4.0, 6.0, 5.0], 2, 3))[1], shape);
    }
}
