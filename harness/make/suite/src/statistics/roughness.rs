//! Roughness of the ground by wavelength and as a vehicle meets it.
//!
//! Central slopes over 1 m to each side have no gain at a wavelength of 2 m. These figures do, so that suites that agree in them
//! are as rough at every wavelength that a vehicle feels.

use super::summary::Tally;
use serde::Serialize;
use vb_math::rng::Stream;
use vb_math::{angle::degrees, atan, hypot, sin_cos};
use vb_terrain::stats::Spectrum;
use vb_world::Heightfield;

/// Edges of the octaves of wavelength, m. The shortest waves on nodes that are 1 m apart have √2 m, along the diagonal.
pub const OCTAVES: [f64; 7] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// The poses of the vehicle in a world, the same in all worlds. Of 4000, a fraction of 2.5 % has a standard error of 0.25 %;
/// a level has some 30 worlds.
const POSES: usize = 4000;
/// The vehicle: half the distance between its axles and half its track, m (HMMWV: 3.302 m and 1.82 m, TM 9-2320-280-10).
const WHEELS: [f64; 2] = [1.651, 0.91];
/// The part of the belly that is checked: along the vehicle from its middle, and to each side, m (frame and differentials of the HMMWV).
const BELLY: [[f64; 2]; 2] = [[-1.1, 1.15], [-0.55, 0.55]];
/// Places along and across the belly.
const PLACES: [usize; 2] = [10, 5];
/// Ground clearance under the belly, m (HMMWV: 16 in, TM 9-2320-280-10 table 1-8).
pub const CLEARANCE: f64 = 0.41;
/// The distance of a pose from the edge of the world, m.
const MARGIN: f64 = 7.0;
/// Width of the bins that angles are counted in, degrees.
const BIN: f64 = 0.01;

/// Percentiles of angles, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Angles {
    pub p50: f64,
    pub p95: f64,
    pub p99: f64,
}

impl Angles {
    fn of(tally: &Tally) -> Self {
        let at = |q| tally.quantile(q).min(tally.max());
        Self { p50: at(0.50), p95: at(0.95), p99: at(0.99) }
    }
}

/// The roughness of the worlds of a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Roughness {
    /// Root mean square of the height within each octave of wavelength (1 to 2 m, then up to 64 m), over worlds, m; `None` where the worlds
    /// are too small for its waves.
    pub octaves: [Option<f64>; OCTAVES.len() - 1],
    /// Root mean square of h(x − 1 m) − 2 h(x) + h(x + 1 m) along x and y, m.
    pub second_difference: f64,
    /// Root mean square twist of squares of 1 m, the sum of two opposite corners less that of the others, m.
    pub twist: f64,
    /// Fraction of poses on four wheels in which the ground reaches the belly; `None` where the worlds are too small.
    pub belly: Option<f64>,
    /// Break-over: the angle between the ground over the metre behind and the metre ahead of a point; degrees.
    pub break_over: Angles,
    /// Slopes of the facets, degrees.
    pub facets: Angles,
}

/// What is summed over worlds for [`Roughness`].
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    worlds: f64,
    /// Sum of mean squares, and the number of worlds that have waves of the octave.
    octaves: [[f64; 2]; OCTAVES.len() - 1],
    second_difference: f64,
    twist: f64,
    /// Poses, and those with the belly in the ground.
    belly: [u64; 2],
    break_over: Tally,
    facets: Tally,
}

impl Sums {
    pub(crate) fn of(h: &Heightfield) -> Self {
        let mut sums = Self {
            worlds: 1.0,
            octaves: octaves(h),
            second_difference: 0.0,
            twist: 0.0,
            belly: [0; 2],
            break_over: Tally::new(BIN),
            facets: facets(h),
        };
        (sums.second_difference, sums.twist) = differences(h);
        sums.drive(h);
        sums
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.worlds += other.worlds;
        for (own, other) in self.octaves.iter_mut().zip(other.octaves) {
            *own = [own[0] + other[0], own[1] + other[1]];
        }
        self.second_difference += other.second_difference;
        self.twist += other.twist;
        self.belly = [self.belly[0] + other.belly[0], self.belly[1] + other.belly[1]];
        self.break_over.merge(&other.break_over);
        self.facets.merge(&other.facets);
    }

    pub(crate) fn finish(&self) -> Roughness {
        let [poses, touching] = self.belly;
        Roughness {
            octaves: self.octaves.map(|[sum, n]| (n > 0.0).then(|| (sum / n).sqrt())),
            second_difference: (self.second_difference / self.worlds).sqrt(),
            twist: (self.twist / self.worlds).sqrt(),
            belly: (poses > 0).then(|| touching as f64 / poses as f64),
            break_over: Angles::of(&self.break_over),
            facets: Angles::of(&self.facets),
        }
    }

    /// Places the vehicle in random poses on its four wheels: the plane of least squares through the ground under them.
    fn drive(&mut self, h: &Heightfield) {
        let half = [h.half_x() - MARGIN, h.half_y() - MARGIN];
        if half.iter().any(|v| *v <= 0.0) {
            return;
        }
        let mut rng = Stream::new(1, &["roughness"]);
        let [length, width] = WHEELS;
        let place = |range: [f64; 2], k: usize, n: usize| {
            range[0] + (range[1] - range[0]) * k as f64 / (n - 1) as f64
        };
        for _ in 0..POSES {
            let middle = half.map(|v| rng.uniform(-v, v));
            let (s, c) = sin_cos(rng.uniform(0.0, std::f64::consts::TAU));
            let z = |u: f64, v: f64| h.height(middle[0] + c * u - s * v, middle[1] + s * u + c * v);
            let [fl, fr, rl, rr] =
                [z(length, width), z(length, -width), z(-length, width), z(-length, -width)];
            let mean = 0.25 * (fl + fr + rl + rr);
            let along = (fl + fr - rl - rr) / (4.0 * length);
            let across = (fl + rl - fr - rr) / (4.0 * width);
            let upright = (1.0 + along * along + across * across).sqrt();
            let mut highest = f64::NEG_INFINITY;
            for i in 0..PLACES[0] {
                for j in 0..PLACES[1] {
                    let (u, v) = (place(BELLY[0], i, PLACES[0]), place(BELLY[1], j, PLACES[1]));
                    highest = highest.max((z(u, v) - mean - along * u - across * v) / upright);
                }
            }
            self.belly[0] += 1;
            self.belly[1] += u64::from(highest > CLEARANCE);
            let [behind, here, ahead] = [z(-1.0, 0.0), z(0.0, 0.0), z(1.0, 0.0)];
            self.break_over.add(degrees((atan(ahead - here) - atan(here - behind)).abs()));
        }
    }
}

/// Mean squares of height by octave, from the Hann-tapered spectrum of the largest square of a power of two of nodes, with the number of
/// worlds (1, or 0 where the square has no wave of the octave).
fn octaves(h: &Heightfield) -> [[f64; 2]; OCTAVES.len() - 1] {
    let side = h.rows().min(h.cols());
    let side = if side < 4 { return [[0.0; 2]; OCTAVES.len() - 1] } else { 1usize << side.ilog2() };
    let mut spectrum = Spectrum::new(side);
    let window: Vec<f64> = (0..side * side).map(|i| h.node(i / side, i % side)).collect();
    spectrum.add(&window);
    std::array::from_fn(|k| {
        let band = spectrum.mean_square(h.resolution(), [OCTAVES[k], OCTAVES[k + 1]]);
        band.map_or([0.0; 2], |power| [power, 1.0])
    })
}

/// Mean squares of second differences and of twists over a metre, or over one node where nodes are farther apart.
fn differences(h: &Heightfield) -> (f64, f64) {
    let n = vb_page::map::nodes_of_a_metre(h.resolution()).min((h.rows().min(h.cols()) - 1) / 2).max(1);
    let (rows, cols) = (h.rows(), h.cols());
    let (mut second, mut twist) = ([0.0; 2], [0.0; 2]);
    let add = |to: &mut [f64; 2], v: f64| *to = [to[0] + v * v, to[1] + 1.0];
    for row in 0..rows {
        for col in 0..cols {
            let z = h.node(row, col);
            if col >= n && col + n < cols {
                add(&mut second, h.node(row, col - n) - 2.0 * z + h.node(row, col + n));
            }
            if row >= n && row + n < rows {
                add(&mut second, h.node(row - n, col) - 2.0 * z + h.node(row + n, col));
            }
            if row + n < rows && col + n < cols {
                add(&mut twist, h.node(row + n, col + n) + z - h.node(row + n, col) - h.node(row, col + n));
            }
        }
    }
    (second[0] / second[1].max(1.0), twist[0] / twist[1].max(1.0))
}

/// Slopes of the two facets of each cell, degrees.
fn facets(h: &Heightfield) -> Tally {
    let mut tally = Tally::new(BIN);
    for row in 0..h.rows() - 1 {
        for col in 0..h.cols() - 1 {
            let [sw, se] = [h.node(row, col), h.node(row, col + 1)];
            let [nw, ne] = [h.node(row + 1, col), h.node(row + 1, col + 1)];
            for [dx, dy] in [[ne - nw, nw - sw], [se - sw, ne - se]] {
                tally.add(degrees(atan(hypot(dx, dy) / h.resolution())));
            }
        }
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(nodes: usize, z: impl Fn(f64, f64) -> f64) -> Heightfield {
        let at = |i: usize| i as f64 - 0.5 * (nodes - 1) as f64;
        Heightfield::new(
            nodes,
            nodes,
            1.0,
            (0..nodes * nodes).map(|i| z(at(i % nodes), at(i / nodes))).collect(),
        )
    }

    fn of(h: &Heightfield) -> Roughness {
        Sums::of(h).finish()
    }

    #[test]
    fn a_wave_is_in_its_octave_alone_with_its_root_mean_square() {
        let tau = std::f64::consts::TAU;
        // Of amplitude 0.2 m along x: 0.2 / √2. The taper spreads it over wave numbers that differ by 2 / 128 m.
        for (wavelength, octave) in [(2.67, 1), (5.33, 2), (11.0, 3), (21.0, 4)] {
            let r = of(&field(129, |x, _| 0.2 * vb_math::sin(tau * x / wavelength)));
            for (k, rms) in r.octaves.into_iter().enumerate() {
                let expected = if k == octave { 0.2 / 2.0f64.sqrt() } else { 0.0 };
                assert!((rms.unwrap() - expected).abs() < 2e-3, "{wavelength} m, octave {k}: {rms:?}");
            }
        }
        // A board of squares: h = ±0.1 m has a wavelength of √2 m.
        let board = of(&field(129, |x, y| 0.1 * vb_math::cos(0.5 * tau * (x + y))));
        assert!((board.octaves[0].unwrap() - 0.1).abs() < 1e-3, "{:?}", board.octaves);
    }

    #[test]
    fn waves_of_two_metres_are_seen() {
        // ±0.1 m along x: no central slope, second differences of 0.4 m along x and none along y, facets of atan 0.2, and a break of
        // twice that across the ridges.
        let r = of(&field(65, |x, _| 0.1 * vb_math::cos(std::f64::consts::PI * x)));
        assert!((r.second_difference - 0.4 / 2.0f64.sqrt()).abs() < 1e-3, "{r:?}");
        assert!(r.twist < 1e-9, "{r:?}");
        assert!((r.facets.p50 - 11.31).abs() < 0.006 && (r.facets.p99 - 11.31).abs() < 0.006, "{r:?}");
        assert!(r.break_over.p99 > 20.0 && r.break_over.p99 < 22.63, "{r:?}");
        // A saddle h = a x y twists every square of 1 m by a.
        assert!((of(&field(65, |x, y| 0.02 * x * y)).twist - 0.02).abs() < 1e-9);
    }

    #[test]
    fn the_belly_is_in_the_ground_on_ridges_higher_than_its_clearance() {
        // Flat ground, and a plane, never reach it.
        assert_eq!(of(&field(65, |_, _| 0.0)).belly, Some(0.0));
        assert_eq!(of(&field(65, |x, y| 0.3 * x - 0.2 * y)).belly, Some(0.0));
        // Ridges of 8 m along y, h = a cos(2π x / 8 m). On a crest, heading along x, the wheels stand at x = ±1.651 m on the facets between
        // the nodes at 1 m (0.707 a) and 2 m (0): 0.247 a high, so the crest is 0.753 a above their plane, which is most. It reaches the
        // belly where a > 0.41 m / 0.753 = 0.54 m.
        let ridges = |a: f64| {
            of(&field(65, move |x, _| a * vb_math::cos(std::f64::consts::TAU * x / 8.0))).belly.unwrap()
        };
        assert!(ridges(0.9) > 0.02, "{}", ridges(0.9));
        assert_eq!(ridges(0.5), 0.0);
        assert_eq!(of(&field(9, |_, _| 0.0)).belly, None, "no room");
    }
}
