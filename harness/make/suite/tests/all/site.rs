//! A survey becomes worlds that are the place.

use vb_suite::generate::GeneratorParams;
use vb_suite::site::{Cut, Site, SiteError, SiteParams, Survey};
use vb_terrain::ElevationImage;
use vb_world::{Density, Obstacle, ObstacleKind, Terrain, TerrainClass, World};

/// A raster of `z(x, y)` over an area about the origin, x east and y north, first row in the north.
fn raster(rows: usize, cols: usize, resolution: f64, z: impl Fn(f64, f64) -> f64) -> ElevationImage {
    let x = |c: usize| (c as f64 - 0.5 * (cols - 1) as f64) * resolution;
    let y = |r: usize| (0.5 * (rows - 1) as f64 - r as f64) * resolution;
    ElevationImage::new(rows, cols, (0..rows * cols).map(|i| z(x(i % cols), y(i / cols))).collect())
}

/// Gentle enough that a bilinear surface of 1 m is within millimetres of it.
fn hills(x: f64, y: f64) -> f64 {
    300.0 + 2.0 * vb_math::sin(x / 25.0) + 1.5 * vb_math::cos(y / 30.0) + 0.01 * x
}

fn worlds(
    survey: &Survey<'_>,
    cut: Cut,
    density: Density,
    site: &SiteParams,
    rules: &GeneratorParams,
    seed: u64,
) -> Result<Vec<World>, SiteError> {
    Site::new(survey, cut, density, site, rules, seed)?.worlds().collect()
}

fn make(survey: &Survey<'_>, cut: Cut, seed: u64) -> Result<Vec<World>, SiteError> {
    worlds(survey, cut, Density::Sparse, &SiteParams::default(), &GeneratorParams::default(), seed)
}

fn survey(heights: &ElevationImage, resolution: f64) -> Survey<'_> {
    Survey { heights, resolution, labels: None, obstacles: None, any_relief: false }
}

#[test]
fn a_world_has_the_heights_of_the_place_it_was_cut_from() {
    for resolution in [0.5, 1.0] {
        let n = (200.0 / resolution) as usize;
        let heights = raster(n, n, resolution, hills);
        let at = [20.0, -13.0];
        let world = make(&survey(&heights, resolution), Cut::At(at), 1).unwrap().remove(0);
        let low = world.heightfield.node(0, 0) - hills(at[0] - 64.0, at[1] - 64.0);
        for (x, y) in [(0.0, 0.0), (-50.0, 31.0), (63.0, -64.0), (12.5, 12.5)] {
            let expected = hills(x + at[0], y + at[1]) + low;
            let z = world.heightfield.height(x, y);
            assert!((z - expected).abs() < 5e-3, "resolution {resolution}, ({x}, {y}): {z} {expected}");
        }
        assert!(world.heightfield.range().0.abs() < 1e-9, "counted from the lowest place");
        assert_eq!((world.tasks.len(), world.terrain), (10, Terrain::Rigid));
        world.check().unwrap();
    }
}

#[test]
fn tiles_lie_side_by_side_from_the_north_west() {
    let heights = raster(260, 390, 1.0, hills);
    let all = make(&survey(&heights, 1.0), Cut::Tiles, 1).unwrap();
    assert_eq!(
        all.iter().map(|w| w.id.as_str()).collect::<Vec<_>>(),
        ["w001", "w002", "w003", "w004", "w005", "w006"]
    );
    // The western edge of the second is the eastern edge of the first, but for the heights they are counted from.
    let edge = |w: &World, x: f64| -> Vec<f64> {
        (-64..=64).map(|y| w.heightfield.height(x, f64::from(y))).collect()
    };
    let (east, west) = (edge(&all[0], 64.0), edge(&all[1], -64.0));
    let apart = east[0] - west[0];
    assert!(east.iter().zip(&west).all(|(a, b)| (a - b - apart).abs() < 1e-3));
    // The first is the north-western one: there the middle of the north-western quarter lies at (-128, 64).
    let rise = |w: &World, at: [f64; 2]| w.heightfield.height(at[0], at[1]) - w.heightfield.height(0.0, 0.0);
    let expected = hills(-128.0 + 30.0, 64.0 + 20.0) - hills(-128.0, 64.0);
    assert!((rise(&all[0], [30.0, 20.0]) - expected).abs() < 5e-3);
}

#[test]
fn ground_follows_the_labels_and_most_of_a_patch_decides() {
    let heights = raster(140, 140, 1.0, hills);
    // The north is mud; a strip of 3 m of a patch is too little to matter.
    let labels = raster(70, 70, 2.0, |_, y| if y > -3.0 { 7.0 } else { 2.0 });
    let mut site = SiteParams::default();
    site.ground.legend = [(7, TerrainClass::Mud), (2, TerrainClass::Grass)].into();
    let survey = Survey { labels: Some(&labels), ..survey(&heights, 1.0) };
    let rules = GeneratorParams::default();
    let made = worlds(&survey, Cut::At([0.0; 2]), Density::Sparse, &site, &rules, 1).unwrap().remove(0);
    assert_eq!(made.terrain, Terrain::Mixed);
    assert_eq!(made.class_at(5.0, 1.0), TerrainClass::Mud);
    assert_eq!(made.class_at(5.0, -1.0), TerrainClass::Grass, "3 of 8 m are mud");
    assert!(made.friction_at(5.0, -20.0) > 0.0 && made.friction_at(5.0, 20.0) == 0.0);
    site.ground.legend.remove(&7);
    let error = worlds(&survey, Cut::At([0.0; 2]), Density::Sparse, &site, &rules, 1).unwrap_err();
    assert!(error.to_string().contains("label 7 at (") && error.to_string().contains("legend"), "{error}");
}

#[test]
fn labels_of_another_rectangle_are_refused() {
    let heights = raster(140, 140, 1.0, hills);
    let labels = raster(100, 140, 1.0, |_, _| 2.0);
    let survey = Survey { labels: Some(&labels), ..survey(&heights, 1.0) };
    let error = make(&survey, Cut::At([0.0; 2]), 1).unwrap_err().to_string();
    assert!(
        error.contains("labels of 140 by 100 samples cannot cover the survey's 140 m by 140 m"),
        "{error}"
    );
}

#[test]
fn without_labels_steep_ground_is_what_the_rules_say() {
    // A wall of 45 degrees along x = 20.
    let heights = raster(140, 140, 1.0, |x, _| (x - 20.0).clamp(0.0, 4.0));
    let world = make(&survey(&heights, 1.0), Cut::At([0.0; 2]), 1).unwrap().remove(0);
    assert_eq!(world.class_at(21.0, 3.0), TerrainClass::Rock);
    assert_eq!([world.class_at(10.0, 3.0), world.class_at(30.0, 3.0)], [TerrainClass::Grass; 2]);
}

#[test]
fn a_hole_matters_only_where_a_world_lies() {
    let heights = raster(300, 300, 1.0, |x, y| {
        if vb_math::hypot(x - 100.0, y - 100.0) < 5.0 { f64::NAN } else { hills(x, y) }
    });
    assert!(make(&survey(&heights, 1.0), Cut::At([-70.0, -70.0]), 1).is_ok());
    let error = make(&survey(&heights, 1.0), Cut::At([80.0, 80.0]), 1).unwrap_err().to_string();
    assert!(error.contains("the height at (9") && error.contains("fill the hole"), "{error}");
}

#[test]
fn a_survey_that_is_too_small_is_refused_with_its_size() {
    let heights = raster(100, 400, 1.0, hills);
    for cut in [Cut::At([0.0; 2]), Cut::Tiles] {
        let error = make(&survey(&heights, 1.0), cut, 1).unwrap_err().to_string();
        assert!(error.contains("which is 400 m by 100 m"), "{error}");
    }
    let heights = raster(130, 130, 1.0, hills);
    assert!(make(&survey(&heights, 1.0), Cut::At([1.0, 0.0]), 1).is_ok());
    assert!(make(&survey(&heights, 1.0), Cut::At([1.5, 0.0]), 1).is_err());
}

#[test]
fn a_survey_with_room_for_more_worlds_than_are_made_is_refused_before_any_is() {
    let heights = raster(200, 200, 1.0, hills);
    for (resolution, worlds) in [(128.0, "40000"), (1e6, "2441406250000"), (1e300, "inf")] {
        let error = make(&survey(&heights, resolution), Cut::Tiles, 1).unwrap_err().to_string();
        assert!(
            error.contains(&format!("room for {worlds}")) && error.contains("limit of 999"),
            "{resolution}: {error}"
        );
    }
    // A grid that is fine enough for the generator's world may be too fine for a large one.
    let site = SiteParams { side: 4096.0, ..SiteParams::default() };
    let mut rules = GeneratorParams::default();
    rules.path.grid = 0.1;
    let error =
        Site::new(&survey(&heights, 50.0), Cut::Tiles, Density::Sparse, &site, &rules, 1).unwrap_err();
    assert!(error.to_string().contains("path.grid: 0.1 is too fine"), "{error}");
}

#[test]
fn obstacles_from_a_list_stand_where_they_are_and_starts_avoid_them() {
    let heights = raster(300, 300, 1.0, hills);
    let block = |x: f64, y: f64| Obstacle {
        x,
        y,
        yaw: 0.3,
        buried: 0.5,
        kind: ObstacleKind::Box { size: [4.0, 4.0, 3.0] },
    };
    // The second is where the first task would start, the third outside of the world.
    let list = [block(30.0, -10.0), block(80.0, -20.0), block(-120.0, 0.0)];
    let survey = Survey { obstacles: Some(&list), ..survey(&heights, 1.0) };
    let world = make(&survey, Cut::At([20.0, -20.0]), 1).unwrap().remove(0);
    assert_eq!(world.obstacles, [block(10.0, 10.0), block(60.0, 0.0)]);
    let start = world.tasks[0].start;
    assert!(vb_math::hypot(start.x - 60.0, start.y) > 5.0, "{start:?}");
    world.check().unwrap();
}

#[test]
fn starts_and_goals_stand_on_ground_that_is_not_too_steep() {
    // All that lies north of y = 10 but the very east is a slope of 45 degrees.
    let heights = raster(140, 140, 1.0, |x, y| if x < 52.0 { (y - 10.0).max(0.0) } else { 0.0 });
    let world = make(&survey(&heights, 1.0), Cut::At([0.0; 2]), 1).unwrap().remove(0);
    for task in &world.tasks {
        assert!(task.start.y < 10.0 && task.goal[1] < 10.0 || task.start.x > 52.0 || task.goal[0] > 52.0);
    }
    let steep = raster(140, 140, 1.0, |x, _| x);
    let error = make(&survey(&steep, 1.0), Cut::At([0.0; 2]), 1).unwrap_err().to_string();
    assert!(
        error.contains("no start and goal at a distance of 120 m") && error.contains("tasks.stand.tilt"),
        "{error}"
    );
}

#[test]
fn heights_in_a_wrong_unit_are_refused_with_the_option_that_gives_it() {
    let centimetres = raster(300, 300, 1.0, |x, y| 100.0 * hills(x, y) + 3000.0 * vb_math::sin(x / 3.0));
    let error = make(&survey(&centimetres, 1.0), Cut::At([0.0; 2]), 1).unwrap_err();
    assert!(matches!(error, SiteError::Relief { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("--unit 0.01") && text.contains("--any-relief") && !text.contains("tasks."),
        "{text}"
    );
    // Whoever wants it may have it, as far as anything can start there.
    let wanted = Survey { any_relief: true, ..survey(&centimetres, 1.0) };
    let error = make(&wanted, Cut::At([0.0; 2]), 1).unwrap_err();
    assert!(matches!(error, SiteError::Steep { .. }) && error.to_string().contains("--unit"), "{error}");
}

#[test]
fn the_level_follows_from_slopes_without_the_mean_plane() {
    let plain = raster(140, 140, 1.0, |x, y| 0.05 * x + 0.03 * y + 0.1 * vb_math::sin(x / 9.0));
    let world = make(&survey(&plain, 1.0), Cut::At([0.0; 2]), 1).unwrap().remove(0);
    let (low, high) = world.heightfield.range();
    assert!(high - low > 9.0, "{low} to {high}: as much relief as any world of vb-100");
    assert_eq!(world.elevation, vb_world::Elevation::Low);
}

/// The worlds that come with the harness are what they are called, but for those whose slopes lie where both levels have worlds.
#[test]
fn the_levels_are_those_of_the_benchmark() {
    let tasks = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
    for (name, others) in [("vb-100", 3), ("smoke", 1)] {
        let suite = vb_world::Suite::open(tasks.join(name)).unwrap();
        let rules = GeneratorParams::default();
        let level = |id: &str| vb_suite::level::level(&suite.load_world(id).unwrap().heightfield, &rules);
        let differ: Vec<_> =
            suite.worlds().iter().filter(|w| level(&w.id) != w.elevation).map(|w| &w.id).collect();
        assert!(differ.len() <= others, "{name}: {differ:?}");
    }
}

#[test]
fn what_is_drawn_follows_from_the_seed() {
    let heights = raster(140, 140, 1.0, hills);
    let of = |seed| make(&survey(&heights, 1.0), Cut::At([0.0; 2]), seed).unwrap();
    assert!(of(1) == of(1) && of(1) != of(2));
}
