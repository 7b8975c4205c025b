//! What follows training: swells and passes, measured on the training scans and on what the decoder draws.

use std::ops::Range;

use vb_terrain::Request;
use vb_terrain::bands::{BANDS, Curve, OCTAVES_REACH, Pass, Plane, REACH, STEEPNESS_REACH};
use vb_terrain::data::{Layer, Scan};
use vb_terrain::model::{Header, Model, SCHEMA, Weights};
use vb_terrain::stats::{Spectrum, deviation, percentile_of_sorted, windows};
use vb_terrain::tiles::Tiles;

use crate::error::TrainError;
use crate::trainer::SIDE;

/// Nodes along the surfaces that are measured.
pub(crate) const DRAWN: usize = 512;
/// Seeds of the surfaces that swells and passes are fitted on.
const FITTED: Range<u64> = 0..6;
/// Passes. What one does to the steepness changes the octaves and the other way round; the training scans' slopes were nearest
/// after the third.
const PASSES: usize = 3;
/// Shares of the values at a curve's knots: every fiftieth, and closer together at both ends.
const TAIL: [f64; 5] = [0.0002, 0.0005, 0.001, 0.003, 0.01];

/// A model's header and passes with these weights.
///
/// The shorter swell is what the longest waves of a tile lack beside the tiles of training. The passes follow one by one, each
/// fitted to what the ones before leave. The longer swell has the variance that surfaces then still lack beside the scans, whose
/// own is 1, so that slopes have the scans' scale too; mean and standard deviation are those of surfaces with all of it.
pub(crate) fn finish<'a>(
    weights: &Weights,
    tiles: &Tiles,
    scans: impl Iterator<Item = &'a Scan>,
    resolution: f64,
    relief: f64,
    detail: f64,
) -> Result<(Header, Vec<Pass>), TrainError> {
    /// Waves in a window that the swell is fitted at: one, of its whole side.
    const WAVE: usize = 1;
    let header = Header {
        schema: SCHEMA,
        resolution,
        relief: 1.0,
        detail,
        swell: [0.0; 2],
        passes: 0,
        mean: 0.0,
        std: 1.0,
    };
    let mut passes = Vec::new();
    let mut real = Spectrum::new(SIDE);
    for i in 0..tiles.len() {
        real.add(&tiles.get(i).heights);
    }
    let without = drawn(&header, weights, &passes, FITTED)?;
    let mut swell = drawn(&Header { swell: [1.0, 0.0], ..header }, weights, &passes, FITTED)?;
    for (swell, without) in swell.iter_mut().flatten().zip(without.iter().flatten()) {
        *swell -= without;
    }
    let power = |surfaces: &[Vec<f64>]| {
        let mut made = Spectrum::new(SIDE);
        for window in surfaces.iter().flat_map(|s| windows(s, DRAWN, SIDE)) {
            made.add(&window);
        }
        made.radial()[WAVE]
    };
    let lacking = real.radial()[WAVE] - power(&without);
    let mut header = Header { swell: [rounded((lacking / power(&swell)).max(0.0).sqrt()), 0.0], ..header };
    let scans: Vec<&Layer> = scans.flat_map(|s| &s.layers).collect();
    let real = Looks::of(scans.iter().map(|l| (l.heights.values(), l.heights.cols(), &l.measured[..])), None);
    while passes.len() < PASSES {
        let surfaces = drawn(&header, weights, &passes, FITTED)?;
        let whole = vec![true; DRAWN * DRAWN];
        let all = || surfaces.iter().map(|s| (&s[..], DRAWN, &whole[..]));
        let made = Looks::of(all(), None);
        let octaves = std::array::from_fn(|band| curve(&made.octaves[band], &real.octaves[band]));
        let made = Looks::of(all(), Some(&octaves));
        passes.push(Pass { steepness: curve(&made.steepness, &real.steepness), octaves });
        header.passes = passes.len();
    }
    let all: Vec<f64> = drawn(&header, weights, &passes, FITTED)?.concat();
    let mean = rounded(all.iter().sum::<f64>() / all.len() as f64);
    let variance = deviation(&all) * deviation(&all);
    let long = rounded((1.0 - variance).max(0.0).sqrt());
    header.swell[1] = long;
    // The longer swell is independent of the rest. Measured over a few surfaces its long waves would make this a matter of chance.
    Ok((Header { relief, mean, std: rounded((variance + long * long).sqrt()), ..header }, passes))
}

/// Surfaces at the model's own resolution, row by row.
pub(crate) fn drawn(
    header: &Header,
    weights: &Weights,
    passes: &[Pass],
    seeds: Range<u64>,
) -> Result<Vec<Vec<f64>>, TrainError> {
    let internal = |e: &dyn std::fmt::Display| TrainError::Internal(e.to_string());
    let model = Model::new(*header, weights, passes).map_err(|e| internal(&e))?;
    seeds
        .map(|seed| {
            let request =
                Request { seed, rows: DRAWN, cols: DRAWN, resolution: header.resolution, fraction: 1.0 };
            Ok(model.surface(&request).map_err(|e| internal(&e))?.heights().to_vec())
        })
        .collect()
}

/// Values of surfaces at the shares of the knots; none where no surface has any.
struct Looks {
    octaves: [Vec<f32>; BANDS],
    /// Of the sum of the octaves.
    steepness: Vec<f32>,
}

impl Looks {
    /// Of surfaces (heights row by row, samples in a row, which samples count), where they reach far enough about a sample. The
    /// steepness is that after these curves, by default of the octaves as they are.
    fn of<'a>(
        surfaces: impl Iterator<Item = (&'a [f64], usize, &'a [bool])>,
        curves: Option<&[Curve; BANDS]>,
    ) -> Self {
        let (mut octaves, mut steepness): ([Vec<f64>; BANDS], Vec<f64>) = Default::default();
        let same: [Curve; BANDS] = std::array::from_fn(|_| unchanged());
        for (heights, cols, counts) in surfaces {
            let plane = Plane { cols, values: heights.iter().map(|v| *v as f32).collect() };
            if plane.cols.min(plane.rows()) <= 2 * REACH {
                continue;
            }
            let take = |to: &mut Vec<f64>, part: &Plane, margin: usize| {
                let counted = |i: usize| counts[(margin + i / part.cols) * cols + margin + i % part.cols];
                to.extend((0..part.values.len()).filter(|i| counted(*i)).map(|i| f64::from(part.values[i])));
            };
            let (mut rest, mut margin) = (plane.clone(), 0);
            for (band, values) in octaves.iter_mut().enumerate() {
                let (rough, smooth) = rest.octave(1 << band);
                margin += 2 << band;
                take(values, &rough, margin);
                rest = smooth;
            }
            let (sum, _) = plane.with_octaves(curves.unwrap_or(&same));
            take(&mut steepness, &sum.steepness(), OCTAVES_REACH + STEEPNESS_REACH);
        }
        Self { octaves: octaves.map(quantiles), steepness: quantiles(steepness) }
    }
}

/// The values at the shares of the knots.
fn quantiles(mut all: Vec<f64>) -> Vec<f32> {
    if all.is_empty() {
        return Vec::new();
    }
    all.sort_by(f64::total_cmp);
    let fractions = TAIL
        .into_iter()
        .chain((1..50).map(|i| f64::from(i) / 50.0))
        .chain(TAIL.map(|t| 1.0 - t).into_iter().rev());
    fractions.map(|fraction| percentile_of_sorted(&all, fraction) as f32).collect()
}

/// The curve from drawn quantiles to those of the scans; where either has none, or all are one, it changes nothing.
fn curve(made: &[f32], real: &[f32]) -> Curve {
    let (mut from, mut to): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    for (made, real) in made.iter().zip(real) {
        if from.last().is_none_or(|last| made > last) {
            from.push(*made);
            to.push(*real);
        }
    }
    Curve::new(from, to).unwrap_or_else(|_| unchanged())
}

/// The curve that changes nothing.
#[allow(clippy::expect_used, reason = "two knots that rise")]
fn unchanged() -> Curve {
    Curve::new(vec![-1.0, 1.0], vec![-1.0, 1.0]).expect("a curve through two knots")
}

/// To three places: a header is read by people.
pub(crate) fn rounded(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0
}
