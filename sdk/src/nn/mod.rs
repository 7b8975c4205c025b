//! Small neural networks for planners: dense layers and convolutions over [`LANES`] inputs at once, and their weights
//! file.
//!
//! A planner embeds its weights ([`Weights::parse`] of `include_bytes!`), gets its networks by name
//! ([`Weights::network`]) and evaluates them ([`Network::run`]). Arithmetic is in single precision in a fixed order,
//! without fused operations, so that results are bit-identical natively and as WASM. Networks that are evaluated
//! thousands of times per step are several times as fast in fixed point ([`FixedNetwork`]).

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
