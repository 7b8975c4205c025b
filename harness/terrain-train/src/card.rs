//! The model's card: what it was trained on, how, and how well it does on scans that it never saw.

use candle_core::Device;
use serde::Serialize;
use vb_math::rng::Stream;
use vb_terrain::data::{Data, Scan};
use vb_terrain::model::{Header, Model, Weights};
use vb_terrain::shape::{BLOCK, LATENT};
use vb_terrain::stats::{Spectrum, deviation, percentile, slopes, spectral_distance};
use vb_terrain::tiles::{Tile, Tiles};
use vb_terrain::{Raster, Request};

use crate::error::TrainError;
use crate::loss;
use crate::network::Network;
use crate::trainer::{CUT, Losses, SIDE, Settings, middle, tensors};

/// Nodes along the surfaces that a model is measured on, and their number.
const DRAWN: usize = 512;
const SURFACES: u64 = 4;

/// A model's card.
#[derive(Clone, Debug, Serialize)]
pub struct Card {
    /// Version of this format: 1.
    pub schema: u32,
    /// SHA-256 of the model file.
    pub sha256: String,
    /// What it was trained on.
    pub data: DataCard,
    /// What training depended on.
    pub settings: Settings,
    /// Steps of training.
    pub steps: u64,
    /// Time that training took, s.
    pub seconds: f64,
    /// Mean losses at the end of training.
    pub losses: Losses,
    /// The model's own header.
    pub header: Header,
    /// How well it does on scans that it never saw; of the training scans where none were held out.
    pub held_out: Metrics,
}

/// The data of a training.
#[derive(Clone, Debug, Serialize)]
pub struct DataCard {
    /// SHA-256 over names and bytes of the files used and of the selection.
    pub sha256: String,
    /// Files that were trained on.
    pub trained: Vec<String>,
    /// Files that were held out.
    pub held_out: Vec<String>,
    /// Different tiles that were trained on.
    pub tiles: usize,
    /// Tiles that were left out as copies.
    pub copies: usize,
    /// Isolated pits that were replaced.
    pub pits: usize,
    /// Isolated spikes that were replaced.
    pub spikes: usize,
    /// Standard deviation of height about each part's plane, in the files' unit.
    pub std: f64,
}

/// How well a model does.
#[derive(Clone, Debug, Serialize)]
pub struct Metrics {
    /// Number of tiles.
    pub tiles: usize,
    /// Root mean square error of reconstruction over that of height itself.
    pub reconstruction_error: f64,
    /// Sliced Wasserstein distance (order 2) of codes from the normal distribution.
    pub latent_distance: f64,
    /// The same between two sets of normal vectors of that number: what chance makes.
    pub latent_distance_of_chance: f64,
    /// Root mean square difference of the radial spectra, drawn to real, dB.
    pub spectrum_db: f64,
    /// Drawn over real power by wavelength in metres, dB.
    pub spectrum: Vec<(f64, f64)>,
    /// The tiles' own figures.
    pub real: Look,
    /// Those of drawn surfaces.
    pub drawn: Look,
}

/// What a surface looks like, at full relief.
#[derive(Clone, Debug, Serialize)]
pub struct Look {
    /// Standard deviation of height, m.
    pub std_m: f64,
    /// Percentiles 50, 90, 95 and 99 of slope over two of the model's samples, degrees.
    pub slope_deg: [f64; 4],
}

impl DataCard {
    pub(crate) fn new(data: &Data, tiles: &Tiles) -> Self {
        let names = |held_out: bool| {
            data.scans.iter().filter(|s| s.held_out == held_out).map(|s| s.name.clone()).collect()
        };
        Self {
            sha256: data.sha256.clone(),
            trained: names(false),
            held_out: names(true),
            tiles: tiles.len(),
            copies: tiles.copies(),
            pits: data.scans.iter().map(|s| s.repaired.pits).sum(),
            spikes: data.scans.iter().map(|s| s.repaired.spikes).sum(),
            std: data.std,
        }
    }
}

/// The decoder's weights as a model file has them.
pub(crate) fn weights(network: &Network) -> Result<Weights, TrainError> {
    let of = |name: &str, end: &str| -> Result<Vec<Vec<f32>>, TrainError> {
        network
            .variables()
            .iter()
            .filter(|(n, _)| n.starts_with(name) && n.ends_with(end))
            .map(|(_, v)| Ok(v.as_tensor().flatten_all()?.to_vec1::<f32>()?))
            .collect()
    };
    Ok(of("decoder.", ".weight")?.into_iter().zip(of("decoder.", ".bias")?).collect())
}

/// The header of a model with these weights. What it draws is measured: the swell is what waves of half a tile and longer lack
/// beside the tiles of training, and mean and standard deviation are those of surfaces with it.
pub(crate) fn header(
    weights: &Weights,
    tiles: &Tiles,
    pitch: f64,
    relief: f64,
    detail: f64,
) -> Result<Header, TrainError> {
    /// Waves in a window that the swell is fitted at: one, of its whole side.
    const WAVE: usize = 1;
    let plain = Header { schema: 1, pitch, relief: 1.0, detail, swell: 0.0, mean: 0.0, std: 1.0 };
    let mut real = Spectrum::new(SIDE);
    for i in 0..tiles.len() {
        real.add(&tiles.get(i).heights);
    }
    let without = drawn(&plain, weights)?;
    let with = drawn(&Header { swell: 1.0, ..plain }, weights)?;
    let mut swell = with.clone();
    for (swell, without) in swell.iter_mut().flatten().zip(without.iter().flatten()) {
        *swell -= without;
    }
    let power = |surfaces: &[Vec<f64>]| spectrum(surfaces).radial()[WAVE];
    let lacking = real.radial()[WAVE] - power(&without);
    let swell = rounded((lacking / power(&swell)).max(0.0).sqrt());
    let all: Vec<f64> = drawn(&Header { swell, ..plain }, weights)?.into_iter().flatten().collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    Ok(Header { relief, swell, mean: rounded(mean), std: rounded(deviation(&all)), ..plain })
}

/// The spectrum of surfaces in windows as large as a tile.
fn spectrum(surfaces: &[Vec<f64>]) -> Spectrum {
    let mut made = Spectrum::new(SIDE);
    for surface in surfaces {
        for i in 0..(DRAWN / SIDE) * (DRAWN / SIDE) {
            let corner = (i / (DRAWN / SIDE) * SIDE) * DRAWN + i % (DRAWN / SIDE) * SIDE;
            let window: Vec<f64> =
                (0..SIDE).flat_map(|r| surface[corner + r * DRAWN..][..SIDE].iter().copied()).collect();
            made.add(&window);
        }
    }
    made
}

/// Surfaces at the model's own pitch.
fn drawn(header: &Header, weights: &Weights) -> Result<Vec<Vec<f64>>, TrainError> {
    let internal = |e: &dyn std::fmt::Display| TrainError::Internal(e.to_string());
    let model = Model::new(*header, weights).map_err(|e| internal(&e))?;
    (0..SURFACES)
        .map(|seed| {
            let request = Request { seed, rows: DRAWN, cols: DRAWN, pitch: header.pitch, share: 1.0 };
            Ok(model.surface(&request).map_err(|e| internal(&e))?.heights().to_vec())
        })
        .collect()
}

/// Measures a model on scans.
pub(crate) fn measure<'a>(
    network: &Network,
    header: &Header,
    weights: &Weights,
    scans: impl Iterator<Item = &'a Scan>,
) -> Result<Metrics, TrainError> {
    let tiles = Tiles::cut(scans, CUT);
    let all: Vec<Tile> = (0..tiles.len()).map(|i| tiles.get(i)).collect();
    if all.is_empty() {
        return Err(TrainError::TooLittle(format!(
            "no held-out file has a whole tile of {SIDE} x {SIDE} samples"
        )));
    }
    let device = Device::Cpu;
    let (mut error, mut power) = (0.0, 0.0);
    let mut codes = Vec::new();
    for part in all.chunks(16) {
        let (x, measured) = tensors(part, &device)?;
        let (latent, _) = network.encode(&x, true)?;
        let (made, x, measured) = (network.decode(&latent, |_| Ok(None))?, middle(&x)?, middle(&measured)?);
        error += f64::from(((made - &x)? * &measured)?.sqr()?.sum_all()?.to_scalar::<f32>()?);
        power += f64::from((x * measured)?.sqr()?.sum_all()?.to_scalar::<f32>()?);
        codes.push(loss::codes(&latent, BLOCK)?);
    }
    let codes = candle_core::Tensor::cat(&codes, 0)?;
    let n = codes.dim(0)?;
    let mut rng = Stream::new(0, &["terrain", "card"]);
    let normal = loss::normal(&[n, LATENT], &mut rng, &device)?;
    let other = loss::normal(&[n, LATENT], &mut rng, &device)?;
    let mut distance = |a, b| -> Result<f64, TrainError> {
        Ok(f64::from(loss::sliced(a, b, 256, &mut rng)?.to_scalar::<f32>()?).sqrt())
    };
    let latent_distance = distance(&codes, &normal)?;
    let latent_distance_of_chance = distance(&other, &normal)?;

    let mut real = Spectrum::new(SIDE);
    let mut of_real = Vec::new();
    for tile in &all {
        let heights: Vec<f64> = tile.heights.iter().map(|z| z * header.relief).collect();
        real.add(&heights);
        of_real.push((heights, SIDE));
    }
    let surfaces = drawn(header, weights)?;
    let made = spectrum(&surfaces);
    let (real, made) = (real.radial(), made.radial());
    /// The mean is taken away.
    const FIRST: usize = 1;
    let decibels = |k: usize| 10.0 / std::f64::consts::LN_10 * vb_math::ln(made[k] / real[k]);
    let wavelength = |k: usize| SIDE as f64 * header.pitch / k as f64;
    let spectrum =
        [1, 2, 3, 4, 6, 8, 12, 16, 24, 32].map(|k| (rounded(wavelength(k)), rounded(decibels(k)))).to_vec();
    Ok(Metrics {
        tiles: all.len(),
        reconstruction_error: rounded((error / power).sqrt()),
        latent_distance: rounded(latent_distance),
        latent_distance_of_chance: rounded(latent_distance_of_chance),
        spectrum_db: rounded(spectral_distance(&made, &real, FIRST)),
        spectrum,
        real: look(&of_real, header.pitch),
        drawn: look(&surfaces.into_iter().map(|s| (s, DRAWN)).collect::<Vec<_>>(), header.pitch),
    })
}

/// What surfaces of so many columns look like.
fn look(surfaces: &[(Vec<f64>, usize)], pitch: f64) -> Look {
    let mut all = Vec::new();
    let mut steep = Vec::new();
    for (heights, cols) in surfaces {
        let half = Raster::new(heights.len() / cols, *cols, heights.clone()).reduced(2);
        steep.extend(slopes(half.values(), half.cols(), 2.0 * pitch));
        all.extend_from_slice(heights);
    }
    let slope_deg = [0.5, 0.9, 0.95, 0.99].map(|share| rounded(percentile(&mut steep, share)));
    Look { std_m: rounded(deviation(&all)), slope_deg }
}

/// To three places: a card is for people.
fn rounded(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0
}
