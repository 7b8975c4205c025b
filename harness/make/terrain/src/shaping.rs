//! Shaping of a drawn surface: gains by wavelength before nodes are taken, and swells that are added.
//!
//! A model is learned from point samples of scans. The worlds of the original are smoother at short wavelengths, since its
//! tiles are reduced scans that a network has decoded and a bicubic filter has resized. A surface that is sampled at 1 m
//! also folds wavelengths below 2 m onto longer ones unless they are removed first. Gains below 1 do both; gains above 1
//! and swells add what a model lacks. The figures are data, see `elevation.shape` of the generator's rules.

use serde::Deserialize;
use vb_math::fft::inverse_2d;

use crate::bands::{Curve, Plane};

/// Samples from the middle of the kernel to its edge.
const KERNEL: usize = 12;
/// Passes of the B-spline about which heights are mapped by a curve: it keeps waves longer than 16 samples, and reaches so far.
const SMOOTHINGS: [usize; 4] = [1, 2, 4, 8];
const SMOOTH: usize = 2 * (1 + 2 + 4 + 8);
/// Samples on each side of a surface that shaping takes away.
pub const REACH: usize = KERNEL + SMOOTH;
/// Samples along a side of the grid of wave numbers on which the kernel is computed: more than 4 · [`KERNEL`].
const GRID: usize = 64;
/// Most knots, and most swells.
const MOST: usize = 32;

/// The parameters of a spectral shaping.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeParams {
    /// Standard deviation of the heights of shaped surfaces at the model's full relief, m.
    pub std: f64,
    /// Wavelengths at which gains are given, ascending, m.
    pub wavelengths: Vec<f64>,
    /// Gain at each wavelength: interpolated over the logarithm of the wavelength, constant below the first, 1 from the last on.
    pub gains: Vec<f64>,
    /// The curve that maps heights relative to the smooth surface (wavelengths above 16 samples), after the gains:
    /// heights at full relief, m, ascending. Beyond the first and the last, heights are multiplied by their factors.
    pub from: Vec<f64>,
    /// The mapped value of each of these heights, m, ascending. A smaller slope above 0 and a larger one below give low
    /// rounded tops and deep narrow pits.
    pub to: Vec<f64>,
    /// Smooth Gaussian fields that are added.
    pub swells: Vec<Swell>,
}

/// A smooth Gaussian field: a cubic B-spline over independent nodes. Its power is uniform over wavelengths above about
/// twice the node spacing.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Swell {
    /// Node spacing, m: a multiple of the model's resolution.
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
        for (name, knots) in [("from", &self.from), ("to", &self.to)] {
            for (k, v) in knots.iter().enumerate() {
                range(format!("{name}[{k}]"), *v, -100.0, 100.0)?;
            }
        }
        self.curve(1.0).map_err(|problem| ("from or to".to_owned(), problem))?;
        if self.swells.len() > MOST {
            return flaw("swells", format!("{} swells: at most {MOST} are allowed", self.swells.len()));
        }
        for (k, s) in self.swells.iter().enumerate() {
            range(format!("swells[{k}].spacing"), s.spacing, 1e-2, 1e4)?;
            range(format!("swells[{k}].std"), s.std, 0.0, 100.0)?;
        }
        Ok(())
    }

    /// The curve, in another unit than m.
    fn curve(&self, unit: f64) -> Result<Curve, String> {
        let knots = |v: &[f64]| v.iter().map(|z| (z * unit) as f32).collect();
        Curve::new(knots(&self.from), knots(&self.to))
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
    /// Rows of the kernel, 2 · [`KERNEL`] + 1 of as many weights, whose sum is 1.
    kernel: Vec<f64>,
    /// Maps heights about the smooth surface, in the decoder's unit.
    curve: Curve,
}

impl Shaping {
    /// The shaping with these figures for samples that are so far apart, m, and in which a metre at full relief is so many of the decoder's units.
    ///
    /// # Errors
    /// What is wrong with the figures: the field and the problem.
    pub fn new(params: &ShapeParams, resolution: f64, unit: f64) -> Result<Self, (String, String)> {
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
        let curve = params.curve(unit).map_err(|problem| ("from or to".to_owned(), problem))?;
        Ok(Self { std: params.std, swells, kernel: kernel(params, resolution), curve })
    }

    /// Standard deviation of the heights of shaped surfaces at the model's full relief, m.
    #[must_use]
    pub fn std(&self) -> f64 {
        self.std
    }

    /// The plane after gains and curve, narrower by [`REACH`] on each side.
    pub(crate) fn applied(&self, plane: &Plane) -> Plane {
        let mut out = self.filtered(plane);
        let mut smooth = out.clone();
        for step in SMOOTHINGS {
            smooth = smooth.octave(step).1;
        }
        out = out.inner(SMOOTH);
        for (v, s) in out.values.iter_mut().zip(&smooth.values) {
            *v = self.curve.at(*v - s) + s;
        }
        out
    }

    /// The plane after the gains, narrower by [`KERNEL`] on each side.
    fn filtered(&self, plane: &Plane) -> Plane {
        let side = 2 * KERNEL + 1;
        let (rows, cols) = (plane.rows() - 2 * KERNEL, plane.cols - 2 * KERNEL);
        let mut values = Vec::with_capacity(rows * cols);
        let mut line = vec![0.0f64; cols];
        for row in 0..rows {
            line.fill(0.0);
            for (k, weights) in self.kernel.chunks_exact(side).enumerate() {
                let from = &plane.values[(row + k) * plane.cols..][..plane.cols];
                for (j, w) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                    for (sum, v) in line.iter_mut().zip(&from[j..]) {
                        *sum += w * f64::from(*v);
                    }
                }
            }
            values.extend(line.iter().map(|v| *v as f32));
        }
        Plane { cols, values }
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
    let side = 2 * KERNEL + 1;
    let at = |i: usize| (GRID + i - KERNEL) % GRID;
    let mut kernel = Vec::with_capacity(side * side);
    for row in 0..side {
        for col in 0..side {
            let away = vb_math::hypot(row as f64 - KERNEL as f64, col as f64 - KERNEL as f64)
                / (KERNEL as f64 + 1.0);
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
            from: vec![-1.0, 1.0],
            to: vec![-1.0, 1.0],
            swells: Vec::new(),
        }
    }

    /// What becomes of a wave along the columns of this length, m, in samples of 0.5 m.
    fn response(shaping: &Shaping, wavelength: f64) -> f64 {
        let cols = 2 * KERNEL + 65;
        let wave = |i: usize| vb_math::cos(std::f64::consts::TAU * 0.5 * (i % cols) as f64 / wavelength);
        let plane = Plane { cols, values: (0..cols * (2 * KERNEL + 1)).map(|i| wave(i) as f32).collect() };
        let out = shaping.filtered(&plane).values;
        let power: f64 = out.iter().enumerate().map(|(i, v)| f64::from(*v) * wave(i + KERNEL)).sum();
        power / (0..out.len()).map(|i| wave(i + KERNEL) * wave(i + KERNEL)).sum::<f64>()
    }

    #[test]
    fn waves_are_multiplied_by_their_gain() {
        // A step in the gains is smoothed over wave numbers of 1 / 12 m; a wavelength in the middle of an even range keeps its gain.
        let low_pass = Shaping::new(&params(&[0.0, 0.0, 1.0]), 0.5, 1.0).unwrap();
        for (wavelength, gain) in [(1.2, 0.0), (2.0, 0.0), (16.0, 1.0)] {
            let found = response(&low_pass, wavelength);
            assert!((found - gain).abs() < 0.03, "{wavelength} m: {found}");
        }
    }

    #[test]
    fn heights_about_the_smooth_surface_are_mapped_by_the_curve() {
        // Equal gains leave the surface, and a straight curve, too: a level plane with one deep pit.
        let side = 2 * REACH + 9;
        let mut plane = Plane { cols: side, values: vec![2.0; side * side] };
        let middle = side / 2 * side + side / 2;
        plane.values[middle] = -1.0;
        let same = Shaping::new(&params(&[1.0, 1.0, 1.0]), 0.5, 1.0).unwrap().applied(&plane);
        assert_eq!((same.cols, same.rows()), (9, 9));
        assert!(same.values.iter().zip(&plane.inner(REACH).values).all(|(a, b)| (a - b).abs() < 1e-4));
        // Heights below the smooth surface are doubled: the pit is 3 m below a surface that it lowers by little, and gets nearly 6 m deep.
        let mut deep = params(&[1.0, 1.0, 1.0]);
        deep.to = vec![-2.0, 0.0, 1.0];
        deep.from = vec![-1.0, 0.0, 1.0];
        let deep = Shaping::new(&deep, 0.5, 1.0).unwrap().applied(&plane);
        assert!((deep.values[4 * 9 + 4] + 4.0).abs() < 0.1, "{}", deep.values[4 * 9 + 4]);
        assert!((deep.values[0] - 2.0).abs() < 0.1);
    }

    #[test]
    fn flaws_are_named() {
        let wrong = |change: &dyn Fn(&mut ShapeParams)| {
            let mut p = params(&[0.0, 0.5, 1.0]);
            p.swells = vec![Swell { spacing: 4.0, std: 0.1 }];
            change(&mut p);
            let (field, problem) = Shaping::new(&p, 0.5, 1.0).unwrap_err();
            format!("{field}: {problem}")
        };
        assert!(wrong(&|p| p.gains.push(1.0)).starts_with("gains: 4 gains for 3"));
        assert!(wrong(&|p| p.gains[1] = f64::NAN).starts_with("gains[1]: NaN must lie in 0 to 10"));
        assert!(wrong(&|p| p.wavelengths[2] = 3.0).starts_with("wavelengths[2]: 3 must be longer"));
        assert!(
            wrong(&|p| p.swells[0].spacing = 4.3).starts_with("swells[0].spacing: 4.3 must be a multiple")
        );
        assert!(wrong(&|p| p.to[0] = 5.0).starts_with("from or to: knots result in decreasing heights"));
        assert!(wrong(&|p| p.std = 0.0).starts_with("std: 0 must lie in"));
    }
}
