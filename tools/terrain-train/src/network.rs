//! Encoder and decoder, with samples last (batch, row, column, channel), so that every convolution is one product of
//! matrices.

use candle_core::{Device, Result, Tensor, Var};
use vb_math::rng::Stream;
use vb_terrain::shape::{CHANNELS, DECODER, LEAK, Layer};

use crate::ops::{activated, windows};

/// A convolution of the encoder; where `halved`, squares of 2 × 2 samples become channels before it.
const ENCODER: [(Layer, bool); 7] = [
    (Layer { kernel: 3, from: 4, to: 32, doubled: false, noise: false, active: true }, true),
    (Layer { kernel: 1, from: 128, to: 64, doubled: false, noise: false, active: true }, true),
    (Layer { kernel: 3, from: 64, to: 64, doubled: false, noise: false, active: true }, false),
    (Layer { kernel: 1, from: 256, to: 96, doubled: false, noise: false, active: true }, true),
    (Layer { kernel: 3, from: 96, to: 96, doubled: false, noise: false, active: true }, false),
    (Layer { kernel: 3, from: 96, to: 96, doubled: false, noise: false, active: true }, false),
    (Layer { kernel: 1, from: 96, to: CHANNELS, doubled: false, noise: false, active: false }, false),
];

/// Layers of the encoder whose results tell what tiles look like, one a resolution.
const SEEN: [usize; 3] = [0, 2, 5];

/// A convolution's trained numbers.
struct Convolution {
    layer: Layer,
    /// (kernel² · from) × to.
    weight: Var,
    bias: Var,
}

impl Convolution {
    fn new(layer: Layer, rng: &mut Stream, device: &Device) -> Result<Self> {
        let inputs = layer.kernel * layer.kernel * layer.from;
        // He et al. 2015, for rectifiers with a leak.
        let leak = f64::from(LEAK);
        let std = (2.0 / ((1.0 + leak * leak) * inputs as f64)).sqrt();
        let values: Vec<f32> = (0..inputs * layer.to).map(|_| rng.normal(0.0, std) as f32).collect();
        let weight = Var::from_vec(values, (inputs, layer.to), device)?;
        let bias = Var::zeros(layer.to, candle_core::DType::F32, device)?;
        Ok(Self { layer, weight, bias })
    }

    /// With `fixed`, nothing is learned from what comes of it.
    fn forward(&self, x: &Tensor, fixed: bool) -> Result<Tensor> {
        let of = |v: &Var| if fixed { v.as_tensor().detach() } else { v.as_tensor().clone() };
        let (weight, bias) = (of(&self.weight), of(&self.bias));
        let x = if self.layer.kernel == 1 {
            x.clone()
        } else {
            windows(x, self.layer.kernel, self.layer.doubled)?
        };
        let (b, h, w, c) = x.dims4()?;
        let y = x.reshape((b * h * w, c))?.matmul(&weight)?;
        let y = if self.layer.active { activated(&y, &bias, LEAK)? } else { y.broadcast_add(&bias)? };
        y.reshape((b, h, w, self.layer.to))
    }
}

/// Squares of 2 × 2 samples as channels.
fn halved(x: &Tensor) -> Result<Tensor> {
    let (b, h, w, c) = x.dims4()?;
    x.reshape((b, h / 2, 2, w / 2, 2, c))?.permute((0, 1, 3, 2, 4, 5))?.reshape((b, h / 2, w / 2, 4 * c))
}

/// The autoencoder.
pub(crate) struct Network {
    encoder: Vec<Convolution>,
    decoder: Vec<Convolution>,
}

impl Network {
    /// A network with random weights.
    pub(crate) fn new(seed: u64, device: &Device) -> Result<Self> {
        let mut rng = Stream::new(seed, &["terrain", "weights"]);
        let encoder =
            ENCODER.into_iter().map(|(l, _)| Convolution::new(l, &mut rng, device)).collect::<Result<_>>()?;
        let decoder =
            DECODER.into_iter().map(|l| Convolution::new(l, &mut rng, device)).collect::<Result<_>>()?;
        Ok(Self { encoder, decoder })
    }

    /// The latent field of tiles (batch, row, column, 1), one cell for 8 × 8 samples, and what the encoder sees on its way there,
    /// at [`SEEN`].
    pub(crate) fn encode(&self, tiles: &Tensor, fixed: bool) -> Result<(Tensor, Vec<Tensor>)> {
        let mut x = tiles.clone();
        let mut seen = Vec::new();
        for (i, (convolution, (_, halve))) in self.encoder.iter().zip(ENCODER).enumerate() {
            if halve {
                x = halved(&x)?;
            }
            if convolution.layer.kernel == 3 {
                // The tile's edge is continued by its last samples.
                x = x.pad_with_same(1, 1, 1)?.pad_with_same(2, 1, 1)?;
            }
            x = convolution.forward(&x, fixed)?;
            if SEEN.contains(&i) {
                seen.push(x.clone());
            }
        }
        Ok((x, seen))
    }

    /// The surface of a latent field, without the cells of its margin. Its details are made of the noise that `noise` gives for
    /// so many tiles, rows and columns; of none, they are what is likeliest.
    pub(crate) fn decode(
        &self,
        latent: &Tensor,
        mut noise: impl FnMut([usize; 3]) -> Result<Option<Tensor>>,
    ) -> Result<Tensor> {
        let mut x = latent.clone();
        for convolution in &self.decoder {
            if convolution.layer.noise {
                let (b, h, w, _) = x.dims4()?;
                let detail = match noise([b, h, w])? {
                    Some(noise) => noise,
                    None => Tensor::zeros((b, h, w, 1), x.dtype(), x.device())?,
                };
                x = Tensor::cat(&[&x, &detail], 3)?;
            }
            x = convolution.forward(&x, false)?;
        }
        Ok(x)
    }

    /// All trained numbers by name.
    pub(crate) fn variables(&self) -> Vec<(String, Var)> {
        let part = |name: &'static str, all: &[Convolution]| {
            all.iter()
                .enumerate()
                .flat_map(|(i, c)| {
                    [
                        (format!("{name}.{i}.weight"), c.weight.clone()),
                        (format!("{name}.{i}.bias"), c.bias.clone()),
                    ]
                })
                .collect::<Vec<_>>()
        };
        [part("encoder", &self.encoder), part("decoder", &self.decoder)].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_terrain::model::{Header, Model, SCHEMA};
    use vb_terrain::shape::{CELL, HALO, NUMBERS};

    use crate::card::weights;

    #[test]
    fn what_is_trained_is_what_the_model_draws() {
        let network = Network::new(3, &Device::Cpu).unwrap();
        // Biases begin at 0: others tell whether they are taken over.
        let mut rng = Stream::new(4, &["test"]);
        for (name, v) in network.variables() {
            if name.ends_with("bias") {
                let values: Vec<f32> = (0..v.elem_count()).map(|_| rng.normal(0.0, 0.3) as f32).collect();
                v.set(&Tensor::from_vec(values, v.shape(), &Device::Cpu).unwrap()).unwrap();
            }
        }
        let header = Header {
            schema: SCHEMA,
            resolution: 1.0,
            relief: 1.0,
            detail: 1.0,
            swell: [0.0; 2],
            passes: 0,
            mean: 0.0,
            std: 1.0,
        };
        let model = Model::new(header, &weights(&network).unwrap(), &[]).unwrap();
        let n = 3;
        let side = n + 2 * HALO;
        let cells: Vec<f32> = (0..side * side * NUMBERS).map(|_| rng.normal(0.0, 1.0) as f32).collect();
        let number = |row: usize, col: usize, i: usize| cells[(row * side + col) * NUMBERS + i];
        let latent: Vec<f32> = (0..side * side * CHANNELS)
            .map(|i| number(i / CHANNELS / side, i / CHANNELS % side, i % CHANNELS))
            .collect();
        let latent = Tensor::from_vec(latent, (1, side, side, CHANNELS), &Device::Cpu).unwrap();
        // The noise of each cell's 4 × 4, then 8 × 8 places, the picture in the middle of the cells.
        let mut levels = vec![(8, CHANNELS + 16), (4, CHANNELS)];
        let made = network.decode(&latent, |[_, h, w]| {
            let (places, start) = levels.pop().unwrap();
            let margin = (places * side - h) / 2;
            let values: Vec<f32> = (0..h * w)
                .map(|i| {
                    let (row, col) = (margin + i / w, margin + i % w);
                    number(row / places, col / places, start + row % places * places + col % places)
                })
                .collect();
            Tensor::from_vec(values, (1, h, w, 1), &Device::Cpu).map(Some)
        });
        let made = made.unwrap().flatten_all().unwrap().to_vec1::<f32>().unwrap();
        let drawn = model.block(&cells, n);
        assert_eq!((made.len(), levels.len()), ((CELL * n) * (CELL * n), 0));
        let spread = (made.iter().map(|v| v * v).sum::<f32>() / made.len() as f32).sqrt();
        // Sums of some hundreds of products in another order.
        for (a, b) in made.iter().zip(&drawn) {
            assert!((a - b).abs() < 2e-5 * spread, "{a} {b}");
        }
    }

    #[test]
    fn an_encoder_makes_one_cell_of_eight_samples() {
        let network = Network::new(1, &Device::Cpu).unwrap();
        let tiles = Tensor::zeros((2, 64, 32, 1), candle_core::DType::F32, &Device::Cpu).unwrap();
        let (latent, seen) = network.encode(&tiles, false).unwrap();
        assert_eq!(latent.dims(), [2, 8, 4, CHANNELS]);
        assert_eq!(seen.iter().map(|s| s.dims()[1]).collect::<Vec<_>>(), [32, 16, 8]);
    }
}
