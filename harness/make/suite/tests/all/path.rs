//! The global planner against geometry that can be worked out by hand.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use vb_math::rng::Stream;
use vb_suite::path::{PathError, PathParams, Planner, length, plan};
use vb_world::{
    Density, Elevation, Heightfield, Obstacle, ObstacleKind, Semantics, Terrain, TerrainClass, World,
    geometry,
};

fn world(obstacles: Vec<Obstacle>) -> World {
    World {
        id: "w001".into(),
        elevation: Elevation::Low,
        terrain: Terrain::Rigid,
        density: Density::Sparse,
        scale: 1.0,
        heightfield: Heightfield::flat(129, 129, 1.0, 0.0),
        semantics: Semantics {
            rows: 1,
            cols: 1,
            patch: 128.0,
            classes: vec![TerrainClass::Clay],
            friction: vec![0.6],
            soil: vb_world::SoilLevels::default(),
        },
        obstacles,
        tasks: Vec::new(),
        beds: Vec::new(),
    }
}

fn wall(x: f64, y: f64, size_x: f64, size_y: f64) -> Obstacle {
    Obstacle { x, y, yaw: 0.0, buried: 0.0, kind: ObstacleKind::Box { size: [size_x, size_y, 2.0] } }
}

/// Least distance from the path to any obstacle, m.
fn clearance(world: &World, path: &[[f64; 2]]) -> f64 {
    let outlines: Vec<_> = world.obstacles.iter().map(Obstacle::footprint).collect();
    path.windows(2)
        .flat_map(|w| outlines.iter().map(|o| geometry::segment_to_polygon(w[0], w[1], o)))
        .fold(f64::INFINITY, f64::min)
}

/// A clearance for which the figures of these tests were worked out.
fn narrow() -> PathParams {
    PathParams { clearance: 2.5, ..PathParams::default() }
}

#[test]
fn a_free_way_is_straight_with_even_waypoints() {
    let path = plan(&world(vec![wall(0.0, 20.0, 5.0, 5.0)]), [-30.0, 0.0], [30.0, 0.0], &narrow()).unwrap();
    assert_eq!(path.len(), 61);
    for (k, p) in path.iter().enumerate() {
        assert!((p[0] - (k as f64 - 30.0)).abs() < 1e-9 && p[1].abs() < 1e-9, "{p:?}");
    }
}

#[test]
fn the_way_round_a_round_obstacle_is_as_long_as_its_tangents_and_arc() {
    // Around a disc of radius R = trunk + clearance, from distance d on either side: two tangents of √(d² - R²) and
    // an arc of R (π - 2 acos(R / d)). The trunk's prism is up to 3.4 % thinner than its cylinder; the grid's
    // points leave the path a little longer than the optimum.
    let kind = ObstacleKind::Trunk { radius: 5.0, height: 3.0 };
    let w = world(vec![Obstacle { x: 0.0, y: 0.0, yaw: 0.0, buried: 0.0, kind }]);
    let (r, d) = (7.5, 30.0f64);
    let shortest = 2.0 * (d * d - r * r).sqrt() + r * (std::f64::consts::PI - 2.0 * vb_math::acos(r / d));
    for turn in [0.0, 0.4, 1.1, 2.0] {
        let (s, c) = vb_math::sin_cos(turn);
        let path = plan(&w, [d * c, d * s], [-d * c, -d * s], &narrow()).unwrap();
        let long = length(&path);
        assert!(long > 0.995 * shortest && long < 1.01 * shortest, "{long} m, shortest {shortest} m");
        assert!(clearance(&w, &path) > 2.499);
    }
}

#[test]
fn a_trap_is_left_and_the_gap_that_is_wide_enough_is_used() {
    // A pocket open to the west around the start's straight line, and a wall with a gap of 4.9 m (too narrow for a
    // clearance of 2.5 m on both sides) at y = 0 and one of 5.2 m at y = 30.
    let mut obstacles =
        vec![wall(-10.0, 8.0, 20.0, 1.0), wall(-10.0, -8.0, 20.0, 1.0), wall(0.0, 0.0, 1.0, 17.0)];
    obstacles.extend([
        wall(20.0, -33.225, 2.0, 61.55),
        wall(20.0, 14.925, 2.0, 24.95),
        wall(20.0, 48.3, 2.0, 31.4),
    ]);
    let w = world(obstacles);
    let path = plan(&w, [-10.0, 0.0], [40.0, 0.0], &narrow()).unwrap();
    assert!(clearance(&w, &path) > 2.499, "{}", clearance(&w, &path));
    let crossing = path.windows(2).find(|p| p[0][0] < 20.0 && p[1][0] >= 20.0).unwrap();
    assert!((crossing[0][1] - 30.0).abs() < 1.5, "{crossing:?}");
}

#[test]
fn random_fields_are_crossed_with_the_clearance_and_close_to_the_straight_line() {
    for seed in 0..20 {
        let mut rng = Stream::new(seed, &["field"]);
        let mut obstacles: Vec<Obstacle> = Vec::new();
        while obstacles.len() < 60 {
            let (x, y) = (rng.uniform(-60.0, 60.0), rng.uniform(-50.0, 50.0));
            if obstacles.iter().all(|o| vb_math::hypot(o.x - x, o.y - y) > 9.0) && x.abs() < 50.0 {
                let size = [rng.uniform(2.0, 5.0), rng.uniform(2.0, 5.0), 2.0];
                let kind = ObstacleKind::Boulder { size, seed: rng.next_u64() };
                obstacles.push(Obstacle { x, y, yaw: rng.uniform(-3.0, 3.0), buried: 1.0, kind });
            }
        }
        let w = world(obstacles);
        let (start, goal) = ([-58.0, rng.uniform(-40.0, 40.0)], [58.0, rng.uniform(-40.0, 40.0)]);
        let path = plan(&w, start, goal, &PathParams { clearance: 1.5, ..narrow() }).unwrap();
        assert!(clearance(&w, &path) > 1.499, "seed {seed}: {}", clearance(&w, &path));
        assert_eq!((path[0], path[path.len() - 1]), (start, goal));
        assert!(path.windows(2).all(|p| length(p) <= 1.002));
        let straight = vb_math::hypot(goal[0] - start[0], goal[1] - start[1]);
        assert!(length(&path) < 1.12 * straight, "seed {seed}: {} of {straight}", length(&path));
    }
}

#[test]
fn a_scaled_world_has_the_scaled_path() {
    let w = world(vec![wall(0.0, 1.0, 6.0, 9.0), wall(12.0, -3.0, 4.0, 8.0)]);
    let path = plan(&w, [-40.0, 0.0], [40.0, 0.0], &narrow()).unwrap();
    // A power of two scales every bit pattern exactly.
    let s = 0.125;
    let small = plan(&w.scaled(s), [-5.0, 0.0], [5.0, 0.0], &narrow()).unwrap();
    assert_eq!(path.len(), small.len());
    for (a, b) in path.iter().zip(&small) {
        assert!((a[0] * s - b[0]).abs() < 1e-9 && (a[1] * s - b[1]).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn what_cannot_be_planned_says_why() {
    let ring: Vec<_> = (0..24)
        .map(|k| {
            let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * f64::from(k) / 24.0);
            wall(40.0 + 12.0 * c, 12.0 * s, 3.0, 3.0)
        })
        .collect();
    let w = world(ring);
    let params = narrow();
    let message = |start, goal| plan(&w, start, goal, &params).unwrap_err().to_string();
    let no_way = message([-40.0, 0.0], [40.0, 0.0]);
    assert!(no_way.contains("no path from [-40.0, 0.0] to [40.0, 0.0] has a clearance of 2.5 m"), "{no_way}");
    let close = message([-40.0, 0.0], [52.0, 3.0]);
    assert!(close.contains("goal [52.0, 3.0] is 1.50 m from obstacles[0]"), "{close}");
    let outside = message([-70.0, 0.0], [0.0, 0.0]);
    assert!(outside.contains("start [-70.0, 0.0] lies outside the world"), "{outside}");
    assert!(message([f64::NAN, 0.0], [0.0, 0.0]).contains("lies outside the world"));
    for (field, bad) in [
        ("grid", PathParams { grid: 0.0, ..params.clone() }),
        ("spacing", PathParams { spacing: f64::NAN, ..params.clone() }),
        ("clearance", PathParams { clearance: -1.0, ..params.clone() }),
    ] {
        let error = Planner::new(&w, &bad).err().unwrap();
        assert!(matches!(error, PathError::Parameter { field: f, .. } if f == field), "{error}");
    }
}
