//! Task selectors on a suite of twelve worlds.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use vb_world::{
    Density, Elevation, Heightfield, Pose2, Provenance, Selector, Semantics, Suite, SuiteMeta, Task, Terrain,
    TerrainClass, World,
};

/// Worlds w001 to w012 with three tasks each (w012 has a fourth); elevation and density have all nine pairs in w001
/// to w009, w010 is deformable.
fn suite() -> (tempfile::TempDir, Suite) {
    let task = |k: usize| Task {
        id: format!("t{k:02}"),
        start: Pose2 { x: -1.0, y: 0.0, yaw: 0.0 },
        goal: [1.0, 0.0],
        path: vec![[-1.0, 0.0], [1.0, 0.0]],
    };
    let world = |k: usize| {
        let soft = k == 9;
        World {
            id: format!("w{:03}", k + 1),
            elevation: Elevation::ALL[k % 3],
            terrain: if soft { Terrain::Deformable } else { Terrain::Rigid },
            density: Density::ALL[k / 3 % 3],
            scale: 1.0,
            heightfield: Heightfield::flat(3, 3, 1.0, 0.0),
            semantics: Semantics {
                rows: 1,
                cols: 1,
                patch: 2.0,
                classes: vec![if soft { TerrainClass::Mud } else { TerrainClass::Clay }],
                friction: vec![if soft { 0.0 } else { 0.6 }],
                soil: vb_world::SoilLevels::default(),
            },
            obstacles: Vec::new(),
            tasks: (0..if k == 11 { 4 } else { 3 }).map(task).collect(),
            beds: Vec::new(),
        }
    };
    let dir = tempfile::tempdir().unwrap();
    let meta = SuiteMeta {
        name: "dozen".into(),
        version: "1".into(),
        description: String::new(),
        provenance: Provenance::Authored { by: "a test".into() },
    };
    let suite = Suite::write(dir.path(), &meta, &(0..12).map(world).collect::<Vec<_>>()).unwrap();
    (dir, suite)
}

fn select(suite: &Suite, text: &str) -> Result<String, String> {
    let chosen = Selector::parse(text).and_then(|s| s.select(suite)).map_err(|e| e.to_string())?;
    Ok(chosen.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))
}

#[test]
fn selectors_choose_in_the_order_of_the_suite_and_nothing_twice() {
    let (_dir, suite) = suite();
    let cases = [
        ("w001/t02", "w001/t02"),
        ("w003/t01,w001/t02,w001/t02", "w001/t02 w003/t01"),
        ("w002", "w002/t00 w002/t01 w002/t02"),
        ("w002-w004/t00", "w002/t00 w003/t00 w004/t00"),
        ("w004-w002/t00", "w002/t00 w003/t00 w004/t00"),
        ("w001/t01-t02", "w001/t01 w001/t02"),
        ("w01*/t00", "w010/t00 w011/t00 w012/t00"),
        ("w*/t03", "w012/t03"),
        ("w001-w002, w002/t00", "w001/t00 w001/t01 w001/t02 w002/t00 w002/t01 w002/t02"),
        ("terrain=deformable", "w010/t00 w010/t01 w010/t02"),
        // Different keys must hold together, in whichever order.
        ("elevation=high,density=dense", "w009/t00 w009/t01 w009/t02"),
        ("density=dense, elevation=high", "w009/t00 w009/t01 w009/t02"),
        ("elevation=high,w*/t00", "w003/t00 w006/t00 w009/t00 w012/t00"),
        ("w001-w006,elevation=low,density=sparse", "w001/t00 w001/t01 w001/t02"),
        // Conditions of one key are alternatives, also where another key stands between them.
        ("density=dense,elevation=high,w*/t00,elevation=low", "w007/t00 w009/t00"),
        ("w001/t01,elevation=low,w004-w009/t00", "w001/t01 w004/t00 w007/t00"),
    ];
    for (text, expected) in cases {
        assert_eq!(select(&suite, text).as_deref(), Ok(expected), "{text}");
    }
    let all = Selector::default().select(&suite).unwrap();
    assert_eq!(all.len(), 37);
    assert_eq!(Selector::parse("*").unwrap().select(&suite).unwrap(), all);
}

#[test]
fn what_does_not_exist_is_named_with_what_does() {
    let (_dir, suite) = suite();
    let cases = [
        ("w099", "\"w099\": no world \"w099\" in suite \"dozen\"; there are w001, w002"),
        ("w001-w099", "no world \"w099\""),
        ("w001,x*", "\"x*\": no world \"x*\""),
        ("w001/t03", "\"w001/t03\": no task \"t03\" in suite \"dozen\"; there are t00, t01, t02"),
        ("t03", "no world \"t03\""),
        ("colour=red", "\"colour\" is no key: use elevation, terrain or density"),
        ("elevation=steep", "\"steep\" is no elevation: use low, medium, high"),
        (
            "terrain=mixed",
            "\"terrain=mixed\" matches none of the 37 tasks of suite \"dozen\"; it has elevation=low|medium|high, terrain=rigid|deformable,",
        ),
        ("w001,elevation=high", "\"w001,elevation=high\" matches none of the 37 tasks"),
        // Each condition must choose a task, although an alternative does.
        ("terrain=rigid,terrain=mixed", "\"terrain=mixed\" matches none"),
        (
            "elevation=high:terrain=rigid",
            "write \"elevation=high,terrain=rigid\", with commas instead of colons",
        ),
        ("w001:w002/t00,w003", "write \"w001,w002/t00\", with commas"),
        (
            "elevation=high&terrain=rigid",
            "different keys must hold together, as in elevation=high,terrain=rigid",
        ),
        ("", "\"\": \"\" names nothing: write w001"),
        ("w001,,w002", "\"\" names nothing"),
        ("w001/", "\"w001/\": \"\" names nothing"),
        ("W001", "\"W001\" names nothing"),
        ("w001/t01/t02", "\"t01/t02\" names nothing"),
    ];
    for (text, expected) in cases {
        let message = select(&suite, text).unwrap_err();
        assert!(message.contains(expected), "{text}: {message}\nlacks {expected}");
    }
}

#[test]
fn levels_of_the_default_suite_are_intersected_between_keys_and_united_within_one() {
    let tasks = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
    let suite = Suite::open(tasks.join("vb-100")).unwrap();
    let count = |text: &str| Selector::parse(text).unwrap().select(&suite).unwrap().len();
    // docs/worlds.md has the first two numbers.
    assert_eq!(count("elevation=high,terrain=rigid"), 200);
    let (low, medium) = (count("elevation=low"), count("elevation=medium"));
    assert_eq!((low, medium), (340, 330));
    assert_eq!(count("elevation=low,elevation=medium"), low + medium);
}
