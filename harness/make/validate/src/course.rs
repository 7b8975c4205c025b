//! Courses for ride and shock: those of the events, made here, and those of files, as ground to drive on.
//!
//! The RMS courses have the statistics of the courses of the Keweenaw Research Center that Project Chrono distributes for RMS 1 and
//! 4 inches. Their spectra, estimated over 304.8 m (Welch's method, windows of 102 m), peak at wavelengths of 5 to 10 m, fall with
//! the fourth power of the wavenumber on both sides, and end in a tail that is nearly the same for both: with q = n / 0.15 m⁻¹,
//! S(n) = B q⁴/(1 + q⁸) + 2.4·10⁻⁵ m n⁻² q⁴/(1 + q⁴), where B follows from the RMS. In bands between wavelengths of 2 and 12 m, in
//! which lie nine tenths of the variance, the measured spectra agree with this within a factor of 1.7 (a test compares them).

use std::f64::consts::TAU;
use std::sync::Arc;

use vb_math::rng::Stream;
use vb_math::{cos, sin};
use vb_terrain::Course;
use vb_world::World;

use crate::grounds::relief;

/// An inch, m.
pub(crate) const INCH: f64 = 0.0254;
/// The wavelength (m) above which the definition of RMS removes the profile: 60 ft.
const TREND: f64 = 60.0 * 0.3048;
/// The length of an RMS course, m: 300 ft. It is periodic, so all of its statistics are those of this length.
const LENGTH: f64 = 300.0 * 0.3048;
/// The distance between the heights of an RMS course, m.
const SPACING: f64 = LENGTH / 900.0;
/// The length over which an RMS course begins and ends, m.
const RAMP: f64 = 80.0 * SPACING;
/// The shortest wavelength of an RMS course, m: about the length that a tyre touches, which averages over shorter ones.
const SHORTEST: f64 = 0.4;
/// The seed of the phases.
const SEED: u64 = 1;
/// The wavenumber at which the spectrum turns, 1/m.
const CORNER: f64 = 0.15;
/// The level of the spectrum's tail, m.
const TAIL: f64 = 2.4e-5;
/// The distance between the heights of a half round, m.
const FINE: f64 = 0.01;
/// Heights that differ by less are level, m.
const LEVEL: f64 = 1e-3;
/// The most nodes of a ground.
const MOST_NODES: f64 = 4e6;

/// A course from a file, for the events `ride-course` and `half-round`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCourse {
    /// The name in figures, such as that of its file.
    pub name: String,
    pub course: Course,
}

/// The two parts of the spectrum of an RMS course at a wavenumber (1/m): the first for a factor B of 1 m³, and the tail, m³.
fn spectrum(n: f64) -> [f64; 2] {
    let q4 = (n / CORNER) * (n / CORNER) * (n / CORNER) * (n / CORNER);
    [q4 / (1.0 + q4 * q4), TAIL / (n * n) * q4 / (1.0 + q4)]
}

/// The wavenumbers of an RMS course, 1/m.
fn wavenumbers() -> impl Iterator<Item = f64> {
    (1..=(LENGTH / SHORTEST) as usize).map(|k| k as f64 / LENGTH)
}

/// The factor B (m³) of a course of this RMS, m. A mean over the length D leaves 1 − sin(πnD)/(πnD) of a wave.
fn factor(rms: f64) -> f64 {
    let mut parts = [0.0; 2];
    for n in wavenumbers() {
        let x = 0.5 * TAU * n * TREND;
        let left = 1.0 - sin(x) / x;
        for (sum, s) in parts.iter_mut().zip(spectrum(n)) {
            *sum += s * left * left / LENGTH;
        }
    }
    ((rms * rms - parts[1]) / parts[0]).max(0.0)
}

/// The root of the mean square (m) of heights `spacing` metres apart about their mean over 60 ft, which is centred and goes no
/// farther than the heights do.
pub(crate) fn detrended_rms(heights: &[f64], spacing: f64) -> f64 {
    let reach = (0.5 * TREND / spacing).round() as usize;
    let mut sums = vec![0.0];
    for z in heights {
        sums.push(sums[sums.len() - 1] + z);
    }
    let square = |i: usize| {
        let (from, to) = (i.saturating_sub(reach), (i + reach + 1).min(heights.len()));
        let z = heights[i] - (sums[to] - sums[from]) / (to - from) as f64;
        z * z
    };
    ((0..heights.len()).map(square).sum::<f64>() / heights.len() as f64).sqrt()
}

/// One period of an RMS course whose detrended RMS (m) is `rms`.
fn period(rms: f64) -> Vec<f64> {
    let count = (LENGTH / SPACING).round() as usize;
    let mut rng = Stream::new(SEED, &["rms course"]);
    let b = factor(rms);
    let waves: Vec<f64> = (0..count).map(|i| TAU * i as f64 / count as f64).collect();
    let mut heights = vec![0.0; count];
    for (k, n) in wavenumbers().enumerate() {
        let phase = rng.uniform(0.0, TAU);
        let [first, tail] = spectrum(n);
        let amplitude = (2.0 * (b * first + tail) / LENGTH).sqrt();
        for (i, z) in heights.iter_mut().enumerate() {
            *z += amplitude * cos(waves[(k + 1) * i % count] + phase);
        }
    }
    // The mean over 60 ft is shorter near the ends, which changes the RMS by some percent.
    let scale = rms / detrended_rms(&heights, SPACING);
    heights.iter().map(|z| z * scale).collect()
}

/// An RMS course with this detrended RMS, m: a period of it, and a ramp before and behind.
pub(crate) fn rms_course(rms: f64) -> Course {
    let period = period(rms);
    let (count, ramp) = (period.len(), (RAMP / SPACING).round() as usize);
    let heights: Vec<f64> = (0..count + 2 * ramp)
        .map(|i| {
            let inside = i.min(count + 2 * ramp - 1 - i) as f64 / ramp as f64;
            let weight = if inside < 1.0 { 0.5 - 0.5 * cos(0.5 * TAU * inside) } else { 1.0 };
            weight * period[(i + count - ramp) % count]
        })
        .collect();
    Course::straight(SPACING, 3.0, &heights)
}

/// Half a circle of this radius (m) across the way, as NRMM's obstacles are: its height is its radius.
pub(crate) fn half_round(radius: f64) -> Course {
    let reach = (radius / FINE).ceil() as i32 + 2;
    let height = |k: i32| {
        let x = f64::from(k) * FINE;
        (radius * radius - x * x).max(0.0).sqrt()
    };
    Course::straight(FINE, 3.0, &(-reach..=reach).map(height).collect::<Vec<_>>())
}

/// A course as ground: level before and behind, and to both sides as its borders are. Full-size.
pub(crate) struct Ground {
    pub(crate) world: Arc<World>,
    /// The first and the last x at which the ground is not level, m; `None` if all of it is.
    pub(crate) uneven: Option<[f64; 2]>,
    /// The detrended RMS of the profile in the middle between these places, m.
    pub(crate) rms: f64,
}

impl Ground {
    /// The course for a vehicle of this width, m at full size. The reference line becomes the x axis, so a course that turns is
    /// driven straightened.
    pub(crate) fn new(course: &Course, width: f64, friction: f64) -> Self {
        let ([from, to], [right, left]) = (course.span(), course.borders());
        // A strip about the reference line, or about the middle of a course that lies beside it.
        let centre = if right < 0.0 && left > 0.0 { 0.0 } else { 0.5 * (right + left) };
        let strip = width + 2.0;
        let mut resolution = course.increment().min(course.finest_section()).max(FINE);
        while (to - from) * strip > MOST_NODES * resolution * resolution {
            resolution *= 2.0;
        }
        // One more node on each side continues the ends level.
        let cells = ((to - from) / resolution * (1.0 - 1e-12)).ceil() + 2.0;
        let (length, middle) = (cells * resolution, 0.5 * (from + to));
        let rows = 2.0 * (0.5 * strip / resolution).ceil();
        let height = |x: f64, y: f64| course.height(middle + x, centre + y);
        let world = relief(length, rows * resolution, resolution, friction, height);
        let field = &world.heightfield;
        let levels = |col: usize, end: usize| {
            (0..field.rows()).all(|row| (field.node(row, col) - field.node(row, end)).abs() < LEVEL)
        };
        let cols = field.cols();
        let place = |col: usize| (col as f64 - 0.5 * (cols - 1) as f64) * resolution;
        let first = (0..cols).find(|col| !levels(*col, 0));
        let last = (0..cols).rev().find(|col| !levels(*col, cols - 1));
        let ends = first.zip(last).filter(|(first, last)| first <= last);
        let uneven = ends.map(|(first, last)| [place(first), place(last)]);
        let profile: Vec<f64> = ends
            .map(|(first, last)| (first..=last).map(|col| field.node(field.rows() / 2, col)).collect())
            .unwrap_or_default();
        let rms = if profile.is_empty() { 0.0 } else { detrended_rms(&profile, resolution) };
        Self { world, uneven, rms }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detrending_keeps_short_waves_and_removes_long_ones() {
        let wave = |length: f64| -> Vec<f64> {
            (0..8000).map(|i| 0.1 * sin(TAU * 0.05 * f64::from(i) / length)).collect()
        };
        // A mean over 60 ft leaves 1 − sin(πL/λ)/(πL/λ) of a wave.
        for length in [2.0, 7.0, 18.288, 100.0] {
            let x = 0.5 * TAU * TREND / length;
            let expected = (1.0 - sin(x) / x) * 0.1 / std::f64::consts::SQRT_2;
            let rms = detrended_rms(&wave(length), 0.05);
            assert!((rms - expected).abs() < 0.02 * 0.0707, "{length}: {rms}, not {expected}");
        }
    }

    #[test]
    fn rms_courses_have_their_rms_and_the_spectrum_of_the_formula() {
        for inches in [1.0, 4.0] {
            let heights = period(inches * INCH);
            assert!((detrended_rms(&heights, SPACING) / (inches * INCH) - 1.0).abs() < 1e-9);
            // The variance of a wave, by its Fourier coefficient, is the spectrum times the distance of wavenumbers.
            let b = factor(inches * INCH);
            for k in [5, 16, 40, 120] {
                let angle = |i: usize| TAU * ((k * i) % heights.len()) as f64 / heights.len() as f64;
                let sum = heights
                    .iter()
                    .enumerate()
                    .fold([0.0, 0.0], |[c, s], (i, z)| [c + z * cos(angle(i)), s + z * sin(angle(i))]);
                let variance =
                    2.0 * (sum[0] * sum[0] + sum[1] * sum[1]) / (heights.len() * heights.len()) as f64;
                let [first, tail] = spectrum(k as f64 / LENGTH);
                let ratio = variance * LENGTH / (b * first + tail);
                assert!((ratio - 1.0).abs() < 0.1, "{inches} in, wave {k}: {ratio}");
            }
        }
    }

    #[test]
    fn the_courses_of_chrono_have_nearly_the_spectrum_of_the_formula() {
        let Some(dir) = vb_testing::shared("cases/chrono/crg_roads") else { return };
        for inches in [1.0, 4.0] {
            let file = dir.join(format!("detrended_rms_course_{inches}in.crg"));
            let course = vb_terrain::read::course(&file).unwrap().course;
            let heights: Vec<f64> =
                (0..6096).map(|k| course.height(100.0 + 0.05 * f64::from(k), 0.0)).collect();
            let rms = detrended_rms(&heights, 0.05);
            assert!((rms / (inches * INCH) - 1.0).abs() < 0.2, "{inches} in: {rms} m");
            // Means over bands of wavenumbers, of the whole length without a window: it begins and ends level.
            let b = factor(rms);
            let variance = |k: usize| {
                let angle = |i: usize| TAU * ((k * i) % heights.len()) as f64 / heights.len() as f64;
                let sum = heights
                    .iter()
                    .enumerate()
                    .fold([0.0, 0.0], |[c, s], (i, z)| [c + z * cos(angle(i)), s + z * sin(angle(i))]);
                2.0 * (sum[0] * sum[0] + sum[1] * sum[1]) / (heights.len() * heights.len()) as f64
            };
            for [low, high] in [[0.08, 0.12], [0.12, 0.2], [0.2, 0.35], [0.35, 0.5]] {
                let waves = (low * 304.8) as usize..(high * 304.8) as usize;
                let own: f64 = waves.clone().map(variance).sum();
                let formula: f64 = waves
                    .map(|k| spectrum(k as f64 / 304.8))
                    .map(|[first, tail]| (b * first + tail) / 304.8)
                    .sum();
                let ratio = own / formula;
                assert!((0.6..1.7).contains(&ratio), "{inches} in, {low} to {high} 1/m: {ratio}");
            }
        }
    }

    #[test]
    fn ground_is_level_beyond_a_course_and_knows_where_it_is_not() {
        let ground = Ground::new(&half_round(12.0 * INCH), 2.2, 0.9);
        let [from, to] = ground.uneven.unwrap();
        assert!((from + 0.3048).abs() <= 0.011 && (to - 0.3048).abs() <= 0.011, "{from} {to}");
        let field = &ground.world.heightfield;
        for (x, z) in [(0.0, 0.3048), (0.2, 0.23), (-0.2, 0.23), (-40.0, 0.0), (90.0, 0.0)] {
            assert!((field.height(x, 0.4) - z).abs() < 1e-3, "{x}: {}", field.height(x, 0.4));
        }
        let rough = Ground::new(&rms_course(INCH), 2.2, 0.9);
        let [from, to] = rough.uneven.unwrap();
        assert!((to - from - LENGTH - 2.0 * RAMP).abs() < 4.0, "{from} {to}");
        assert_eq!(
            [rough.world.heightfield.height(-200.0, 0.0), rough.world.heightfield.height(200.0, 0.0)]
                .map(|z| z.abs() < LEVEL),
            [true; 2]
        );
        assert!(Ground::new(&Course::straight(0.5, 2.0, &[0.0; 9]), 2.0, 0.9).uneven.is_none());
    }
}
