//! The shape of the networks: what training and inference must agree on.

use serde::{Deserialize, Serialize};

/// Samples along a cell of the latent field.
pub const CELL: usize = 8;
/// Cells along a block whose numbers together are one latent code.
pub const BLOCK: usize = 4;
/// Numbers in a cell.
pub const CHANNELS: usize = 4;
/// Numbers in a code: those of a block of cells, which is a square of 32 samples.
pub const LATENT: usize = BLOCK * BLOCK * CHANNELS;
/// Cells about a point of the surface that reach it, on each side: the decoder needs so many more than it makes.
pub const HALO: usize = 2;
/// Normal numbers that a cell takes in all: the latent ones, and noise for 4 × 4 and 8 × 8 places.
pub const NUMBERS: usize = CHANNELS + 16 + 64;
/// Samples from one node of a swell to the next: of the shorter, whose waves a tile of training has, and of the longer.
pub const SWELLS: [usize; 2] = [16, 64];
/// Slope of the activation below zero.
pub const LEAK: f32 = 0.2;

/// A convolution of the decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layer {
    /// Samples along its kernel's side: 1 or 3.
    pub kernel: usize,
    /// Channels in.
    pub from: usize,
    /// Channels out.
    pub to: usize,
    /// Whether each sample becomes 2 × 2 before it.
    pub doubled: bool,
    /// Whether its last channel in is noise, which details are made of.
    pub noise: bool,
    /// Whether the activation, a leaky rectifier, follows.
    pub active: bool,
}

/// The decoder: from a latent field to heights. No padding anywhere, so that each sample of the surface is the same function
/// of the cells about it, at whichever place: a surface has no seams, since it has no pieces.
pub const DECODER: [Layer; 9] = [
    layer(3, CHANNELS, 96),
    layer(1, 96, 96),
    doubled(96, 64),
    layer(1, 64, 64),
    doubled(64, 32),
    noisy(32, 32),
    doubled(32, 16),
    noisy(16, 16),
    Layer { active: false, ..layer(3, 16, 1) },
];

/// A convolution with activation.
const fn layer(kernel: usize, from: usize, to: usize) -> Layer {
    Layer { kernel, from, to, doubled: false, noise: false, active: true }
}

/// The same, 3 × 3, at twice the resolution.
const fn doubled(from: usize, to: usize) -> Layer {
    Layer { doubled: true, ..layer(3, from, to) }
}

/// The same, 1 × 1, with a channel of noise besides.
const fn noisy(from: usize, to: usize) -> Layer {
    Layer { noise: true, ..layer(1, from + 1, to) }
}
