//! Shaping of a drawn surface: gains by wavelength before nodes are taken, and swells that are added.
//!
//! A model is learned from point samples of scans. The worlds of the original are smoother at short wavelengths, since its
//! tiles are reduced scans that a network has decoded and a bicubic filter has resized. A surface that is sampled at 1 m
//! also folds wavelengths below 2 m onto longer ones unless they are removed first. Gains below 1 do both; gains above 1
//! and swells add what a model lacks. The figures are data, see `elevation.shape` of the generator's rules.

use serde::Deserialize;
use vb_math::fft::inverse_2d;

/// Samples from the middle of the kernel to its edge.
pub const REACH: usize = 12;
/// Samples along a side of the grid of wave numbers on which the kernel is computed: more than 4 · [`REACH`].
const GRID: usize = 64;
/// Most knots, and most swells.
const MOST: usize = 32;

/// The figures of a shaping, as in a file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeParams {
    /// Standard deviation of the heights of shaped surfaces at the model's full relief, m.
    pub std: f64,
    /// Wavelengths at which gains are given, ascending, m.
    pub wavelengths: Vec<f64>,
    /// Gain at each wavelength: interpolated over the logarithm of the wavelength, constant below the first, 1 from the last on.
    pub gains: Vec<f64>,
    /// Smooth normal fields that are added.
    pub swells: Vec<Swell>,
}

/// A smooth normal field: a cubic B-spline over independent nodes. Its power is even over wavelengths longer than about
/// twice the distance between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Swell {
    /// Distance between nodes, m: a multiple of the model's resolution.
    pub spacing: f64,
    /// Standard deviation at full relief, m.
    pub std: f64,
}

impl ShapeParams {
    /// What is wrong: the field and the problem.
    ///
    /// # Errors
    /// The first flaw.
    pub fn check(&self) -> Result<(), (String, String)> {
        let flaw = |field: &str, problem: String| Err((field.to_owned(), problem));
        let range = |field: String, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err((field, format!("{value} must lie in {low} to {high}")))
            }
        };
        range("std".into(), self.std, 1e-3, 100.0)?;
        let knots = self.wavelengths.len();
        if !(1..=MOST).contains(&knots) {
            return flaw("wavelengths", format!("{knots} wavelengths: 1 to {MOST} are allowed"));
        }
        if self.gains.len() != knots {
            return flaw(
                "gains",
                format!("{} gains for {knots} wavelengths: must be as many", self.gains.len()),
            );
        }
        for (k, w) in self.wavelengths.iter().enumerate() {
            range(format!("wavelengths[{k}]"), *w, 1e-3, 1e5)?;
        }
        if let Some(k) = self.wavelengths.windows(2).position(|w| w[0] >= w[1]) {
            let problem = format!("{} must be longer than the one before it", self.wavelengths[k + 1]);
            return flaw(&format!("wavelengths[{}]", k + 1), problem);
        }
        for (k, g) in self.gains.iter().enumerate() {
            range(format!("gains[{k}]"), *g, 0.0, 10.0)?;
        }
        if self.swells.len() > MOST {
            return flaw("swells", format!("{} swells: at most {MOST} are allowed", self.swells.len()));
        }
        for (k, s) in self.swells.iter().enumerate() {
            range(format!("swells[{k}].spacing"), s.spacing, 1e-2, 1e4)?;
            range(format!("swells[{k}].std"), s.std, 0.0, 100.0)?;
        }
        Ok(())
    }

    /// Gain at a wavelength, m.
    fn gain(&self, wavelength: f64) -> f64 {
        let (w, g) = (&self.wavelengths, &self.gains);
        let after = w.partition_point(|k| *k <= wavelength);
        if after == 0 {
            return g[0];
        }
        if after == w.len() {
            return 1.0;
        }
        let t = vb_math::ln(wavelength / w[after - 1]) / vb_math::ln(w[after] / w[after - 1]);
        g[after - 1] + t * (g[after] - g[after - 1])
    }
}

/// A shaping for a model's resolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaping {
    /// Standard deviation of shaped heights at full relief, m.
    std: f64,
    /// Swells: samples between nodes, and standard deviation, m.
    pub(crate) swells: Vec<(usize, f64)>,
    /// Rows of the kernel, 2 · [`REACH`] + 1 of as many weights, whose sum is 1.
    kernel: Vec<f64>,
}

impl Shaping {
    /// The shaping with these figures for samples that are so far apart, m.
    ///
    /// # Errors
    /// What is wrong with the figures: the field and the problem.
    pub fn new(params: &ShapeParams, resolution: f64) -> Result<Self, (String, String)> {
        params.check()?;
        let mut swells = Vec::with_capacity(params.swells.len());
        for (k, s) in params.swells.iter().enumerate() {
            let step = (s.spacing / resolution).round();
            if step < 1.0 || (step * resolution - s.spacing).abs() > 1e-9 * s.spacing {
                let problem =
                    format!("{} must be a multiple of the model's resolution, {resolution} m", s.spacing);
                return Err((format!("swells[{k}].spacing"), problem));
            }
            swells.push((step as usize, s.std));
        }
        Ok(Self { std: params.std, swells, kernel: kernel(params, resolution) })
    }

    /// Standard deviation of the heights of shaped surfaces at the model's full relief, m.
    #[must_use]
    pub fn std(&self) -> f64 {
        self.std
    }

    /// A row-major plane after the gains, narrower by [`REACH`] on each side.
    pub(crate) fn filtered(&self, values: &[f32], cols: usize) -> Vec<f32> {
        let side = 2 * REACH + 1;
        let (rows, width) = ((values.len() / cols) - 2 * REACH, cols - 2 * REACH);
        let mut out = Vec::with_capacity(rows * width);
        let mut line = vec![0.0f64; width];
        for row in 0..rows {
            line.fill(0.0);
            for (k, weights) in self.kernel.chunks_exact(side).enumerate() {
                let from = &values[(row + k) * cols..][..cols];
                for (j, w) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                    for (sum, v) in line.iter_mut().zip(&from[j..]) {
                        *sum += w * f64::from(*v);
                    }
                }
            }
            out.extend(line.iter().map(|v| *v as f32));
        }
        out
    }
}

/// The kernel whose transform has the gains, for samples that are so far apart: the inverse transform on a periodic grid, cut off by
/// a round Hann window (which smooths the gains over about 1 / (2 · reach) in wave number) and scaled to a sum of 1, so that the longest
/// waves stay as they are.
fn kernel(params: &ShapeParams, resolution: f64) -> Vec<f64> {
    let wave = |i: usize| i.min(GRID - i) as f64 / (GRID as f64 * resolution);
    let mut waves: Vec<[f64; 2]> = (0..GRID * GRID)
        .map(|i| {
            let k = vb_math::hypot(wave(i / GRID), wave(i % GRID));
            [if k > 0.0 { params.gain(1.0 / k) } else { 1.0 }, 0.0]
        })
        .collect();
    inverse_2d(&mut waves, GRID);
    let side = 2 * REACH + 1;
    let at = |i: usize| (GRID + i - REACH) % GRID;
    let mut kernel = Vec::with_capacity(side * side);
    for row in 0..side {
        for col in 0..side {
            let away =
                vb_math::hypot(row as f64 - REACH as f64, col as f64 - REACH as f64) / (REACH as f64 + 1.0);
            let window =
                if away < 1.0 { 0.5 * (1.0 + vb_math::cos(std::f64::consts::PI * away)) } else { 0.0 };
            kernel.push(window * waves[at(row) * GRID + at(col)][0]);
        }
    }
    let sum: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|w| *w /= sum);
    kernel
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(gains: &[f64]) -> ShapeParams {
        ShapeParams {
            std: 1.0,
            wavelengths: vec![1.5, 3.0, 6.0][..gains.len()].to_vec(),
            gains: gains.to_vec(),
            swells: Vec::new(),
        }
    }

    /// What becomes of a wave along the columns of this length, m, in samples of 0.5 m.
    fn response(shaping: &Shaping, wavelength: f64) -> f64 {
        let cols = 2 * REACH + 65;
        let wave = |i: usize| vb_math::cos(std::f64::consts::TAU * 0.5 * (i % cols) as f64 / wavelength);
        let plane: Vec<f32> = (0..cols * (2 * REACH + 1)).map(|i| wave(i) as f32).collect();
        let out = shaping.filtered(&plane, cols);
        let power: f64 = out.iter().enumerate().map(|(i, v)| f64::from(*v) * wave(i + REACH)).sum();
        power / (0..out.len()).map(|i| wave(i + REACH) * wave(i + REACH)).sum::<f64>()
    }

    #[test]
    fn waves_are_multiplied_by_their_gain() {
        // A step in the gains is smoothed over wave numbers of 1 / 12 m; a wavelength in the middle of an even range keeps its gain.
        let low_pass = Shaping::new(&params(&[0.0, 0.0, 1.0]), 0.5).unwrap();
        for (wavelength, gain) in [(1.2, 0.0), (2.0, 0.0), (16.0, 1.0)] {
            let found = response(&low_pass, wavelength);
            assert!((found - gain).abs() < 0.03, "{wavelength} m: {found}");
        }
        // Of equal gains every wave but the longest, which stay: the kernel's sum is 1.
        let same = Shaping::new(&params(&[1.0, 1.0, 1.0]), 0.5).unwrap();
        let plane: Vec<f32> = (0..30 * 30).map(|i| (i * i % 17) as f32).collect();
        let out = same.filtered(&plane, 30);
        assert_eq!(out.len(), 6 * 6);
        assert!((out[0] - plane[REACH * 30 + REACH]).abs() < 1e-5);
    }

    #[test]
    fn flaws_are_named() {
        let wrong = |change: &dyn Fn(&mut ShapeParams)| {
            let mut p = params(&[0.0, 0.5, 1.0]);
            p.swells = vec![Swell { spacing: 4.0, std: 0.1 }];
            change(&mut p);
            let (field, problem) = Shaping::new(&p, 0.5).unwrap_err();
            format!("{field}: {problem}")
        };
        assert!(wrong(&|p| p.gains.push(1.0)).starts_with("gains: 4 gains for 3"));
        assert!(wrong(&|p| p.gains[1] = f64::NAN).starts_with("gains[1]: NaN must lie in 0 to 10"));
        assert!(wrong(&|p| p.wavelengths[2] = 3.0).starts_with("wavelengths[2]: 3 must be longer"));
        assert!(
            wrong(&|p| p.swells[0].spacing = 4.3).starts_with("swells[0].spacing: 4.3 must be a multiple")
        );
        assert!(wrong(&|p| p.std = 0.0).starts_with("std: 0 must lie in"));
    }
}
