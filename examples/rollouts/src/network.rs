//! A network of two hidden layers, for many samples at once.

use vb_sdk::rng::Rng;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_of_a_block_gets_what_the_layers_sums_say() {
        let network = Network::random(&mut Rng::new(7));
        let input: [Block; WIDTH] =
            std::array::from_fn(|i| std::array::from_fn(|k| 0.3 * i as f32 - 0.1 * k as f32));
        let out = network.forward(&input);
        // By hand, in double precision, one sample and unit at a time.
        fn layer<const I: usize, const O: usize>(l: &Layer<I, O>, x: &[f64]) -> Vec<f64> {
            let unit = |o: usize| x.iter().zip(&l.weights[o]).map(|(x, w)| x * f64::from(*w)).sum::<f64>();
            (0..O).map(|o| unit(o) + f64::from(l.biases[o])).collect()
        }
        let positive = |x: Vec<f64>| x.into_iter().map(|x| x.max(0.0)).collect::<Vec<_>>();
        for k in 0..BLOCK {
            let x: Vec<f64> = input.iter().map(|block| f64::from(block[k])).collect();
            let hidden = positive(layer(&network.second, &positive(layer(&network.first, &x))));
            for (o, expected) in layer(&network.last, &hidden).into_iter().enumerate() {
                assert!((f64::from(out[o][k]) - expected).abs() < 1e-4, "{k} {o}: {} {expected}", out[o][k]);
            }
        }
    }
}
