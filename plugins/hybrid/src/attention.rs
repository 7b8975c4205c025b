//! Attention to terrain patches along the motion.
//!
//! The features of a patch depend only on its position and heading, so the table of the vehicle's own patch also serves
//! the patches ahead. A step looks up the features at [`PLACES`], weights them by motion and terrain, and takes their
//! mean. The idea follows Datar et al., *Terrain-Attentive Learning for Efficient 6-DoF Kinodynamic Modeling on
//! Vertically Challenging Terrain* (IROS 2024): the relevant terrain depends on the motion.

use vb_sdk::HeightMap;
use vb_sdk::mppi::{LANES, Lanes};
use vb_sdk::nn::{FixedNetwork, FixedScratch, Pair, Weights, WeightsError, from_fixed};
use wide::i16x8;

use crate::kinodynamics::TOLD;
use crate::table::{CHANNELS, Table, headings_of};
use crate::terrain::Terrain;

/// Attended positions, forward and to the left, in wheelbases; the first is the vehicle's own.
pub const PLACES: [[f32; 2]; 5] = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.6, 0.6], [1.6, -0.6]];

/// Offset of an attended position for this wheelbase, m.
#[must_use]
pub fn place(place: usize, [x, y]: [&Lanes; 2], [cos, sin]: [&Lanes; 2], wheelbase: f32) -> [Lanes; 2] {
    let [forward, left] = PLACES[place].map(|v| v * wheelbase);
    [
        std::array::from_fn(|l| x[l] + forward * cos[l] - left * sin[l]),
        std::array::from_fn(|l| y[l] + forward * sin[l] + left * cos[l]),
    ]
}

/// A positive weight that increases with z: z/2 + √(z²/4 + 1), Barron's squareplus (*Squareplus: A Softplus-Like
/// Algebraic Rectifier*, 2021), which needs no exponential.
#[must_use]
pub(crate) fn weight(z: f32) -> f32 {
    0.5 * z + (0.25 * z * z + 1.0).sqrt()
}

/// The table of terrain features, and the networks of the attention weights.
#[derive(Clone, Debug)]
pub struct Attention {
    table: Table,
    query: FixedNetwork,
    key: FixedNetwork,
}

impl Attention {
    /// Builds the attention of these weights over the elevation map of the terrain.
    ///
    /// # Errors
    /// Returns an error if the weights lack a network.
    pub fn new(heights: &HeightMap, terrain: &Terrain, weights: &Weights) -> Result<Self, WeightsError> {
        Ok(Self {
            table: Table::of(heights, terrain, weights)?,
            query: weights.fixed_network("query", &[TOLD], PLACES.len())?,
            key: weights.fixed_network("key", &[CHANNELS], 1)?,
        })
    }

    /// Terrain features for vehicles with this wheelbase and these state inputs: at their own positions, then the
    /// attention-weighted mean over all positions. Returns the attention weight per position; their sum is 1 for each
    /// vehicle.
    pub fn look(
        &self,
        (at, direction): ([&Lanes; 2], [&Lanes; 2]),
        wheelbase: f32,
        told: &[Pair],
        seen: &mut [Pair],
        scratch: &mut FixedScratch,
    ) -> [Lanes; PLACES.len()] {
        let mut asked = [[0; LANES]; PLACES.len()];
        self.query.run(told, &mut asked, scratch);
        let (own, mean) = seen.split_at_mut(CHANNELS / 2);
        let mut weights = [[0.0; LANES]; PLACES.len()];
        let mut total = [0.0; LANES];
        let headings = headings_of(direction);
        let there: [_; PLACES.len()] = std::array::from_fn(|k| {
            let [x, y] = place(k, at, direction, wheelbase);
            let there = self.table.at([&x, &y], &headings);
            let pairs = Pair::across(&there);
            if k == 0 {
                own.copy_from_slice(&pairs);
            }
            let mut key = [[0; LANES]];
            self.key.run(&pairs, &mut key, scratch);
            for l in 0..LANES {
                weights[k][l] = weight(from_fixed(asked[k][l]) + from_fixed(key[0][l]));
                total[l] += weights[k][l];
            }
            there
        });
        let part = total.map(|t| 1.0 / t);
        for values in &mut weights {
            values.iter_mut().zip(part).for_each(|(v, part)| *v *= part);
        }
        let means: [[i16; CHANNELS]; LANES] = std::array::from_fn(|l| {
            let parts = there.iter().zip(&weights);
            let part = |v: f32| (v * 32768.0) as i16;
            let sum = parts.map(|(values, w)| i16x8::from(values[l]).mul_scale_round_n(part(w[l])));
            sum.fold(i16x8::ZERO, |a, b| a.saturating_add(b)).to_array()
        });
        mean.copy_from_slice(&Pair::across(&means));
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_ahead_of_the_vehicle_and_to_both_sides() {
        // It looks north from (10, 20); a wheelbase is 3 m.
        let (x, y, cos, sin) = ([10.0; LANES], [20.0; LANES], [0.0; LANES], [1.0; LANES]);
        let at = |k: usize| place(k, [&x, &y], [&cos, &sin], 3.0).map(|v| v[0]);
        let expected = [[10.0, 20.0], [10.0, 23.0], [10.0, 26.0], [8.2, 24.8], [11.8, 24.8]];
        for (k, expected) in expected.iter().enumerate() {
            assert!(at(k).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{k}: {:?}", at(k));
        }
    }

    #[test]
    fn weights_are_above_nothing_and_grow() {
        // squareplus(0) = 1; far from 0 it is z, or goes to -1/z.
        assert_eq!(weight(0.0), 1.0);
        assert!((weight(30.0) - 30.0 - 1.0 / 30.0).abs() < 1e-3 && (weight(-30.0) - 1.0 / 30.0).abs() < 1e-3);
        let all: Vec<f32> = (-100..=100).map(|k| weight(0.1 * k as f32)).collect();
        assert!(all[0] > 0.0 && all.windows(2).all(|w| w[0] < w[1]));
    }
}
