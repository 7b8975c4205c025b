//! The loop of training.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use candle_core::{Device, Tensor};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use vb_math::rng::Stream;
use vb_terrain::shape::{BLOCK, CELL, CHANNELS, HALO};
use vb_terrain::tiles::{Cut, Tile, Tiles};

use crate::adam::Adam;
use crate::error::{TrainError, write};
use crate::loss::{self, Patches};
use crate::network::Network;

/// Samples along a tile's side. The middle square, less the cells of the margin, is reconstructed.
pub(crate) const SIDE: usize = 64;
/// How tiles are cut.
pub(crate) const CUT: Cut = Cut { side: SIDE, stride: 8, holes: 0.12 };
/// Metadata of a checkpoint.
const KEY: &str = "vb-terrain-train";
/// Time between checkpoints.
const KEEP: Duration = Duration::from_secs(60);
/// Steps between messages.
const TELL: u64 = 25;

/// What a training depends on besides the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Names all random draws.
    pub seed: u64,
    /// Tiles a step.
    pub batch: usize,
    /// Surfaces drawn from the prior a step.
    pub drawn: usize,
    /// Learning rate at its highest.
    pub rate: f64,
    /// Weight of the codes' sliced distance from the normal distribution.
    pub latent_weight: f64,
    /// Weight of the distance between patches of drawn surfaces and of tiles.
    pub patch_weight: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 1, batch: 16, drawn: 4, rate: 3e-3, latent_weight: 1.0, patch_weight: 1.0 }
    }
}

/// When a training ends.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// After so many passes over as many tiles as there are.
    Epochs(u64),
    /// After so much time. How far one gets depends on the machine, and so does the model.
    Time(Duration),
}

/// Mean losses of some steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// Mean absolute plus mean squared error of reconstruction, in standard deviations of height.
    pub reconstruction: f64,
    /// Squared sliced Wasserstein distance of codes from the normal distribution.
    pub latent: f64,
    /// Squared sliced distance of patches, in units of their own spread.
    pub patches: f64,
    /// The same of responses to filters.
    pub responses: f64,
    /// The same of what the encoder sees.
    pub features: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Progress {
    pub step: u64,
    /// Share of the whole, from 0 to 1.
    pub fraction: f64,
    /// Seconds a step.
    pub pace: f64,
    /// Losses since the last message.
    pub losses: Losses,
}

/// The state of a training on disk beside the tensors.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mark {
    schema: u32,
    data: String,
    settings: Settings,
    step: u64,
    seconds: f64,
    losses: Losses,
}

pub(crate) struct Trainer<'a> {
    pub(crate) network: Network,
    optimiser: Adam,
    tiles: &'a Tiles<'a>,
    /// Hash of the data.
    data: &'a str,
    settings: Settings,
    device: Device,
    pub(crate) step: u64,
    /// Time spent by runs before.
    before: f64,
    /// Mean losses when they were told last.
    losses: Losses,
    checkpoint: PathBuf,
}

impl<'a> Trainer<'a> {
    pub(crate) fn new(
        tiles: &'a Tiles<'a>,
        data: &'a str,
        settings: Settings,
        checkpoint: PathBuf,
    ) -> Result<Self, TrainError> {
        let device = Device::Cpu;
        let network = Network::new(settings.seed, &device)?;
        let optimiser = Adam::new(network.variables())?;
        Ok(Self {
            network,
            optimiser,
            tiles,
            data,
            settings,
            device,
            step: 0,
            before: 0.0,
            losses: Losses::default(),
            checkpoint,
        })
    }

    /// Takes up a training where its last checkpoint was.
    pub(crate) fn resume(&mut self) -> Result<(), TrainError> {
        let path = self.checkpoint.clone();
        let problem = |problem: String| TrainError::Checkpoint { path: path.clone(), problem };
        let bytes = std::fs::read(&path).map_err(|e| problem(format!("can't be read: {e}")))?;
        let damaged = |e: &dyn std::fmt::Display| {
            problem(format!("is no whole checkpoint ({e}): start again without --resume"))
        };
        let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(|e| damaged(&e))?;
        let mark = metadata.metadata().as_ref().and_then(|m| m.get(KEY));
        let mark: Mark = serde_json::from_str(mark.map_or("", String::as_str)).map_err(|e| damaged(&e))?;
        if mark.schema != 1 {
            return Err(damaged(&format!("schema {}", mark.schema)));
        }
        if mark.data != self.data {
            return Err(problem(
                "was trained on other data: give the same --data, or start again without --resume".into(),
            ));
        }
        if mark.settings != self.settings {
            return Err(problem(
                "was trained with other settings: give the same ones, or start again without --resume".into(),
            ));
        }
        let tensors = SafeTensors::deserialize(&bytes).map_err(|e| damaged(&e))?;
        let device = &self.device;
        self.optimiser
            .restore(|name| {
                let t = tensors.tensor(name).map_err(candle_core::Error::wrap)?;
                if t.dtype() != Dtype::F32 {
                    candle_core::bail!("{name} is {:?}", t.dtype());
                }
                let values = t.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
                Tensor::from_vec(values.collect(), t.shape(), device)
            })
            .map_err(|e| damaged(&e))?;
        (self.step, self.before, self.losses) = (mark.step, mark.seconds, mark.losses);
        Ok(())
    }

    /// Writes the state to disk.
    fn keep(&self, seconds: f64) -> Result<(), TrainError> {
        let mark = Mark {
            schema: 1,
            data: self.data.into(),
            settings: self.settings,
            step: self.step,
            seconds,
            losses: self.losses,
        };
        let internal = |e: &dyn std::fmt::Display| TrainError::Internal(e.to_string());
        let metadata = serde_json::to_string(&mark).map_err(|e| internal(&e))?;
        let mut parts = Vec::new();
        for (name, tensor) in self.optimiser.state() {
            let values = tensor.flatten_all()?.to_vec1::<f32>()?;
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            parts.push((name, tensor.dims().to_vec(), bytes));
        }
        let views = parts
            .iter()
            .map(|(name, shape, bytes)| {
                Ok((
                    name.as_str(),
                    TensorView::new(Dtype::F32, shape.clone(), bytes).map_err(|e| internal(&e))?,
                ))
            })
            .collect::<Result<Vec<_>, TrainError>>()?;
        let metadata = [(KEY.to_owned(), metadata)].into_iter().collect();
        let bytes = safetensors::serialize(views, Some(metadata)).map_err(|e| internal(&e))?;
        write(&self.checkpoint, &bytes)
    }

    /// Steps that one pass over as many tiles as there are takes.
    fn epoch(&self) -> u64 {
        (self.tiles.len().div_ceil(self.settings.batch)).max(1) as u64
    }

    /// Trains to the end; tells how it goes from time to time. Returns the last mean losses and the seconds spent.
    pub(crate) fn run(
        &mut self,
        end: End,
        mut tell: impl FnMut(&Progress),
    ) -> Result<(Losses, f64), TrainError> {
        let since = now();
        let spent = |before: f64| before + since.elapsed().as_secs_f64();
        let fraction = |step: u64, epoch: u64, seconds: f64| match end {
            End::Epochs(n) => step as f64 / (n * epoch).max(1) as f64,
            End::Time(limit) => seconds / limit.as_secs_f64().max(1e-9),
        };
        let (mut sum, mut steps) = ([0.0; 5], 0.0);
        let (mut kept, mut told) = (now(), now());
        loop {
            let done = fraction(self.step, self.epoch(), spent(self.before));
            if done >= 1.0 {
                break;
            }
            for (sum, value) in sum.iter_mut().zip(self.once(done)?) {
                *sum += value;
            }
            steps += 1.0;
            if self.step.is_multiple_of(TELL) {
                let [reconstruction, latent, patches, responses, features] = sum.map(|s| s / steps);
                self.losses = Losses { reconstruction, latent, patches, responses, features };
                if !self.losses.reconstruction.is_finite() {
                    return Err(TrainError::Internal(
                        "the losses are no numbers any more: lower --rate".into(),
                    ));
                }
                let pace = told.elapsed().as_secs_f64() / steps;
                let fraction = fraction(self.step, self.epoch(), spent(self.before)).min(1.0);
                tell(&Progress { step: self.step, fraction, pace, losses: self.losses });
                (sum, steps, told) = ([0.0; 5], 0.0, now());
            }
            if kept.elapsed() >= KEEP {
                self.keep(spent(self.before))?;
                kept = now();
            }
        }
        let seconds = spent(self.before);
        self.keep(seconds)?;
        Ok((self.losses, seconds))
    }

    /// One step at a share of the whole: its losses.
    fn once(&mut self, fraction: f64) -> Result<[f64; 5], TrainError> {
        let s = self.settings;
        self.step += 1;
        // A stream of its own: a training that was broken off and resumed draws the same.
        let mut rng = Stream::new(s.seed, &["terrain", "step", &self.step.to_string()]);
        let (tiles, measured) =
            tensors(&(0..s.batch).map(|_| self.tiles.draw(&mut rng)).collect::<Vec<_>>(), &self.device)?;
        let (latent, seen) = self.network.encode(&tiles, false)?;
        let made = self.network.decode(&latent, |_| Ok(None))?;
        let reconstruction = loss::reconstruction(&made, &middle(&tiles)?, &middle(&measured)?)?;
        let codes = loss::codes(&latent, BLOCK)?;
        let prior = loss::normal(codes.dims(), &mut rng, &self.device)?;
        let distance = loss::sliced(&codes, &prior, 128, &mut rng)?;
        let side = SIDE / CELL + 2 * HALO;
        let field = loss::normal(&[s.drawn, side, side, CHANNELS], &mut rng, &self.device)?;
        let device = &self.device;
        let drawn = self
            .network
            .decode(&field, |[b, h, w]| loss::normal(&[b, h, w, 1], &mut rng, device).map(Some))?;
        let seen: Vec<Tensor> = seen.iter().map(Tensor::detach).collect();
        let real = Patches::real(&tiles, &measured, &seen, 1024, &mut rng)?;
        let (_, seen) = self.network.encode(&drawn, true)?;
        let [patches, responses, features] = real.distance(&drawn, &seen, 40, &mut rng)?;
        let looks = (((&patches + &responses)? + &features)? * s.patch_weight)?;
        let total = ((&reconstruction + (&distance * s.latent_weight)?)? + looks)?;
        let gradients = total.backward()?;
        // A warm start, then half a cosine down to a fiftieth.
        let warm = (self.step as f64 / 50.0).min(1.0);
        let cosine = 0.5 + 0.5 * vb_math::cos(std::f64::consts::PI * fraction);
        self.optimiser.step(&gradients, self.step, s.rate * warm * cosine.max(0.02))?;
        let mut values = [0.0; 5];
        for (value, loss) in
            values.iter_mut().zip([&reconstruction, &distance, &patches, &responses, &features])
        {
            *value = f64::from(loss.to_scalar::<f32>()?);
        }
        Ok(values)
    }
}

/// Tiles and what of them was measured, as (batch, row, column, 1).
pub(crate) fn tensors(tiles: &[Tile], device: &Device) -> Result<(Tensor, Tensor), TrainError> {
    let shape = (tiles.len(), SIDE, SIDE, 1);
    let heights = tiles.iter().flat_map(|t| t.heights.iter().map(|v| *v as f32)).collect::<Vec<_>>();
    let measured =
        tiles.iter().flat_map(|t| t.measured.iter().map(|m| f32::from(u8::from(*m)))).collect::<Vec<_>>();
    Ok((Tensor::from_vec(heights, shape, device)?, Tensor::from_vec(measured, shape, device)?))
}

/// The part of tiles that the decoder makes of their latent field.
pub(crate) fn middle(tiles: &Tensor) -> Result<Tensor, TrainError> {
    let (margin, side) = (HALO * CELL, SIDE - 2 * HALO * CELL);
    Ok(tiles.narrow(1, margin, side)?.narrow(2, margin, side)?)
}

pub(crate) fn checkpoint_of(model: &Path) -> PathBuf {
    model.with_extension("checkpoint")
}

#[allow(
    clippy::disallowed_methods,
    reason = "paces messages and checkpoints, and ends a training that has a time limit"
)]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_terrain::ElevationImage;
    use vb_terrain::data::{Layer, Scan};
    use vb_terrain::repair::Repaired;

    /// Waves of two lengths.
    fn scan() -> Scan {
        let z = |i: usize| {
            let (r, c) = ((i / 80) as f64, (i % 80) as f64);
            vb_math::sin(0.7 * r) * vb_math::cos(0.5 * c) + 0.5 * vb_math::sin(0.2 * (r + c))
        };
        let heights = ElevationImage::new(80, 80, (0..80 * 80).map(z).collect());
        let layer = Layer { heights, measured: vec![true; 80 * 80] };
        Scan { name: "waves".into(), held_out: false, repaired: Repaired::default(), layers: vec![layer] }
    }

    const SETTINGS: Settings =
        Settings { seed: 5, batch: 2, drawn: 1, rate: 3e-3, latent_weight: 1.0, patch_weight: 1.0 };

    fn numbers(t: &Trainer) -> Vec<Vec<f32>> {
        let all = t.network.variables().into_iter();
        all.map(|(_, v)| v.as_tensor().flatten_all().unwrap().to_vec1().unwrap()).collect()
    }

    #[test]
    fn a_training_that_was_broken_off_goes_on_as_if_it_had_not_been() {
        let scan = scan();
        let tiles = Tiles::cut([&scan], CUT);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.checkpoint");
        let mut whole = Trainer::new(&tiles, "data", SETTINGS, path.clone()).unwrap();
        whole.once(0.0).unwrap();
        whole.once(0.3).unwrap();
        whole.keep(1.5).unwrap();
        let losses = whole.once(0.6).unwrap();
        let mut broken = Trainer::new(&tiles, "data", SETTINGS, path.clone()).unwrap();
        broken.resume().unwrap();
        assert_eq!((broken.step, broken.before), (2, 1.5));
        assert_eq!(broken.once(0.6).unwrap(), losses);
        assert_eq!(numbers(&broken), numbers(&whole));
        // Other data, other settings and a damaged file are told.
        let why = |data: &str, settings: Settings| {
            Trainer::new(&tiles, data, settings, path.clone()).unwrap().resume().unwrap_err().to_string()
        };
        assert!(why("other", SETTINGS).contains("other data"));
        assert!(why("data", Settings { seed: 6, ..SETTINGS }).contains("other settings"));
        std::fs::write(&path, "no checkpoint").unwrap();
        assert!(why("data", SETTINGS).contains("no whole checkpoint"));
    }

    #[test]
    fn training_makes_the_losses_small() {
        let scan = scan();
        let tiles = Tiles::cut([&scan], CUT);
        let dir = tempfile::tempdir().unwrap();
        let mut t = Trainer::new(&tiles, "data", SETTINGS, dir.path().join("a")).unwrap();
        let first = t.once(0.0).unwrap();
        let mut last = [0.0; 5];
        for _ in 0..60 {
            last = t.once(0.0).unwrap();
        }
        assert!(last[0] < 0.7 * first[0] && last[2] < 0.7 * first[2], "{first:?} {last:?}");
    }
}
