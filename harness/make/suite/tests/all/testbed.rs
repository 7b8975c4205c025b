//! Beds for trials of one task: what their rules promise, and that the one in `tasks` is what they make.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::collections::BTreeMap;
use std::path::Path;
use vb_math::angle::{degrees, turn};
use vb_math::{atan2, hypot};
use vb_suite::testbed::{Testbed, TestbedParams};
use vb_terrain::Model;
use vb_world::{Elevation, Suite, Terrain, TerrainClass, World};

/// Seed of the suite in `tasks`.
const SEED: u64 = 2027;

/// The terrain model of the built-in rules.
fn model() -> Model {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/terrain/rocks.safetensors");
    Model::read(Path::new(file)).unwrap()
}

fn made(text: &str, seed: u64) -> Vec<World> {
    let rules = TestbedParams::parse(text, "mine.yaml").unwrap();
    Testbed { rules: &rules, model: &model(), seed }.worlds().unwrap()
}

#[test]
fn the_testbed_in_tasks_is_what_its_rules_make() {
    let suite = Suite::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/testbed")).unwrap();
    let (rules, model) = (TestbedParams::default(), model());
    let testbed = Testbed { rules: &rules, model: &model, seed: SEED };
    assert_eq!(*suite.meta(), testbed.meta("testbed", "2"));
    let worlds = testbed.worlds().unwrap();
    assert_eq!(suite.worlds().len(), worlds.len());
    for world in &worlds {
        assert!(suite.load_world(&world.id).unwrap() == *world, "{}", world.id);
    }
    assert!(made(TestbedParams::DEFAULT_YAML, SEED + 1) != worlds, "another seed makes other beds");
}

#[test]
fn a_low_and_a_high_bed_have_equal_shares_of_four_materials_and_no_obstacles() {
    let worlds = made(TestbedParams::DEFAULT_YAML, 3);
    assert_eq!(worlds.iter().map(|w| w.elevation).collect::<Vec<_>>(), [Elevation::Low, Elevation::High]);
    for world in &worlds {
        assert_eq!((world.terrain, world.obstacles.len()), (Terrain::Rigid, 0));
        let mut patches = BTreeMap::new();
        for class in &world.semantics.classes {
            *patches.entry(class.name()).or_insert(0) += 1;
        }
        // 8 x 8 patches of 10 m; foam bears the class of clay.
        assert_eq!(patches, BTreeMap::from([("clay", 16), ("grass", 16), ("rock", 16), ("wood", 16)]));
        let mean = |class: TerrainClass| {
            let of_class = world.semantics.classes.iter().zip(&world.semantics.friction);
            of_class.filter(|(c, _)| **c == class).map(|(_, mu)| mu).sum::<f64>() / 16.0
        };
        // Sixteen draws fix the mean to a quarter of their standard deviation; four times that is allowed.
        for (class, mu, std) in [
            (TerrainClass::Rock, 0.65, 0.08),
            (TerrainClass::Clay, 0.60, 0.05),
            (TerrainClass::Grass, 0.36, 0.07),
            (TerrainClass::Wood, 0.45, 0.06),
        ] {
            assert!((mean(class) - mu).abs() < std, "{}: {}", class.name(), mean(class));
        }
    }
    let spread = |w: &World| {
        let z = w.heightfield.heights();
        let mean = z.iter().sum::<f64>() / z.len() as f64;
        (z.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / z.len() as f64).sqrt()
    };
    // 0.165 and 0.55 m over many beds; one differs by some 13 %.
    for (world, std) in worlds.iter().zip([0.165, 0.55]) {
        assert!((spread(world) / std - 1.0).abs() < 0.3, "{}: {}", world.id, spread(world));
    }
}

#[test]
fn trials_go_to_one_goal_from_starts_that_differ_by_the_noise() {
    let many = TestbedParams::DEFAULT_YAML.replace("trials: {count: 5,", "trials: {count: 100,");
    for world in made(&many, 4) {
        let goal = world.tasks[0].goal;
        // The undisturbed start lies opposite the goal, 72 m away.
        let [x, y] = goal.map(|v| -v);
        assert!((hypot(x, y) - 36.0).abs() < 1e-3);
        let heading = atan2(goal[1] - y, goal[0] - x);
        let off: Vec<[f64; 3]> = (world.tasks.iter())
            .map(|t| [t.start.x - x, t.start.y - y, degrees(turn(heading, t.start.yaw))])
            .collect();
        for (k, std) in [0.5, 0.5, 5.0].into_iter().enumerate() {
            // Clipped at two standard deviations, which leaves 0.96 of one (the normal distribution's second moment
            // there); a hundred draws fix it to 7 %, and are allowed three times that.
            assert!(off.iter().all(|o| o[k].abs() <= 2.0 * std + 1e-3));
            let rms = (off.iter().map(|o| o[k] * o[k]).sum::<f64>() / 100.0).sqrt();
            assert!((rms / std - 0.96).abs() < 0.21, "{}: {rms}", world.id);
        }
        assert!(
            world.tasks.iter().all(|t| t.goal == goal && t.path.first() == Some(&[t.start.x, t.start.y]))
        );
        assert!(world.tasks.windows(2).all(|t| t[0].start != t[1].start));
    }
    let still = TestbedParams::DEFAULT_YAML
        .replace("noise: {position: 0.5, heading: 5.0}", "noise: {position: 0.0, heading: 0.0}");
    for world in made(&still, 4) {
        assert!(world.tasks.windows(2).all(|t| t[0].start == t[1].start));
    }
}

#[test]
fn rules_that_no_surface_can_keep_are_named_as_the_file_names_them() {
    let error = |changes: &[(&str, &str)]| {
        let mut text = TestbedParams::DEFAULT_YAML.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let rules = TestbedParams::parse(&text, "mine.yaml").unwrap();
        Testbed { rules: &rules, model: &model(), seed: 1 }.worlds().unwrap_err().to_string()
    };
    // A small surface is drawn faster, and all of them are drawn in vain.
    let level = error(&[
        ("side: 80.0", "side: 20.0"),
        ("distance: 72.0", "distance: 10.0"),
        ("tilt: 15.0", "tilt: 0.01"),
    ]);
    assert!(
        level.contains("w001: no start and goal at a distance of 10 m") && level.contains("raise stand.tilt"),
        "{level}"
    );
    let rough = error(&[("std: 0.165", "std: 99.0")]);
    assert!(rough.starts_with("bed or elevation: a relief fraction of"), "{rough}");
}
