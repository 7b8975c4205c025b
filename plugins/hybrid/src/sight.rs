//! What of the ground the networks see.

use vb_sdk::HeightMap;
use vb_sdk::mppi::Lanes;
use vb_sdk::nn::{FixedScratch, Pair, Weights, WeightsError};

use crate::attention::{Attention, PLACES};
use crate::kinodynamics::{State, TOLD};
use crate::table::{CHANNELS, Table, headings_of};
use crate::terrain::Terrain;

/// A way to look at the ground.
#[derive(Clone, Debug)]
pub enum Sight {
    /// The patch about the vehicle, at the nearest of some headings.
    Patch(Table),
    /// The same, and those at places that it may come to.
    Attention(Box<Attention>),
}

/// Numbers that are seen, at most.
pub const SEEN: usize = 2 * CHANNELS;

impl Sight {
    /// The way that weights were trained with, over a map of heights of which a terrain was made.
    ///
    /// # Errors
    /// Returns an error if the weights lack a network.
    pub fn new(heights: &HeightMap, terrain: &Terrain, weights: &Weights) -> Result<Self, WeightsError> {
        Ok(match weights.note("sight") {
            Some("attention") => Self::Attention(Box::new(Attention::new(heights, terrain, weights)?)),
            _ => Self::Patch(Table::of(heights, terrain, weights)?),
        })
    }

    /// The parts of what networks are told and see, which in fixed point begin with pairs of their own.
    #[must_use]
    pub fn parts(&self) -> &'static [usize] {
        match self {
            Self::Patch(_) => &[TOLD, CHANNELS],
            Self::Attention(_) => &[TOLD, SEEN],
        }
    }

    /// What vehicles of this wheelbase see that are told this of themselves, and the attention that they pay to each place.
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
