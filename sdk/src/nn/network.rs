//! Layers, one after the other.

use super::{LANES, Lanes, Layer};

/// The slope of the activation below 0: between two layers, v becomes v if v ≥ 0 and `LEAK`·v else (Maas et al. 2013, *Rectifier
/// nonlinearities improve neural network acoustic models*).
pub const LEAK: f32 = 0.1;

/// Layers with leaky rectifiers between them; the last one is linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    layers: Vec<Layer>,
    widest: usize,
}

/// Memory for the evaluation of networks, so that it isn't allocated each time.
#[derive(Clone, Debug, Default)]
pub struct Scratch([Vec<Lanes>; 2]);

impl Network {
    /// A network of these layers, each of which takes what the one before gives; `None` where they don't fit together, one has not
    /// as many numbers as its shape says, or there is none.
    #[must_use]
    pub fn new(layers: Vec<Layer>) -> Option<Self> {
        let fits = layers.windows(2).all(|l| l[0].shape.outputs() == l[1].shape.inputs())
            && layers.iter().all(Layer::is_whole);
        let widest = layers.iter().map(|l| l.shape.outputs()).max()?;
        fits.then_some(Self { layers, widest })
    }

    /// The layers, from the inputs to the outputs.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |l| l.shape.inputs())
    }

    /// The number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |l| l.shape.outputs())
    }

    /// The multiplications for one input.
    #[must_use]
    pub fn multiplications(&self) -> usize {
        self.layers.iter().map(|l| l.shape.multiplications()).sum()
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
            let source = if k == 0 { input } else { &from[..layer.shape.inputs()] };
            if k == last {
                layer.run(source, output);
            } else {
                let target = &mut to[..layer.shape.outputs()];
                layer.run(source, target);
                target.iter_mut().for_each(rectify);
                std::mem::swap(from, to);
            }
        }
    }
}

/// The activation: the greater of v and [`LEAK`]·v.
fn rectify(values: &mut Lanes) {
    for value in values {
        let leak = LEAK * *value;
        *value = if *value < leak { leak } else { *value };
    }
}
