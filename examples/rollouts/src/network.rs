//! A network of two hidden layers, for many samples at once: in floating point, and in 16-bit integers.
//!
//! WASM under determinism makes every NaN canonical, which takes two instructions after each of floating-point
//! arithmetic and none after one of integers. Integers have SIMD of twice the width, too.

use bytemuck::cast;
use vb_sdk::rng::Rng;
use wide::{i16x8, i32x4};

/// Samples that are computed together: two SIMD registers of WASM.
pub(crate) const BLOCK: usize = 8;
/// One number of every sample of a block.
pub(crate) type Block = [f32; BLOCK];

/// Numbers that go in and out.
pub(crate) const WIDTH: usize = 6;
const HIDDEN: usize = 64;

/// 6-64-64-6 units with biases; max(0, x) between the layers.
pub(crate) struct Network {
    first: Layer<WIDTH, HIDDEN>,
    second: Layer<HIDDEN, HIDDEN>,
    last: Layer<HIDDEN, WIDTH>,
}

impl Network {
    pub(crate) fn random(rng: &mut Rng) -> Self {
        Self { first: Layer::random(rng), second: Layer::random(rng), last: Layer::random(rng) }
    }

    pub(crate) fn forward(&self, input: &[Block; WIDTH]) -> [Block; WIDTH] {
        self.last.forward(&positive(self.second.forward(&positive(self.first.forward(input)))))
    }
}

fn positive<const N: usize>(mut blocks: [Block; N]) -> [Block; N] {
    for x in blocks.as_flattened_mut() {
        *x = if *x > 0.0 { *x } else { 0.0 };
    }
    blocks
}

/// A linear layer.
struct Layer<const IN: usize, const OUT: usize> {
    weights: Box<[[f32; IN]; OUT]>,
    biases: Box<[f32; OUT]>,
}

impl<const IN: usize, const OUT: usize> Layer<IN, OUT> {
    /// Weights of variance 2/IN (He et al. 2015, eq. 10).
    fn random(rng: &mut Rng) -> Self {
        let spread = (6.0 / IN as f64).sqrt();
        let mut weight = || rng.uniform(-spread, spread) as f32;
        let mut weights = Box::new([[0.0; IN]; OUT]);
        weights.as_flattened_mut().fill_with(&mut weight);
        Self { weights, biases: Box::new(std::array::from_fn(|_| 0.1 * weight())) }
    }

    /// Two units at a time, so that each input is loaded half as often.
    fn forward(&self, input: &[Block; IN]) -> [Block; OUT] {
        let mut out = [[0.0; BLOCK]; OUT];
        for (pair, (rows, biases)) in
            out.chunks_exact_mut(2).zip(self.weights.chunks_exact(2).zip(self.biases.chunks_exact(2)))
        {
            let mut sums = [[biases[0]; BLOCK], [biases[1]; BLOCK]];
            for (x, (a, b)) in input.iter().zip(rows[0].iter().zip(&rows[1])) {
                for k in 0..BLOCK {
                    sums[0][k] += a * x[k];
                    sums[1][k] += b * x[k];
                }
            }
            pair.copy_from_slice(&sums);
        }
        out
    }
}

/// Activations are multiples of 2^-11, below 16; weights are multiples of 2^-12, below 8.
const ACTIVATION_BITS: i32 = 11;
const WEIGHT_BITS: i32 = 12;

/// The same network in integers. Inputs and activations beyond ±16 are cut off, and so must sums of a unit stay below
/// 256: 32 bits hold no more.
pub(crate) struct FixedNetwork {
    first: FixedLayer<WIDTH, HIDDEN>,
    second: FixedLayer<HIDDEN, HIDDEN>,
    last: FixedLayer<HIDDEN, WIDTH>,
}

/// Two numbers of every sample of a block: in each half those of four samples, side by side.
type Pair = [i16x8; 2];

impl FixedNetwork {
    pub(crate) fn of(network: &Network) -> Self {
        Self {
            first: FixedLayer::of(&network.first),
            second: FixedLayer::of(&network.second),
            last: FixedLayer::of(&network.last),
        }
    }

    pub(crate) fn forward(&self, input: &[Block; WIDTH]) -> [Block; WIDTH] {
        let fixed = |x: f32| (x * (1 << ACTIVATION_BITS) as f32) as i16;
        let mut pairs = [[i16x8::ZERO; 2]; WIDTH / 2];
        for (pair, blocks) in pairs.iter_mut().zip(input.chunks_exact(2)) {
            for (half, place) in pair.iter_mut().zip([0, BLOCK / 2]) {
                let both: [i16; 8] = std::array::from_fn(|k| fixed(blocks[k % 2][place + k / 2]));
                *half = both.into();
            }
        }
        let mut out = [[0.0; BLOCK]; WIDTH];
        let sums = self.last.forward(&activate(&self.second.forward(&activate(&self.first.forward(&pairs)))));
        for (block, sums) in out.iter_mut().zip(sums) {
            let sums: [i32; BLOCK] = cast(sums);
            *block = sums.map(|s| s as f32 * (1.0 / (1 << (ACTIVATION_BITS + WEIGHT_BITS)) as f32));
        }
        out
    }
}

/// Makes activations of the sums of pairs of units.
fn activate<const OUT: usize>(sums: &[[i32x4; 2]; OUT]) -> [Pair; HALF_HIDDEN] {
    let (least, most) = (i32x4::ZERO, i32x4::splat(i16::MAX.into()));
    let positive = |sum: i32x4| (sum >> WEIGHT_BITS).max(least).min(most);
    let mut pairs = [[i16x8::ZERO; 2]; HALF_HIDDEN];
    for (pair, units) in pairs.iter_mut().zip(sums.chunks_exact(2)) {
        for half in 0..2 {
            // The first of two numbers is the lower half of 32 bits: WASM, and all that it runs on here, is little-endian.
            pair[half] = cast(positive(units[0][half]) | (positive(units[1][half]) << 16));
        }
    }
    pairs
}

const HALF_HIDDEN: usize = HIDDEN / 2;

struct FixedLayer<const IN: usize, const OUT: usize> {
    /// Of each unit, the weights of two inputs in one number.
    weights: Vec<[i32; HALF_HIDDEN]>,
    /// With the bits of a product.
    biases: Box<[i32; OUT]>,
}

impl<const IN: usize, const OUT: usize> FixedLayer<IN, OUT> {
    fn of(layer: &Layer<IN, OUT>) -> Self {
        let fixed = |w: f32| (w * (1 << WEIGHT_BITS) as f32).round_ties_even() as i16;
        let mut weights = vec![[0; HALF_HIDDEN]; OUT];
        for (pairs, row) in weights.iter_mut().zip(layer.weights.iter()) {
            for (pair, two) in pairs.iter_mut().zip(row.chunks_exact(2)) {
                *pair = cast([fixed(two[0]), fixed(two[1])]);
            }
        }
        let scale = (1 << (ACTIVATION_BITS + WEIGHT_BITS)) as f32;
        Self { weights, biases: Box::new(layer.biases.map(|b| (b * scale) as i32)) }
    }

    /// Sums of every unit, for both halves of the block. Two units at a time, so that each input is loaded half as often.
    fn forward<const PAIRS: usize>(&self, input: &[Pair; PAIRS]) -> [[i32x4; 2]; OUT] {
        const { assert!(2 * PAIRS == IN && PAIRS <= HALF_HIDDEN) };
        let mut out = [[i32x4::ZERO; 2]; OUT];
        for (two, (rows, biases)) in
            out.chunks_exact_mut(2).zip(self.weights.chunks_exact(2).zip(self.biases.chunks_exact(2)))
        {
            let mut sums = [[i32x4::splat(biases[0]); 2], [i32x4::splat(biases[1]); 2]];
            for (x, (a, b)) in input.iter().zip(rows[0].iter().zip(&rows[1])) {
                let (a, b): (i16x8, i16x8) = (cast(i32x4::splat(*a)), cast(i32x4::splat(*b)));
                for half in 0..2 {
                    sums[0][half] += x[half].dot(a);
                    sums[1][half] += x[half].dot(b);
                }
            }
            two.copy_from_slice(&sums);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In double precision, one sample and unit at a time.
    fn layer<const I: usize, const O: usize>(l: &Layer<I, O>, x: &[f64]) -> Vec<f64> {
        let unit = |o: usize| x.iter().zip(&l.weights[o]).map(|(x, w)| x * f64::from(*w)).sum::<f64>();
        (0..O).map(|o| unit(o) + f64::from(l.biases[o])).collect()
    }

    #[test]
    fn every_sample_of_a_block_gets_what_the_layers_sums_say() {
        let network = Network::random(&mut Rng::new(7));
        let input: [Block; WIDTH] =
            std::array::from_fn(|i| std::array::from_fn(|k| 0.3 * i as f32 - 0.1 * k as f32));
        let out = network.forward(&input);
        let fixed = FixedNetwork::of(&network).forward(&input);
        let positive = |x: Vec<f64>| x.into_iter().map(|x| x.max(0.0)).collect::<Vec<_>>();
        for k in 0..BLOCK {
            let x: Vec<f64> = input.iter().map(|block| f64::from(block[k])).collect();
            let hidden = positive(layer(&network.second, &positive(layer(&network.first, &x))));
            for (o, expected) in layer(&network.last, &hidden).into_iter().enumerate() {
                assert!((f64::from(out[o][k]) - expected).abs() < 1e-4, "{k} {o}: {} {expected}", out[o][k]);
                // Weights are rounded by up to 2^-13 and activations by up to 2^-11, through three layers.
                assert!(
                    (f64::from(fixed[o][k]) - expected).abs() < 0.01,
                    "{k} {o}: {} {expected}",
                    fixed[o][k]
                );
            }
        }
    }
}
