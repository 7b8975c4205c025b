//! Dense layers, one after the other.

use super::{LANES, Lanes, Layer};

/// The slope of the activation below 0: between two layers, v becomes v if v ≥ 0 and `LEAK`·v else (Maas et al. 2013, *Rectifier
/// nonlinearities improve neural network acoustic models*).
pub const LEAK: f32 = 0.1;

/// Dense layers with leaky rectifiers between them; the last one is linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    layers: Vec<Layer>,
    widest: usize,
}

/// Memory for the evaluation of networks, so that it isn't allocated each time.
#[derive(Clone, Debug, Default)]
pub struct Scratch([Vec<Lanes>; 2]);

impl Network {
    /// A network of these layers, each of which takes what the one before gives; `None` where they don't fit together, or
    /// there is none.
    #[must_use]
    pub fn new(layers: Vec<Layer>) -> Option<Self> {
        let fits = layers.windows(2).all(|l| l[0].outputs == l[1].inputs);
        let widest = layers.iter().map(|l| l.outputs).max()?;
        fits.then_some(Self { layers, widest })
    }

    /// The number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |l| l.inputs)
    }

    /// The number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |l| l.outputs)
    }

    /// The multiplications for one input.
    #[must_use]
    pub fn multiplications(&self) -> usize {
        self.layers.iter().map(|l| l.inputs * l.outputs).sum()
    }

    /// Evaluates the network for [`LANES`] inputs at once: entry i of `input` has input i of each of them. `output` has one
    /// entry for each output.
    ///
    /// # Panics
    /// Panics if there are not as many entries as inputs or outputs.
    pub fn run(&self, input: &[Lanes], output: &mut [Lanes], scratch: &mut Scratch) {
        assert!(input.len() == self.inputs() && output.len() == self.outputs(), "another number of values");
        let Scratch([from, to]) = scratch;
        from.resize(self.widest.max(from.len()), [0.0; LANES]);
        to.resize(self.widest.max(to.len()), [0.0; LANES]);
        let last = self.layers.len() - 1;
        for (k, layer) in self.layers.iter().enumerate() {
            let source = if k == 0 { input } else { &from[..layer.inputs] };
            if k == last {
                layer.run(source, output);
            } else {
                let target = &mut to[..layer.outputs];
                layer.run(source, target);
                target.iter_mut().for_each(rectify);
                std::mem::swap(from, to);
            }
        }
    }
}

/// The activation: the greater of v and [`LEAK`]·v.
pub fn rectify(values: &mut Lanes) {
    for value in values {
        let leak = LEAK * *value;
        *value = if *value < leak { leak } else { *value };
    }
}

/// Outputs that are summed side by side, so that each input is loaded once for all of them.
const ROWS: usize = 4;

impl Layer {
    /// bias + weights · x, for [`LANES`] x at once.
    fn run(&self, x: &[Lanes], y: &mut [Lanes]) {
        let (blocks, rest) = y.as_chunks_mut::<ROWS>();
        let (biases, rest_biases) = self.bias.as_chunks::<ROWS>();
        let (weights, rest_weights) = self.weights.split_at(blocks.len() * ROWS * self.inputs);
        for ((rows, biases), y) in weights.chunks_exact(ROWS * self.inputs).zip(biases).zip(blocks) {
            *y = sums(std::array::from_fn(|r| &rows[r * self.inputs..][..self.inputs]), biases, x);
        }
        for ((row, bias), y) in rest_weights.chunks_exact(self.inputs).zip(rest_biases).zip(rest) {
            [*y] = sums([row], &[*bias], x);
        }
    }
}

/// The sums of some rows of weights, each in the order of the inputs.
#[inline]
fn sums<const N: usize>(rows: [&[f32]; N], biases: &[f32; N], x: &[Lanes]) -> [Lanes; N] {
    let mut sums = biases.map(|bias| [bias; LANES]);
    for (i, x) in x.iter().enumerate() {
        for (sum, row) in sums.iter_mut().zip(&rows) {
            let w = row[i];
            for l in 0..LANES {
                sum[l] += w * x[l];
            }
        }
    }
    sums
}
