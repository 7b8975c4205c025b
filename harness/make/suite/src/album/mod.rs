//! A suite as a page to look through: one file that needs nothing else, no network either.

mod page;
mod plot;
#[cfg(test)]
mod tests;

use crate::statistics::{SuiteStatistics, WorldStatistics};
use vb_world::World;

/// Pixels of all relief pictures together: a page of many worlds stays below 15 MB.
const PIXELS: f64 = 6.6e6;
/// Least and greatest number of pixels along the longer side of a picture.
const SIDE: [f64; 2] = [96.0, 384.0];

/// A page that is made world by world, so that only one need be in memory.
#[derive(Debug)]
pub struct Album {
    side: usize,
    cards: Vec<String>,
}

impl Album {
    /// An album for this number of worlds; the more there are, the coarser their pictures.
    #[must_use]
    pub fn new(worlds: usize) -> Self {
        let side = (PIXELS / worlds.max(1) as f64).sqrt().clamp(SIDE[0], SIDE[1]);
        Self { side: side as usize, cards: Vec::with_capacity(worlds) }
    }

    /// Draws a world; `figures` must be its own.
    pub fn add(&mut self, world: &World, figures: &WorldStatistics) {
        self.cards.push(page::card(world, figures, self.side));
    }

    /// The page of all worlds that were added; `statistics` must be those of their suite.
    #[must_use]
    pub fn page(&self, statistics: &SuiteStatistics) -> String {
        page::page(&self.cards, statistics)
    }
}
