//! Terrain features of a network at every position and heading.

use vb_sdk::HeightMap;
use vb_sdk::mppi::{LANES, Lanes};
use vb_sdk::nn::{FixedNetwork, FixedScratch, Pair, Weights, WeightsError};
use wide::i16x8;

use crate::terrain::{Nodes, PATCH, Terrain};

/// Features per position and heading.
pub const CHANNELS: usize = 8;
/// Headings of the table.
pub const HEADINGS: usize = 16;

/// A direction as a fractional heading index, from 0 to [`HEADINGS`]. Headings are equidistant along the square whose
/// corners are the axes: nearly equal angles, without a trigonometric function.
#[must_use]
pub(crate) fn around(cos: f32, sin: f32) -> f32 {
    let sum = (cos.abs() + sin.abs()).max(1e-6);
    let (c, s) = (cos / sum, sin / sum);
    let north = if cos >= 0.0 { s } else { 1.0 - c };
    let south = if cos >= 0.0 { 3.0 + c } else { 2.0 - s };
    let around = if sin >= 0.0 { north } else { south };
    around * (HEADINGS / 4) as f32
}

/// The table heading nearest to a direction.
#[must_use]
pub fn heading_of(cos: f32, sin: f32) -> usize {
    // NaN becomes 0.
    (around(cos, sin) + 0.5) as i32 as usize % HEADINGS
}

/// The table headings nearest to directions.
#[must_use]
pub(crate) fn headings_of([cos, sin]: [&Lanes; 2]) -> [usize; LANES] {
    std::array::from_fn(|l| heading_of(cos[l], sin[l]))
}

/// The cosine and the sine of a table heading.
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

/// [`CHANNELS`] features at every node of a grid, for each heading, in fixed point.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Indexed by heading, row and column.
    values: Vec<[i16; CHANNELS]>,
    rows: usize,
    cols: usize,
    per_metre: f32,
    origin: [f32; 2],
}

impl Table {
    /// Builds the table of the network `ground`.
    ///
    /// # Errors
    /// Returns an error if the weights lack the network.
    pub fn of(heights: &HeightMap, terrain: &Terrain, weights: &Weights) -> Result<Self, WeightsError> {
        Ok(Self::new(heights, terrain, &weights.fixed_network("ground", &[PATCH], CHANNELS)?))
    }

    /// Evaluates a network of [`PATCH`] inputs and [`CHANNELS`] outputs on the patch at every node of the elevation map
    /// of the terrain.
    #[must_use]
    pub fn new(heights: &HeightMap, terrain: &Terrain, network: &FixedNetwork) -> Self {
        let frame = heights.frame;
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let mut values = vec![[0; CHANNELS]; HEADINGS * rows * cols];
        let (mut patch, mut output) = ([[0.0; LANES]; PATCH], [[0; LANES]; CHANNELS]);
        let mut pairs = [Pair::default(); PATCH / 2];
        let mut scratch = FixedScratch::default();
        let nodes = Nodes::new(heights, terrain);
        for h in 0..HEADINGS {
            let patches = terrain.patches(&nodes, heading(h));
            for row in 0..rows {
                for first in (0..cols).step_by(LANES) {
                    patches.at(row, first, &mut patch);
                    Pair::fill(&mut pairs, &patch);
                    network.run(&pairs, &mut output, &mut scratch);
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

    /// The features for these positions (m) and headings, interpolated between the four nodes around each; positions
    /// outside the map are clamped to its edge.
    #[must_use]
    pub fn at(&self, [x, y]: [&Lanes; 2], headings: &[usize; LANES]) -> [[i16; CHANNELS]; LANES] {
        let most = |n: usize| (n - 1) as f32;
        let (last_col, last_row) = (most(self.cols), most(self.rows));
        let c: Lanes = x.map(|x| ((x - self.origin[0]) * self.per_metre).clamp(0.0, last_col));
        let r: Lanes = y.map(|y| ((y - self.origin[1]) * self.per_metre).clamp(0.0, last_row));
        let (end_col, end_row) = (self.cols as i32 - 2, self.rows as i32 - 2);
        let col: [i32; LANES] = c.map(|c| (c as i32).min(end_col));
        let row: [i32; LANES] = r.map(|r| (r as i32).min(end_row));
        // A fraction of 1 becomes 32767/32768.
        let part = |at: f32, node: i32| ((at - node as f32) * 32768.0) as i32;
        let u: [i32; LANES] = std::array::from_fn(|l| part(c[l], col[l]).min(32767));
        let v: [i32; LANES] = std::array::from_fn(|l| part(r[l], row[l]).min(32767));
        std::array::from_fn(|l| {
            let i = (headings[l] * self.rows + row[l] as usize) * self.cols + col[l] as usize;
            let around = &self.values[i..i + self.cols + 2];
            let (u, v) = (i16x8::splat(u[l] as i16), i16x8::splat(v[l] as i16));
            let between = |a: [i16; CHANNELS], b: [i16; CHANNELS], part: i16x8| -> [i16; CHANNELS] {
                (i16x8::new(a) + i16x8::new(b).saturating_sub(a.into()).mul_scale_round(part)).to_array()
            };
            let low = between(around[0], around[1], u);
            let high = between(around[self.cols], around[self.cols + 1], u);
            between(low, high, v)
        })
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
