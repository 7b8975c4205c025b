//! Fit of a shaping to the spectrum of other surfaces, for instance the original's worlds.
//!
//! Gains are adjusted, band by band, until the mean square of the heights in each band of wavelength is that of the other surfaces.
//! Above 8 m, where a kernel would have to be wide, swells add what is missing. The curve stays as it is given: a spectrum does not show whether
//! tops or pits are sharp.

use vb_world::Heightfield;

use crate::model::Model;
use crate::shaping::{ShapeParams, Shaping, Swell};
use crate::stats::{Spectrum, deviation};

/// Edges of the bands that gains are fitted to, m, in steps that the kernel can follow. The first band has what nodes at 1 m have above half
/// a wave a node, along the diagonal.
const EDGES: [f64; 6] = [1.4, 2.0, 2.4, 2.85, 4.0, 8.0];
/// The octaves that swells are fitted to, and the distance between the nodes of each, m. The power of a swell is even for wavelengths over
/// 4.4 times that distance, and three quarters of it lie in the octave from there on.
const SWELLS: [([f64; 2], f64); 3] = [([8.0, 16.0], 2.0), ([16.0, 32.0], 4.0), ([32.0, 64.0], 8.0)];
/// Nodes along the windows whose spectrum is taken, and their distance, m.
const WINDOW: usize = 128;
const RESOLUTION: f64 = 1.0;
/// Rounds of adjustment, and the fraction of each correction of a gain's logarithm that is made, since the kernel's window mixes bands.
const ROUNDS: usize = 12;
const DAMPING: f64 = 0.7;
/// Greatest gain.
const MOST: f64 = 4.0;

/// Mean squares of height by band, the short ones first.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    values: Vec<f64>,
}

fn bands() -> impl Iterator<Item = [f64; 2]> {
    EDGES.windows(2).map(|w| [w[0], w[1]]).chain(SWELLS.iter().map(|s| s.0))
}

/// The mean squares of some windows of heights (m), row by row.
fn measured(windows: impl Iterator<Item = Vec<f64>>) -> Bands {
    let mut spectrum = Spectrum::new(WINDOW);
    windows.for_each(|w| spectrum.add(&w));
    Bands { values: bands().map(|band| spectrum.mean_square(RESOLUTION, band).unwrap_or(0.0)).collect() }
}

/// Mean squares of surfaces with nodes at 1 m, each divided by its fraction of the full relief.
pub fn of_surfaces(surfaces: &[(Heightfield, f64)]) -> Result<Bands, String> {
    for (h, _) in surfaces {
        if h.rows().min(h.cols()) < WINDOW || (h.resolution() - RESOLUTION).abs() > 1e-9 {
            return Err(format!(
                "{} x {} nodes with a spacing of {} m: at least {WINDOW} x {WINDOW} nodes with {RESOLUTION} m are needed",
                h.rows(),
                h.cols(),
                h.resolution()
            ));
        }
    }
    let window = |(h, fraction): &(Heightfield, f64)| {
        (0..WINDOW * WINDOW).map(|i| h.node(i / WINDOW, i % WINDOW) / fraction).collect()
    };
    Ok(measured(surfaces.iter().map(window)))
}

/// The shaping, with the curve of `start`, with which `count` surfaces, of `seed` and the seeds after it, have these mean squares at full relief. `progress` hears after
/// each round of the ratio of the root mean squares, drawn to wanted, by band.
pub fn fit(
    model: &Model,
    wanted: &Bands,
    start: &ShapeParams,
    seed: u64,
    count: usize,
    mut progress: impl FnMut(usize, &[f64]),
) -> Result<ShapeParams, String> {
    let unshaped: Vec<_> =
        (0..count as u64).map(|k| model.unshaped(seed + k, WINDOW + 1, RESOLUTION)).collect();
    // A knot in the middle of each band; from the end of the last on the gain is 1.
    let middle = |w: &[f64]| ((w[0] * w[1]).sqrt() * 100.0).round() / 100.0;
    let mut params = ShapeParams {
        std: 1.0,
        wavelengths: EDGES.windows(2).map(middle).chain([10.0]).collect(),
        gains: vec![1.0; EDGES.len()],
        from: start.from.clone(),
        to: start.to.clone(),
        swells: SWELLS.iter().map(|s| Swell { spacing: s.1, std: 0.0 }).collect(),
    };
    for round in 0..=ROUNDS {
        let shaping = Shaping::new(&params, model.header().resolution, model.metre())
            .map_err(|(f, p)| format!("{f}: {p}"))?;
        let heights: Vec<_> = unshaped.iter().map(|u| model.heights(u, &shaping)).collect();
        let variance = heights.iter().map(|h| deviation(h) * deviation(h)).sum::<f64>() / count as f64;
        params.std = rounded(variance.sqrt());
        let window = |h: &Vec<f64>| {
            (0..WINDOW).flat_map(|r| h[r * (WINDOW + 1)..][..WINDOW].iter().copied()).collect()
        };
        let drawn = measured(heights.iter().map(window));
        let ratios: Vec<f64> = drawn.values.iter().zip(&wanted.values).map(|(d, w)| (d / w).sqrt()).collect();
        progress(round, &ratios);
        if round == ROUNDS {
            break;
        }
        let gains = EDGES.len() - 1;
        for (gain, ratio) in params.gains.iter_mut().zip(&ratios[..gains]) {
            *gain = rounded((*gain * vb_math::exp(-DAMPING * vb_math::ln(*ratio))).clamp(0.0, MOST));
        }
        for (k, swell) in params.swells.iter_mut().enumerate() {
            let missing = wanted.values[gains + k] - drawn.values[gains + k];
            swell.std = rounded((swell.std * swell.std + DAMPING * missing).max(0.0).sqrt());
        }
    }
    Ok(params)
}

/// To three decimals, which people can read.
fn rounded(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0
}
