//! Plane geometry on convex polygons (counter-clockwise vertex lists, m).

/// Twice the signed area of the triangle a, b, c: positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn edges(polygon: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&a, &b)| (a, b))
}

/// The convex hull of a set of points, counter-clockwise, without collinear vertices
/// (Andrew's monotone chain, 1979).
#[must_use]
pub fn convex_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0 {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

/// Tells whether a convex polygon contains a point; its border counts as inside.
#[must_use]
pub fn contains(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    edges(polygon).all(|(a, b)| turn(a, b, p) >= 0.0)
}

/// The distance from a point to a segment, m.
#[must_use]
pub fn point_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let length2 = dot(ab, ab);
    let t = if length2 > 0.0 { (dot(ap, ab) / length2).clamp(0.0, 1.0) } else { 0.0 };
    vb_math::hypot(ap[0] - t * ab[0], ap[1] - t * ab[1])
}

/// The distance from a point to a convex polygon, m; it is 0 inside.
#[must_use]
pub fn point_to_polygon(p: [f64; 2], polygon: &[[f64; 2]]) -> f64 {
    if contains(polygon, p) {
        return 0.0;
    }
    edges(polygon).map(|(a, b)| point_to_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}

/// The distance from a segment to a convex polygon, m; it is 0 where they touch.
#[must_use]
pub fn segment_to_polygon(a: [f64; 2], b: [f64; 2], polygon: &[[f64; 2]]) -> f64 {
    if contains(polygon, a) || contains(polygon, b) {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for (c, d) in edges(polygon) {
        let crosses = turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0;
        if crosses {
            return 0.0;
        }
        least = least
            .min(point_to_segment(a, c, d))
            .min(point_to_segment(b, c, d))
            .min(point_to_segment(c, a, b))
            .min(point_to_segment(d, a, b));
    }
    least
}

/// Tells whether a convex polygon and an axis-aligned square (centre, half side, m) share area, by separating axes: two
/// convex sets are apart if and only if an edge normal of one of them separates them.
#[must_use]
pub fn overlaps_square(polygon: &[[f64; 2]], centre: [f64; 2], half: f64) -> bool {
    for k in 0..2 {
        let (low, high) =
            polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        if high <= centre[k] - half || low >= centre[k] + half {
            return false;
        }
    }
    edges(polygon).all(|(a, b)| {
        // Outward normal of a counter-clockwise edge; the square's nearest corner against the edge's line.
        let normal = [b[1] - a[1], a[0] - b[0]];
        let nearest = dot(normal, sub(centre, a)) - half * (normal[0].abs() + normal[1].abs());
        nearest < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn hull_drops_inner_and_collinear_points_and_turns_left() {
        let mut points = SQUARE.to_vec();
        points.extend([[1.0, 1.0], [1.0, 0.0], [0.5, 1.5]]);
        assert_eq!(convex_hull(&points), SQUARE);
    }

    #[test]
    fn distances_are_euclidean_and_zero_inside() {
        // Worked by hand: corner (2, 2) to (5, 6) is a 3-4-5 triangle; the diagonal x + y = 6 passes (2, 2) at
        // √2.
        assert_eq!(point_to_polygon([1.0, 1.9], &SQUARE), 0.0);
        assert_eq!(point_to_polygon([5.0, 6.0], &SQUARE), 5.0);
        assert_eq!(point_to_polygon([1.0, -0.5], &SQUARE), 0.5);
        assert!((segment_to_polygon([6.0, 0.0], [0.0, 6.0], &SQUARE) - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(segment_to_polygon([-1.0, 1.0], [3.0, 1.0], &SQUARE), 0.0);
        assert_eq!(segment_to_polygon([-1.0, 3.0], [3.0, 3.0], &SQUARE), 1.0);
    }

    #[test]
    fn a_square_that_only_touches_or_passes_a_corner_does_not_overlap() {
        let diamond = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        assert!(overlaps_square(&diamond, [0.0, 0.0], 0.1));
        assert!(overlaps_square(&diamond, [0.9, 0.9], 0.45), "corner (0.45, 0.45) lies inside x + y < 1");
        assert!(!overlaps_square(&diamond, [0.9, 0.9], 0.39), "corner (0.51, 0.51) lies outside x + y < 1");
        assert!(!overlaps_square(&diamond, [2.0, 0.0], 1.0));
    }
}
