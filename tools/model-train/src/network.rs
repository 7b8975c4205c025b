//! Networks while they are trained.

use candle_core::{Device, Result, Tensor, Var};
use vb_math::rng::Stream;
use vb_sdk::nn::{LEAK, Layer, Weights};

use crate::repeatable::{dense, rectify};

/// Dense layers with leaky rectifiers between them.
pub struct Dense {
    name: String,
    /// Weights (inputs × outputs) and bias of each layer.
    layers: Vec<(Var, Var)>,
}

impl Dense {
    /// Random weights for layers of these sizes, the inputs first; the last layer begins small, so that nothing is corrected.
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
            let (from, to) = (layer.shape.inputs(), layer.shape.outputs());
            if to != outputs || from > inputs {
                candle_core::bail!(
                    "layer {name} turns {inputs} inputs into {outputs} outputs, not {from} into {to}"
                );
            }
            let mut values = vec![0.0_f32; inputs * outputs];
            for (o, row) in layer.weights.chunks_exact(from).enumerate() {
                for (i, w) in row.iter().enumerate() {
                    values[i * outputs + o] = *w;
                }
            }
            weights.set(&Tensor::from_vec(values, (inputs, outputs), &Device::Cpu)?)?;
            bias.set(&Tensor::from_vec(layer.bias.clone(), outputs, &Device::Cpu)?)?;
        }
        Ok(())
    }

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
            x = dense(&x, weights, bias)?;
            if k + 1 < self.layers.len() {
                x = rectify(&x)?;
            }
        }
        Ok(x)
    }

    /// The layers as planners have them.
    pub fn layers(&self) -> Result<Vec<Layer>> {
        let layer = |(k, (weights, bias)): (usize, &(Var, Var))| {
            let name = format!("{}.{k}", self.name);
            let rows = weights.t()?.contiguous()?.flatten_all()?.to_vec1()?;
            Ok(Layer::dense(name, weights.dim(0)?, rows, bias.to_vec1()?))
        };
        self.layers.iter().enumerate().map(layer).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::nn::{Convolution, LANES, Lanes, Network, Scratch, Shape};

    fn random(count: usize, seed: u64) -> Vec<f32> {
        let mut random = Stream::new(seed, &["test"]);
        (0..count).map(|_| random.normal(0.0, 1.0) as f32).collect()
    }

    /// What a network of a planner gives for one input.
    fn run(layers: Vec<Layer>, input: &[f32]) -> Vec<f32> {
        let network = Network::new(layers).unwrap();
        let mut output = vec![[0.0; LANES]; network.outputs()];
        let input: Vec<Lanes> = input.iter().map(|v| [*v; LANES]).collect();
        network.run(&input, &mut output, &mut Scratch::default());
        output.iter().map(|v| v[LANES - 1]).collect()
    }

    fn alike(own: &[f32], candle: &Tensor) {
        let candle = candle.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert_eq!(own.len(), candle.len());
        for (a, b) in own.iter().zip(&candle) {
            assert!((a - b).abs() < 1e-4, "{own:?} {candle:?}");
        }
    }

    #[test]
    fn dense_layers_give_in_planners_what_they_give_in_training() {
        let dense = Dense::new("net", &[7, 12, 5], 3).unwrap();
        let input = random(7, 4);
        let should = dense.forward(&Tensor::from_vec(input.clone(), (1, 7), &Device::Cpu).unwrap()).unwrap();
        alike(&run(dense.layers().unwrap(), &input), &should);
    }

    #[test]
    fn convolutions_give_in_planners_what_they_give_in_training() {
        for (kernel, stride, padding) in [(3, 1, 1), (3, 2, 1), (4, 2, 0), (1, 1, 0)] {
            let shape = Convolution { planes: 3, rows: 8, cols: 10, outputs: 4, kernel, stride, padding };
            let (weights, bias) = (random(4 * 3 * kernel * kernel, 5), random(4, 6));
            let input = random(3 * 8 * 10, 7);
            let of = |values: &[f32], shape: (usize, usize, usize, usize)| {
                Tensor::from_vec(values.to_vec(), shape, &Device::Cpu).unwrap()
            };
            let planes = of(&input, (1, 3, 8, 10));
            let sums = planes.conv2d(&of(&weights, (4, 3, kernel, kernel)), padding, stride, 1, 1).unwrap();
            let should = sums.broadcast_add(&of(&bias, (1, 4, 1, 1))).unwrap();
            let layer = Layer { name: "net.0".into(), shape: Shape::Convolution(shape), weights, bias };
            alike(&run(vec![layer], &input), &should);
        }
    }
}
