//! The depth camera.

use crate::common::{V3, altered, flat, perceive, scene, seed, standing, upright, watch};
use vb_sdk::{DepthImage, DepthInfo};
use vb_sense::Profile;
use vb_world::{Heightfield, Semantics, SoilLevels, TerrainClass, World};

/// A camera that looks straight ahead from 2 m before the vehicle, where nothing of the vehicle is in its way.
const AHEAD: (&str, &str) = (
    "roof_front: {above_m: 0.1, pitch_deg: 15}",
    "at: {position_m: [3, 0, 1], roll_deg: 0, pitch_deg: 0, yaw_deg: 0}",
);

fn image(changes: &[(&str, &str)], scene: &std::sync::Arc<vb_sense::rays::Scene>) -> (DepthInfo, DepthImage) {
    let profile = altered("oracle", &[&[AHEAD], changes].concat());
    let mut p = perceive(&profile, &["depth"], scene, &seed(1, "t"));
    let info = p.depth_info().unwrap();
    (info, watch(&mut p, 0, |_| standing(0.0, 0.0, 0.0, 0.0)).depth.unwrap())
}

/// A wall 10 m before the camera.
fn wall() -> std::sync::Arc<vb_sense::rays::Scene> {
    scene(flat(), vec![upright(13.5, 0.0, 0.0, [1.0, 60.0, 30.0])])
}

#[test]
fn all_of_a_wall_across_has_one_depth_and_the_ground_that_of_a_pinhole() {
    let (info, image) = image(&[], &wall());
    assert_eq!((info.rows, info.cols, image.depths.len(), image.labels.len()), (64, 96, 64 * 96, 64 * 96));
    // 90° across 96 pixels: a focal length of 48 pixels.
    for row in 0..64 {
        let down = (f64::from(row) + 0.5 - 32.0) / 48.0;
        let ground = if down > 0.0 { 1.0 / down } else { f64::INFINITY };
        for col in 0..96 {
            let depth = f64::from(image.depths[row as usize * 96 + col]);
            let label = image.labels[row as usize * 96 + col];
            assert!((depth - ground.min(10.0)).abs() < 1e-4, "{row} {col}: {depth}");
            assert_eq!(label, if ground < 10.0 { TerrainClass::Dirt.label() } else { 10 }, "{row} {col}");
        }
    }
}

#[test]
fn rows_go_down_columns_go_right_and_what_is_out_of_range_is_zero() {
    // A post to the left of the camera.
    let s = scene(flat(), vec![upright(8.0, 2.5, 0.0, [0.5, 0.5, 30.0])]);
    let (_, image) = image(&[], &s);
    let at = |row: usize, col: usize| (image.depths[row * 96 + col], image.labels[row * 96 + col]);
    // It is at 2.5 m to the left in a depth of 4.75 m: 25 pixels left of the middle.
    let (depth, label) = at(5, 48 - 26);
    assert!((f64::from(depth) - 4.75).abs() < 1e-4, "{depth}");
    assert_eq!(label, 10);
    assert_eq!(at(5, 48 + 25), (0.0, 255), "the sky");
    assert!(at(60, 70).0 > 0.0 && at(60, 70).1 == TerrainClass::Dirt.label(), "the ground");
    // 1 m below the camera at a depth of 20 m are 2.4 pixels.
    assert_eq!((at(33, 70).0, at(35, 70).0 > 0.0), (0.0, true));
}

#[test]
fn the_error_grows_with_the_depth_squared() {
    let (_, noisy) =
        image(&[("error_per_m: 0", "error_per_m: 0.003"), ("dropout: 0\n", "dropout: 0.25\n")], &wall());
    let (_, exact) = image(&[], &wall());
    let (mut n, mut squares, mut lost) = (0.0, 0.0, 0.0);
    for (e, m) in exact.depths.iter().zip(&noisy.depths) {
        let (e, m) = (f64::from(*e), f64::from(*m));
        if m > 0.0 {
            let off = (m - e) / (0.003 * e * e);
            (n, squares) = (n + 1.0, squares + off * off);
        } else {
            lost += 1.0;
        }
    }
    assert!((squares / n - 1.0).abs() < 5.0 * f64::sqrt(2.0 / n), "{}", squares / n);
    let all = n + lost;
    assert!((lost / all - 0.25).abs() < 5.0 * f64::sqrt(0.25 * 0.75 / all), "{}", lost / all);
}

#[test]
fn classes_are_confused_as_often_as_stated() {
    let (_, image) =
        image(&[("labels: true\n", "labels: true\n  confusions: {dirt: {mud: 0.2, clay: 0.1}}\n")], &wall());
    let count = |label: u8| image.labels.iter().filter(|l| **l == label).count() as f64;
    let [dirt, mud, clay] =
        [TerrainClass::Dirt, TerrainClass::Mud, TerrainClass::Clay].map(|c| count(c.label()));
    let n = dirt + mud + clay;
    for (got, p) in [(dirt, 0.7), (mud, 0.2), (clay, 0.1)] {
        assert!((got / n - p).abs() < 5.0 * f64::sqrt(p * (1.0 - p) / n), "{got} of {n}");
    }
    assert_eq!(n + count(10), 64.0 * 96.0, "obstacles are recognised");
}

#[test]
fn a_camera_without_labels_has_none() {
    let (info, image) = image(&[("labels: true", "labels: false")], &wall());
    assert!(!info.labels && image.labels.is_empty() && image.depths[0] > 0.0);
}

#[test]
fn a_pixel_has_the_class_of_the_patch_that_it_sees() {
    let patches = Semantics {
        rows: 1,
        cols: 2,
        patch: 40.0,
        classes: vec![TerrainClass::Sand, TerrainClass::Grass],
        friction: vec![0.0, 0.5],
        soil: SoilLevels::default(),
    };
    let base = World::uniform("w", Heightfield::flat(41, 81, 1.0, 0.0), TerrainClass::Dirt, 0.8);
    let s = std::sync::Arc::new(vb_sense::rays::Scene::new(std::sync::Arc::new(World {
        semantics: patches,
        ..base
    })));
    let profile = altered("oracle", &[AHEAD]);
    let mut p = perceive(&profile, &["depth"], &s, &seed(1, "t"));
    // The camera is 5 m before the border at x = 0.
    let image = watch(&mut p, 0, |_| standing(-8.0, 0.0, 0.0, 0.0)).depth.unwrap();
    for (k, (depth, label)) in
        image.depths.iter().zip(&image.labels).enumerate().filter(|(_, (d, _))| **d > 0.0)
    {
        let expected = if *depth < 5.0 { TerrainClass::Sand } else { TerrainClass::Grass };
        assert_eq!(*label, expected.label(), "pixel {k} at {depth} m");
    }
    let here = V3::new(-8.0, 0.0, 0.0);
    assert_eq!(s.world().class_at(here.x, here.y), TerrainClass::Sand);
    assert!(Profile::built_in("oracle").is_some());
}
