//! The import against the released data and the figures measured on it. Without that data the tests say so and
//! pass.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use crate::common::{facet_slopes, percentile};
use std::path::{Path, PathBuf};
use vb_files::yaml;
use vb_suite::{
    import::{Ground, ImportError, Source},
    path,
};
use vb_world::{ObstacleKind, Suite, Terrain, geometry};

fn shared() -> Option<PathBuf> {
    vb_testing::shared("verti-bench/BenchMaps").map(|_| vb_testing::shared_folder())
}

/// Rows of a CSV file as (header, cells).
fn table(file: PathBuf) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|l| header.iter().map(|h| (*h).to_owned()).zip(l.split(',').map(str::to_owned)).collect())
        .collect()
}

fn number(row: &std::collections::BTreeMap<String, String>, key: &str) -> f64 {
    row[key].parse().unwrap_or_else(|_| panic!("{key} = {:?}", row[key]))
}

#[test]
fn pixels_labels_and_heights_are_those_of_the_reference_vectors() {
    let Some(shared) = shared() else { return };
    let vectors = std::fs::read_to_string(shared.join("reference/testvectors.json")).unwrap();
    let vectors: serde_json::Value = serde_json::from_str(&vectors).unwrap();
    let source = Source::find(shared.join("verti-bench")).unwrap();
    let present: Vec<u32> = source.ids().collect();
    let mut checked = 0;
    for (id, v) in vectors.as_object().unwrap() {
        let id: u32 = id.parse().unwrap();
        if !present.contains(&id) {
            eprintln!("world {id} is not among the reference data");
            continue;
        }
        let world = source.world(id).unwrap();
        let max = v["max_height"].as_f64().unwrap();
        assert_eq!(world.heightfield.to_levels().0, [0.0, max]);
        for p in v["pixels"].as_array().unwrap() {
            let (x, y) = (p["x"].as_f64().unwrap(), p["y"].as_f64().unwrap());
            let (row, col) = (p["row"].as_u64().unwrap() as usize, p["col"].as_u64().unwrap() as usize);
            let grey = p["grey"].as_f64().unwrap();
            // Node (south row, col): exactly the grey's share of the range.
            assert_eq!(world.heightfield.node(128 - row, col), max * (grey / 255.0), "world {id}: {p}");
            assert!(
                (world.heightfield.height(x, y) - p["mesh_z"].as_f64().unwrap()).abs() < 1e-6,
                "{id}: {p}"
            );
            let (i, j) = ((row / 8).min(15), (col / 8).min(15));
            let class = world.semantics.classes[(15 - i) * 16 + j];
            assert_eq!(u64::from(class.label()), p["label"].as_u64().unwrap(), "world {id}: {p}");
            checked += 1;
        }
        for p in v["mesh_heights_128m"].as_array().unwrap() {
            let (x, y, z) = (p["x"].as_f64().unwrap(), p["y"].as_f64().unwrap(), p["z"].as_f64().unwrap());
            // The vectors carry millimetres of position and micrometres of height.
            assert!((world.heightfield.height(x, y) - z).abs() < 1e-6, "world {id}: {p}");
        }
    }
    assert!(checked >= 12);
}

#[test]
fn every_world_has_the_measured_statistics_tasks_and_short_safe_paths() {
    let Some(shared) = shared() else { return };
    let source = Source::find(shared.join("verti-bench")).unwrap();
    let worlds = table(shared.join("reference/worlds.csv"));
    let tasks = table(shared.join("reference/tasks.csv"));
    let (mut ours, mut beziers, mut count) = (0.0, 0.0, 0usize);
    for id in source.ids() {
        let world = source.world(id).unwrap();
        let row = worlds.iter().find(|r| r["world"] == id.to_string()).unwrap();
        let level = if row["difficulty"] == "mid" { "medium" } else { &row["difficulty"] };
        assert_eq!(world.elevation.name(), level);
        assert_eq!(world.terrain.name(), row["terrain_type"]);
        assert_eq!(world.density.name(), row["density"]);

        let heights = world.heightfield.heights();
        let n = heights.len() as f64;
        let mean = heights.iter().sum::<f64>() / n;
        let std = (heights.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / n).sqrt();
        let (low, high) = world.heightfield.range();
        for (key, value) in [("h_min", low), ("h_mean", mean), ("h_std", std), ("h_max", high)] {
            assert!((value - number(row, key)).abs() < 1.1e-4, "world {id}: {key}: {value}");
        }
        let slopes = facet_slopes(&world);
        for (key, p) in [
            ("facet_slope_p50_deg", 50.0),
            ("facet_slope_p90", 90.0),
            ("facet_slope_p99", 99.0),
            ("facet_slope_max", 100.0),
        ] {
            let value = percentile(&slopes, p);
            assert!((value - number(row, key)).abs() < 0.011, "world {id}: {key}: {value}");
        }
        let mut classes = Vec::new();
        for class in vb_world::TerrainClass::ALL {
            let n = world.semantics.classes.iter().filter(|&&c| c == class).count();
            if n > 0 {
                classes.push(format!("{}:{n}", class.name()));
            }
        }
        let mut expected: Vec<_> = row["classes"].split(';').map(str::to_owned).collect();
        classes.sort();
        expected.sort();
        assert_eq!(classes, expected, "world {id}");
        let boxes = world.obstacles.iter().filter(|o| matches!(o.kind, ObstacleKind::Box { .. })).count();
        assert_eq!(boxes as f64, number(row, "rocks"));
        assert_eq!((world.obstacles.len() - boxes) as f64, number(row, "trees"));

        let outlines: Vec<_> = world.obstacles.iter().map(vb_world::Obstacle::footprint).collect();
        for (k, task) in world.tasks.iter().enumerate() {
            let row =
                tasks.iter().find(|r| r["world"] == id.to_string() && r["task"] == k.to_string()).unwrap();
            for (key, value) in [
                ("start_x", task.start.x),
                ("start_y", task.start.y),
                ("goal_x", task.goal[0]),
                ("goal_y", task.goal[1]),
            ] {
                assert!((value - number(row, key)).abs() < 1e-5, "world {id}, task {k}: {key}: {value}");
            }
            let turn = vb_math::angle::wrap(task.start.yaw - number(row, "yaw0_rad"));
            assert!(turn.abs() < 1e-5, "world {id}, task {k}: yaw {}", task.start.yaw);
            for (key, [x, y]) in
                [("true_ground_start", [task.start.x, task.start.y]), ("true_ground_goal", task.goal)]
            {
                let z = world.heightfield.height(x, y);
                assert!((z - number(row, key)).abs() < 1.1e-4, "world {id}, task {k}: {key}: {z}");
            }
            let closest = task
                .path
                .windows(2)
                .flat_map(|w| outlines.iter().map(|o| geometry::segment_to_polygon(w[0], w[1], o)))
                .fold(f64::INFINITY, f64::min);
            // The least distance of the original's paths (measured over its 1000 tasks).
            assert!(closest >= 1.99, "world {id}, task {k}: {closest} m");
            assert_eq!(task.path[0], [task.start.x, task.start.y]);
            assert_eq!(task.path[task.path.len() - 1], task.goal);
            assert!(task.path.windows(2).all(|w| path::length(w) < 1.01));
            ours += path::length(&task.path);
            beziers += number(row, "bezier_len_m");
            count += 1;
        }
    }
    assert_eq!(count, 10 * source.ids().len());
    eprintln!("{count} paths: mean {} m, original {} m", ours / count as f64, beziers / count as f64);
    assert!(ours <= beziers, "mean {} m, original {} m", ours / count as f64, beziers / count as f64);
}

/// The sections are what a run of the original's own code showed (physical_sections.json of the reference data): a
/// section must have its class and its friction everywhere, and together they must leave nothing out.
#[test]
fn the_ground_as_simulated_is_that_of_the_physical_sections() {
    let Some(shared) = shared() else { return };
    let reference = std::fs::read_to_string(shared.join("reference/physical_sections.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_str(&reference).unwrap();
    let source = Source::find(shared.join("verti-bench")).unwrap().ground(Ground::AsSimulated);
    let (mut rigid, mut soil) = (0, 0);
    for id in source.ids() {
        let world = source.world(id).unwrap();
        let s = &world.semantics;
        let mut covered = vec![false; s.rows * s.cols];
        for section in reference[id.to_string()].as_array().unwrap() {
            let int = |v: &serde_json::Value| v.as_u64().unwrap() as f64;
            // Bounds in metres south of the northern edge and east of the western one. Pixel ranges are half-open,
            // and neighbours share a row of pixels.
            let [north, west, south, east] = match section.get("rows") {
                Some(rows) => [int(&rows[0]), 0.0, int(&rows[1]) - 1.0, 128.0],
                None => {
                    let [i, j, h, w] = ["i0", "j0", "h", "w"].map(|k| int(&section[k]));
                    [8.0 * i, 8.0 * j, 8.0 * (i + h), 8.0 * (j + w)]
                }
            };
            let mu = section.get("friction").map_or(0.0, |f| f.as_f64().unwrap());
            let is_rigid = section["kind"] == "rigid";
            if is_rigid {
                rigid += 1
            } else {
                soil += 1
            }
            // Every patch of the section, by its centre.
            let count = |from: f64, to: f64| ((to - from) / s.patch).round() as usize;
            for i in 0..count(north, south) {
                for j in 0..count(west, east) {
                    let y = 64.0 - north - s.patch * (i as f64 + 0.5);
                    let x = west - 64.0 + s.patch * (j as f64 + 0.5);
                    let patch = s.patch_index(x, y);
                    let (class, friction) = (s.classes[patch], s.friction[patch]);
                    assert_eq!(class.name(), section["type"], "world {id}: {section} at {x}, {y}");
                    // serde_json may miss the last bit.
                    assert!((friction - mu).abs() < 1e-15, "world {id}: {section} at {x}, {y}: {friction}");
                    assert_eq!(class.is_deformable(), !is_rigid, "world {id}: {section} at {x}, {y}");
                    assert!(!covered[patch], "world {id}: {section} overlaps another at {x}, {y}");
                    covered[patch] = true;
                }
            }
        }
        assert!(covered.iter().all(|&c| c), "world {id}: the sections leave patches out");
    }
    eprintln!("{} worlds: {rigid} rigid sections, {soil} of soil", source.ids().len());
    assert!(rigid > 0 && soil > 0);
}

#[test]
fn obstacles_as_simulated_are_boxes_centred_at_their_stored_position() {
    let Some(shared) = shared() else { return };
    let source = Source::find(shared.join("verti-bench")).unwrap().ground(Ground::AsSimulated);
    // Least and greatest height of the stored z above the true ground, m, by level, over all 100 worlds (measured).
    let ranges = [[-1.20, 1.14], [-1.78, 1.62], [-2.76, 2.35]];
    let mut hanging = 0;
    for id in source.ids() {
        let world = source.world(id).unwrap();
        let level = ["low", "mid", "high"][world.elevation as usize];
        let config = shared.join("verti-bench/BenchMaps/sampled_maps/Configs/Final");
        let config = std::fs::read_to_string(config.join(format!("config{id}_{level}.yaml"))).unwrap();
        let config: serde_json::Value = yaml::parse(&config).unwrap();
        let list = |key: &str| config["obstacles"][key].as_array().unwrap().clone();
        let stored = [list("rocks"), list("trees")].concat();
        assert_eq!(stored.len(), world.obstacles.len());
        for (o, stored) in world.obstacles.iter().zip(stored) {
            // Full extents of Chrono's boxes: 4.4 s × 4.4 s × 3.8 s and 1 × 1 × 5 (envs/utils/asset_utils.py).
            let size = match stored.get("scale") {
                Some(s) => [4.4, 4.4, 3.8].map(|l| l * s.as_f64().unwrap()),
                None => [1.0, 1.0, 5.0],
            };
            assert_eq!((o.kind, o.yaw), (ObstacleKind::Box { size }, 0.0), "world {id}");
            let [x, y, z] = ["x", "y", "z"].map(|k| stored["position"][k].as_f64().unwrap());
            assert_eq!([o.x, o.y], [x, y], "world {id}");
            let above = z - o.base_z(&world.heightfield);
            let centre = o.base_z(&world.heightfield) - o.buried + 0.5 * size[2];
            assert!((centre - z).abs() < 1e-9, "world {id}: {o:?}: {centre} m, stored {z} m");
            let [low, high] = ranges[world.elevation as usize];
            // The published range is rounded to centimetres.
            assert!(above > low - 0.005 && above < high + 0.005, "world {id}: {o:?}: {above} m");
            hanging += usize::from(o.buried < 0.0);
        }
    }
    eprintln!("{hanging} obstacles hang above the ground at their centre");
}

#[test]
fn as_simulated_patches_share_the_friction_of_their_section() {
    let Some(shared) = shared() else { return };
    let described = Source::find(shared.join("verti-bench")).unwrap();
    let simulated = described.clone().ground(Ground::AsSimulated);
    assert_ne!(described.meta(), simulated.meta());
    let id = described.ids().next().unwrap();
    let (a, b) = (described.world(id).unwrap(), simulated.world(id).unwrap());
    assert_eq!(a.terrain, Terrain::Rigid);
    // Classes, heights and tasks' ends are the same; friction takes fewer values.
    assert_eq!((&a.semantics.classes, &a.heightfield), (&b.semantics.classes, &b.heightfield));
    let values = |w: &vb_world::World| {
        w.semantics.friction.iter().map(|f| f.to_bits()).collect::<std::collections::BTreeSet<_>>()
    };
    assert!(values(&b).is_subset(&values(&a)) && values(&b).len() < values(&a).len() / 4);
}

#[test]
fn an_imported_suite_reads_back_bit_for_bit() {
    let Some(shared) = shared() else { return };
    let source = Source::find(shared.join("verti-bench/BenchMaps")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let mut hashes = Vec::new();
    for ground in Ground::ALL {
        let source = source.clone().ground(ground);
        let worlds: Vec<_> = source.ids().take(2).map(|id| source.world(id).unwrap()).collect();
        let dir = dir.path().join(ground.name());
        Suite::write(&dir, &source.meta(), &worlds).unwrap();
        let suite = Suite::open(&dir).unwrap();
        for world in &worlds {
            assert_eq!(&suite.load_world(&world.id).unwrap(), world);
        }
        // A suite says which ground it has, and its hash tells it too.
        assert_eq!(suite.meta(), &source.meta());
        assert!(format!("{:?}", suite.meta().provenance).contains(ground.name()));
        hashes.push(suite.hash());
    }
    assert_ne!(hashes[0], hashes[1]);
}

/// A copy of world 1 alone in the original's layout.
fn copy_of_world_1(shared: &Path) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for file in ["Worlds/1.bmp", "Configs/Final/config1_high.yaml", "Configs/Final/labels1_high.npy"] {
        let to = dir.path().join("BenchMaps/sampled_maps").join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        let bytes = std::fs::read(shared.join("verti-bench/BenchMaps/sampled_maps").join(file)).unwrap();
        std::fs::write(to, bytes).unwrap();
    }
    dir
}

fn error(dir: &Path) -> String {
    let result: Result<_, ImportError> = Source::find(dir).and_then(|s| s.world(1));
    let message = result.unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn flaws_of_binary_files_are_named() {
    let Some(shared) = shared() else { return };
    type Change = fn(&mut Vec<u8>);
    let cases: &[(&str, Change, &str)] = &[
        (
            "Worlds/1.bmp",
            |b| b.truncate(9000),
            "1.bmp: file: is truncated (9000 bytes, but the image needs 18106): restore the file",
        ),
        ("Worlds/1.bmp", |b| b.truncate(20), "1.bmp: file: is truncated (20 bytes, but its header needs 54)"),
        ("Worlds/1.bmp", |b| b.clear(), "1.bmp: file: is not a Windows bitmap"),
        ("Worlds/1.bmp", |b| b[18] = 128, "1.bmp: size: 128 x 129 pixels: must be 129 x 129"),
        ("Worlds/1.bmp", |b| b[28] = 24, "1.bmp: format: 24 bits a pixel"),
        ("Worlds/1.bmp", |b| b[30] = 1, "1.bmp: format: 8 bits a pixel, compression 1"),
        ("Worlds/1.bmp", |b| b[54 + 4 * 7] = 9, "1.bmp: palette: entry 7 is [7, 7, 9]"),
        (
            "Worlds/1.bmp",
            |b| b[10..14].copy_from_slice(&[60, 0, 0, 0]),
            "1.bmp: file: its pixels begin at byte 60, inside the palette",
        ),
        (
            "Worlds/1.bmp",
            |b| b[10..14].fill(255),
            "1.bmp: file: is truncated (18106 bytes, but the image needs",
        ),
        (
            "labels1_high.npy",
            |b| b.truncate(5000),
            "labels1_high.npy: data: 1218 values, but the shape (129, 129)",
        ),
        (
            "labels1_high.npy",
            |b| b.truncate(40),
            "labels1_high.npy: file: is truncated (40 bytes, within its header)",
        ),
        ("labels1_high.npy", |b| b[0] = b'x', "labels1_high.npy: file: is not a NumPy array"),
        (
            "labels1_high.npy",
            |b| b[6] = 9,
            "labels1_high.npy: file: version 9 of the array's format is not supported",
        ),
        ("labels1_high.npy", |b| b[23] = b'8', "labels1_high.npy: descr: '<i8': must be '<i4'"),
        (
            "labels1_high.npy",
            |b| b[128 + 4 * 130] = 9,
            "labels1_high.npy: [1, 1]: label 9 (snow) differs from",
        ),
        (
            "labels1_high.npy",
            |b| b[128 + 4 * 130] = 77,
            "labels1_high.npy: [1, 1]: label 77 must lie in 0 to 9",
        ),
    ];
    for (file, change, expected) in cases {
        let dir = copy_of_world_1(&shared);
        let maps = dir.path().join("BenchMaps/sampled_maps");
        let path =
            if file.ends_with("npy") { maps.join("Configs/Final").join(file) } else { maps.join(file) };
        let mut bytes = std::fs::read(&path).unwrap();
        change(&mut bytes);
        std::fs::write(&path, bytes).unwrap();
        let message = error(dir.path());
        assert!(message.contains(expected), "{message}\nlacks {expected}");
    }
}

#[test]
fn flaws_of_the_config_are_named() {
    let Some(shared) = shared() else { return };
    let cases: &[(&str, &str, &[&str])] = &[
        ("max_height: 16.0", "max_height: high", &["terrain.max_height: \"high\""]),
        ("max_height: 16.0", "max_height: -1.0", &["terrain.max_height: -1"]),
        ("length: 64.5", "length: 64.3", &["terrain.width: 64.5 differs from terrain.length, 64.3"]),
        (
            "difficulty: high",
            "difficulty: low",
            &["terrain.difficulty: low does not agree with the file's name"],
        ),
        ("difficulty: high", "difficulty: steep", &["terrain.difficulty", "steep"]),
        ("obstacle_density: dense", "obstacle_density: [1]", &["obstacle_density"]),
        ("obstacle_density: dense", "", &["obstacle_density"]),
        ("x: 26.124761159978952", "x: 260.0", &["obstacles[0]: centre [260.0,", "lies outside the world"]),
        ("x: 26.124761159978952", "x: east", &["obstacles.rocks[0].position.x: \"east\""]),
        ("scale: 0.9556456543050853", "scale: -1.0", &["obstacles.rocks[0].scale: -1"]),
        ("index: [0, 0]", "index: [0, 1]", &["textures[1].index: [0, 1] was given before"]),
        ("index: [0, 0]", "index: [0, 16]", &["textures[0].index: [0, 16] lies outside"]),
        ("friction: 0.5409885399236531", "friction: slippery", &["textures[0].friction: \"slippery\""]),
        ("friction: 0.5409885399236531", "friction: 7.5", &["friction[0][0]: 7.5 on dirt"]),
        ("friction: 0.5409885399236531\n", "speed: 3\n", &["textures[0].friction: is missing"]),
        (
            "terrain_type: rigid",
            "terrain_type: deformable",
            &["concrete does not belong in a world whose ground is"],
        ),
        ("textures:", "textures: []\nold:", &["textures: 0 entries"]),
        (
            "goal: [-60.0,",
            "goal: [26.12, -16.76, 0.0] #",
            &["positions[0]: goal [26.12, -16.76] is 0.00 m from"],
        ),
        ("goal: [-60.0,", "goal: [-90.0,", &["positions[0]: goal [-90.0,", "outside"]),
    ];
    for (from, to, expected) in cases {
        let dir = copy_of_world_1(&shared);
        let path = dir.path().join("BenchMaps/sampled_maps/Configs/Final/config1_high.yaml");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message = error(dir.path());
        for part in [&["config1_high.yaml: "], *expected].concat() {
            assert!(message.contains(part), "{from} -> {to}: {message}\nlacks {part}");
        }
    }
}

#[test]
fn the_layout_is_found_from_its_folder_and_from_above_and_below() {
    let Some(shared) = shared() else { return };
    let dir = copy_of_world_1(&shared);
    for place in ["", "BenchMaps", "BenchMaps/sampled_maps"] {
        assert_eq!(Source::find(dir.path().join(place)).unwrap().ids().collect::<Vec<_>>(), [1], "{place}");
    }
    // Other files beside the configs do no harm; a second config of the same world does.
    let configs = dir.path().join("BenchMaps/sampled_maps/Configs/Final");
    std::fs::write(configs.join("configuration.txt"), "").unwrap();
    std::fs::write(configs.join("config1_low.yaml"), "").unwrap();
    let message = Source::find(dir.path()).unwrap_err().to_string();
    assert!(message.contains("is also a config of world 1: remove one"), "{message}");
}

#[test]
fn missing_files_are_named() {
    let empty = tempfile::tempdir().unwrap();
    let message = error(empty.path());
    assert!(message.contains("no world found: give the original's BenchMaps folder"), "{message}");
    let Some(shared) = shared() else { return };
    for file in ["Worlds/1.bmp", "Configs/Final/labels1_high.npy"] {
        let dir = copy_of_world_1(&shared);
        std::fs::remove_file(dir.path().join("BenchMaps/sampled_maps").join(file)).unwrap();
        let message = error(dir.path());
        assert!(message.contains(file) && message.contains("cannot read"), "{message}");
    }
}
