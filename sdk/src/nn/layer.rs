//! Layers: dense layers, and convolutions over planes of values.

use super::{LANES, Lanes};

/// A layer: weighted sums of its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The name, `NETWORK.NUMBER`.
    pub name: String,
    /// The inputs of the sums.
    pub shape: Shape,
    /// Dense layer: a row of input weights per output. Convolution: for each output plane the kernel of each input
    /// plane, row by row.
    pub weights: Vec<f32>,
    /// The bias of each output, or of each output plane.
    pub bias: Vec<f32>,
}

/// The inputs of a layer's sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// All inputs.
    Dense {
        /// The number of inputs.
        inputs: usize,
        /// The number of outputs.
        outputs: usize,
    },
    /// The neighbourhood of each position.
    Convolution(Convolution),
}

/// A convolution (as in neural networks: without mirroring the kernel) over planes of rows of values. Inputs and
/// outputs are planes one after the other, each row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Convolution {
    /// Input planes.
    pub planes: usize,
    /// Rows per plane.
    pub rows: usize,
    /// Values per row.
    pub cols: usize,
    /// Output planes.
    pub outputs: usize,
    /// Rows and columns of the kernel.
    pub kernel: usize,
    /// Stride of the kernel.
    pub stride: usize,
    /// Rows and columns of zero padding.
    pub padding: usize,
}

impl Convolution {
    /// Rows and columns of an output plane; none if the kernel is larger than the input.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        let along = |n: usize| match (n + 2 * self.padding).checked_sub(self.kernel) {
            Some(rest) => rest / self.stride + 1,
            None => 0,
        };
        (along(self.rows), along(self.cols))
    }
}

impl Shape {
    /// The number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        match self {
            Self::Dense { inputs, .. } => *inputs,
            Self::Convolution(c) => c.planes * c.rows * c.cols,
        }
    }

    /// The number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        match self {
            Self::Dense { outputs, .. } => *outputs,
            Self::Convolution(c) => c.outputs * c.size().0 * c.size().1,
        }
    }

    /// The number of weights and of biases.
    #[must_use]
    pub fn numbers(&self) -> (usize, usize) {
        match self {
            Self::Dense { inputs, outputs } => (inputs * outputs, *outputs),
            Self::Convolution(c) => (c.outputs * c.planes * c.kernel * c.kernel, c.outputs),
        }
    }

    /// Multiplications per input.
    #[must_use]
    pub fn multiplications(&self) -> usize {
        match self {
            Self::Dense { inputs, outputs } => inputs * outputs,
            Self::Convolution(c) => self.outputs() * c.planes * c.kernel * c.kernel,
        }
    }
}

impl Layer {
    /// Creates a dense layer; the numbers of inputs and outputs follow from weights and bias.
    #[must_use]
    pub fn dense(name: impl Into<String>, inputs: usize, weights: Vec<f32>, bias: Vec<f32>) -> Self {
        Self { name: name.into(), shape: Shape::Dense { inputs, outputs: bias.len() }, weights, bias }
    }

    /// Whether the numbers of weights and biases match the shape.
    pub(super) fn is_whole(&self) -> bool {
        (self.weights.len(), self.bias.len()) == self.shape.numbers()
    }

    /// bias + weights · x, for [`LANES`] x at once.
    pub(super) fn run(&self, x: &[Lanes], y: &mut [Lanes]) {
        match &self.shape {
            Shape::Dense { inputs, .. } => self.all(*inputs, x, y),
            Shape::Convolution(c) => self.convolve(c, x, y),
        }
    }

    fn all(&self, inputs: usize, x: &[Lanes], y: &mut [Lanes]) {
        let (blocks, rest) = y.as_chunks_mut::<ROWS>();
        let (biases, rest_biases) = self.bias.as_chunks::<ROWS>();
        let (weights, rest_weights) = self.weights.split_at(blocks.len() * ROWS * inputs);
        for ((rows, biases), y) in weights.chunks_exact(ROWS * inputs).zip(biases).zip(blocks) {
            *y = sums(std::array::from_fn(|r| &rows[r * inputs..][..inputs]), biases, x);
        }
        for ((row, bias), y) in rest_weights.chunks_exact(inputs).zip(rest_biases).zip(rest) {
            [*y] = sums([row], &[*bias], x);
        }
    }

    fn convolve(&self, c: &Convolution, x: &[Lanes], y: &mut [Lanes]) {
        let (rows, cols) = c.size();
        let own = c.planes * c.kernel * c.kernel;
        let planes = y.chunks_exact_mut(rows * cols).zip(self.weights.chunks_exact(own)).zip(&self.bias);
        for ((plane, weights), bias) in planes {
            for (k, sum) in plane.iter_mut().enumerate() {
                *sum = [*bias; LANES];
                let (top, left) = (k / cols * c.stride, k % cols * c.stride);
                for (w, weight) in weights.iter().enumerate() {
                    let (from, row, col) = (w / (c.kernel * c.kernel), w / c.kernel % c.kernel, w % c.kernel);
                    // Padding rows and columns wrap to large numbers here.
                    let (row, col) =
                        ((top + row).wrapping_sub(c.padding), (left + col).wrapping_sub(c.padding));
                    if row < c.rows && col < c.cols {
                        let x = &x[(from * c.rows + row) * c.cols + col];
                        for l in 0..LANES {
                            sum[l] += weight * x[l];
                        }
                    }
                }
            }
        }
    }
}

/// Outputs of a dense layer that are summed at once, so that each input is loaded once for all of them.
const ROWS: usize = 4;

/// The sums of some rows of weights, each in the order of the inputs.
#[inline]
fn sums<const N: usize>(rows: [&[f32]; N], biases: &[f32; N], x: &[Lanes]) -> [Lanes; N] {
    let mut sums = biases.map(|bias| [bias; LANES]);
    let mut add = |i: usize, x: &Lanes| {
        for (sum, row) in sums.iter_mut().zip(&rows) {
            let w = row[i];
            for l in 0..LANES {
                sum[l] += w * x[l];
            }
        }
    };
    // Four at a time: a fuel-counting WASM runtime spills all sums to memory once per loop iteration.
    let (fours, rest) = x.as_chunks::<4>();
    for (k, four) in fours.iter().enumerate() {
        four.iter().enumerate().for_each(|(i, x)| add(4 * k + i, x));
    }
    rest.iter().enumerate().for_each(|(i, x)| add(4 * fours.len() + i, x));
    sums
}
