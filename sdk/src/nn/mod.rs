//! Small neural networks in planners: dense layers over [`LANES`] inputs side by side, and the file of their weights.
//!
//! A planner embeds its weights ([`Weights::parse`] of `include_bytes!`), takes its networks from them by name
//! ([`Weights::network`]) and evaluates them ([`Network::run`]). All arithmetic is in single precision and in a fixed order,
//! without fused operations, so the same bits come out natively and in WASM.

mod file;
mod network;
#[cfg(test)]
mod tests;

pub use file::{Layer, Weights, WeightsError};
pub use network::{LEAK, Network, Scratch, rectify};

pub use crate::mppi::{LANES, Lanes};
