//! Granular beds on disk and their limits.

use std::path::Path;
use vb_world::{
    GranularBed, GranularMaterial, Heightfield, Obstacle, ObstacleKind, Provenance, Semantics, SoilLevels,
    Suite, SuiteMeta, TerrainClass, World,
};

/// A level world of 16 × 8 m in patches of 1 m, with a bed of gravel from (−4, −2) to (4, 2).
fn world() -> World {
    let bed = GranularBed {
        name: "stones".into(),
        material: GranularMaterial {
            class: TerrainClass::Gravel,
            radius: [0.03, 0.045],
            density: 2650.0,
            friction: 0.75,
            rolling_resistance: 0.5,
            cohesion: 0.0,
            compaction: 0.9,
        },
        x: 0.0,
        y: 0.0,
        length: 8.0,
        width: 4.0,
        depth: 0.25,
        seed: u64::MAX,
    };
    let inside = |k: usize| bed.contains((k % 16) as f64 - 7.5, (k / 16) as f64 - 3.5);
    let class = |k| if inside(k) { TerrainClass::Gravel } else { TerrainClass::Clay };
    let ground = World::uniform("w001", Heightfield::flat(9, 17, 1.0, 1.5), TerrainClass::Clay, 0.6);
    World {
        semantics: Semantics {
            rows: 8,
            cols: 16,
            patch: 1.0,
            classes: (0..128).map(class).collect(),
            friction: vec![0.6; 128],
            soil: SoilLevels::default(),
        },
        beds: vec![bed],
        ..ground
    }
}

fn write(dir: &Path, world: &World) -> Suite {
    let meta = SuiteMeta {
        name: "beds".into(),
        version: "1".into(),
        description: "Beds".into(),
        provenance: Provenance::Authored { by: "tests".into() },
    };
    Suite::write(dir, &meta, [world]).unwrap()
}

#[test]
fn a_world_with_beds_reads_back_and_its_hash_covers_them() {
    let folders = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let suite = write(&folders[0].path().join("s"), &world());
    assert_eq!(suite.load_world("w001").unwrap().beds, world().beds);
    let mut other = world();
    other.beds[0].seed = 7;
    let other = write(&folders[1].path().join("s"), &other);
    let bare = World { beds: Vec::new(), ..world() };
    let bare_suite = write(&folders[2].path().join("s"), &bare);
    let hash = |suite: &Suite| suite.worlds()[0].sha256.clone();
    assert!(hash(&suite) != hash(&other) && hash(&suite) != hash(&bare_suite));
    assert!(!folders[2].path().join("s/worlds/w001/beds.yaml").exists());
    assert!(bare_suite.load_world("w001").unwrap().beds.is_empty());
}

#[test]
fn a_scaled_bed_keeps_its_number_of_grains() {
    let (full, small) = (world(), world().scaled(0.1));
    let relative = small.beds[0].grains() / full.beds[0].grains();
    assert!((relative - 1.0).abs() < 1e-9, "{relative}");
    assert_eq!(small.bed_at(0.39, 0.19), Some(0));
    assert_eq!(small.bed_at(0.41, 0.0), None);
}

/// The flaw of a changed world.
fn flaw(change: impl FnOnce(&mut World)) -> String {
    let mut world = world();
    world.check().unwrap();
    change(&mut world);
    let message = world.check().unwrap_err().to_string();
    assert_eq!(world.flaws().last().unwrap().to_string(), message);
    message
}

#[test]
fn beds_that_cannot_be_are_named_with_what_is_possible() {
    let cases: [(String, &[&str]); 10] = [
        (flaw(|w| w.beds[0].depth = 0.1), &["beds[0].depth: 0.1 m must be at least 0.18 m", "0.09 m"]),
        (flaw(|w| w.beds[0].name = "My stones".into()), &["beds[0].material: \"My stones\" is not an id"]),
        (flaw(|w| w.beds[0].width = 0.0), &["beds[0].width: 0 m must be at least 0.36 m"]),
        (flaw(|w| w.beds[0].x = f64::NAN), &["beds[0]", "lies outside the world"]),
        (flaw(|w| w.beds[0].x = 6.0), &["beds[0]: the bed from [2.0, -2.0] to [10.0, 2.0] lies outside"]),
        (flaw(|w| w.beds[0].length = 7.0), &["beds[0]: its edges", "of 1 m"]),
        (
            flaw(|w| w.beds[0].length = 10.0),
            &["beds[0].material: the patch in row 2, column 3", "is clay", "gravel"],
        ),
        (flaw(|w| w.beds.push(w.beds[0].clone())), &["beds[1]: overlaps beds[0]"]),
        (
            flaw(|w| {
                let kind = ObstacleKind::Box { size: [1.0, 1.0, 1.0] };
                w.obstacles.push(Obstacle { x: 4.4, y: 0.0, yaw: 0.0, buried: 0.1, kind });
            }),
            &["beds[0]: obstacles[0] stands in it"],
        ),
        (
            flaw(|w| w.beds[0].material.radius = [0.005, 0.005]),
            &["beds: about", "grains fill them; 200000 are possible"],
        ),
    ];
    for (message, parts) in cases {
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in: {message}");
        }
    }
    let mut world = world();
    let heights = (0..9 * 17).map(|k| if k == 4 * 17 + 8 { 1.6 } else { 1.5 }).collect();
    world.heightfield = Heightfield::new(9, 17, 1.0, heights);
    let message = world.check().unwrap_err().to_string();
    assert!(message.contains("rises from 1.5 to 1.6 m: it must be level within 0.01 m"), "{message}");
}

#[test]
fn what_the_file_says_wrongly_is_named_with_field_and_value() {
    let cases = [
        (
            "radius: [0.03, 0.045]",
            "radius: [0.03, 0.02]",
            "materials.stones.radius[1]: 0.02 must lie in 0.03 to",
        ),
        ("friction: 0.75", "friction: -1.0", "materials.stones.friction: -1 must lie in 0 to 2"),
        (
            "{material: stones",
            "{material: stone",
            "beds[0].material: \"stone\" is none of the materials: stones",
        ),
        ("density: 2650.0", "density: heavy", "materials.stones.density"),
        ("depth: 0.25", "deep: 0.25", "deep"),
    ];
    for (from, to, wanted) in cases {
        let dir = tempfile::tempdir().unwrap();
        let suite = write(&dir.path().join("s"), &world());
        let file = dir.path().join("s/worlds/w001/beds.yaml");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{from} is not in {text}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        let message = suite.load_world("w001").unwrap_err().to_string();
        assert!(message.contains("beds.yaml") && message.contains(wanted), "{wanted:?} is not in: {message}");
    }
    let dir = tempfile::tempdir().unwrap();
    let suite = write(&dir.path().join("s"), &world());
    for (text, wanted) in
        [("", "beds.yaml: beds: the file is empty"), ("materials: {}\nbeds: []\n", "beds: is empty")]
    {
        std::fs::write(dir.path().join("s/worlds/w001/beds.yaml"), text).unwrap();
        let message = suite.load_world("w001").unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}
