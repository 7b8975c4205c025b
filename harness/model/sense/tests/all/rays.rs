//! Rays against closed forms and against every triangle by itself.

use crate::common::{V3, flat, scene, tilted, upright};
use proptest::prelude::*;
use vb_math::rng::Stream;
use vb_sense::rays::{Hit, Scene, Surface};
use vb_world::{Heightfield, Obstacle, ObstacleKind};

/// Of what closed forms give, m.
const MILLIMETRE: f64 = 1e-3;

fn distance(scene: &Scene, from: [f64; 3], along: [f64; 3]) -> Option<f64> {
    scene.cast(&V3::from(from), &V3::from(along).normalize(), 1000.0, None).map(|h| h.distance)
}

#[track_caller]
fn assert_distance(scene: &Scene, from: [f64; 3], along: [f64; 3], expected: f64) {
    let got = distance(scene, from, along).expect("a hit");
    assert!((got - expected).abs() < MILLIMETRE, "{from:?} {along:?}: {got}, expected {expected}");
}

#[test]
fn a_ray_meets_a_level_plane_where_its_height_is_used_up() {
    let s = scene(flat(), vec![]);
    for (from, along) in [
        ([0.3, 0.2, 2.0], [1.0, 0.0, -0.1]),
        ([-7.77, 3.1, 5.0], [-0.3, 0.8, -0.4]),
        // Straight down, on a node, on a grid line, and on a diagonal of the cells.
        ([0.5, 0.25, 3.0], [0.0, 0.0, -1.0]),
        ([1.0, 2.0, 3.0], [0.0, 0.0, -1.0]),
        ([1.0, 2.0, 1.0], [1.0, 0.0, -0.05]),
        ([1.0, 2.0, 1.0], [0.0, -1.0, -0.05]),
        ([-5.0, -5.0, 1.0], [1.0, 1.0, -0.08]),
        ([5.0, -5.0, 1.0], [-1.0, 1.0, -0.08]),
        // From below.
        ([0.3, 0.2, -2.0], [0.2, 0.1, 0.5]),
        ([1.0, 1.0, -2.0], [1.0, 1.0, 1.0]),
        // From outside the world, over its edge.
        ([-60.0, 0.5, 5.0], [1.0, 0.01, -0.1]),
    ] {
        let d = V3::from(along).normalize();
        assert_distance(&s, from, along, -from[2] / d.z);
    }
}

#[test]
fn a_ray_that_meets_nothing_has_no_hit() {
    let s = scene(flat(), vec![upright(10.0, 0.0, 0.0, [2.0, 2.0, 2.0])]);
    for (from, along) in [
        ([0.0, 0.0, 2.0], [1.0, 0.0, 0.1]),
        ([0.0, 0.0, 2.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, 2.5], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, -2.0], [0.0, 0.3, -1.0]),
        // The ground ends at the edge of the world.
        ([0.0, 0.0, 2.0], [0.0, 1.0, -0.01]),
        ([-60.0, 0.0, 2.0], [-1.0, 0.0, -0.1]),
        ([-60.0, 70.0, 2.0], [1.0, 0.0, -0.1]),
    ] {
        assert_eq!(distance(&s, from, along), None, "{from:?} {along:?}");
    }
    let down = V3::new(0.0, 0.0, -1.0);
    assert!(s.cast(&V3::new(0.0, 0.0, 2.0), &down, 1.99, None).is_none(), "beyond the reach");
    assert!(s.cast(&V3::new(0.0, 0.0, 2.0), &down, 2.01, None).is_some());
}

#[test]
fn a_ray_meets_a_tilted_plane_where_the_plane_is() {
    let (a, b, c) = (1.0, 0.2, -0.1);
    let s = scene(tilted(a, b, c), vec![]);
    for (from, along) in [
        ([0.3, 0.2, 6.0], [1.0, 0.3, -0.2]),
        ([-7.7, 3.1, 5.0], [-0.3, 0.8, -0.4]),
        // Grazing: it comes nearer by a hundredth of its way.
        ([-20.0, 0.0, -2.5], [1.0, 0.0, 0.19]),
        ([2.0, -3.0, 9.0], [0.0, 0.0, -1.0]),
        ([0.0, 0.0, -4.0], [0.1, 0.2, 1.0]),
    ] {
        let d = V3::from(along).normalize();
        // z0 + t dz = a + b (x0 + t dx) + c (y0 + t dy).
        let expected = (a + b * from[0] + c * from[1] - from[2]) / (d.z - b * d.x - c * d.y);
        assert_distance(&s, from, along, expected);
    }
}

#[test]
fn a_box_on_a_plane_is_hit_where_its_nearest_face_is() {
    // From x = 9 to 11, y = -1.5 to 1.5, z = 0 to 2.
    let s = scene(flat(), vec![upright(10.0, 0.0, 0.0, [2.0, 3.0, 2.0])]);
    assert_distance(&s, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 9.0);
    assert_distance(&s, [10.0, 0.5, 8.0], [0.0, 0.0, -1.0], 6.0);
    assert_distance(&s, [0.0, 1.49, 1.0], [1.0, 0.0, 0.0], 9.0);
    // Just beside it and just above it, on to the ground.
    assert_distance(&s, [0.0, 1.51, 1.0], [1.0, 0.0, -0.05], 20.0 * 1.0025_f64.sqrt());
    assert_distance(&s, [0.0, 0.0, 3.0], [1.0, 0.0, -0.08], 37.5 * 1.0064_f64.sqrt());
    // From within it, where it ends.
    assert_distance(&s, [10.0, 0.0, 1.0], [1.0, 0.0, 0.0], 1.0);
    let hit = s.cast(&V3::new(0.0, 0.0, 1.0), &V3::x(), 100.0, None).unwrap();
    assert_eq!(hit.surface, Surface::Obstacle(0));
    // Turned by 45 degrees, its corner is nearest: √2 m before its middle.
    let turned = scene(flat(), vec![upright(10.0, 0.0, std::f64::consts::FRAC_PI_4, [2.0, 2.0, 2.0])]);
    assert_distance(&turned, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 10.0 - 2.0_f64.sqrt());
}

#[test]
fn a_step_is_hit_on_its_face_and_behind_its_edge() {
    // The ground rises from 0 at x = 0 to 2 m at x = 1.
    let height = |i: usize| if i % 81 > 40 { 2.0 } else { 0.0 };
    let s = scene(Heightfield::new(81, 81, 1.0, (0..81 * 81).map(height).collect()), vec![]);
    for y in [0.0, 0.3, 5.5] {
        assert_distance(&s, [-10.0, y, 1.0], [1.0, 0.0, 0.0], 10.5);
        assert_distance(&s, [-10.0, y, 2.5], [1.0, 0.0, -0.02], 25.0 * 1.0004_f64.sqrt());
        // From above over the edge: at x = 1 the ray is at 2.4 m and falls by 1.2 m a metre, more slowly than the face, so
        // it comes to the ground at x = -1.
        assert_distance(&s, [3.0, y, 4.8], [-1.0, 0.0, -1.2], 4.0 * (1.0_f64 + 1.2 * 1.2).sqrt());
    }
}

#[test]
fn a_ray_along_the_edge_of_the_world_meets_the_ground_though_its_direction_is_rounded() {
    // A ramp that rises by 0.2 m in the last of 40 cells of 0.1 m, up to y = 2 m; half its width is 0.05 m.
    let heights = (0..82).map(|i| if i / 2 == 40 { 0.2 } else { 0.0 }).collect();
    let s = scene(Heightfield::new(41, 2, 0.1, heights), vec![]);
    for x in [-0.05, 0.05] {
        // As the sine and the cosine of half a circle and the like come out.
        for aside in [-2e-16, -6e-17, 0.0, 6e-17, 2e-16] {
            let hit = s.cast(&V3::new(x, -1.8, 0.1), &V3::new(aside, 1.0, 0.0), 100.0, None).unwrap();
            assert!((hit.distance - 3.75).abs() < 1e-9, "{x} {aside}: {hit:?}");
        }
    }
}

/// The nearest hit with any triangle (Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997).
fn brute_force(h: &Heightfield, o: &V3, d: &V3) -> Option<f64> {
    let node = |row: usize, col: usize| {
        let r = h.resolution();
        V3::new(col as f64 * r - h.half_x(), row as f64 * r - h.half_y(), h.node(row, col))
    };
    let mut nearest: Option<f64> = None;
    for row in 0..h.rows() - 1 {
        for col in 0..h.cols() - 1 {
            let [sw, se, nw, ne] =
                [node(row, col), node(row, col + 1), node(row + 1, col), node(row + 1, col + 1)];
            for [a, b, c] in [[sw, ne, nw], [sw, se, ne]] {
                let (e1, e2) = (b - a, c - a);
                let p = d.cross(&e2);
                let det = e1.dot(&p);
                if det.abs() < 1e-14 {
                    continue;
                }
                let t = o - a;
                let q = t.cross(&e1);
                let (u, v, s) = (t.dot(&p) / det, d.dot(&q) / det, e2.dot(&q) / det);
                let eps = 1e-9;
                if u >= -eps && v >= -eps && u + v <= 1.0 + eps && s >= 0.0 {
                    nearest = Some(nearest.map_or(s, |n: f64| n.min(s)));
                }
            }
        }
    }
    nearest
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn the_nearest_hit_is_that_of_all_triangles_one_by_one(
        seed in any::<u64>(),
        (rows, cols) in (2_usize..40, 2_usize..40),
        resolution in 0.1_f64..2.0,
        rough in 0.0_f64..2.0,
        (x, y) in (-0.6_f64..0.6, -0.6_f64..0.6),
        height in -2.0_f64..4.0,
        (yaw, pitch) in (0.0_f64..6.3, -1.57_f64..1.57),
        snapped in 0_u8..4,
    ) {
        let mut stream = Stream::new(seed, &["ground"]);
        let h = Heightfield::new(rows, cols, resolution, (0..rows * cols).map(|_| stream.normal(0.0, rough)).collect());
        let (mut x, mut y, mut yaw) = (2.0 * x * h.half_x(), 2.0 * y * h.half_y(), yaw);
        // Some start on nodes and go along grid lines and diagonals.
        if snapped == 0 {
            x = ((x + h.half_x()) / resolution).round() * resolution - h.half_x();
            y = ((y + h.half_y()) / resolution).round() * resolution - h.half_y();
            yaw = (yaw / std::f64::consts::FRAC_PI_4).floor() * std::f64::consts::FRAC_PI_4;
        }
        let ((s, c), (up, flat)) = (vb_math::sin_cos(yaw), vb_math::sin_cos(pitch));
        let (origin, direction) = (V3::new(x, y, height), V3::new(flat * c, flat * s, up));
        let expected = brute_force(&h, &origin, &direction);
        let got = scene(h.clone(), vec![]).cast(&origin, &direction, 1e4, None).map(|h| h.distance);
        match (got, expected) {
            (None, None) => {}
            (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-6 * (1.0 + b), "{a} for {b}"),
            // At the very edge of the world rounding decides.
            (one, other) => {
                let t = one.or(other).unwrap_or(0.0);
                let at = origin + direction * t;
                let inside = h.half_x() - at.x.abs() > 1e-6 && h.half_y() - at.y.abs() > 1e-6;
                prop_assert!(!inside, "{one:?} for {other:?} at {at:?}");
            }
        }
    }

    #[test]
    fn a_fan_in_any_plane_hits_the_ground_where_its_rays_do_in_any_order(
        seed in any::<u64>(),
        rough in 0.0_f64..1.5,
        (x, y, height) in (-25.0_f64..25.0, -25.0_f64..25.0, -1.0_f64..4.0),
        (yaw, pitch, lean) in (0.0_f64..6.3, -0.5_f64..0.5, -1.0_f64..1.0),
        order in 0_u8..3,
    ) {
        let mut stream = Stream::new(seed, &["ground"]);
        let field = Heightfield::new(41, 41, 1.0, (0..41 * 41).map(|_| stream.normal(0.0, rough)).collect());
        let s = scene(field, vec![]);
        let turn = nalgebra::UnitQuaternion::from_euler_angles(lean, pitch, yaw);
        let origin = V3::new(x, y, height);
        let mut rises: Vec<i32> = (-15..15).collect();
        match order {
            0 => {}
            1 => rises.reverse(),
            _ => stream.shuffle(&mut rises),
        }
        let mut fan = s.fan(&origin, &(turn * V3::y()), &(turn * V3::x()), 80.0);
        for rise in rises {
            let (up, flat) = vb_math::sin_cos(0.06 * f64::from(rise));
            let direction = turn * V3::new(flat, 0.0, up);
            let (one, alone) = (fan.cast(&direction, None), s.cast(&origin, &direction, 80.0, None));
            prop_assert!(is_same(one, alone), "{one:?} for {alone:?}");
        }
    }

    #[test]
    fn a_boulder_is_hit_where_parry_hits_it(seed in 0_u64..1000, yaw in 0.0_f64..6.3, (a, b) in (0.0_f64..6.3, -1.5_f64..1.5)) {
        use parry3d_f64::math::Vector;
        use parry3d_f64::query::{Ray, RayCast};
        let kind = ObstacleKind::Boulder { size: [4.4, 4.0, 3.8], seed };
        let boulder = Obstacle { x: 3.0, y: -2.0, yaw, buried: 1.9, kind };
        // So deep below it that the ground is in no ray's way.
        let ground = Heightfield::flat(3, 3, 40.0, -1000.0);
        let s = scene(ground, vec![boulder]);
        let (sy, cy) = vb_math::sin_cos(yaw);
        let place = |v: &[f64; 3]| Vector::new(3.0 + cy * v[0] - sy * v[1], -2.0 + sy * v[0] + cy * v[1], v[2] - 1000.0);
        let hull = parry3d_f64::shape::ConvexPolyhedron::from_convex_hull(&boulder.hull().iter().map(place).collect::<Vec<_>>()).unwrap();
        let ((s1, c1), (s2, c2)) = (vb_math::sin_cos(a), vb_math::sin_cos(b));
        // From around it, past it by up to its size.
        let origin = V3::new(3.0 + 9.0 * c1 * c2, -2.0 + 9.0 * s1 * c2, -1000.0 + 9.0 * s2.abs() + 0.1);
        let direction = (V3::new(3.0 + s2, -2.0 + c1, -1000.0 + 0.8 * s1) - origin).normalize();
        let ray = Ray::new(Vector::new(origin.x, origin.y, origin.z), Vector::new(direction.x, direction.y, direction.z));
        let expected = hull.cast_local_ray(&ray, 100.0, false);
        let ours = s.cast(&origin, &direction, 100.0, None);
        // Below the middle the ground may come first.
        if let Some(t) = expected.filter(|t| origin.z + direction.z * t > -1000.0 + 1e-6) {
            let hit = ours.unwrap();
            prop_assert!((hit.distance - t).abs() < 1e-6, "{hit:?} for {t}");
            prop_assert_eq!(hit.surface, Surface::Obstacle(0));
        }
    }
}

/// The same hit but for rounding.
fn is_same(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.surface == b.surface && (a.distance - b.distance).abs() < 1e-6,
        (a, b) => a == b,
    }
}

#[test]
fn a_fan_hits_what_its_rays_hit_one_by_one() {
    let mut stream = Stream::new(4, &["fan"]);
    let field = Heightfield::new(81, 81, 1.0, (0..81 * 81).map(|_| stream.normal(0.0, 0.3)).collect());
    let boulders = (0..30)
        .map(|seed| Obstacle {
            x: stream.uniform(-35.0, 35.0),
            y: stream.uniform(-35.0, 35.0),
            yaw: stream.uniform(0.0, 6.0),
            buried: 1.0,
            kind: ObstacleKind::Boulder { size: [4.0, 3.0, 3.0], seed },
        })
        .collect();
    let s = scene(field, boulders);
    let origin = V3::new(1.3, 2.2, 2.5);
    let mut on_obstacles = 0;
    for col in 0..300 {
        let (sin, cos) = vb_math::sin_cos(0.021 * f64::from(col));
        // Planes that lean.
        let (forward, up) = (V3::new(cos, sin, 0.1 * cos).normalize(), V3::new(0.1, -0.2, 1.0));
        let normal = forward.cross(&up).normalize();
        let up = normal.cross(&forward);
        let mut fan = s.fan(&origin, &normal, &forward, 60.0);
        for row in -10..10 {
            let (rise, flat) = vb_math::sin_cos(0.03 * f64::from(row));
            let direction = forward * flat + up * rise;
            let hit = fan.cast(&direction, None);
            let alone = s.cast(&origin, &direction, 60.0, None);
            assert!(is_same(hit, alone), "{hit:?} for {alone:?}");
            on_obstacles += usize::from(hit.is_some_and(|h| h.surface != Surface::Ground));
        }
    }
    assert!(on_obstacles > 500, "{on_obstacles}");
}
