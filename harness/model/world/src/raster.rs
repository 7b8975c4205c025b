//! A raster of values over the world.

/// Values on a grid of squares, row-major, row 0 in the south, column 0 in the west.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    /// The number of rows, from south to north.
    pub rows: usize,
    /// The number of columns, from west to east.
    pub cols: usize,
    /// The side of a square, m.
    pub resolution: f64,
    /// The centre (x, y) of the square (0, 0), m.
    pub origin: [f64; 2],
    /// The values, row-major.
    pub data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// The centre (x, y) of a square, m.
    #[must_use]
    pub fn centre(&self, row: usize, col: usize) -> [f64; 2] {
        [self.origin[0] + col as f64 * self.resolution, self.origin[1] + row as f64 * self.resolution]
    }

    /// The (row, col) of the square that holds (x, y); `None` outside. A shared edge belongs to the square in the east
    /// or north.
    #[must_use]
    pub fn cell(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let fx = (x - self.origin[0]) / self.resolution + 0.5;
        let fy = (y - self.origin[1]) / self.resolution + 0.5;
        let inside = fx >= 0.0 && fy >= 0.0 && fx < self.cols as f64 && fy < self.rows as f64;
        inside.then_some((fy as usize, fx as usize))
    }

    /// The value of a square.
    #[must_use]
    pub fn get(&self, row: usize, col: usize) -> T {
        self.data[row * self.cols + col]
    }
}
