//! Damage done to worlds of the built-in suite, and what is said of it.

use super::*;
use std::path::PathBuf;
use tempfile::TempDir;
use vb_world::{Density, Elevation, Obstacle, ObstacleKind, Provenance, SuiteMeta};

/// The extents of its hull in `tasks/vehicles/hmmwv.yaml`.
const HMMWV: Vehicle = Vehicle { length: 4.66, width: 2.1 };

fn built_in(name: &str) -> Suite {
    let tasks = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
    Suite::open(tasks.join(name)).unwrap()
}

/// Low ground, rigid: nothing odd about it before it is damaged.
fn good() -> World {
    built_in("vb-paper").load_world("w001").unwrap()
}

fn write(worlds: &[World]) -> (TempDir, Suite) {
    let dir = tempfile::tempdir().unwrap();
    let meta = SuiteMeta {
        name: "damaged".into(),
        version: "1".into(),
        description: String::new(),
        provenance: Provenance::Authored { by: "a test".into() },
    };
    let suite = Suite::write(dir.path(), &meta, worlds).unwrap();
    (dir, suite)
}

fn findings(worlds: &[World]) -> Vec<Finding> {
    let (_dir, suite) = write(worlds);
    validate(&suite, &Limits::of(HMMWV), |_, _| {})
}

/// What is found in the built-in world after this damage.
fn after(damage: impl FnOnce(&mut World)) -> Vec<Finding> {
    let mut world = good();
    damage(&mut world);
    findings(&[world])
}

/// There is exactly one finding, and it says all of this.
fn only(found: &[Finding], severity: Severity, rule: Rule, says: &[&str]) {
    assert_eq!(found.len(), 1, "{found:#?}");
    let f = &found[0];
    assert_eq!((f.severity, f.rule, f.world.as_deref()), (severity, rule, Some("w001")), "{f:?}");
    for part in says {
        assert!(f.text.contains(part), "{part:?} is not in {}", f.text);
    }
    assert_eq!(f.text.lines().count(), 1);
}

fn cube(x: f64, y: f64, side: f64) -> Obstacle {
    Obstacle { x, y, yaw: 0.0, buried: 0.5 * side, kind: ObstacleKind::Box { size: [side; 3] } }
}

/// A flat spot of the built-in world, so that damage of one kind shows nothing else.
fn flat(world: &mut World) {
    let h = &world.heightfield;
    let heights = h.heights().iter().map(|z| 1.3 + 0.02 * (z - 1.3)).collect();
    world.heightfield = vb_world::Heightfield::new(h.rows(), h.cols(), h.resolution(), heights);
}

#[test]
fn the_built_in_suite_has_no_error_and_each_of_its_worlds_is_told() {
    let suite = built_in("smoke");
    let mut heard = Vec::new();
    let found = validate(&suite, &Limits::of(HMMWV), |world, _| heard.push(world.map(str::to_owned)));
    assert!(found.iter().all(|f| f.severity == Severity::Warning), "{found:#?}");
    let mut expected: Vec<_> = suite.worlds().iter().map(|w| Some(w.id.clone())).collect();
    expected.push(None);
    assert_eq!(heard, expected);
}

#[test]
fn all_flaws_of_a_world_are_told_and_worlds_after_it_are_checked() {
    let mut second = built_in("smoke").load_world("w002").unwrap();
    second.tasks[0].start.yaw += std::f64::consts::PI;
    second.tasks[0].start.yaw -= if second.tasks[0].start.yaw > 6.0 { std::f64::consts::TAU } else { 0.0 };
    let (dir, suite) = write(&[good(), second]);
    let file = dir.path().join("worlds/w001/tasks.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(
        &file,
        text.replace("goal: [60.0, 0.0]", "goal: [600.0, 0.0]").replace("goal: [-60.0", "goal: [-65.0"),
    )
    .unwrap();
    let found = validate(&suite, &Limits::of(HMMWV), |_, _| {});
    let texts: Vec<_> = found.iter().map(|f| (f.severity, f.rule, f.text.as_str())).collect();
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(texts[0].2.contains("tasks[0].goal: [-65.0"), "{texts:?}");
    assert!(texts[1].2.contains("tasks[5].goal: [600.0"), "{texts:?}");
    assert!(texts[..2].iter().all(|t| (t.0, t.1) == (Severity::Error, Rule::Format)));
    assert_eq!((texts[2].0, texts[2].1), (Severity::Warning, Rule::Ends));
    assert!(texts[2].2.contains("tasks[0] (t00).start.yaw: faces"), "{texts:?}");
}

#[test]
fn a_changed_world_is_told_by_its_hash_and_checked_all_the_same() {
    let (dir, suite) = write(&[good()]);
    let file = dir.path().join("worlds/w001/obstacles.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (head, rest) = text.split_once("buried: ").unwrap();
    let rest = rest.split_once(|c: char| c != '.' && !c.is_ascii_digit()).unwrap();
    let cut = &text[text.len() - rest.1.len() - 1..];
    std::fs::write(&file, format!("{head}buried: -0.5{cut}")).unwrap();
    let found = validate(&suite, &Limits::of(HMMWV), |_, _| {});
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].rule == Rule::Format && found[0].text.contains("content hash of w001"));
    assert!(found[1].text.contains("obstacles[0].buried: -0.5 lets it hang 0.50 m"), "{found:?}");
}

#[test]
fn a_start_or_goal_where_the_vehicle_touches_an_obstacle_is_an_error() {
    // Its edge lies 0.95 m beside the start's centre: the point is free, the vehicle of 2.1 m width is not, nor is the path.
    let found = after(|w| w.obstacles.push(cube(60.0, 1.7, 1.5)));
    let errors: Vec<_> = found.iter().filter(|f| f.rule == Rule::Ends).collect();
    // Start of t00, goal of t05.
    assert_eq!(errors.len(), 2, "{found:#?}");
    assert!(errors.iter().all(|f| f.severity == Severity::Error && f.text.contains("touches obstacles[")));
    assert!(
        errors[0].text.contains("tasks[0] (t00).start") && errors[1].text.contains("tasks[5] (t05).goal")
    );
}

#[test]
fn a_start_where_the_vehicle_stands_over_the_edge_is_an_error() {
    let found = after(|w| {
        w.tasks.truncate(1);
        w.tasks[0].start.x = 62.5;
        w.tasks[0].path.insert(0, [62.5, 0.0]);
        w.tasks[0].path.splice(1..1, [[61.6, 0.0], [60.8, 0.0]]);
    });
    only(&found, Severity::Error, Rule::Ends, &["tasks[0] (t00).start", "[64.83,", "outside the world"]);
}

#[test]
fn a_start_on_ground_too_steep_to_stand_on_is_an_error_and_one_too_slippery_a_warning() {
    let tilted = |grade: f64, mu: f64| {
        after(|w| {
            flat(w);
            let h = &w.heightfield;
            let z = |i: usize| (grade * (i % h.cols()) as f64).min(grade * 10.0) + h.heights()[i] - 1.3;
            let heights = (0..h.heights().len()).map(z).collect();
            w.heightfield = vb_world::Heightfield::new(h.rows(), h.cols(), h.resolution(), heights);
            w.semantics.friction.fill(mu);
            w.elevation = Elevation::High;
            // West to east only: it starts at x = -60, on the slope that ends at x = -54.
            w.tasks = w.tasks.split_off(5);
            w.tasks.truncate(1);
        })
        .into_iter()
        .filter(|f| f.rule == Rule::Ends)
        .collect::<Vec<_>>()
    };
    // atan 1.1 = 47.7°, beyond 45°; atan 0.65 = 33°, beyond 31°, the 60 % grade. Held by frictions of 1.2 and 0.9.
    let says = |tilt| ["tasks[0] (t05).start", tilt, "flatter"];
    only(&tilted(1.1, 1.2), Severity::Error, Rule::Ends, &says("is tilted by 47."));
    only(&tilted(0.65, 0.9), Severity::Warning, Rule::Ends, &says("is tilted by 33."));
    // atan 0.3 = 16.7°: fine for the vehicle, but 0.25 does not hold it; 0.35 does.
    only(&tilted(0.3, 0.25), Severity::Warning, Rule::Ends, &["slides off", "friction 0.25"]);
    assert!(tilted(0.3, 0.35).is_empty());
}

#[test]
fn a_path_through_an_obstacle_is_an_error_and_one_close_to_it_a_warning() {
    let near = |gap: f64| {
        after(|w| {
            w.obstacles.clear();
            w.density = Density::Sparse;
            w.tasks.truncate(1);
            let task = &mut w.tasks[0];
            task.path = (0..=120).map(|k| [60.0 - f64::from(k), 0.0]).collect();
            // Its edge lies `gap` beside the path.
            w.obstacles.push(cube(0.0, gap + 1.0, 2.0));
            // Enough of them, far away, for the label.
            w.obstacles.extend((0..10).map(|k| cube(-50.0 + 10.0 * f64::from(k), -40.0, 2.0)));
        })
    };
    assert!(near(3.5).is_empty(), "{:?}", near(3.5));
    only(
        &near(3.4),
        Severity::Warning,
        Rule::Path,
        &["tasks[0] (t00).path[", "obstacles[0] at 3.40 m", "3.5 m"],
    );
    only(
        &near(1.0),
        Severity::Error,
        Rule::Path,
        &["obstacles[0] at 1.00 m", "half the vehicle's width of 1.05 m"],
    );
}

#[test]
fn waypoints_too_far_apart_or_on_one_spot_and_a_path_along_the_edge_are_warned_of() {
    let mut gap = String::new();
    let found = after(|w| {
        w.tasks.truncate(1);
        let path = &mut w.tasks[0].path;
        path.remove(3);
        let [dx, dy] = [0, 1].map(|k| path[3][k] - path[2][k]);
        gap = format!("{:.2} m from the next waypoint", (dx * dx + dy * dy).sqrt());
    });
    only(&found, Severity::Warning, Rule::Path, &["path[2]", &gap, "put waypoints"]);
    let found = after(|w| {
        w.tasks.truncate(1);
        let twice = w.tasks[0].path[7];
        w.tasks[0].path.insert(7, twice);
    });
    only(&found, Severity::Warning, Rule::Path, &["path[7]", "is a duplicate"]);
    let found = after(|w| {
        flat(w);
        w.obstacles.truncate(0);
        w.obstacles.extend((0..11).map(|k| cube(-50.0 + 10.0 * f64::from(k), -40.0, 2.0)));
        w.tasks.truncate(1);
        let mut path: Vec<[f64; 2]> = (0..=63).map(|k| [60.0, f64::from(k)]).collect();
        path.extend((1..=120).map(|k| [60.0 - f64::from(k), 63.0]));
        path.extend((1..=63).map(|k| [-60.0, 63.0 - f64::from(k)]));
        w.tasks[0].path = path;
        w.tasks[0].start.yaw = 1.57;
    });
    only(&found, Severity::Warning, Rule::Path, &["path[63]", "closer to the world's edge", "inwards"]);
}

#[test]
fn a_steep_place_on_a_path_is_warned_of_beyond_the_limit_only() {
    let world = good();
    let (_dir, suite) = write(&[world]);
    let steep = |tilt| {
        validate(&suite, &Limits { tilt, ..Limits::of(HMMWV) }, |_, _| {})
            .into_iter()
            .filter(|f| f.text.contains("tilts the vehicle by"))
            .count()
    };
    assert_eq!(steep(45.0), 0);
    assert_eq!(steep(0.5), 10, "one a task: its steepest place");
}

#[test]
fn obstacles_that_overlap_hang_or_are_hidden_are_warned_of() {
    let with = |more: Vec<Obstacle>| {
        after(|w| {
            w.obstacles = (0..10).map(|k| cube(-50.0 + 10.0 * f64::from(k), -40.0, 2.0)).collect();
            w.obstacles.extend(more);
            w.tasks.truncate(1);
            w.tasks[0].path = (0..=120).map(|k| [60.0 - f64::from(k), 0.0]).collect();
        })
    };
    assert!(with(vec![]).is_empty(), "{:?}", with(vec![]));
    only(
        &with(vec![cube(-49.0, -39.0, 2.0)]),
        Severity::Warning,
        Rule::Obstacles,
        &["obstacles[0]: overlaps obstacles[10]"],
    );
    let hanging = Obstacle { buried: -0.75, ..cube(55.0, -40.0, 2.0) };
    only(&with(vec![hanging]), Severity::Warning, Rule::Obstacles, &["obstacles[10].buried", "hang 0.75 m"]);
    let hidden = Obstacle { buried: 2.0, ..hanging };
    only(&with(vec![hidden]), Severity::Warning, Rule::Obstacles, &["obstacles[10].buried", "buries all"]);
}

#[test]
fn labels_that_the_world_belies_are_warned_of() {
    // The world is low (0.17 m) and sparse (11 obstacles).
    let found = after(|w| w.elevation = Elevation::High);
    only(&found, Severity::Warning, Rule::Labels, &["world.yaml: elevation: high is unusual", "too flat"]);
    let found = after(|w| w.density = Density::Dense);
    only(
        &found,
        Severity::Warning,
        Rule::Labels,
        &["world.yaml: density: dense is unusual for 11 obstacles", "43"],
    );
    let high = built_in("smoke").load_world("w003").unwrap();
    assert_eq!(high.elevation, Elevation::High);
    let found = findings(&[World { id: "w001".into(), elevation: Elevation::Low, ..high }]);
    only(&found, Severity::Warning, Rule::Labels, &["low is unusual", "too rugged"]);
}

#[test]
fn worlds_and_tasks_that_are_there_twice_are_told() {
    let twin = World { id: "w002".into(), ..good() };
    let found = findings(&[good(), twin.clone()]);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].severity == Severity::Error && found[0].text.contains("those of w001"), "{found:?}");
    let mut sibling = twin;
    sibling.tasks.truncate(4);
    let found = findings(&[good(), sibling]);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].severity == Severity::Warning && found[0].text.contains("has the heights of w001"));
    let found = after(|w| {
        let again = vb_world::Task { id: "t99".into(), ..w.tasks[2].clone() };
        w.tasks.push(again);
    });
    only(&found, Severity::Warning, Rule::Content, &["tasks[10] (t99)", "start and goal of t02"]);
}

#[test]
fn what_is_missing_or_not_listed_is_told() {
    let found = after(|w| w.tasks.clear());
    only(&found, Severity::Warning, Rule::Content, &["tasks.yaml: tasks: is empty"]);
    let (dir, suite) = write(&[good()]);
    std::fs::create_dir(dir.path().join("worlds/w077")).unwrap();
    let found = validate(&suite, &Limits::of(HMMWV), |_, _| {});
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].world.is_none() && found[0].text.contains("worlds/w077"));
    assert!(findings(&[])[0].text.contains("is empty"));
    std::fs::remove_file(dir.path().join("worlds/w001/elevation.png")).unwrap();
    let found = validate(&suite, &Limits::of(HMMWV), |_, _| {});
    assert!(
        found[0].rule == Rule::Format && found[0].text.contains("elevation.png: cannot read"),
        "{found:?}"
    );
}

#[test]
fn many_findings_of_a_kind_are_counted_not_listed() {
    let found = after(|w| w.obstacles.iter_mut().for_each(|o| o.buried = -0.1));
    // 11 obstacles: ten lines and the rest.
    assert_eq!(found.len(), SHOWN + 1, "{found:#?}");
    assert!(found[SHOWN].text.contains("1 more finding of the rule obstacles"), "{found:?}");
}

#[test]
fn a_changed_suite_under_the_name_and_version_of_a_released_one_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let meta = |version: &str| SuiteMeta {
        name: "smoke".into(),
        version: version.into(),
        description: String::new(),
        provenance: Provenance::Authored { by: "a test".into() },
    };
    let suite = |version| Suite::write(dir.path().join(version), &meta(version), &[good()]).unwrap();
    let found = validate(&suite("3"), &Limits::of(HMMWV), |_, _| {});
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!((found[0].severity, found[0].rule), (Severity::Error, Rule::Content));
    assert!(found[0].text.contains("smoke 3 was released with the hash"), "{}", found[0].text);
    assert_eq!(validate(&suite("3-mine"), &Limits::of(HMMWV), |_, _| {}), []);
}
