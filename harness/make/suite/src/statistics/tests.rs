//! Figures of small worlds that can be worked out by hand.

use super::*;
use vb_world::{Heightfield, Obstacle, ObstacleKind, Pose2, Semantics, SoilLevels, SuiteMeta, Task};

fn task(id: &str, path: &[[f64; 2]]) -> Task {
    let (start, goal) = (path[0], path[path.len() - 1]);
    Task { id: id.into(), start: Pose2 { x: start[0], y: start[1], yaw: 0.0 }, goal, path: path.to_vec() }
}

/// 8 m x 8 m at 1 m: a plane that rises eastwards by one half; a box of 2 m, half in the ground, 3 m south of the x axis.
fn plane() -> World {
    let heights = (0..81).map(|i| 0.5 * f64::from(i % 9)).collect();
    let mut world = World::uniform("w001", Heightfield::new(9, 9, 1.0, heights), TerrainClass::Clay, 0.6);
    let kind = ObstacleKind::Box { size: [2.0, 1.0, 2.0] };
    world.obstacles = vec![Obstacle { x: 0.0, y: -3.0, yaw: 0.0, buried: 0.5, kind }];
    world.tasks = vec![task("t00", &[[-3.0, 0.0], [1.0, 3.0], [1.0, 0.0]])];
    world
}

/// Level ground in four patches: mud, clay, clay, rock.
fn patches() -> World {
    let mut world = World::uniform("w002", Heightfield::flat(9, 9, 1.0, 2.0), TerrainClass::Clay, 0.5);
    world.elevation = Elevation::High;
    world.terrain = Terrain::Mixed;
    world.semantics = Semantics {
        rows: 2,
        cols: 2,
        patch: 4.0,
        classes: vec![TerrainClass::Mud, TerrainClass::Clay, TerrainClass::Clay, TerrainClass::Rock],
        friction: vec![0.0, 0.4, 0.8, 0.7],
        soil: SoilLevels { mud: SoilLevel::Hard, ..SoilLevels::default() },
    };
    world
}

#[test]
fn a_plane_has_one_slope_and_the_spread_of_its_steps() {
    let w = WorldStatistics::of(&plane());
    // Nine columns at 0, 0.5 … 4: mean 2, variance (9² − 1) / 12 · 0.25 = 5 / 3.
    assert!((w.height_mean - 2.0).abs() < 1e-12);
    assert!((w.height_std - (5.0f64 / 3.0).sqrt()).abs() < 1e-12);
    assert_eq!((w.relief, w.extent), (4.0, [8.0, 8.0]));
    // atan(1/2) = 26.565°.
    for slope in [w.slopes.p50, w.slopes.p95, w.slopes.p99, w.slopes.max] {
        assert!((slope - 26.565).abs() < 0.0051, "{slope}");
    }
}

#[test]
fn slopes_are_taken_over_a_metre_whatever_the_resolution() {
    // Ridges 2 m apart on a grid of 0.25 m: from 1 m west to 1 m east the ground is level, from node to node it is not.
    let heights = (0..81 * 81).map(|i| if i % 81 % 8 < 4 { 0.1 } else { -0.1 }).collect();
    let ripples = World::uniform("w001", Heightfield::new(81, 81, 0.25, heights), TerrainClass::Clay, 0.6);
    assert_eq!(WorldStatistics::of(&ripples).slopes.max, 0.0);
}

#[test]
fn a_task_has_the_figures_of_its_path() {
    let w = WorldStatistics::of(&plane());
    let t = &w.tasks[0];
    // 4 m straight; 5 m (a 3-4-5 triangle) and 3 m driven; the box ends at y = -2.5, the path at y = 0.
    assert_eq!((t.straight, t.length, t.ratio, t.clearance), (4.0, 8.0, 2.0, Some(2.5)));
    // 4 m eastwards rise by 2 m over 5 m: atan(0.4) = 21.801°; northwards the plane is level.
    assert_eq!(t.ascent, 2.0);
    assert!((t.steepest - 21.801).abs() < 1e-3, "{}", t.steepest);
    assert_eq!((w.obstacles, w.covered), (Kinds { boxes: 1, ..Kinds::default() }, 2.0 / 64.0));
}

#[test]
fn classes_have_their_share_of_the_area_and_soil_its_level() {
    let w = WorldStatistics::of(&patches());
    let fractions: Vec<_> = w.classes.iter().map(|c| (c.class, c.fraction, c.soil)).collect();
    let expected = [
        (TerrainClass::Clay, 0.5, None),
        (TerrainClass::Rock, 0.25, None),
        (TerrainClass::Mud, 0.25, Some(SoilLevel::Hard)),
    ];
    assert_eq!(fractions, expected);
    let friction = w.friction.unwrap();
    assert_eq!((friction.count, friction.min, friction.max), (3, 0.4, 0.8));
}

#[test]
fn a_suite_adds_its_worlds_up_by_label_class_and_density() {
    let dir = tempfile::tempdir().unwrap();
    let meta = SuiteMeta {
        name: "two".into(),
        version: "1".into(),
        description: String::new(),
        provenance: Provenance::Authored { by: "hand".into() },
    };
    let suite = Suite::write(dir.path(), &meta, &[plane(), patches()]).unwrap();
    let s = SuiteStatistics::of(&suite).unwrap();
    assert_eq!((s.world_count, s.task_count, s.hash.clone()), (2, 1, suite.hash()));
    assert_eq!(s.provenance, "authored by hand");
    assert_eq!(s.cells.len(), 27);
    let filled: Vec<_> =
        s.cells.iter().filter(|c| c.worlds > 0).map(|c| (c.elevation, c.terrain, c.worlds)).collect();
    assert_eq!(filled, [(Elevation::Low, Terrain::Rigid, 1), (Elevation::High, Terrain::Mixed, 1)]);
    assert_eq!(s.relief.iter().map(|r| r.elevation).collect::<Vec<_>>(), [Elevation::Low, Elevation::High]);
    // Clay: 64 m² at 0.6, 16 m² at 0.4 and at 0.8 of 128 m²: share 0.75, mean 0.6, variance 32 · 0.04 / 96.
    let clay = &s.classes[0];
    let f = clay.friction.unwrap();
    assert_eq!((clay.class, clay.worlds, clay.fraction), (TerrainClass::Clay, 2, 0.75));
    assert!((f.mean - 0.6).abs() < 1e-12 && (f.std - (0.04f64 / 3.0).sqrt()).abs() < 1e-9, "{f:?}");
    assert_eq!((f.min, f.max), (0.4, 0.8));
    let mud = s.classes.iter().find(|c| c.class == TerrainClass::Mud).unwrap();
    assert_eq!((mud.soil, mud.friction), (Some([0, 0, 1]), None));
    // One sparse world has the box: 2 m wide, 1.5 m above the ground.
    let o = &s.obstacles[0];
    assert_eq!((o.density, o.worlds, o.kinds.boxes), (Density::Sparse, 2, 1));
    assert_eq!((o.per_world.mean, o.width.unwrap().max, o.height.unwrap().max), (0.5, 2.0, 1.5));
    assert_eq!(s.tasks.as_ref().unwrap().ratio.max, 2.0);
    assert_eq!(s.tasks_by_density.len(), 1);
}

#[test]
fn a_suite_without_worlds_has_empty_figures() {
    let dir = tempfile::tempdir().unwrap();
    let meta = SuiteMeta {
        name: "none".into(),
        version: "1".into(),
        description: String::new(),
        provenance: Provenance::Authored { by: "hand".into() },
    };
    let suite = Suite::write(dir.path(), &meta, &[]).unwrap();
    let s = SuiteStatistics::of(&suite).unwrap();
    assert!(s.tasks.is_none() && s.relief.is_empty() && s.classes.is_empty());
    assert!(s.cells.iter().all(|c| c.worlds == 0));
}
