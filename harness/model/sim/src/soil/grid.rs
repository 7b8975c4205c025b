//! What the soil remembers: plastic sinkage and heaps, on tiles that exist where something has been.

/// Cells along a tile's side.
const SIDE: usize = 64;
const NONE: u32 = u32::MAX;

/// The memory of a patch of soil.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cell {
    /// Depth to which the soil was pressed and stays so, below its raised surface, m.
    pub(crate) plastic: f64,
    /// Height by which heaped-up soil raises the undisturbed surface, m.
    pub(crate) raised: f64,
}

/// A square grid of cells over a world, of which only touched tiles take memory.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    resolution: f64,
    inverse_resolution: f64,
    /// Position of the south-western corner.
    origin: [f64; 2],
    /// Tiles along x and y.
    count: [usize; 2],
    index: Vec<u32>,
    tiles: Vec<Cell>,
}

impl Grid {
    /// Covers a rectangle of half extents `half` about the origin.
    pub(crate) fn new(half: [f64; 2], resolution: f64) -> Self {
        let count = half.map(|h| (2.0 * h / (resolution * SIDE as f64)).ceil().max(1.0) as usize);
        Self {
            resolution,
            inverse_resolution: 1.0 / resolution,
            origin: half.map(|h| -h),
            count,
            index: vec![NONE; count[0] * count[1]],
            tiles: Vec::new(),
        }
    }

    pub(crate) fn resolution(&self) -> f64 {
        self.resolution
    }

    /// (tile, cell within it) of a position; none outside.
    #[inline]
    fn find(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let fx = (x - self.origin[0]) * self.inverse_resolution;
        let fy = (y - self.origin[1]) * self.inverse_resolution;
        if !(fx >= 0.0 && fy >= 0.0) {
            return None;
        }
        // By way of u32, which a conversion reaches with fewer instructions.
        let (i, j) = (fx as u32 as usize, fy as u32 as usize);
        let (ti, tj) = (i / SIDE, j / SIDE);
        if ti >= self.count[0] || tj >= self.count[1] {
            return None;
        }
        Some((tj * self.count[0] + ti, (j % SIDE) * SIDE + i % SIDE))
    }

    /// The cell at a position; undisturbed where nothing has been and outside.
    #[inline]
    pub(crate) fn at(&self, x: f64, y: f64) -> Cell {
        match self.find(x, y) {
            Some((tile, cell)) if self.index[tile] != NONE => {
                self.tiles[self.index[tile] as usize * SIDE * SIDE + cell]
            }
            _ => Cell::default(),
        }
    }

    /// The cell at a position; none outside, and where nothing has been on the whole tile.
    pub(crate) fn touched(&self, x: f64, y: f64) -> Option<&Cell> {
        let (tile, cell) = self.find(x, y)?;
        let slot = self.index[tile];
        (slot != NONE).then(|| &self.tiles[slot as usize * SIDE * SIDE + cell])
    }

    /// The number of the cell at a position, to be changed; none outside. It stays the same whatever else is touched.
    #[inline]
    pub(crate) fn touch(&mut self, x: f64, y: f64) -> Option<usize> {
        let (tile, cell) = self.find(x, y)?;
        if self.index[tile] == NONE {
            self.allocate(tile);
        }
        Some(self.index[tile] as usize * SIDE * SIDE + cell)
    }

    /// The cell of a number that [`Self::touch`] gave.
    #[inline]
    pub(crate) fn cell_mut(&mut self, number: usize) -> &mut Cell {
        &mut self.tiles[number]
    }

    /// The cell at a position, to be changed; none outside.
    #[inline]
    pub(crate) fn at_mut(&mut self, x: f64, y: f64) -> Option<&mut Cell> {
        self.touch(x, y).map(|number| self.cell_mut(number))
    }

    #[cold]
    fn allocate(&mut self, tile: usize) {
        self.index[tile] = (self.tiles.len() / (SIDE * SIDE)) as u32;
        self.tiles.resize(self.tiles.len() + SIDE * SIDE, Cell::default());
    }

    /// Every touched cell with its centre, in the order of positions.
    pub(crate) fn cells(&self) -> impl Iterator<Item = ([f64; 2], &Cell)> + '_ {
        self.index.iter().enumerate().filter(|(_, slot)| **slot != NONE).flat_map(move |(tile, &slot)| {
            let (ti, tj) = (tile % self.count[0], tile / self.count[0]);
            (0..SIDE * SIDE).map(move |cell| {
                let centre = |k: usize, t: usize, within: usize| {
                    self.origin[k] + ((t * SIDE + within) as f64 + 0.5) * self.resolution
                };
                let at = [centre(0, ti, cell % SIDE), centre(1, tj, cell / SIDE)];
                (at, &self.tiles[slot as usize * SIDE * SIDE + cell])
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_what_they_are_given_and_cost_memory_only_where_touched() {
        let mut g = Grid::new([64.0, 64.0], 0.1);
        assert_eq!(g.tiles.len(), 0);
        g.at_mut(3.16, -7.77).unwrap().plastic = 0.2;
        assert_eq!(g.at(3.11, -7.71).plastic, 0.2, "the same cell");
        assert_eq!(g.at(3.21, -7.77).plastic, 0.0, "its neighbour");
        assert_eq!(g.at(63.9, 63.9), Cell::default());
        assert_eq!(g.touched(3.11, -7.71).unwrap().plastic, 0.2);
        assert!(g.touched(63.9, 63.9).is_none() && g.touched(70.0, 0.0).is_none());
        assert_eq!(g.tiles.len(), SIDE * SIDE);
        assert!(g.at_mut(70.0, 0.0).is_none() && g.at(f64::NAN, 0.0) == Cell::default());
        let touched: Vec<_> = g.cells().filter(|(_, c)| c.plastic > 0.0).collect();
        assert_eq!(touched.len(), 1);
        let [x, y] = touched[0].0;
        assert!((x - 3.15).abs() < 1e-9 && (y + 7.75).abs() < 1e-9, "{x} {y}");
    }
}
