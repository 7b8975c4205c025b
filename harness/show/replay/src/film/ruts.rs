//! How the ground had changed at a moment.

use crate::Motion;
use vb_world::World;

/// Cells along a side of a tile.
const TILE: usize = 64;

/// The changes of the ground during a run, for any moment of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ruts {
    /// The side of a cell, m; 0 where nothing is known.
    side: f64,
    half: [f64; 2],
    tiles_across: usize,
    /// For each tile that was touched the number of each cell's list plus one, and 0 for a cell that was not.
    tiles: Vec<Option<Box<[u32]>>>,
    /// For each cell that was touched when it lay how much higher than at first, s and m, in the order of time.
    lists: Vec<Vec<(f64, f64)>>,
}

impl Ruts {
    pub(crate) fn new(motion: &Motion, world: &World) -> Self {
        let side = motion.soil_resolution;
        let half = [world.heightfield.half_x(), world.heightfield.half_y()];
        if motion.ruts.is_empty() || side <= 0.0 {
            return Self::default();
        }
        let across = |half: f64| (2.0 * half / side) as usize / TILE + 1;
        let (tiles_across, tiles_down) = (across(half[0]), across(half[1]));
        let mut ruts = Self {
            side,
            half,
            tiles_across,
            tiles: vec![None; tiles_across * tiles_down],
            lists: Vec::new(),
        };
        for rut in &motion.ruts {
            let Some((tile, cell)) = ruts.place(rut.at[0], rut.at[1]) else { continue };
            let tile = ruts.tiles[tile].get_or_insert_with(|| vec![0; TILE * TILE].into());
            if tile[cell] == 0 {
                ruts.lists.push(Vec::new());
                tile[cell] = ruts.lists.len() as u32;
            }
            ruts.lists[tile[cell] as usize - 1].push((rut.time, rut.change()));
        }
        ruts
    }

    /// Whether the ground never changed, or nothing is known of it.
    pub(crate) fn is_empty(&self) -> bool {
        self.lists.is_empty()
    }

    /// The tile and the cell in it in which a place lies.
    fn place(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let cell = |v: f64, half: f64| {
            let at = (v + half) / self.side;
            (at >= 0.0 && v <= half).then_some(at as usize)
        };
        let (col, row) = (cell(x, self.half[0])?, cell(y, self.half[1])?);
        Some(((row / TILE) * self.tiles_across + col / TILE, (row % TILE) * TILE + col % TILE))
    }

    /// By how much the ground at a place was higher at a time than at first, m; none where nothing had touched it.
    pub(crate) fn change(&self, time: f64, x: f64, y: f64) -> Option<f64> {
        let (tile, cell) = self.place(x, y)?;
        let list = self.tiles.get(tile)?.as_ref()?[cell].checked_sub(1)?;
        let told = &self.lists[list as usize];
        let before = told.partition_point(|(t, _)| *t <= time);
        Some(told[before.checked_sub(1)?].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Repeat, Rut};
    use vb_world::{Heightfield, TerrainClass};

    #[test]
    fn the_ground_is_as_it_was_told_last() {
        let world = World::uniform("w", Heightfield::flat(11, 11, 1.0, 0.0), TerrainClass::Sand, 0.5);
        let rut = |time, x, y, depth| Rut { time, at: [x, y], depth, raised: 0.0 };
        let motion = Motion {
            repeat: Repeat::Exact,
            frames: Vec::new(),
            steering: Vec::new(),
            wheels: 0,
            wheel_frames: Vec::new(),
            contacts: Vec::new(),
            ruts: vec![rut(1.0, 0.05, 0.05, 0.02), rut(2.0, 0.05, 0.05, 0.07), rut(2.0, -4.95, 4.95, 0.01)],
            soil_resolution: 0.1,
            grains: crate::Grains::default(),
        };
        let ruts = Ruts::new(&motion, &world);
        assert_eq!(ruts.change(0.9, 0.03, 0.08), None, "before the wheel came");
        assert_eq!(ruts.change(1.0, 0.03, 0.08), Some(-0.02));
        assert_eq!(ruts.change(5.0, 0.03, 0.08), Some(-0.07));
        assert_eq!(ruts.change(5.0, 0.13, 0.08), None, "the next cell");
        assert_eq!(ruts.change(5.0, -4.99, 4.99), Some(-0.01));
        assert_eq!(ruts.change(5.0, 5.5, 0.0), None, "outside of the world");
        assert!(!ruts.is_empty() && Ruts::default().is_empty());
    }
}
