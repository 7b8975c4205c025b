//! The in-memory model: scaling and occupancy.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use vb_world::{
    Density, Elevation, Heightfield, Obstacle, ObstacleKind, Pose2, Semantics, Task, Terrain, TerrainClass,
    World,
};

fn world(obstacles: Vec<Obstacle>) -> World {
    let heights: Vec<f64> = (0..81).map(|k| f64::from(k * k % 23) * 0.1).collect();
    World {
        id: "w001".into(),
        elevation: Elevation::Low,
        terrain: Terrain::Rigid,
        density: Density::Sparse,
        scale: 1.0,
        heightfield: Heightfield::new(9, 9, 1.0, heights),
        semantics: Semantics {
            rows: 2,
            cols: 2,
            patch: 4.0,
            classes: vec![TerrainClass::Clay, TerrainClass::Rock, TerrainClass::Wood, TerrainClass::Dirt],
            friction: vec![0.5, 0.6, 0.7, 0.8],
            soil: vb_world::SoilLevels::default(),
        },
        obstacles,
        beds: Vec::new(),
        tasks: vec![Task {
            id: "t00".into(),
            start: Pose2 { x: -3.5, y: -1.0, yaw: 0.3 },
            goal: [3.0, 3.5],
            path: vec![[-3.5, -1.0], [0.0, 3.0], [3.0, 3.5]],
        }],
    }
}

fn obstacles() -> Vec<Obstacle> {
    vec![
        Obstacle {
            x: 1.0,
            y: -2.0,
            yaw: 0.7,
            buried: 0.4,
            kind: ObstacleKind::Boulder { size: [1.2, 1.1, 0.9], seed: 5 },
        },
        Obstacle {
            x: -1.0,
            y: 2.0,
            yaw: 0.0,
            buried: 0.2,
            kind: ObstacleKind::Box { size: [1.0, 2.0, 1.5] },
        },
        Obstacle {
            x: 0.0,
            y: 0.0,
            yaw: 1.0,
            buried: 1.0,
            kind: ObstacleKind::Trunk { radius: 0.3, height: 2.5 },
        },
    ]
}

#[test]
fn scaling_multiplies_every_length_and_nothing_else() {
    let (w, s) = (world(obstacles()), 1.0 / 6.0);
    let v = w.scaled(s);
    v.check().unwrap();
    let ratio = |a: f64, b: f64| assert!((b - a * s).abs() <= 1e-15 + 1e-12 * a.abs(), "{a} -> {b}");
    assert_eq!(v.scale, s);
    ratio(w.heightfield.resolution(), v.heightfield.resolution());
    ratio(w.semantics.patch, v.semantics.patch);
    for (a, b) in w.heightfield.heights().iter().zip(v.heightfield.heights()) {
        ratio(*a, *b);
    }
    for (a, b) in w.obstacles.iter().zip(&v.obstacles) {
        assert_eq!(a.yaw, b.yaw);
        ratio(a.base_z(&w.heightfield), b.base_z(&v.heightfield));
        for (p, q) in [(a.x, b.x), (a.y, b.y), (a.buried, b.buried)]
            .into_iter()
            .chain(a.size().into_iter().zip(b.size()))
        {
            ratio(p, q);
        }
        for (p, q) in a.hull().iter().flatten().zip(b.hull().iter().flatten()) {
            ratio(*p, *q);
        }
        for (p, q) in a.footprint().iter().flatten().zip(b.footprint().iter().flatten()) {
            ratio(*p, *q);
        }
    }
    let (a, b) = (&w.tasks[0], &v.tasks[0]);
    assert_eq!(a.start.yaw, b.start.yaw);
    let points = |t: &Task| [vec![[t.start.x, t.start.y], t.goal], t.path.clone()].concat();
    for (p, q) in points(a).iter().flatten().zip(points(b).iter().flatten()) {
        ratio(*p, *q);
    }
    for (x, y) in [(-3.3, 2.1), (0.1, 0.3), (3.9, -3.6)] {
        assert_eq!(w.friction_at(x, y), v.friction_at(x * s, y * s));
        assert_eq!(w.class_at(x, y), v.class_at(x * s, y * s));
        let (p, q) = (w.heightfield.at(x, y), v.heightfield.at(x * s, y * s));
        assert!((p.dzdx - q.dzdx).abs() < 1e-9 && (p.dzdy - q.dzdy).abs() < 1e-9, "slopes are angles");
    }
    assert_eq!(v.scaled(0.5).scale, s * 0.5);
    assert_eq!((w.clone().at_scale(1.0), w.clone().at_scale(s)), (w, v));
}

#[test]
fn occupancy_marks_each_square_that_a_footprint_overlaps_and_no_other() {
    // A box of 1 × 2 m at (-1, 2) covers x in [-1.5, -0.5], y in [1, 3]: at 0.5 m that is columns 5, 6 (squares
    // from -1.5 to -0.5) and rows 10 to 13 (from 1.0 to 3.0) of a raster that begins at -4.
    let cube = obstacles()[1];
    let raster = world(vec![cube]).occupancy(0.5);
    assert_eq!((raster.rows, raster.cols, raster.origin), (16, 16, [-3.75, -3.75]));
    for row in 0..16 {
        for col in 0..16 {
            let expected = u8::from((10..14).contains(&row) && (5..7).contains(&col));
            assert_eq!(raster.get(row, col), expected, "{row} {col}");
        }
    }
    // Shifted by a tenth of a square it also covers a part of the next column.
    let raster = world(vec![Obstacle { x: cube.x + 0.05, ..cube }]).occupancy(0.5);
    assert_eq!(raster.data.iter().filter(|&&v| v == 1).count(), 12);
}

#[test]
fn occupancy_agrees_with_sampling_the_footprints() {
    let w = world(obstacles());
    let raster = w.occupancy(0.1);
    assert_eq!((raster.rows, raster.cols), (80, 80));
    let outlines: Vec<_> = w.obstacles.iter().map(Obstacle::footprint).collect();
    for row in 0..raster.rows {
        for col in 0..raster.cols {
            let c = raster.centre(row, col);
            assert_eq!(raster.cell(c[0], c[1]), Some((row, col)));
            let hit = |p: [f64; 2]| outlines.iter().any(|o| vb_world::geometry::contains(o, p));
            let samples = (0..121)
                .map(|k| [c[0] + 0.0098 * f64::from(k % 11 - 5), c[1] + 0.0098 * f64::from(k / 11 - 5)]);
            let sampled = samples.into_iter().any(hit);
            if sampled {
                assert_eq!(raster.get(row, col), 1, "{c:?} holds a point of a footprint");
            }
            let near = outlines.iter().any(|o| vb_world::geometry::point_to_polygon(c, o) < 0.0708);
            if !near {
                assert_eq!(raster.get(row, col), 0, "{c:?} is farther than half a diagonal");
            }
        }
    }
}

#[test]
fn a_square_count_is_not_raised_by_rounding() {
    let mut w = world(Vec::new());
    w.heightfield = Heightfield::flat(129, 129, 1.0, 0.0);
    for (resolution, n) in [(1.0, 128), (0.1, 1280), (0.5, 256), (0.3, 427)] {
        assert_eq!(w.occupancy(resolution).cols, n, "{resolution}");
    }
    assert_eq!(w.occupancy(1.0).cell(64.1, 0.0), None);
    assert!(w.is_rigid());
}
