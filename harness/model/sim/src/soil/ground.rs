//! Which soil lies where in a world.

use super::grid::Grid;
use super::law::{Soil, SoilLaw};
use super::set::SoilSet;
use crate::error::SimError;
use vb_world::World;

#[derive(Clone, Debug)]
pub(crate) struct SoilGround {
    soils: Vec<Soil>,
    /// For each patch of the semantics the index of its soil, or `RIGID` or `GRANULAR`.
    patches: Vec<u8>,
    rows: usize,
    cols: usize,
    /// Patches a metre.
    per_metre: f64,
    /// Width of the strip within soil over which a load is handed over from rigid ground, m.
    pub(crate) blend: f64,
    /// Whether any of the soils has slip sinkage.
    digs: bool,
    /// Whether some patches are granular beds.
    has_beds: bool,
    pub(crate) grid: Grid,
}

const RIGID: u8 = u8::MAX;
/// In `patches`, those of granular beds.
const GRANULAR: u8 = u8::MAX - 1;
/// Width of the strip within soil over which a load is handed over from rigid ground, in the full-size world, m.
const BLEND: f64 = 0.1;

/// What lies under a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Under {
    /// Rigid ground only.
    Rigid,
    /// One soil only, by its number.
    Soil(u8),
    /// A granular bed only, whose forces are not the ground's.
    Granular,
    Mixed,
}

impl Under {
    /// Whether there may be soil.
    pub(crate) fn has_soil(self) -> bool {
        matches!(self, Self::Soil(_) | Self::Mixed)
    }
}

impl SoilGround {
    /// The soil of a world, with its memory at a resolution (m).
    ///
    /// # Errors
    /// Returns [`SimError::NoSoil`] if a class of the world has no soil in the set.
    pub(crate) fn new(world: &World, set: &SoilSet, resolution: f64) -> Result<Self, SimError> {
        let s = &world.semantics;
        let mut soils: Vec<Soil> = Vec::new();
        let mut patches = Vec::with_capacity(s.classes.len());
        // Which soil a law became: its tables take thousands of powers to make, and patches come by the thousand.
        let mut prepared: Vec<(&SoilLaw, u8)> = Vec::new();
        let mut is_granular = vec![false; s.classes.len()];
        for bed in &world.beds {
            // Their edges lie on borders of patches.
            let [low, high] = bed.corners();
            let half = 0.5 * s.patch;
            let first = s.patch_index(low[0] + half, low[1] + half);
            let last = s.patch_index(high[0] - half, high[1] - half);
            for row in first / s.cols..=last / s.cols {
                is_granular[row * s.cols + first % s.cols..=row * s.cols + last % s.cols].fill(true);
            }
        }
        for (&class, &is_granular) in s.classes.iter().zip(&is_granular) {
            if is_granular {
                patches.push(GRANULAR);
                continue;
            }
            let Some(level) = s.soil.of(class) else {
                patches.push(RIGID);
                continue;
            };
            let law = set.law(class, level).ok_or_else(|| SimError::NoSoil {
                world: world.id.clone(),
                class: class.name(),
                set: set.name.clone(),
            })?;
            let known = prepared.iter().find(|(l, _)| *l == law).map(|(_, index)| *index);
            patches.push(known.unwrap_or_else(|| {
                let soil = law.prepare();
                let index = soils.iter().position(|s| *s == soil).unwrap_or_else(|| {
                    soils.push(soil);
                    soils.len() - 1
                });
                prepared.push((law, index as u8));
                index as u8
            }));
        }
        let half = [world.heightfield.half_x(), world.heightfield.half_y()];
        Ok(Self {
            digs: soils.iter().any(Soil::digs),
            has_beds: !world.beds.is_empty(),
            soils,
            patches,
            rows: s.rows,
            cols: s.cols,
            per_metre: 1.0 / s.patch,
            blend: BLEND * world.scale,
            grid: Grid::new(half, resolution),
        })
    }

    /// One soil throughout, over a rectangle of half extents `half` about the origin.
    pub(crate) fn of_one(soil: Soil, half: [f64; 2], resolution: f64) -> Self {
        let side = 2.0 * half[0].max(half[1]);
        Self {
            digs: soil.digs(),
            has_beds: false,
            soils: vec![soil],
            patches: vec![0],
            rows: 1,
            cols: 1,
            per_metre: 1.0 / side,
            blend: BLEND,
            grid: Grid::new(half, resolution),
        }
    }

    /// Rigid ground throughout.
    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self {
            digs: false,
            has_beds: false,
            soils: Vec::new(),
            patches: vec![RIGID],
            rows: 1,
            cols: 1,
            per_metre: 1.0,
            blend: BLEND,
            grid: Grid::new([1.0, 1.0], 1.0),
        }
    }

    /// Whether the world is rigid throughout.
    pub(crate) fn is_empty(&self) -> bool {
        self.soils.is_empty() && !self.has_beds
    }

    /// Whether there is soil anywhere.
    pub(crate) fn has_soil(&self) -> bool {
        !self.soils.is_empty()
    }

    /// Whether the ground at a position is a granular bed.
    pub(crate) fn is_granular(&self, x: f64, y: f64) -> bool {
        self.has_beds && self.kind(self.row(y).0, self.column(x).0) == GRANULAR
    }

    #[inline]
    fn column(&self, x: f64) -> (usize, f64) {
        cell(x * self.per_metre + 0.5 * self.cols as f64, self.cols)
    }

    #[inline]
    fn row(&self, y: f64) -> (usize, f64) {
        cell(y * self.per_metre + 0.5 * self.rows as f64, self.rows)
    }

    #[inline]
    fn kind(&self, row: usize, col: usize) -> u8 {
        self.patches[row * self.cols + col]
    }

    /// The soil at a position; none on rigid ground.
    #[inline]
    pub(crate) fn soil_at(&self, x: f64, y: f64) -> Option<&Soil> {
        self.soils.get(usize::from(self.kind(self.row(y).0, self.column(x).0)))
    }

    /// Whether sinkage depends on slip anywhere.
    pub(crate) fn digs(&self) -> bool {
        self.digs
    }

    pub(crate) fn soils(&self) -> &[Soil] {
        &self.soils
    }

    /// The soil of a number that [`Under`] gives.
    #[inline]
    pub(crate) fn soil(&self, number: u8) -> Option<&Soil> {
        self.soils.get(usize::from(number))
    }

    /// What lies within `reach` of a position along x and y.
    #[inline]
    pub(crate) fn under(&self, x: f64, y: f64, reach: f64) -> Under {
        let (c0, c1) = (self.column(x - reach).0, self.column(x + reach).0);
        let (r0, r1) = (self.row(y - reach).0, self.row(y + reach).0);
        let first = self.kind(r0, c0);
        for row in r0..=r1 {
            for col in c0..=c1 {
                if self.kind(row, col) != first {
                    return Under::Mixed;
                }
            }
        }
        match first {
            RIGID => Under::Rigid,
            GRANULAR => Under::Granular,
            soil => Under::Soil(soil),
        }
    }

    /// Share of a load that soil carries, where rigid ground carries the rest: 0 on rigid ground, rising linearly to 1
    /// within `reach` of its edge, so that loads are handed over without a jump.
    pub(crate) fn fraction(&self, x: f64, y: f64, reach: f64) -> f64 {
        let span = 2.0 * reach * self.per_metre;
        let split = |low: (usize, f64), high: (usize, f64)| {
            if low.0 == high.0 { 1.0 } else { ((1.0 - low.1) / span).clamp(0.0, 1.0) }
        };
        let (c0, c1) = (self.column(x - reach), self.column(x + reach));
        let (r0, r1) = (self.row(y - reach), self.row(y + reach));
        let (u, v) = (split(c0, c1), split(r0, r1));
        let soil = |row: usize, col: usize| f64::from(u8::from(self.kind(row, col) != RIGID));
        let area = v * (u * soil(r0.0, c0.0) + (1.0 - u) * soil(r0.0, c1.0))
            + (1.0 - v) * (u * soil(r1.0, c0.0) + (1.0 - u) * soil(r1.0, c1.0));
        // The square of half side `reach` holds half of each where its middle is on the edge.
        (2.0 * area - 1.0).max(0.0)
    }
}

/// Index of the cell at a coordinate in cells, and how far within it; the nearest cell outside.
#[inline]
fn cell(f: f64, count: usize) -> (usize, f64) {
    let k = (f.max(0.0) as usize).min(count - 1);
    (k, f - k as f64)
}
