//! Tables of points, with straight lines between them.

/// The value and the derivative at `x`. Beyond the ends the value is constant and the derivative is 0.
#[inline]
#[must_use]
pub fn interpolate(points: &[[f64; 2]], x: f64) -> (f64, f64) {
    let k = points.partition_point(|p| p[0] <= x);
    if k == 0 {
        return (points[0][1], 0.0);
    }
    if k == points.len() {
        return (points[k - 1][1], 0.0);
    }
    let ([x0, y0], [x1, y1]) = (points[k - 1], points[k]);
    let slope = (y1 - y0) / (x1 - x0);
    (y0 + slope * (x - x0), slope)
}

/// The derivative at `x` between the ends of the table, both included; at a point that of the line to its right, at the last
/// point that of the last line.
#[inline]
#[must_use]
pub(crate) fn slope_within(points: &[[f64; 2]], x: f64) -> f64 {
    let k = points.partition_point(|p| p[0] <= x).clamp(1, points.len() - 1);
    let ([x0, y0], [x1, y1]) = (points[k - 1], points[k]);
    (y1 - y0) / (x1 - x0)
}
