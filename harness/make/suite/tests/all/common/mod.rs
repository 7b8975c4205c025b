//! Statistics of surfaces, as the reference figures were measured.

use vb_world::World;

/// Percentile by linear interpolation between order statistics, as NumPy's default.
pub(crate) fn percentile(sorted: &[f64], p: f64) -> f64 {
    let at = p / 100.0 * (sorted.len() - 1) as f64;
    let k = (at as usize).min(sorted.len() - 2);
    sorted[k] + (at - k as f64) * (sorted[k + 1] - sorted[k])
}

/// Slope of every triangle of the surface, degrees, ascending.
pub(crate) fn facet_slopes(world: &World) -> Vec<f64> {
    let h = &world.heightfield;
    let mut slopes = Vec::new();
    for row in 0..h.rows() - 1 {
        for col in 0..h.cols() - 1 {
            for [u, v] in [[0.25, 0.75], [0.75, 0.25]] {
                let x = (col as f64 + u) * h.resolution() - h.half_x();
                let y = (row as f64 + v) * h.resolution() - h.half_y();
                let p = h.at(x, y);
                slopes.push(vb_math::angle::degrees(vb_math::atan(vb_math::hypot(p.dzdx, p.dzdy))));
            }
        }
    }
    slopes.sort_by(f64::total_cmp);
    slopes
}
