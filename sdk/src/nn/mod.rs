//! Small neural networks in planners: dense layers and convolutions over [`LANES`] inputs side by side, and the file of their weights.
//!
//! A planner embeds its weights ([`Weights::parse`] of `include_bytes!`), takes its networks from them by name
//! ([`Weights::network`]) and evaluates them ([`Network::run`]). All arithmetic is in single precision and in a fixed order,
//! without fused operations, so the same bits come out natively and in WASM. A network that is evaluated thousands of times a step
//! does so in a fraction of the time in fixed point ([`FixedNetwork`]).

mod file;
mod fixed;
mod layer;
mod network;
#[cfg(test)]
mod tests;

pub use file::{Weights, WeightsError};
pub use fixed::{Fixed, FixedNetwork, FixedScratch, Pair, UNIT, from_fixed, to_fixed};
pub use layer::{Convolution, Layer, Shape};
pub use network::{LEAK, Network, Scratch};

pub use crate::mppi::{LANES, Lanes};
