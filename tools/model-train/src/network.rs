//! Networks while they are trained.

use candle_core::{Device, Result, Tensor, Var};
use vb_math::rng::Stream;
use vb_sdk::nn::{LEAK, Layer, Weights};

/// The activation: max(x, leak · x).
///
/// # Errors
/// Returns an error if there is no memory.
pub fn rectify(x: &Tensor) -> Result<Tensor> {
    x.maximum(&(x * f64::from(LEAK))?)
}

/// Dense layers with leaky rectifiers between them.
pub struct Dense {
    name: String,
    /// Weights (inputs × outputs) and bias of each layer.
    layers: Vec<(Var, Var)>,
}

impl Dense {
    /// Random weights for layers of these sizes, the inputs first; the last layer begins small, so that nothing is corrected.
    ///
    /// # Errors
    /// Returns an error if there is no memory.
    pub fn new(name: &str, sizes: &[usize], seed: u64) -> Result<Self> {
        let mut random = Stream::new(seed, &["model", name]);
        let mut layers = Vec::new();
        for (k, pair) in sizes.windows(2).enumerate() {
            let (inputs, outputs) = (pair[0], pair[1]);
            // He et al. 2015, for rectifiers with a leak.
            let leak = f64::from(LEAK);
            let std = (2.0 / ((1.0 + leak * leak) * inputs as f64)).sqrt();
            let std = if k + 2 == sizes.len() { 0.1 * std } else { std };
            let values: Vec<f32> = (0..inputs * outputs).map(|_| random.normal(0.0, std) as f32).collect();
            let weights = Var::from_vec(values, (inputs, outputs), &Device::Cpu)?;
            layers.push((weights, Var::from_vec(vec![0.0_f32; outputs], outputs, &Device::Cpu)?));
        }
        Ok(Self { name: name.to_owned(), layers })
    }

    /// Begins with the weights of a trained network of this name, if there is one. Inputs that it hasn't got, at the end, count for
    /// nothing at first.
    ///
    /// # Errors
    /// Returns an error if its layers have other sizes.
    pub fn begin_with(&self, trained: &Weights) -> Result<()> {
        for (k, (weights, bias)) in self.layers.iter().enumerate() {
            let name = format!("{}.{k}", self.name);
            let Some(layer) = trained.layers.iter().find(|l| l.name == name) else { continue };
            let (inputs, outputs) = weights.dims2()?;
            if layer.outputs != outputs || layer.inputs > inputs {
                let (from, to) = (layer.inputs, layer.outputs);
                candle_core::bail!(
                    "layer {name} turns {inputs} inputs into {outputs} outputs, not {from} into {to}"
                );
            }
            let mut values = vec![0.0_f32; inputs * outputs];
            for (o, row) in layer.weights.chunks_exact(layer.inputs).enumerate() {
                for (i, w) in row.iter().enumerate() {
                    values[i * outputs + o] = *w;
                }
            }
            weights.set(&Tensor::from_vec(values, (inputs, outputs), &Device::Cpu)?)?;
            bias.set(&Tensor::from_vec(layer.bias.clone(), outputs, &Device::Cpu)?)?;
        }
        Ok(())
    }

    /// The variables.
    pub fn variables(&self) -> impl Iterator<Item = Var> {
        self.layers.iter().flat_map(|(w, b)| [w.clone(), b.clone()])
    }

    /// The outputs for rows of inputs.
    ///
    /// # Errors
    /// Returns an error if the rows have another length.
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let mut x = x.clone();
        for (k, (weights, bias)) in self.layers.iter().enumerate() {
            x = x.matmul(weights)?.broadcast_add(bias)?;
            if k + 1 < self.layers.len() {
                x = rectify(&x)?;
            }
        }
        Ok(x)
    }

    /// The layers as planners have them.
    ///
    /// # Errors
    /// Returns an error if a variable can't be read.
    pub fn layers(&self) -> Result<Vec<Layer>> {
        let layer = |(k, (weights, bias)): (usize, &(Var, Var))| {
            let (inputs, outputs) = weights.dims2()?;
            Ok(Layer {
                name: format!("{}.{k}", self.name),
                inputs,
                outputs,
                weights: weights.t()?.contiguous()?.flatten_all()?.to_vec1()?,
                bias: bias.to_vec1()?,
            })
        };
        self.layers.iter().enumerate().map(layer).collect()
    }
}
