//! The elevation level of a surface by how rough it is.

use vb_world::{Elevation, Heightfield};

use crate::generate::GeneratorParams;

/// Root mean square slope over 2 m of the benchmark's worlds without their mean plane for each metre of the spread of heights that
/// is usual for their level, 1/m. The medians of the levels of vb-100 give 0.655, 0.650 and 0.650; with this value the levels
/// meet where fewest of its worlds lie on the wrong side.
const SLOPE: f64 = 0.665;
/// Half the distance over which slopes are taken, m.
const REACH: f64 = 1.0;

/// The spread of heights (standard deviation, m) of the benchmark's worlds that are as rough as a surface: the root mean square of
/// its slopes without the mean plane, in proportion. A tilted plain has none, whatever its relief is.
#[must_use]
pub fn spread(surface: &Heightfield) -> f64 {
    let (n, k) = (surface.cols().min(surface.rows()), reach(surface));
    let base = 2.0 * k as f64 * surface.resolution();
    let (mut sum, mut count, mut mean) = ([0.0; 2], 0.0, [0.0; 2]);
    slopes(surface, n, k, base, |slope| {
        for i in 0..2 {
            mean[i] += slope[i];
            sum[i] += slope[i] * slope[i];
        }
        count += 1.0;
    });
    if count == 0.0 {
        return 0.0;
    }
    // The mean of a slope is that of the plane.
    let variance: f64 =
        (0..2).map(|i| (sum[i] / count - (mean[i] / count) * (mean[i] / count)).max(0.0)).sum();
    variance.sqrt() / SLOPE
}

/// The level whose usual spread of heights is nearest to that of worlds as rough as the surface, as a ratio. With the default rules the
/// levels meet at root mean square slopes of 0.293 and 0.430. Low worlds of vb-100 have 0.187 to 0.260, medium ones 0.312 to
/// 0.430, high ones 0.407 to 0.557: all but three of its 100 worlds, and all but one of the 10 of smoke, are what they are called.
#[must_use]
pub fn level(surface: &Heightfield, rules: &GeneratorParams) -> Elevation {
    let own = spread(surface).max(1e-9);
    let distance = |level: Elevation| vb_math::ln(own / rules.elevation.std.get(level)).abs();
    let nearest = Elevation::ALL.into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    nearest.unwrap_or(Elevation::Low)
}

/// Median slope of the nodes, degrees.
#[cfg(feature = "site")]
pub(crate) fn median_slope(surface: &Heightfield) -> f64 {
    let (n, k) = (surface.cols().min(surface.rows()), reach(surface));
    let mut all = Vec::with_capacity(n * n);
    slopes(surface, n, k, 2.0 * k as f64 * surface.resolution(), |[x, y]| all.push(vb_math::hypot(x, y)));
    vb_math::atan(vb_terrain::stats::percentile(&mut all, 0.5)).to_degrees()
}

/// Nodes in the reach of slopes.
fn reach(surface: &Heightfield) -> usize {
    (REACH / surface.resolution()).round().max(1.0) as usize
}

fn slopes(surface: &Heightfield, n: usize, k: usize, base: f64, mut each: impl FnMut([f64; 2])) {
    for row in k..n.saturating_sub(k) {
        for col in k..n.saturating_sub(k) {
            let x = (surface.node(row, col + k) - surface.node(row, col - k)) / base;
            let y = (surface.node(row + k, col) - surface.node(row - k, col)) / base;
            each([x, y]);
        }
    }
}
