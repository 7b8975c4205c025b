//! Heights by spectral synthesis.
//!
//! A Gaussian random field with the wanted spectrum, made locally rougher and smoother by a second, smooth field,
//! with a few pits.
//! The parameters were fitted to the original's worlds (facts §2.3): height spread, slope percentiles,
//! autocorrelation, spectrum.

use super::params::{GeneratorParams, GridParams};
use vb_math::fft::{Complex, inverse_2d};
use vb_math::rng::Stream;
use vb_world::{Elevation, Heightfield};

/// Between-world factors of the height spread lie within this many standard deviations of their logarithm.
const SPREAD_LIMIT: f64 = 2.2;
/// The modulating field is limited to this many standard deviations.
const MODULATION_LIMIT: f64 = 2.5;

/// The surface of a world whose tasks have these starts and goals.
pub(crate) fn surface(
    params: &GeneratorParams,
    level: Elevation,
    ends: &[[[f64; 2]; 2]],
    rng: &mut Stream,
) -> Heightfield {
    let (grid, e) = (&params.grid, &params.elevation);
    let spectrum = e.spectrum;
    let base = field(grid, rng, |k| {
        let ratio = k * spectrum.corner;
        let cut = k * spectrum.cutoff;
        vb_math::pow(1.0 + ratio * ratio, -0.5 * spectrum.exponent) * vb_math::exp(-cut * cut)
    });
    let rough = e.roughness;
    let modulation = field(grid, rng, |k| {
        let cut = k * rough.length;
        vb_math::exp(-cut * cut)
    });
    let amplitude = |u: f64| vb_math::exp(rough.strength * u.clamp(-MODULATION_LIMIT, MODULATION_LIMIT));
    let mut z: Vec<f64> = base.iter().zip(&modulation).map(|(b, &u)| b * amplitude(u)).collect();
    standardise(&mut z);
    dig(params, &mut z, ends, rng);
    standardise(&mut z);
    let spread = rng.normal(0.0, 1.0).clamp(-SPREAD_LIMIT, SPREAD_LIMIT);
    let std = e.std.get(level) * vb_math::exp(e.std_spread * spread);
    let (mean, max) = (e.mean.get(level), e.max.get(level));
    let levels: Vec<u16> =
        z.iter().map(|v| ((mean + std * v).clamp(0.0, max) / max * 65535.0).round() as u16).collect();
    Heightfield::from_levels(grid.nodes, grid.nodes, grid.pitch, [0.0, max], &levels)
}

/// Lowers the surface by bell-shaped pits.
fn dig(params: &GeneratorParams, z: &mut [f64], ends: &[[[f64; 2]; 2]], rng: &mut Stream) {
    let (grid, pits, half) = (&params.grid, &params.elevation.pits, params.half());
    let [low, high] = pits.count;
    for _ in 0..low + rng.below((high - low + 1) as u64) as usize {
        let centre = loop {
            let p = [rng.uniform(-half, half), rng.uniform(-half, half)];
            let far = |q: &[f64; 2]| vb_math::hypot(p[0] - q[0], p[1] - q[1]) >= pits.task_clearance;
            if ends.iter().flatten().all(far) {
                break p;
            }
        };
        let depth = rng.uniform(pits.depth[0], pits.depth[1]);
        let radius = rng.uniform(pits.radius[0], pits.radius[1]);
        // Beyond six radii the bell is below 2e-8 of its depth.
        let span = |v: f64| {
            let index = |v: f64| ((v + half) / grid.pitch).max(0.0) as usize;
            index(v - 6.0 * radius)..(index(v + 6.0 * radius) + 2).min(grid.nodes)
        };
        for row in span(centre[1]) {
            for col in span(centre[0]) {
                let dx = col as f64 * grid.pitch - half - centre[0];
                let dy = row as f64 * grid.pitch - half - centre[1];
                z[row * grid.nodes + col] -=
                    depth * vb_math::exp(-0.5 * (dx * dx + dy * dy) / (radius * radius));
            }
        }
    }
}

/// A standard normal random field on the grid whose power at wave number k (cycles/m) is proportional to
/// `power(k)`. It is cut from a periodic field of at least twice the side, so that opposite edges are independent.
fn field(grid: &GridParams, rng: &mut Stream, power: impl Fn(f64) -> f64) -> Vec<f64> {
    let n = (2 * grid.nodes - 1).next_power_of_two();
    let base = 1.0 / (n as f64 * grid.pitch);
    let wave = |i: usize| if i <= n / 2 { i as f64 } else { n as f64 - i as f64 } * base;
    let mut spectrum: Vec<Complex> = Vec::with_capacity(n * n);
    for row in 0..n {
        for col in 0..n {
            let k = vb_math::hypot(wave(row), wave(col));
            // No mean: the height of a world is set by its parameters.
            let amplitude = if row + col == 0 { 0.0 } else { power(k).sqrt() };
            spectrum.push([amplitude * rng.normal(0.0, 1.0), amplitude * rng.normal(0.0, 1.0)]);
        }
    }
    inverse_2d(&mut spectrum, n);
    // The real part of a field of independent complex Gaussians is a real Gaussian field of the same spectrum.
    let mut all: Vec<f64> = spectrum.iter().map(|v| v[0]).collect();
    standardise(&mut all);
    (0..grid.nodes).flat_map(|r| all[r * n..r * n + grid.nodes].iter().copied()).collect()
}

/// Shifts and scales to mean 0 and standard deviation 1 (a constant becomes 0).
fn standardise(values: &mut [f64]) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let std = (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt();
    for v in values {
        *v = if std > 0.0 { (*v - mean) / std } else { 0.0 };
    }
}
