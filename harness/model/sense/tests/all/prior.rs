//! The maps that a planner is given at the start.

use crate::common::{altered, flat, seed, tilted, upright, world};
use vb_sense::{PriorMaps, Profile};
use vb_world::{Semantics, SoilLevels, TerrainClass, World};

fn maps(profile: &Profile, world: &World) -> PriorMaps {
    PriorMaps::new(profile, world, &seed(1, "w/t"))
}

#[test]
fn under_the_oracle_they_are_the_world() {
    let w = world(tilted(1.0, 0.1, 0.2), vec![upright(3.3, 4.4, 0.3, [2.0, 1.0, 1.0])]).scaled(1.0 / 6.0);
    let m = maps(&Profile::built_in("oracle").unwrap(), &w);
    let (e, s, o) = (m.elevation.unwrap(), m.semantics.unwrap(), m.occupancy.unwrap());
    let h = &w.heightfield;
    assert_eq!((e.frame.rows, e.frame.cols, e.frame.resolution), (81, 81, h.resolution()));
    assert_eq!((e.frame.origin_x, e.frame.origin_y), (-h.half_x(), -h.half_y()));
    assert!(e.data.iter().zip(h.heights()).all(|(a, b)| *a == *b as f32));
    assert_eq!((s.frame.rows, s.frame.cols, s.data.len()), (1, 1, 1));
    assert_eq!(s.data[0], TerrainClass::Dirt.label());
    let expected = w.occupancy(0.5 / 6.0);
    assert_eq!((o.frame.rows as usize, o.frame.origin_x), (expected.rows, expected.origin[0]));
    assert_eq!(o.data, expected.data);
    assert!(o.data.contains(&1));
}

#[test]
fn a_coarse_map_is_the_mean_with_errors_of_the_stated_size_and_no_obstacles() {
    let exact = altered("onboard", &[("error_std_m: 0.3", "error_std_m: 0")]);
    let w = world(tilted(1.0, 0.1, 0.2), vec![]);
    let e = maps(&exact, &w).elevation.unwrap();
    assert_eq!((e.frame.rows, e.frame.cols, e.frame.resolution, e.frame.origin_x), (21, 21, 4.0, -40.0));
    // The mean of a plane over a square about a place is its height there; at the edge only what is within counts.
    for row in 1..20 {
        for col in 1..20 {
            let (x, y) = e.frame.position(row, col);
            assert!((f64::from(e.at(row, col)) - (1.0 + 0.1 * x + 0.2 * y)).abs() < 1e-5, "{row} {col}");
        }
    }
    assert_eq!(maps(&exact, &w).occupancy, None);
    let onboard = Profile::built_in("onboard").unwrap();
    let (mut squares, mut product) = (0.0, 0.0);
    for run in 0..400 {
        let m = PriorMaps::new(&onboard, &w, &seed(run, "w/t")).elevation.unwrap();
        let off = |row, col| f64::from(m.at(row, col) - e.at(row, col));
        squares += off(10, 10) * off(10, 10) / 400.0;
        product += off(10, 10) * off(10, 14) / 400.0;
    }
    // 0.3 m, correlated by exp(−16/30) over 16 m.
    let bound = 5.0 * f64::sqrt(2.0 / 400.0);
    assert!((squares / 0.09 - 1.0).abs() < bound, "{squares}");
    assert!((product / 0.09 - vb_math::exp(-16.0 / 30.0)).abs() < bound, "{product}");
}

#[test]
fn a_coarse_map_of_the_ground_has_the_commonest_class_and_its_confusions() {
    let patches = |rows: usize, cols: usize, classes: Vec<TerrainClass>, patch: f64| Semantics {
        rows,
        cols,
        patch,
        friction: vec![0.5; classes.len()],
        classes,
        soil: SoilLevels::default(),
    };
    // Three columns of grass to one of mud, in squares of two columns of patches: 1 m to 2 m.
    let sure = altered("onboard", &[("resolution_m: 8", "resolution_m: 4")]);
    let classes =
        (0..80 * 80).map(|i| if i % 4 == 3 { TerrainClass::Snow } else { TerrainClass::Grass }).collect();
    let w = World { semantics: patches(80, 80, classes, 1.0), ..world(flat(), vec![]) };
    let s = maps(&sure, &w).semantics.unwrap();
    assert_eq!((s.frame.rows, s.frame.cols, s.frame.resolution, s.frame.origin_x), (20, 20, 4.0, -38.0));
    let share = |label: TerrainClass, data: &[u8]| {
        data.iter().filter(|l| **l == label.label()).count() as f64 / data.len() as f64
    };
    // Grass is taken for dirt in 3 % of 400 squares.
    assert!((share(TerrainClass::Dirt, &s.data) - 0.03).abs() < 5.0 * f64::sqrt(0.03 * 0.97 / 400.0));
    assert!((share(TerrainClass::Dirt, &s.data) + share(TerrainClass::Grass, &s.data) - 1.0).abs() < 1e-12);
}

#[test]
fn degraded_knows_nothing_beforehand() {
    let m = maps(&Profile::built_in("degraded").unwrap(), &world(flat(), vec![]));
    assert_eq!(m, PriorMaps::default());
}
