//! Suites on disk: what is written reads back, and what is wrong is named.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::Path;
use vb_world::{
    Density, Elevation, Georeference, Heightfield, Obstacle, ObstacleKind, Pose2, Provenance, Semantics,
    SoilLevel, SoilLevels, Suite, SuiteMeta, Task, Terrain, TerrainClass, World,
};

/// A small world of odd size (5 × 9 nodes at 2 m) with every kind of obstacle and awkward numbers.
fn world(id: &str) -> World {
    let levels: Vec<u16> = (0..45u16).map(|k| k * 257).collect();
    let class = [TerrainClass::Clay, TerrainClass::Snow];
    World {
        id: id.into(),
        elevation: Elevation::High,
        terrain: Terrain::Mixed,
        density: Density::Sparse,
        scale: 1.0,
        heightfield: Heightfield::from_levels(5, 9, 2.0, [0.0, 9.6], &levels),
        semantics: Semantics {
            rows: 2,
            cols: 4,
            patch: 4.0,
            // The southern row begins with clay, the northern with snow.
            classes: (0..8).map(|k| class[(k + k / 4) % 2]).collect(),
            friction: (0..8)
                .map(|k| if (k + k / 4) % 2 == 0 { 0.1 + 0.07 * k as f64 } else { 0.0 })
                .collect(),
            soil: SoilLevels { snow: SoilLevel::Hard, ..SoilLevels::default() },
        },
        obstacles: vec![
            Obstacle {
                x: 1.0 / 3.0,
                y: -0.7,
                yaw: 0.1 + 0.2,
                buried: 0.45,
                kind: ObstacleKind::Boulder { size: [1.1, 1.0, 0.9], seed: u64::MAX },
            },
            Obstacle {
                x: -4.0,
                y: 2.0,
                yaw: -3.0,
                buried: 0.0,
                kind: ObstacleKind::Box { size: [1.0, 2.0, 3.0] },
            },
            Obstacle {
                x: 5.0,
                y: 3.0,
                yaw: 0.0,
                buried: 2.5,
                kind: ObstacleKind::Trunk { radius: 0.5, height: 5.0 },
            },
        ],
        beds: Vec::new(),
        tasks: vec![
            Task {
                id: "t00".into(),
                start: Pose2 { x: -7.0, y: 0.0, yaw: 0.0 },
                goal: [7.0, 1e-7],
                path: vec![[-7.0, 0.0], [0.3, 2.0], [7.0, 1e-7]],
            },
            Task {
                id: "t01".into(),
                start: Pose2 { x: 7.0, y: 0.0, yaw: std::f64::consts::PI },
                goal: [-7.0, 0.0],
                path: (0..15).map(|k| [7.0 - f64::from(k), 0.0]).collect(),
            },
        ],
    }
}

fn meta() -> SuiteMeta {
    SuiteMeta {
        name: "test \"quoted\"".into(),
        version: "1".into(),
        description: "two lines\nof text: yes".into(),
        provenance: Provenance::Generated { generator: "by hand".into(), seed: 7 },
    }
}

fn written() -> (tempfile::TempDir, Suite) {
    let dir = tempfile::tempdir().unwrap();
    let suite = Suite::write(dir.path(), &meta(), &[world("w001"), world("w002")]).unwrap();
    (dir, suite)
}

fn edit(dir: &Path, file: &str, from: &str, to: &str) {
    let path = dir.join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no {from:?}:\n{text}");
    std::fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn the_place_of_a_suite_reads_back_and_is_checked() {
    let place = Georeference {
        crs: "EPSG:32632".into(),
        proj: Some("+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs".into()),
        metres: [1.0, 0.5],
        origins: [("w001".to_owned(), [500_150.25, 5_699_850.0])].into(),
    };
    assert_eq!(place.at("w001", [10.0, -10.0]), Some([500_160.25, 5_699_830.0]));
    assert_eq!(place.at("w002", [0.0, 0.0]), None);
    let provenance = Provenance::Imported { source: "a \"survey\"".into(), place: Some(place) };
    let meta = SuiteMeta { provenance, ..meta() };
    let dir = tempfile::tempdir().unwrap();
    Suite::write(dir.path(), &meta, &[world("w001")]).unwrap();
    assert_eq!(Suite::open(dir.path()).unwrap().meta(), &meta);
    edit(dir.path(), "suite.yaml", "metres: [1.0, 0.5]", "metres: [1.0, 0.0]");
    let error = Suite::open(dir.path()).unwrap_err().to_string();
    assert!(error.contains("provenance.imported.place.metres"), "{error}");
}

#[test]
fn a_world_reads_back_bit_for_bit_and_writes_the_same_bytes_again() {
    let (dir, written) = written();
    let opened = Suite::open(dir.path()).unwrap();
    assert_eq!(opened.meta(), &meta());
    assert_eq!(opened.worlds(), written.worlds());
    assert_eq!(opened.task_count(), 4);
    let back = opened.load_world("w002").unwrap();
    assert_eq!(back, world("w002"));

    let again = tempfile::tempdir().unwrap();
    let second = Suite::write(again.path(), &meta(), &[opened.load_world("w001").unwrap(), back]).unwrap();
    assert_eq!(second.hash(), opened.hash());
    for file in ["suite.yaml", "worlds/w001/elevation.png", "worlds/w001/tasks.yaml"] {
        assert_eq!(
            std::fs::read(dir.path().join(file)).unwrap(),
            std::fs::read(again.path().join(file)).unwrap()
        );
    }
}

#[test]
fn the_hash_covers_the_levels_and_not_how_they_are_compressed() {
    let (dir, suite) = written();
    let image = dir.path().join("worlds/w001/elevation.png");
    let store = |data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 9, 5);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::NoCompression);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        std::fs::write(&image, bytes).unwrap();
    };
    let packed = std::fs::read(&image).unwrap();
    let mut data = vec![0; 90];
    png::Decoder::new(std::io::Cursor::new(&packed)).read_info().unwrap().next_frame(&mut data).unwrap();
    store(&data);
    assert_ne!(std::fs::read(&image).unwrap(), packed);
    suite.load_world("w001").unwrap();
    data[17] ^= 1;
    store(&data);
    assert!(suite.load_world("w001").is_err(), "one level of another world");
}

#[test]
fn heights_that_never_were_levels_lose_at_most_half_a_level() {
    let mut w = world("w001");
    let heights: Vec<f64> = (0..45).map(|k| 0.1 * f64::from(k * k % 17) - 0.33).collect();
    w.heightfield = Heightfield::new(5, 9, 2.0, heights.clone());
    let dir = tempfile::tempdir().unwrap();
    let back = Suite::write(dir.path(), &meta(), &[w]).unwrap().load_world("w001").unwrap();
    let half_level = 0.5 * 1.6 / 65535.0;
    for (a, b) in heights.iter().zip(back.heightfield.heights()) {
        assert!((a - b).abs() <= half_level * 1.001, "{a} {b}");
    }
}

#[test]
fn the_image_has_its_first_row_in_the_north() {
    let (dir, _) = written();
    let bytes = std::fs::read(dir.path().join("worlds/w001/elevation.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; 90];
    reader.next_frame(&mut data).unwrap();
    // The north-west node is row 4, column 0 from the south: level 36 · 257, two equal bytes.
    assert_eq!(data[..4], [36, 36, 37, 37]);
}

#[test]
fn the_hash_depends_on_content_and_not_on_place_name_or_line_ends() {
    let (dir, first) = written();
    let elsewhere = tempfile::tempdir().unwrap();
    let other = SuiteMeta { name: "other".into(), ..meta() };
    let second = Suite::write(elsewhere.path(), &other, &[world("w001"), world("w002")]).unwrap();
    assert_eq!(first.hash(), second.hash());

    let path = dir.path().join("worlds/w001/tasks.yaml");
    let crlf = std::fs::read_to_string(&path).unwrap().replace('\n', "\r\n");
    std::fs::write(path, crlf).unwrap();
    assert_eq!(Suite::open(dir.path()).unwrap().load_world("w001").unwrap(), world("w001"));

    let mut changed = world("w002");
    changed.semantics.friction[0] += 1e-12;
    let third = tempfile::tempdir().unwrap();
    assert_ne!(Suite::write(third.path(), &meta(), &[world("w001"), changed]).unwrap().hash(), first.hash());
}

#[test]
fn a_changed_world_is_refused_by_its_hash() {
    let (dir, suite) = written();
    edit(dir.path(), "worlds/w002/tasks.yaml", "[0.3, 2.0]", "[0.3, 2.1]");
    let message = suite.load_world("w002").unwrap_err().to_string();
    assert!(message.contains("suite.yaml: worlds: the content hash of w002 is"), "{message}");
    assert_eq!(suite.verify_world("w002").unwrap_err().to_string(), message);
    assert!(suite.load_world("w001").is_ok());
    assert!(suite.verify_world("w001").is_ok());
}

#[test]
fn a_world_is_examined_for_all_its_flaws_and_given_if_its_values_make_sense() {
    let (dir, suite) = written();
    let (whole, errors) = suite.examine_world("w001").unwrap();
    assert!(whole == Some(world("w001")) && errors.is_empty());
    // Changed but sound: the hash is told, and the world is there.
    edit(dir.path(), "worlds/w002/tasks.yaml", "[0.3, 2.0]", "[0.3, 2.1]");
    let (changed, errors) = suite.examine_world("w002").unwrap();
    assert_eq!(changed.unwrap().tasks[0].path[1], [0.3, 2.1]);
    assert!(errors.len() == 1 && errors[0].to_string().contains("content hash of w002"), "{errors:?}");
    // One flaw in the ground and one in each task: all are told, the first as loading tells it.
    edit(dir.path(), "worlds/w001/world.yaml", "terrain: mixed", "terrain: rigid");
    edit(dir.path(), "worlds/w001/tasks.yaml", "[0.3, 2.0]", "[0.3, 2000.0]");
    edit(dir.path(), "worlds/w001/tasks.yaml", "id: t01", "id: t00");
    let (none, errors) = suite.examine_world("w001").unwrap();
    let errors: Vec<_> = errors.iter().map(ToString::to_string).collect();
    assert!(none.is_none() && errors.len() == 3, "{errors:?}");
    assert_eq!(errors[0], suite.load_world("w001").unwrap_err().to_string());
    assert!(errors[1].contains("tasks[0].path[1]") && errors[2].contains("tasks[1].id"), "{errors:?}");
    assert!(suite.examine_world("w009").is_err());
}

#[test]
fn each_flaw_is_named_with_file_field_and_value() {
    let cases: &[(&str, &str, &str, &[&str])] = &[
        ("world.yaml", "rows: 5", "rows: 5, colour: red", &["world.yaml: grid", "colour"]),
        ("world.yaml", "rows: 5", "rows: five", &["world.yaml: grid.rows", "five"]),
        ("world.yaml", "rows: 5", "rows: 6", &["elevation.png: size: 5 x 9", "grid.rows 6"]),
        ("world.yaml", "rows: 5, ", "", &["world.yaml: grid", "rows"]),
        ("world.yaml", "pitch: 2.0", "pitch: -2.0", &["world.yaml: grid.pitch: -2"]),
        ("world.yaml", "pitch: 2.0", "pitch: 1.0", &["semantics.yaml: patch", "measures 8 m"]),
        ("world.yaml", "[0.0, 9.6]", "[0.0, .nan]", &["world.yaml: grid.height_range[1]: \".nan\""]),
        ("world.yaml", "schema: 1", "schema: 2", &["world.yaml: schema: version 2 is not supported"]),
        ("world.yaml", "elevation: high", "elevation: steep", &["world.yaml: elevation", "steep"]),
        (
            "world.yaml",
            "terrain: mixed",
            "terrain: rigid",
            &["semantics.yaml: classes[1][1]", "snow", "rigid"],
        ),
        ("world.yaml", "length: m", "length: ft", &["world.yaml: units.length", "ft"]),
        ("semantics.yaml", "\"cFcF\"", "\"cFc\"", &["semantics.yaml: classes[1]", "3 letters"]),
        ("semantics.yaml", "\"cFcF\"", "\"cFcQ\"", &["semantics.yaml: classes[1]", "'Q'", "legend"]),
        ("semantics.yaml", "rows: 2", "rows: 3", &["semantics.yaml: classes: 2 rows, but rows is 3"]),
        ("semantics.yaml", "[0.1, 0.0", "[3.5, 0.0", &["semantics.yaml: friction[1][0]: 3.5 on clay"]),
        ("semantics.yaml", "[0.1, 0.0", "[0.1, 0.3", &["semantics.yaml: friction[1][1]: 0.3 on snow"]),
        ("semantics.yaml", "[0.1, 0.0", "[.nan, 0.0", &["semantics.yaml: friction[1][0]: NaN"]),
        ("semantics.yaml", "[0.1, 0.0, ", "[0.1, ", &["semantics.yaml: friction[1]: 3 values"]),
        ("obstacles.yaml", "kind: box", "kind: sphere", &["obstacles.yaml: obstacles[1].kind", "sphere"]),
        (
            "obstacles.yaml",
            "x: -4.0",
            "x: -40.0",
            &["obstacles.yaml: obstacles[1]: centre [-40.0, 2.0]", "x ±8 m"],
        ),
        ("obstacles.yaml", "radius: 0.5", "radius: -0.5", &["obstacles.yaml: obstacles[2].radius: -0.5"]),
        (
            "obstacles.yaml",
            "radius: 0.5",
            "radius: 1e-200",
            &["obstacles[2].radius: ", "from 0.001 to 1000 m"],
        ),
        (
            "obstacles.yaml",
            "radius: 0.5, ",
            "",
            &["obstacles.yaml: obstacles[2].radius: is missing: a trunk"],
        ),
        (
            "obstacles.yaml",
            "radius: 0.5",
            "radius: 0.5, seed: 3",
            &["obstacles[2].seed: does not belong to a trunk"],
        ),
        (
            "obstacles.yaml",
            "buried: 2.5",
            "buried: 15.5",
            &["obstacles.yaml: obstacles[2].buried: 15.5", "[-10, 15] m"],
        ),
        (
            "obstacles.yaml",
            "size: [1.0, 2.0, 3.0]",
            "size: [1.0, 2.0]",
            &["obstacles.yaml: obstacles[1].size"],
        ),
        (
            "tasks.yaml",
            "goal: [7.0, ",
            "goal: [70.0, ",
            &["tasks[0].goal: [70.0, 1e-7] lies outside the world"],
        ),
        (
            "tasks.yaml",
            "goal: [7.0, ",
            "goal: [-4.0, 2.0] # ",
            &["tasks[0].goal: [-4.0, 2.0] lies inside obstacles[1]"],
        ),
        (
            "tasks.yaml",
            "goal: [7.0, 1e-7]",
            "goal: [6.0, 0.0]",
            &["tasks[0].path: ends at [7.0, 1e-7]", "[6.0, 0.0]"],
        ),
        ("tasks.yaml", "x: -7.0", "x: -6.0", &["tasks[0].path: begins at [-7.0, 0.0]", "[-6.0, 0.0]"]),
        ("tasks.yaml", "x: -7.0", "x: west", &["tasks.yaml: tasks[0].start.x", "west"]),
        ("tasks.yaml", "x: -7.0", "x: -7.0, z: 1.0", &["tasks.yaml: tasks[0].start", "z"]),
        ("tasks.yaml", "yaw: 0.0", "yaw: .inf", &["tasks[0].start.yaw: inf"]),
        ("tasks.yaml", "[0.3, 2.0]", "[0.3, 20.0]", &["tasks[0].path[1]: [0.3, 20.0] lies outside"]),
        ("tasks.yaml", "id: t01", "id: t00", &["tasks[1].id: \"t00\" is used twice"]),
        ("tasks.yaml", "id: t01", "id: T/1", &["tasks[1].id: \"T/1\" is not an id"]),
        ("tasks.yaml", "tasks:", "tasks: [", &["tasks.yaml: "]),
    ];
    for (file, from, to, expected) in cases {
        let (dir, suite) = written();
        edit(&dir.path().join("worlds/w001"), file, from, to);
        let message = suite.load_world("w001").expect_err(&format!("{file}: {to}")).to_string();
        assert!(message.starts_with(&*dir.path().join("worlds/w001").to_string_lossy()), "{message}");
        assert!(!message.contains('\n'), "{message}");
        for part in *expected {
            assert!(message.contains(part), "{file}: {from} -> {to}: {message}\nlacks {part:?}");
        }
    }
}

#[test]
fn flaws_of_the_index_are_named() {
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "schema: 1",
            "schema: 9",
            &["suite.yaml: schema: version 9 is not supported, this build reads version 1"],
        ),
        ("schema: 1", "", &["suite.yaml", "schema"]),
        ("version:", "versoin:", &["suite.yaml", "versoin"]),
        ("id: w002", "id: w001", &["worlds[1].id: \"w001\" is used twice"]),
        ("id: w002", "id: ../w2", &["worlds[1].id: \"../w2\" is not an id"]),
        ("sha256: \"", "sha256: \"Z", &["worlds[0].sha256"]),
        ("density: sparse", "density: 3", &["worlds[0].density", "3"]),
        ("seed: 7", "seed: minus", &["provenance", "minus"]),
    ];
    for (from, to, expected) in cases {
        let (dir, _) = written();
        edit(dir.path(), "suite.yaml", from, to);
        let message = Suite::open(dir.path()).expect_err(to).to_string();
        for part in *expected {
            assert!(message.contains(part), "{from} -> {to}: {message}\nlacks {part:?}");
        }
        assert!(!message.contains('\n'), "{message}");
    }
    let (dir, _) = written();
    edit(dir.path(), "suite.yaml", "elevation: high", "elevation: low");
    let message = Suite::open(dir.path()).unwrap().load_world("w001").unwrap_err().to_string();
    assert!(message.contains("suite.yaml: worlds[0]: says w001 (low") && message.contains("say w001 (high"));
}

#[test]
fn missing_cut_or_foreign_files_are_named() {
    let (dir, suite) = written();
    let folder = dir.path().join("worlds/w001");
    let image = folder.join("elevation.png");
    let whole = std::fs::read(&image).unwrap();
    let message = |suite: &Suite| suite.load_world("w001").unwrap_err().to_string();

    for keep in [0, 7, 30, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&image, &whole[..keep]).unwrap();
        assert!(
            message(&suite).contains("elevation.png: image: not a whole PNG"),
            "{keep}: {}",
            message(&suite)
        );
    }
    std::fs::write(&image, b"BM not a PNG at all").unwrap();
    assert!(message(&suite).contains("elevation.png: image: not a whole PNG"), "{}", message(&suite));
    let mut grey8 = Vec::new();
    let mut encoder = png::Encoder::new(&mut grey8, 9, 5);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[0; 45]).unwrap();
    std::fs::write(&image, grey8).unwrap();
    assert!(message(&suite).contains("elevation.png: format: Grayscale, Eight"), "{}", message(&suite));
    std::fs::write(&image, &whole).unwrap();

    std::fs::write(folder.join("tasks.yaml"), b"tasks: \xff").unwrap();
    assert!(message(&suite).contains("tasks.yaml: byte 7: is not UTF-8"), "{}", message(&suite));
    std::fs::remove_file(folder.join("tasks.yaml")).unwrap();
    assert!(message(&suite).contains("tasks.yaml: cannot read"), "{}", message(&suite));

    let none = Suite::open(dir.path().join("nowhere")).unwrap_err().to_string();
    assert!(
        none.contains("nowhere") && none.contains("cannot read") && none.contains("suite.yaml"),
        "{none}"
    );
    let unknown = suite.load_world("w9").unwrap_err().to_string();
    assert!(unknown.contains("no world is called \"w9\"; there are w001, w002"), "{unknown}");
}

#[test]
fn writing_refuses_flaws_and_places_that_are_taken() {
    let (dir, _) = written();
    let taken = Suite::write(dir.path(), &meta(), &[world("w001")]).unwrap_err().to_string();
    assert!(taken.contains("already exists and is not empty"), "{taken}");

    let mut bad = world("w001");
    bad.heightfield = Heightfield::flat(5, 9, 2.0, f64::NAN);
    let fresh = dir.path().join("fresh");
    let message = Suite::write(&fresh, &meta(), &[bad]).unwrap_err().to_string();
    assert!(message.contains("elevation.png: node at row 0") && message.contains("NaN"), "{message}");
    assert!(Suite::open(&fresh).is_err(), "an interrupted suite must not open");

    let scaled = world("w001").scaled(0.5);
    let message = Suite::write(dir.path().join("s"), &meta(), &[scaled]).unwrap_err().to_string();
    assert!(message.contains("scale: 0.5 cannot be stored"), "{message}");
    let twice =
        Suite::write(dir.path().join("t"), &meta(), &[world("w001"), world("w001")]).unwrap_err().to_string();
    assert!(twice.contains("worlds[1].id: \"w001\" is used twice"), "{twice}");

    let file = dir.path().join("file");
    std::fs::write(&file, "").unwrap();
    let message = Suite::write(file.join("below"), &meta(), &[world("w001")]).unwrap_err().to_string();
    assert!(message.contains("below: cannot write"), "{message}");
}

#[test]
fn no_damage_to_a_world_makes_reading_panic() {
    let (dir, suite) = written();
    let folder = dir.path().join("worlds/w001");
    let mut rng = vb_math::rng::Stream::new(3, &["damage"]);
    for file in ["world.yaml", "elevation.png", "semantics.yaml", "obstacles.yaml", "tasks.yaml"] {
        let whole = std::fs::read(folder.join(file)).unwrap();
        for _ in 0..150 {
            let mut bytes = whole.clone();
            for _ in 0..1 + rng.below(3) {
                let at = rng.below(bytes.len() as u64) as usize;
                match rng.below(4) {
                    0 => bytes[at] = rng.next_u64() as u8,
                    1 => bytes[at] = b"-:,[]{}&*!9e. \n"[rng.below(15) as usize],
                    2 => drop(bytes.remove(at)),
                    _ => bytes.insert(at, b"0129-.e"[rng.below(7) as usize]),
                }
            }
            std::fs::write(folder.join(file), &bytes).unwrap();
            if let Err(e) = suite.load_world("w001") {
                assert!(!e.to_string().contains('\n'), "{e}");
            }
        }
        std::fs::write(folder.join(file), whole).unwrap();
    }
    assert!(suite.load_world("w001").is_ok());
}
