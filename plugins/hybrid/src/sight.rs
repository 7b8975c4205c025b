//! Terrain inputs of the networks.

use vb_sdk::HeightMap;
use vb_sdk::mppi::Lanes;
use vb_sdk::nn::{FixedScratch, Pair, Weights, WeightsError};

use crate::attention::{Attention, PLACES};
use crate::kinodynamics::{State, TOLD};
use crate::table::{CHANNELS, Table, headings_of};
use crate::terrain::Terrain;

/// Kind of terrain input.
#[derive(Clone, Debug)]
pub enum Sight {
    /// The patch around the vehicle, at the nearest table heading.
    Patch(Table),
    /// The patch, and those at attended positions.
    Attention(Box<Attention>),
}

/// Maximum number of terrain features.
pub const SEEN: usize = 2 * CHANNELS;

impl Sight {
    /// The kind of input that weights were trained with, over the elevation map of the terrain.
    ///
    /// # Errors
    /// Returns an error if the weights lack a network.
    pub fn new(heights: &HeightMap, terrain: &Terrain, weights: &Weights) -> Result<Self, WeightsError> {
        Ok(match weights.note("sight") {
            Some("attention") => Self::Attention(Box::new(Attention::new(heights, terrain, weights)?)),
            _ => Self::Patch(Table::of(heights, terrain, weights)?),
        })
    }

    /// The sizes of the input parts: state and command inputs, and terrain features. In fixed point each part begins a
    /// new pair.
    #[must_use]
    pub fn parts(&self) -> &'static [usize] {
        match self {
            Self::Patch(_) => &[TOLD, CHANNELS],
            Self::Attention(_) => &[TOLD, SEEN],
        }
    }

    /// Terrain features for vehicles with this wheelbase and these state inputs, and the attention weight of each
    /// position.
    pub fn look(
        &self,
        s: &State,
        wheelbase: f32,
        told: &[Pair],
        seen: &mut [Pair],
        scratch: &mut FixedScratch,
    ) -> Option<[Lanes; PLACES.len()]> {
        let (place, direction) = ([&s.x, &s.y], [&s.cos, &s.sin]);
        match self {
            Self::Patch(table) => {
                seen.copy_from_slice(&Pair::across(&table.at(place, &headings_of(direction))));
                None
            }
            Self::Attention(a) => Some(a.look((place, direction), wheelbase, told, seen, scratch)),
        }
    }
}
