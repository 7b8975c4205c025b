//! What a network makes of the ground at every place and heading.

use vb_sdk::HeightMap;
use vb_sdk::mppi::{LANES, Lanes};
use vb_sdk::nn::{Network, Scratch, Weights, WeightsError};

use crate::terrain::{Nodes, PATCH, Terrain};

/// Numbers that the network gives for each place and heading.
pub const CHANNELS: usize = 8;
/// Headings of the table.
pub const HEADINGS: usize = 16;

/// A direction as a number of headings, from 0 to [`HEADINGS`]. Headings lie at equal distances along the square whose corners are
/// the axes: nearly equal angles, without a trigonometric function.
#[must_use]
pub fn around(cos: f32, sin: f32) -> f32 {
    let sum = (cos.abs() + sin.abs()).max(1e-6);
    let around = match (cos >= 0.0, sin >= 0.0) {
        (true, true) => sin / sum,
        (false, true) => 1.0 - cos / sum,
        (false, false) => 2.0 - sin / sum,
        (true, false) => 3.0 + cos / sum,
    };
    around * (HEADINGS / 4) as f32
}

/// The heading of the table that is nearest to a direction.
#[must_use]
pub fn heading_of(cos: f32, sin: f32) -> usize {
    // What is no number becomes 0.
    (around(cos, sin) + 0.5) as usize % HEADINGS
}

/// The cosine and the sine of a heading of the table.
#[must_use]
pub fn heading(index: usize) -> [f32; 2] {
    let around = (index % HEADINGS) as f32 / (HEADINGS / 4) as f32;
    let along = around % 1.0;
    let [x, y] = match around as usize {
        0 => [1.0 - along, along],
        1 => [-along, 1.0 - along],
        2 => [along - 1.0, -along],
        _ => [along, along - 1.0],
    };
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

/// [`CHANNELS`] numbers at every node of a grid, for each heading.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// By heading, row and column.
    values: Vec<[f32; CHANNELS]>,
    rows: usize,
    cols: usize,
    per_metre: f32,
    origin: [f32; 2],
}

impl Table {
    /// The table of the network `ground`.
    ///
    /// # Errors
    /// Returns an error if the weights lack it.
    pub fn of(heights: &HeightMap, terrain: &Terrain, weights: &Weights) -> Result<Self, WeightsError> {
        Ok(Self::new(heights, terrain, &weights.network("ground", PATCH, CHANNELS)?))
    }

    /// Evaluates a network of [`PATCH`] inputs and [`CHANNELS`] outputs on the patch at every node of a map of heights, of which a
    /// terrain was made.
    #[must_use]
    pub fn new(heights: &HeightMap, terrain: &Terrain, network: &Network) -> Self {
        let frame = heights.frame;
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let mut values = vec![[0.0; CHANNELS]; HEADINGS * rows * cols];
        let (mut patch, mut output) = ([[0.0; LANES]; PATCH], [[0.0; LANES]; CHANNELS]);
        let mut scratch = Scratch::default();
        let nodes = Nodes::new(heights, terrain);
        for h in 0..HEADINGS {
            let patches = terrain.patches(&nodes, heading(h));
            for row in 0..rows {
                for first in (0..cols).step_by(LANES) {
                    patches.at(row, first, &mut patch);
                    network.run(&patch, &mut output, &mut scratch);
                    let own = &mut values[(h * rows + row) * cols + first..][..LANES.min(cols - first)];
                    for (l, value) in own.iter_mut().enumerate() {
                        *value = std::array::from_fn(|c| output[c][l]);
                    }
                }
            }
        }
        let origin = [frame.origin_x as f32, frame.origin_y as f32];
        Self { values, rows, cols, per_metre: (1.0 / frame.resolution) as f32, origin }
    }

    /// The numbers at these places (m) and headings, interpolated between the four nodes about each; beyond the edge, those of the
    /// edge.
    pub fn at(&self, [x, y]: [&Lanes; 2], [cos, sin]: [&Lanes; 2], output: &mut [Lanes]) {
        for l in 0..LANES {
            let most = |n: usize| (n - 1) as f32;
            let c = ((x[l] - self.origin[0]) * self.per_metre).clamp(0.0, most(self.cols));
            let r = ((y[l] - self.origin[1]) * self.per_metre).clamp(0.0, most(self.rows));
            let (col, row) = ((c as usize).min(self.cols - 2), (r as usize).min(self.rows - 2));
            let (u, v) = (c - col as f32, r - row as f32);
            let i = (heading_of(cos[l], sin[l]) * self.rows + row) * self.cols + col;
            let (south, north) = (&self.values[i..i + 2], &self.values[i + self.cols..i + self.cols + 2]);
            for k in 0..CHANNELS {
                let low = south[0][k] + u * (south[1][k] - south[0][k]);
                let high = north[0][k] + u * (north[1][k] - north[0][k]);
                output[k][l] = low + v * (high - low);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_nearest_to_themselves_and_go_around() {
        for h in 0..HEADINGS {
            let [cos, sin] = heading(h);
            assert_eq!(heading_of(cos, sin), h);
            let angle = vb_sdk::math::atan2(f64::from(sin), f64::from(cos)).to_degrees().rem_euclid(360.0);
            // Within 5 degrees of equal angles.
            assert!((angle - 22.5 * h as f64).abs() < 5.0, "{h}: {angle}");
        }
        assert_eq!(heading_of(f32::NAN, 0.0), heading_of(f32::NAN, 0.0));
        // A full turn: -1 degree is nearest to 0.
        assert_eq!(heading_of(0.9998, -0.0175), 0);
    }
}
