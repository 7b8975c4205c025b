//! The decoder, in arithmetic of a fixed order: every sample is a sum over channels and kernel from first to last, in f32,
//! without fused or platform functions. The same weights and cells give the same bits on any machine and in any division
//! of the work.

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};

use crate::shape::{CELL, CHANNELS, DECODER, HALO, LEAK, Layer, NUMBERS};

/// Output channels and samples that are summed at a time. Neither changes any sum.
const LANES: usize = 4;
const RUN: usize = 16;

/// Channels of a picture, each row by row.
struct Planes {
    channels: usize,
    rows: usize,
    cols: usize,
    /// With a run more at the end, so that whole runs can be read from every place.
    values: Vec<f32>,
}

impl Planes {
    fn new(channels: usize, rows: usize, cols: usize) -> Self {
        Self { channels, rows, cols, values: vec![0.0; channels * rows * cols + RUN] }
    }
}

/// A convolution without padding over one of the four places that a sample of a doubled picture can have, or over a
/// picture as it is.
#[derive(Clone, Debug)]
struct Convolution {
    from: usize,
    to: usize,
    /// Samples along its kernel's side.
    side: usize,
    /// For each group of output channels, input channel and place in the kernel.
    weights: Vec<[f32; LANES]>,
    bias: Vec<[f32; LANES]>,
    active: bool,
}

/// Where a convolution's results go: row and column times `step`, plus `shift`.
#[derive(Clone, Copy)]
struct Target {
    step: usize,
    shift: [usize; 2],
}

impl Convolution {
    /// `weight(row, column, from, to)` for a kernel of this side.
    fn new(
        layer: Layer,
        side: usize,
        bias: &[f32],
        weight: impl Fn(usize, usize, usize, usize) -> f32,
    ) -> Self {
        let groups = layer.to.div_ceil(LANES);
        let lanes = |g: usize, value: &dyn Fn(usize) -> f32| {
            let lane = |l: usize| if g * LANES + l < layer.to { value(g * LANES + l) } else { 0.0 };
            [lane(0), lane(1), lane(2), lane(3)]
        };
        let mut weights = Vec::with_capacity(groups * layer.from * side * side);
        for g in 0..groups {
            for from in 0..layer.from {
                for row in 0..side {
                    for col in 0..side {
                        weights.push(lanes(g, &|to| weight(row, col, from, to)));
                    }
                }
            }
        }
        let bias = (0..groups).map(|g| lanes(g, &|to| bias[to])).collect();
        Self { from: layer.from, to: layer.to, side, weights, bias, active: layer.active }
    }

    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, input: &Planes, out: &mut Planes, target: Target) {
        let all = |x: f32| f32x16::splat(simd, x);
        let (rows, cols) = (input.rows + 1 - self.side, input.cols + 1 - self.side);
        let plane = input.rows * input.cols;
        let taps = self.side * self.side;
        for (g, bias) in self.bias.iter().enumerate() {
            let weights = &self.weights[g * self.from * taps..(g + 1) * self.from * taps];
            for row in 0..rows {
                for first in (0..cols).step_by(RUN) {
                    let mut sums = [all(bias[0]), all(bias[1]), all(bias[2]), all(bias[3])];
                    for (from, weights) in weights.chunks_exact(taps).enumerate() {
                        let base = from * plane + row * input.cols + first;
                        for (line, weights) in weights.chunks_exact(self.side).enumerate() {
                            let base = base + line * input.cols;
                            for (tap, w) in weights.iter().enumerate() {
                                let x = f32x16::from_slice(simd, &input.values[base + tap..base + tap + RUN]);
                                for (sum, w) in sums.iter_mut().zip(w) {
                                    *sum += all(*w) * x;
                                }
                            }
                        }
                    }
                    let last = RUN.min(cols - first);
                    for (lane, sum) in sums.iter().enumerate().take(self.to - (g * LANES).min(self.to)) {
                        let line = (g * LANES + lane) * out.rows * out.cols
                            + (row * target.step + target.shift[0]) * out.cols
                            + target.shift[1];
                        let mut values = [0.0f32; RUN];
                        sum.store_slice(&mut values);
                        for (i, &s) in values[..last].iter().enumerate() {
                            let s = if self.active && s < 0.0 { LEAK * s } else { s };
                            out.values[line + (first + i) * target.step] = s;
                        }
                    }
                }
            }
        }
    }
}

/// One layer: a convolution, or four for a doubled picture.
#[derive(Clone, Debug)]
struct Step {
    phases: Vec<Convolution>,
    /// Whether its last channel in is noise.
    noise: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Decoder {
    steps: Vec<Step>,
}

impl Decoder {
    /// From the weights, (row, column, from, to) in this order, and biases of [`DECODER`]'s layers.
    pub(crate) fn new(weights: &[(Vec<f32>, Vec<f32>)]) -> Self {
        let layers = DECODER.iter().zip(weights).map(|(&layer, (weight, bias))| {
            let k = layer.kernel;
            let at = |r: usize, c: usize, f: usize, t: usize| {
                weight[((r * k + c) * layer.from + f) * layer.to + t]
            };
            let noise = layer.noise;
            if !layer.doubled {
                return Step { phases: vec![Convolution::new(layer, k, bias, at)], noise };
            }
            // Of three samples in a row of a doubled picture two are the same: 2 × 2 places of the picture, for each
            // of the four places that the first sample can have, weighted by the sums of what falls on them.
            let parts = |odd: usize, i: usize| match (odd, i) {
                (0, 0) => 0..2,
                (0, _) => 2..3,
                (_, 0) => 0..1,
                _ => 1..3,
            };
            let phase = |p: usize| {
                Convolution::new(layer, 2, bias, |r, c, f, t| {
                    let mut sum = 0.0;
                    for row in parts(p / 2, r) {
                        for col in parts(p % 2, c) {
                            sum += at(row, col, f, t);
                        }
                    }
                    sum
                })
            };
            Step { phases: (0..4).map(phase).collect(), noise }
        });
        Self { steps: layers.collect() }
    }

    /// The surface of `n` × `n` cells, row-major, from the numbers of the (n + 4)² cells about them, [`NUMBERS`] each: the
    /// latent ones first, then the noise of 4 × 4 and 8 × 8 places, row by row.
    pub(crate) fn run(&self, cells: &[f32], n: usize) -> Vec<f32> {
        self.run_with(Level::new(), cells, n)
    }

    /// [`Self::run`] with one of the processor's sets of instructions, which changes no bit.
    fn run_with(&self, level: Level, cells: &[f32], n: usize) -> Vec<f32> {
        let side = n + 2 * HALO;
        debug_assert_eq!(cells.len(), side * side * NUMBERS);
        let mut planes = Planes::new(CHANNELS, side, side);
        for (i, cell) in cells.chunks_exact(NUMBERS).enumerate() {
            for (channel, value) in cell[..CHANNELS].iter().enumerate() {
                planes.values[channel * side * side + i] = *value;
            }
        }
        // Places along a cell, and where the next noise begins in a cell's numbers.
        let (mut scale, mut start) = (1, CHANNELS);
        for step in &self.steps {
            if step.noise {
                planes = with_noise(planes, cells, side, scale, start);
                start += scale * scale;
            }
            let first = &step.phases[0];
            let shrink = first.side - 1;
            let (rows, cols) = (planes.rows - shrink, planes.cols - shrink);
            let places = if step.phases.len() == 1 { 1 } else { 2 };
            let mut out = Planes::new(first.to, places * rows, places * cols);
            for (p, phase) in step.phases.iter().enumerate() {
                let target = Target { step: places, shift: [p / 2, p % 2] };
                dispatch!(level, simd => phase.run(simd, &planes, &mut out, target));
            }
            planes = out;
            scale *= places;
        }
        debug_assert_eq!((planes.channels, planes.rows), (1, CELL * n));
        planes.values.truncate(planes.rows * planes.cols);
        planes.values
    }
}

/// The picture with the noise of its places as another channel. It lies in the middle of its `side`² cells, which have
/// `scale` places along each side.
fn with_noise(planes: Planes, cells: &[f32], side: usize, scale: usize, start: usize) -> Planes {
    let margin = (scale * side - planes.rows) / 2;
    let mut out = Planes::new(planes.channels + 1, planes.rows, planes.cols);
    let size = planes.channels * planes.rows * planes.cols;
    out.values[..size].copy_from_slice(&planes.values[..size]);
    for i in 0..planes.rows * planes.cols {
        let (row, col) = (margin + i / planes.cols, margin + i % planes.cols);
        let cell = row / scale * side + col / scale;
        out.values[size + i] = cells[cell * NUMBERS + start + row % scale * scale + col % scale];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::rng::Stream;

    /// The layers as they are defined, sample by sample, in f64.
    fn plainly(weights: &[(Vec<f32>, Vec<f32>)], cells: &[f32], n: usize) -> Vec<f64> {
        let all = n + 2 * HALO;
        let mut side = all;
        let number = |row: usize, col: usize, i: usize| f64::from(cells[(row * all + col) * NUMBERS + i]);
        let latent = |i: usize| number(i / all % all, i % all, i / (all * all));
        let mut x: Vec<f64> = (0..CHANNELS * all * all).map(latent).collect();
        let (mut places, mut start) = (1, CHANNELS);
        for (layer, (weight, bias)) in DECODER.iter().zip(weights) {
            if layer.doubled {
                places *= 2;
            }
            if layer.noise {
                // The picture's middle is that of the cells.
                let margin = (places * all - side) / 2;
                for i in 0..side * side {
                    let (row, col) = (margin + i / side, margin + i % side);
                    let at = start + row % places * places + col % places;
                    x.push(number(row / places, col / places, at));
                }
                start += places * places;
            }
            let scale = if layer.doubled { 2 } else { 1 };
            let out = scale * side + 1 - layer.kernel;
            let mut y = Vec::with_capacity(layer.to * out * out);
            for t in 0..layer.to {
                for i in 0..out * out {
                    let mut sum = f64::from(bias[t]);
                    for r in 0..layer.kernel {
                        for c in 0..layer.kernel {
                            let (row, col) = ((i / out + r) / scale, (i % out + c) / scale);
                            for f in 0..layer.from {
                                let w = weight[((r * layer.kernel + c) * layer.from + f) * layer.to + t];
                                sum += f64::from(w) * x[(f * side + row) * side + col];
                            }
                        }
                    }
                    y.push(if layer.active && sum < 0.0 { f64::from(LEAK) * sum } else { sum });
                }
            }
            (x, side) = (y, out);
        }
        x
    }

    pub(crate) fn random_weights(seed: u64) -> Vec<(Vec<f32>, Vec<f32>)> {
        let mut rng = Stream::new(seed, &["decoder"]);
        DECODER
            .iter()
            .map(|l| {
                let inputs = l.kernel * l.kernel * l.from;
                let std = (2.0 / inputs as f64).sqrt();
                let mut draw = |n: usize, std: f64| (0..n).map(|_| rng.normal(0.0, std) as f32).collect();
                (draw(inputs * l.to, std), draw(l.to, 0.1))
            })
            .collect()
    }

    #[test]
    fn it_is_the_network_that_the_shape_defines() {
        let weights = random_weights(1);
        let mut rng = Stream::new(2, &["cells"]);
        let n = 3;
        let cells: Vec<f32> = (0..NUMBERS * (n + 4) * (n + 4)).map(|_| rng.normal(0.0, 1.0) as f32).collect();
        let made = Decoder::new(&weights).run(&cells, n);
        let plain = plainly(&weights, &cells, n);
        assert_eq!(made.len(), (CELL * n) * (CELL * n));
        // Sums of some hundreds of f32 products: an error of 1e-5 of the spread at most.
        let spread = (plain.iter().map(|v| v * v).sum::<f64>() / plain.len() as f64).sqrt();
        for (a, b) in made.iter().zip(&plain) {
            assert!((f64::from(*a) - b).abs() < 1e-5 * spread.max(1.0), "{a} {b}");
        }
    }

    #[test]
    fn every_instruction_set_of_the_processor_gives_the_same_bits() {
        let decoder = Decoder::new(&random_weights(5));
        let mut rng = Stream::new(6, &["cells"]);
        // Rows that fill a run of samples, and some that don't.
        let n = 5;
        let cells: Vec<f32> = (0..NUMBERS * (n + 4) * (n + 4)).map(|_| rng.normal(0.0, 1.0) as f32).collect();
        let bits = |level| -> Vec<u32> {
            decoder.run_with(level, &cells, n).iter().map(|v: &f32| v.to_bits()).collect()
        };
        let plain = bits(Level::baseline());
        let mut levels = vec![Level::new()];
        #[cfg(target_arch = "x86_64")]
        {
            let best = Level::new();
            levels.extend(best.as_sse4_2().map(Level::Sse4_2));
            levels.extend(best.as_avx2().map(Level::Avx2));
        }
        for level in levels {
            assert_eq!(bits(level), plain, "{level:?}");
        }
    }

    #[test]
    fn a_sample_has_the_same_bits_in_whichever_block_it_is_made() {
        let decoder = Decoder::new(&random_weights(3));
        let mut rng = Stream::new(4, &["cells"]);
        let side = 9;
        let field: Vec<f32> = (0..NUMBERS * side * side).map(|_| rng.normal(0.0, 1.0) as f32).collect();
        let part = |row: usize, col: usize, n: usize| {
            let m = n + 2 * HALO;
            let cell = |i: usize| &field[((row + i / m) * side + col + i % m) * NUMBERS..][..NUMBERS];
            let cells: Vec<f32> = (0..m * m).flat_map(cell).copied().collect();
            decoder.run(&cells, n)
        };
        let whole = part(0, 0, 5);
        for (row, col, n) in [(0, 0, 1), (1, 2, 2), (4, 4, 1), (2, 0, 3)] {
            let made = part(row, col, n);
            for (i, v) in made.iter().enumerate() {
                let (r, c) = (row * CELL + i / (n * CELL), col * CELL + i % (n * CELL));
                assert_eq!(v.to_bits(), whole[r * 5 * CELL + c].to_bits());
            }
        }
    }
}
