//! Networks of consecutive layers.

use super::{LANES, Lanes, Layer};

/// The negative slope of the activation between layers: v becomes v if v ≥ 0, otherwise `LEAK`·v (Maas et al. 2013,
/// *Rectifier nonlinearities improve neural network acoustic models*).
pub const LEAK: f32 = 0.1;

/// Layers with leaky rectifiers between them; the last layer is linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    layers: Vec<Layer>,
    widest: usize,
}

/// Scratch memory for evaluating networks.
#[derive(Clone, Debug, Default)]
pub struct Scratch([Vec<Lanes>; 2]);

impl Network {
    /// Creates a network of these layers; `None` if there is no layer, consecutive layers do not match, or the number
    /// of values of a layer does not match its shape.
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

    /// Multiplications per input.
    #[must_use]
    pub fn multiplications(&self) -> usize {
        self.layers.iter().map(|l| l.shape.multiplications()).sum()
    }

    /// Evaluates the network for [`LANES`] inputs at once: entry i of `input` contains input i of each. `output` has
    /// one entry per output.
    ///
    /// # Panics
    /// Panics if the number of entries is not the number of inputs or outputs.
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

/// The activation: the maximum of v and [`LEAK`]·v.
fn rectify(values: &mut Lanes) {
    for value in values {
        let leak = LEAK * *value;
        *value = if *value < leak { leak } else { *value };
    }
}
