//! The sections that the original's simulator makes of the rigid patches, and the friction of each (`combine_rigid` in
//! its envs/terrain.py).
//!
//! For each class, in the order in which the classes first appear among the patches, the largest rectangle of patches
//! that are still free becomes a section, until none is left. A section has *one* friction value: that of the patch
//! which a loop over a Python set of its patches sees last, hence [`last_of_set`].

use vb_world::TerrainClass;

/// A rectangle of patches with one friction value. Rows count from the north, columns from the west.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Section {
    /// North-western patch.
    pub(crate) row: usize,
    /// North-western patch.
    pub(crate) col: usize,
    /// Number of patch rows.
    pub(crate) height: usize,
    /// Number of patch columns.
    pub(crate) width: usize,
    /// The patch (row, column) whose friction is that of the whole section.
    pub(crate) friction_from: (usize, usize),
}

impl Section {
    /// Its patches as (row, column), row by row.
    pub(crate) fn patches(&self) -> impl Iterator<Item = (usize, usize)> + Clone + use<> {
        let (row, col, height, width) = (self.row, self.col, self.height, self.width);
        (row..row + height).flat_map(move |i| (col..col + width).map(move |j| (i, j)))
    }
}

/// The sections of all rigid patches of an `n` × `n` world. `classes` is row-major with the north row first; `pixels`
/// is the number of pixels along a patch without the one it shares with its neighbour (8 in the release).
pub(crate) fn rigid_sections(classes: &[TerrainClass], n: usize, pixels: usize) -> Vec<Section> {
    let mut seen: Vec<TerrainClass> = Vec::new();
    for &class in classes.iter().filter(|c| !c.is_deformable()) {
        if !seen.contains(&class) {
            seen.push(class);
        }
    }
    let shapes = shapes(n, pixels);
    let mut sections = Vec::new();
    for class in seen {
        let mut free: Vec<bool> = classes.iter().map(|&c| c == class).collect();
        while let Some((row, col, height, width)) = largest_rectangle(&free, n, &shapes) {
            let mut section = Section { row, col, height, width, friction_from: (row, col) };
            section.friction_from = last_of_set(section.patches());
            section.patches().for_each(|(i, j)| free[i * n + j] = false);
            sections.push(section);
        }
    }
    sections
}

/// Rectangles as (width, height) in patches, in the order in which they are tried: by their area in pixels, largest
/// first; among equals the narrower, then the lower.
fn shapes(n: usize, pixels: usize) -> Vec<(usize, usize)> {
    let mut shapes: Vec<_> = (1..=n).flat_map(|w| (1..=n).map(move |h| (w, h))).collect();
    shapes.sort_by_key(|&(w, h)| std::cmp::Reverse((pixels * w + 1) * (pixels * h + 1)));
    shapes
}

/// The first shape that fits anywhere on free patches, at the first place row by row: (row, column, height, width).
fn largest_rectangle(
    free: &[bool],
    n: usize,
    shapes: &[(usize, usize)],
) -> Option<(usize, usize, usize, usize)> {
    // Free patches north and west of each corner of the grid.
    let side = n + 1;
    let mut count = vec![0usize; side * side];
    for i in 0..n {
        for j in 0..n {
            count[(i + 1) * side + j + 1] = count[i * side + j + 1] + count[(i + 1) * side + j]
                - count[i * side + j]
                + usize::from(free[i * n + j]);
        }
    }
    let inside = |i: usize, j: usize, h: usize, w: usize| {
        count[(i + h) * side + j + w] + count[i * side + j]
            - count[i * side + j + w]
            - count[(i + h) * side + j]
    };
    shapes.iter().find_map(|&(w, h)| {
        (0..=n - h)
            .flat_map(|i| (0..=n - w).map(move |j| (i, j)))
            .find(|&(i, j)| inside(i, j, h, w) == w * h)
            .map(|(i, j)| (i, j, h, w))
    })
}

/// The pair that a loop over a Python set meets last if these distinct pairs were added one after the other.
///
/// CPython (3.8 to 3.13) keeps a set in an open table in the order of slots. A pair goes to the slot given by the low
/// bits of its hash, or where that is taken to one of the nine behind it, or on by a sequence that the higher bits
/// drive; at 3/5 full the table grows fourfold and is filled anew in its old order (`Objects/setobject.c`). The
/// original ran on such a CPython.
///
/// # Panics
/// Panics if there are no pairs.
pub(crate) fn last_of_set(pairs: impl Iterator<Item = (usize, usize)>) -> (usize, usize) {
    let mut table: Vec<Option<(usize, usize)>> = vec![None; 8];
    for (k, pair) in pairs.enumerate() {
        insert(&mut table, pair);
        let (used, mask) = (k + 1, table.len() - 1);
        if used * 5 >= mask * 3 {
            // More than four times as many slots as pairs, in a power of two.
            let mut larger = vec![None; (4 * used + 1).next_power_of_two()];
            table.into_iter().flatten().for_each(|p| insert(&mut larger, p));
            table = larger;
        }
    }
    table.into_iter().flatten().last().expect("a section has patches")
}

/// Puts a pair that is not in the table into its slot.
fn insert(table: &mut [Option<(usize, usize)>], pair: (usize, usize)) {
    /// Slots tried in a row.
    const LINEAR_PROBES: u64 = 9;
    let mask = table.len() as u64 - 1;
    let mut perturb = pair_hash(pair);
    let mut slot = perturb & mask;
    loop {
        let probes = if slot + LINEAR_PROBES <= mask { LINEAR_PROBES } else { 0 };
        if let Some(free) = (slot..=slot + probes).find(|&s| table[s as usize].is_none()) {
            table[free as usize] = Some(pair);
            return;
        }
        perturb >>= 5;
        slot = slot.wrapping_mul(5).wrapping_add(1).wrapping_add(perturb) & mask;
    }
}

/// CPython's hash of a tuple of two small non-negative integers, whose own hashes are their values: xxHash's
/// accumulation without its last mixing (`Objects/tupleobject.c`, since 3.8).
fn pair_hash((a, b): (usize, usize)) -> u64 {
    const PRIME_1: u64 = 11_400_714_785_074_694_791;
    const PRIME_2: u64 = 14_029_467_366_897_019_727;
    const PRIME_5: u64 = 2_870_177_450_012_600_261;
    let mix = |acc: u64, lane: usize| {
        acc.wrapping_add((lane as u64).wrapping_mul(PRIME_2)).rotate_left(31).wrapping_mul(PRIME_1)
    };
    let hash = mix(mix(PRIME_5, a), b).wrapping_add(2 ^ (PRIME_5 ^ 3_527_539));
    // −1 means an error there, and is replaced.
    if hash == u64::MAX { 1_546_275_796 } else { hash }
}

#[cfg(test)]
mod tests {
    use super::*;
    use TerrainClass::{Clay, Mud, Wood};

    /// Expected values: CPython 3.11, `hash((i, j)) % 2**64` and `list({...})[-1]` after adding row by row.
    #[test]
    fn hashes_and_order_are_those_of_cpython() {
        let hashes = [
            ((0, 0), 9_988_604_870_027_030_631),
            ((0, 1), 16_496_245_626_129_029_056),
            ((3, 15), 13_865_362_051_753_533_500),
            ((15, 15), 12_306_551_139_672_935_295),
        ];
        for (pair, hash) in hashes {
            assert_eq!(pair_hash(pair), hash, "{pair:?}");
        }
        // (row, column, height, width) of a rectangle, and its last pair.
        let rectangles = [
            ((4, 5, 1, 1), (4, 5)),
            ((0, 0, 1, 4), (0, 0)),
            ((3, 3, 2, 2), (4, 3)),
            ((2, 2, 1, 5), (2, 5)),
            ((0, 0, 3, 5), (1, 3)),
            ((4, 1, 4, 7), (6, 3)),
            ((0, 0, 16, 16), (7, 8)),
            ((5, 0, 9, 16), (7, 8)),
            ((3, 0, 1, 16), (3, 11)),
            ((0, 7, 8, 9), (7, 14)),
            ((11, 2, 5, 4), (15, 3)),
        ];
        for ((row, col, height, width), last) in rectangles {
            let section = Section { row, col, height, width, friction_from: (row, col) };
            assert_eq!(last_of_set(section.patches()), last, "{section:?}");
        }
    }

    #[test]
    fn the_largest_rectangle_goes_first_and_wide_ones_yield_to_high_ones_of_the_same_area() {
        #[rustfmt::skip]
        let classes = [
            Clay, Clay, Clay, Wood,
            Clay, Wood, Wood, Wood,
            Clay, Wood, Wood, Mud,
            Mud,  Mud,  Clay, Mud,
        ];
        let sections = rigid_sections(&classes, 4, 8);
        let rectangles: Vec<_> = sections.iter().map(|s| (s.row, s.col, s.height, s.width)).collect();
        // Clay comes first as it appears first: 3 × 1 and 1 × 3 have the same area, the narrower goes first.
        let expected = [(0, 0, 3, 1), (0, 1, 1, 2), (3, 2, 1, 1), (1, 1, 2, 2), (0, 3, 2, 1)];
        assert_eq!(rectangles, expected);
    }
}
