//! The model's card: what it was trained on, how, and how well it does on scans that it never saw.

use std::ops::{Range, RangeInclusive};

use candle_core::Device;
use serde::Serialize;
use vb_math::rng::Stream;
use vb_terrain::ElevationImage;
use vb_terrain::bands::Pass;
use vb_terrain::data::{Data, Scan};
use vb_terrain::model::{Header, Weights};
use vb_terrain::shape::{BLOCK, LATENT};
use vb_terrain::stats::{Spectrum, deviation, exponent, percentile, slopes, spectral_distance, windows};
use vb_terrain::tiles::{Tile, Tiles};

use crate::error::TrainError;
use crate::finish::{DRAWN, drawn, rounded};
use crate::loss;
use crate::network::Network;
use crate::trainer::{CUT, Losses, SIDE, Settings, middle, tensors};

/// Seeds of the surfaces that a model is measured on: others than those that it was fitted on.
const MEASURED: Range<u64> = 100..112;
/// Waves in a window of a tile's side that the exponent is fitted over: of 1/1 to 1/10 of that side.
const WAVES: RangeInclusive<usize> = 1..=10;

#[derive(Clone, Debug, Serialize)]
pub struct Card {
    /// Version of this format: 2.
    pub schema: u32,
    /// SHA-256 of the model file.
    pub sha256: String,
    pub data: DataCard,
    pub settings: Settings,
    pub steps: u64,
    /// Time that training took, s.
    pub seconds: f64,
    /// Mean losses at the end of training.
    pub losses: Losses,
    pub header: Header,
    /// What the training scans look like: how far they and the held-out ones are apart is what chance makes.
    pub trained_on: Look,
    /// How well it does on scans that it never saw; of the training scans where none were held out.
    pub held_out: Metrics,
}

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

#[derive(Clone, Debug, Serialize)]
pub struct Metrics {
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
    /// The scans' own figures.
    pub real: Look,
    /// Those of drawn surfaces.
    pub drawn: Look,
}

/// What a surface looks like, at full relief.
#[derive(Clone, Debug, Serialize)]
pub struct Look {
    /// Standard deviation of height, m.
    pub std_m: f64,
    /// Percentiles 50, 90, 95, 99 and 99.5 of the slope of every second sample by central differences, degrees.
    pub slope_deg: [f64; 5],
    /// The same of every sample.
    pub fine_slope_deg: [f64; 5],
    /// Exponent of the power law that the power of every second sample follows: waves as long as a tile to a tenth of it.
    pub exponent: f64,
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

/// Measures a model on scans.
pub(crate) fn measure(
    network: &Network,
    header: &Header,
    weights: &Weights,
    passes: &[Pass],
    scans: &[&Scan],
) -> Result<Metrics, TrainError> {
    let tiles = Tiles::cut(scans.iter().copied(), CUT);
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
    for tile in &all {
        real.add(&tile.heights.iter().map(|z| z * header.relief).collect::<Vec<_>>());
    }
    let surfaces = drawn(header, weights, passes, MEASURED)?;
    let mut made = Spectrum::new(SIDE);
    for window in surfaces.iter().flat_map(|s| windows(s, DRAWN, SIDE)) {
        made.add(&window);
    }
    let (real, made) = (real.radial(), made.radial());
    /// The mean is taken away.
    const FIRST: usize = 1;
    let decibels = |k: usize| 10.0 / std::f64::consts::LN_10 * vb_math::ln(made[k] / real[k]);
    let wavelength = |k: usize| SIDE as f64 * header.resolution / k as f64;
    let spectrum =
        [1, 2, 3, 4, 6, 8, 12, 16, 24, 32].map(|k| (rounded(wavelength(k)), rounded(decibels(k)))).to_vec();
    Ok(Metrics {
        tiles: all.len(),
        reconstruction_error: rounded((error / power).sqrt()),
        latent_distance: rounded(latent_distance),
        latent_distance_of_chance: rounded(latent_distance_of_chance),
        spectrum_db: rounded(spectral_distance(&made, &real, FIRST)),
        spectrum,
        real: look_of_scans(scans, header),
        drawn: look_of_drawn(surfaces, header.resolution),
    })
}

/// What scans look like at the model's relief: their slopes wherever they were measured, their power on tiles.
pub(crate) fn look_of_scans(scans: &[&Scan], header: &Header) -> Look {
    let tiles = Tiles::cut(scans.iter().copied(), CUT);
    let mut spectrum = Spectrum::new(SIDE / 2);
    let scaled = |heights: &[f64]| heights.iter().map(|z| z * header.relief).collect::<Vec<_>>();
    for tile in (0..tiles.len()).map(|i| tiles.get(i)) {
        for part in halves(&ElevationImage::new(SIDE, SIDE, scaled(&tile.heights))) {
            spectrum.add(part.values());
        }
    }
    let layers = scans.iter().flat_map(|s| &s.layers).map(|l| {
        let (rows, cols) = (l.heights.rows(), l.heights.cols());
        let measured = scaled(l.heights.values()).into_iter().zip(&l.measured);
        ElevationImage::new(rows, cols, measured.map(|(z, m)| if *m { z } else { f64::NAN }).collect())
    });
    look(&layers.collect::<Vec<_>>(), header.resolution, &spectrum)
}

/// What drawn surfaces look like.
fn look_of_drawn(surfaces: Vec<Vec<f64>>, resolution: f64) -> Look {
    let mut spectrum = Spectrum::new(SIDE / 2);
    for window in surfaces.iter().flat_map(|s| windows(s, DRAWN, SIDE)) {
        for part in halves(&ElevationImage::new(SIDE, SIDE, window)) {
            spectrum.add(part.values());
        }
    }
    let rasters: Vec<_> = surfaces.into_iter().map(|s| ElevationImage::new(DRAWN, DRAWN, s)).collect();
    look(&rasters, resolution, &spectrum)
}

/// Every second sample, from each of the four that can be the first.
fn halves(raster: &ElevationImage) -> impl Iterator<Item = ElevationImage> {
    (0..4).map(|i| raster.thinned(i / 2, i % 2, 2))
}

fn look(rasters: &[ElevationImage], resolution: f64, spectrum: &Spectrum) -> Look {
    let (mut all, mut steep, mut fine) = (Vec::new(), Vec::new(), Vec::new());
    for raster in rasters {
        fine.extend(slopes(raster.values(), raster.cols(), resolution));
        for part in halves(raster) {
            steep.extend(slopes(part.values(), part.cols(), 2.0 * resolution));
        }
        all.extend(raster.values().iter().filter(|v| !v.is_nan()));
    }
    // Beside a hole there is no slope.
    let percentiles = |slopes: &mut Vec<f64>| {
        slopes.retain(|s| !s.is_nan());
        [0.5, 0.9, 0.95, 0.99, 0.995].map(|fraction| rounded(percentile(slopes, fraction)))
    };
    Look {
        std_m: rounded(deviation(&all)),
        slope_deg: percentiles(&mut steep),
        fine_slope_deg: percentiles(&mut fine),
        exponent: rounded(exponent(&spectrum.radial(), WAVES)),
    }
}
