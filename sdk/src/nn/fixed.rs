//! Dense layers in 16-bit fixed point.
//!
//! Values are multiples of 1/[`UNIT`] from -16 to 16, and saturate. Products are summed exactly in 32 bits; each sum is
//! rounded once. Processors multiply eight pairs of such numbers at once instead of four floats, and WASM runtimes need
//! no NaN canonicalisation, so networks are several times as fast. Integer arithmetic is bit-identical on all
//! platforms.

use wide::bytemuck::cast;
use wide::{f32x4, i16x8, i32x4, i32x8};

use super::{LANES, LEAK, Lanes, Layer, Network, Shape};

/// The fixed-point representation of 1.
pub const UNIT: i16 = 2048;

/// Converts to fixed point, rounding to nearest. NaN maps to the minimum.
#[must_use]
#[inline]
pub fn to_fixed(value: f32) -> i16 {
    // Offset to positive values, where the cast rounds down.
    let above = (value * f32::from(UNIT) + 32768.5) as i32;
    (above.clamp(0, 65535) - 32768) as i16
}

/// Converts from fixed point.
#[must_use]
#[inline]
pub fn from_fixed(fixed: i16) -> f32 {
    f32::from(fixed) * (1.0 / f32::from(UNIT))
}

/// One value for each of [`LANES`] inputs, in fixed point.
pub type Fixed = [i16; LANES];

/// Two values for each of [`LANES`] inputs, in fixed point, interleaved for the processor's multiply-add of pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pair([i16x8; 2]);

impl Pair {
    /// Interleaves a first and a second value of each input.
    #[must_use]
    #[inline]
    pub fn new(a: Fixed, b: Fixed) -> Self {
        Self([
            i16x8::new([a[0], b[0], a[1], b[1], a[2], b[2], a[3], b[3]]),
            i16x8::new([a[4], b[4], a[5], b[5], a[6], b[6], a[7], b[7]]),
        ])
    }

    /// Interleaves the values of inputs; an odd last value is paired with 0.
    ///
    /// # Panics
    /// Panics if the number of pairs is not half the number of values, rounded up.
    pub fn fill(pairs: &mut [Self], values: &[Lanes]) {
        assert_eq!(pairs.len(), values.len().div_ceil(2), "another number of pairs");
        for (pair, values) in pairs.iter_mut().zip(values.chunks(2)) {
            *pair = Self::new(values[0].map(to_fixed), values.get(1).map_or([0; LANES], |b| b.map(to_fixed)));
        }
    }

    /// Interleaves eight fixed-point values as four pairs per input.
    #[must_use]
    #[inline]
    pub fn across(values: &[Fixed; LANES]) -> [Self; 4] {
        // Transposes four inputs' rows of four pairs; each pair is moved as a number of 32 bits.
        let columns = |first: usize| f32x4::transpose(std::array::from_fn(|k| cast(values[first + k])));
        let (low, high) = (columns(0), columns(4));
        std::array::from_fn(|p| Self([cast(low[p]), cast(high[p])]))
    }
}

/// Outputs that are summed at once.
const ROWS: usize = 4;

/// A layer: outputs in groups of [`ROWS`], the last group padded with zeros.
#[derive(Clone, Debug, PartialEq)]
struct FixedLayer {
    /// Indexed by group and input pair.
    weights: Vec<[[i16; 2]; ROWS]>,
    /// Indexed by group: the initial sums, with half of the loss of rounding down.
    bias: Vec<[i32; ROWS]>,
    /// Number of input pairs.
    pairs: usize,
    /// Bits by which the weights are scaled up.
    shift: u32,
}

/// A [`Network`] in fixed point ([`Network::fixed`]).
#[derive(Clone, Debug, PartialEq)]
pub struct FixedNetwork {
    layers: Vec<FixedLayer>,
    widest: usize,
    outputs: usize,
}

/// Scratch memory for evaluating fixed-point networks.
#[derive(Clone, Debug, Default)]
pub struct FixedScratch([Vec<Pair>; 2]);

impl Network {
    /// Converts the network to fixed point. Its inputs come in parts of these sizes, each of which begins a new pair:
    /// the last pair of a part of odd size has an unused second value. Returns `None` if a layer is not dense, or its
    /// weights are so large (about 30 000, or 60 000 in sum for an output) that sums may exceed 32 bits.
    ///
    /// # Panics
    /// Panics if the parts do not sum to the number of inputs.
    #[must_use]
    pub fn fixed(&self, parts: &[usize]) -> Option<FixedNetwork> {
        assert_eq!(parts.iter().sum::<usize>(), self.inputs(), "another number of inputs");
        let mut layers: Vec<FixedLayer> = Vec::new();
        for layer in self.layers() {
            let Shape::Dense { inputs, .. } = layer.shape else { return None };
            let parts = if layers.is_empty() { parts } else { &[inputs] };
            layers.push(FixedLayer::new(layer, parts, shift(layer)?));
        }
        let widest = layers.iter().map(|l| l.bias.len() * ROWS / 2).max().unwrap_or(0);
        Some(FixedNetwork { layers, widest, outputs: self.outputs() })
    }
}

impl FixedNetwork {
    /// The number of input pairs.
    #[must_use]
    pub fn pairs(&self) -> usize {
        self.layers.first().map_or(0, |l| l.pairs)
    }

    /// The number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Evaluates the network for [`LANES`] inputs at once. `output` has one entry per output, with a value for each
    /// input.
    ///
    /// # Panics
    /// Panics if the number of entries is not the number of input pairs or outputs.
    pub fn run(&self, input: &[Pair], output: &mut [Fixed], scratch: &mut FixedScratch) {
        assert!(input.len() == self.pairs() && output.len() == self.outputs, "another number of values");
        let FixedScratch([from, to]) = scratch;
        from.resize(self.widest.max(from.len()), Pair::default());
        to.resize(self.widest.max(to.len()), Pair::default());
        let Some((last, hidden)) = self.layers.split_last() else { return };
        for (k, layer) in hidden.iter().enumerate() {
            let source = if k == 0 { input } else { &from[..layer.pairs] };
            for (group, target) in to.as_chunks_mut::<2>().0.iter_mut().enumerate().take(layer.bias.len()) {
                let [a, b, c, d] = layer.sums(group, source).map(|v| rectified(v).to_array());
                *target = [Pair::new(a, b), Pair::new(c, d)];
            }
            std::mem::swap(from, to);
        }
        let source = if hidden.is_empty() { input } else { &from[..last.pairs] };
        for (group, target) in output.chunks_mut(ROWS).enumerate() {
            target.copy_from_slice(&last.sums(group, source).map(i16x8::to_array)[..target.len()]);
        }
    }
}

/// The activation, with a [`LEAK`] to the fifth digit.
#[inline]
fn rectified(v: i16x8) -> i16x8 {
    const PART: i16 = (LEAK * 32768.0 + 0.5) as i16;
    v.max(v.mul_scale_round_n(PART))
}

impl FixedLayer {
    fn new(layer: &Layer, parts: &[usize], shift: u32) -> Self {
        let pairs: usize = parts.iter().map(|n| n.div_ceil(2)).sum();
        let scale = f64::from(1_u32 << shift);
        let rounded = |value: f64, scale: f64| (value * scale + 0.5).floor();
        let groups = layer.bias.len().div_ceil(ROWS);
        let mut weights = vec![[[0_i16; 2]; ROWS]; groups * pairs];
        let mut bias = vec![[0; ROWS]; groups];
        for output in 0..layer.bias.len() {
            let (group, row) = (output / ROWS, output % ROWS);
            let unit = f64::from(UNIT);
            // Compensates for rounding down.
            let half = if shift > 0 { 1 << (shift - 1) } else { 0 };
            bias[group][row] = rounded(f64::from(layer.bias[output]), scale * unit) as i32 + half;
            let inputs = layer.shape.inputs();
            let own = &layer.weights[output * inputs..][..inputs];
            let (mut pair, mut first) = (group * pairs, 0);
            for part in parts {
                for (k, w) in own[first..first + part].iter().enumerate() {
                    weights[pair + k / 2][row][k % 2] = rounded(f64::from(*w), scale) as i16;
                }
                (pair, first) = (pair + part.div_ceil(2), first + part);
            }
        }
        Self { weights, bias, pairs, shift }
    }

    /// The outputs of a group.
    #[inline]
    fn sums(&self, group: usize, input: &[Pair]) -> [i16x8; ROWS] {
        let mut sums = self.bias[group].map(|bias| [i32x4::splat(bias); 2]);
        let weights = &self.weights[group * self.pairs..][..self.pairs];
        let mut add = |weights: &[[i16; 2]; ROWS], Pair([low, high]): &Pair| {
            for (sum, pair) in sums.iter_mut().zip(weights) {
                let pair: i16x8 = cast(i32x4::splat(cast(*pair)));
                sum[0] += low.dot(pair);
                sum[1] += high.dot(pair);
            }
        };
        // Four at a time: a fuel-counting WASM runtime spills all sums to memory once per loop iteration.
        let ((weights, last_weights), (input, last)) = (weights.as_chunks::<4>(), input.as_chunks::<4>());
        for (weights, input) in weights.iter().zip(input) {
            weights.iter().zip(input).for_each(|(weights, pair)| add(weights, pair));
        }
        last_weights.iter().zip(last).for_each(|(weights, pair)| add(weights, pair));
        sums.map(|sum| {
            let sum: i32x8 = cast(sum.map(|s| s >> self.shift));
            i16x8::from_i32x8_saturate(sum)
        })
    }
}

/// The maximum number of bits by which the weights of a layer can be scaled up so that they fit 16 bits and no sum
/// exceeds 32 bits for any input; `None` if no scale fits.
fn shift(layer: &Layer) -> Option<u32> {
    let fits = |shift: u32| {
        let scale = f64::from(1_u32 << shift);
        let mut rows = layer.weights.chunks(layer.shape.inputs()).zip(&layer.bias);
        rows.all(|(row, bias)| {
            // Each weight may be half a step larger; so may the bias, including its rounding offset.
            let sizes = row.iter().map(|w| f64::from(w.abs()) * scale + 0.5);
            let sum = sizes.clone().sum::<f64>() * 32768.0
                + (f64::from(bias.abs()) * f64::from(UNIT) + 1.0) * scale
                + 1.0;
            sizes.fold(0.0, f64::max) < 32767.0 && sum < f64::from(i32::MAX)
        })
    };
    (0..16).rev().find(|shift| fits(*shift))
}
