//! What pictures promise, seen from outside: colours and places of pixels that follow from theory.

use std::path::PathBuf;
use std::sync::Arc;
use vb_render::{Change, Moment, Painter, RenderError, Size, View};
use vb_sim::{Gear, VehicleState, WheelState};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Obstacle, ObstacleKind, Semantics, SoilLevels, TerrainClass, World};

type V3 = nalgebra::Vector3<f64>;

const WHOLE: View = View::Top { window: None };

fn vehicles() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/vehicles")
}

fn model(name: &str) -> VehicleModel {
    let spec = VehicleSpec::load(&vehicles().join(format!("{name}.yaml"))).expect("shipped");
    VehicleModel::new(spec).expect("valid")
}

fn state(x: f64, y: f64, z: f64, yaw: f64) -> VehicleState {
    VehicleState {
        time: 0.0,
        position: V3::new(x, y, z),
        attitude: nalgebra::UnitQuaternion::from_axis_angle(&V3::z_axis(), yaw),
        velocity_body: V3::zeros(),
        angular_velocity_body: V3::zeros(),
        wheels: vec![WheelState::default(); 4],
        steering: 0.0,
        gear: Gear::Forward,
        engine_speed: 0.0,
    }
}

fn moment(state: &VehicleState) -> Moment<'_> {
    Moment {
        state,
        turned: &[],
        goal: [f64::NAN; 2],
        goal_radius: 0.0,
        path: &[],
        trail: &[],
        change: None,
        grains: &[],
        colour: None,
    }
}

fn square(side: u32) -> Size {
    Size { width: side, height: side }
}

/// Level ground of 40 m × 40 m.
fn level(class: TerrainClass) -> World {
    World::uniform("level", Heightfield::flat(41, 41, 1.0, 0.0), class, 0.5)
}

fn pixel(picture: &[u8], size: Size, col: usize, row: usize) -> [u8; 3] {
    let k = 3 * (row * size.width as usize + col);
    [picture[k], picture[k + 1], picture[k + 2]]
}

fn count(picture: &[u8], test: impl Fn([u8; 3]) -> bool) -> usize {
    picture.chunks_exact(3).filter(|p| test([p[0], p[1], p[2]])).count()
}

/// The yellow of the goal's jewel, in sun or shade.
fn golden(p: [u8; 3]) -> bool {
    p[0] > 100 && p[1] > 70 && p[2] < 60
}

/// The blue of the vehicle's body, in sun or shade.
fn blue(p: [u8; 3]) -> bool {
    u16::from(p[2]) > 2 * u16::from(p[0]) && p[2] > 50
}

#[test]
fn level_ground_has_the_colour_of_its_class_in_the_view_from_above() {
    let model = model("hmmwv");
    for class in TerrainClass::ALL {
        let painter = Painter::new(&Arc::new(level(class)), &model);
        // The vehicle is in the south-eastern corner.
        let state = state(15.0, -15.0, 0.7, 0.0);
        let size = square(80);
        let picture = painter.picture(WHOLE, size, &moment(&state)).unwrap();
        assert_eq!(picture.len(), size.bytes());
        for row in 0..40 {
            for col in 0..40 {
                assert_eq!(pixel(&picture, size, col, row), class.colour(), "{class:?} {col} {row}");
            }
        }
    }
}

#[test]
fn north_is_up_and_east_is_right_in_the_view_from_above() {
    let mut world = level(TerrainClass::Clay);
    let classes = [TerrainClass::Clay, TerrainClass::Rock, TerrainClass::Grass, TerrainClass::Snow];
    world.semantics = Semantics {
        rows: 2,
        cols: 2,
        patch: 20.0,
        classes: classes.to_vec(),
        friction: vec![0.5, 0.5, 0.5, 0.0],
        soil: SoilLevels::default(),
    };
    let painter = Painter::new(&Arc::new(world), &model("hmmwv"));
    let (state, size) = (state(0.0, 0.0, 0.7, 0.0), square(100));
    let picture = painter.picture(WHOLE, size, &moment(&state)).unwrap();
    // Classes are listed from the south-west eastwards, then the northern ones.
    for (class, [col, row]) in classes.into_iter().zip([[10, 90], [90, 90], [10, 10], [90, 10]]) {
        assert_eq!(pixel(&picture, size, col, row), class.colour(), "{class:?}");
    }
    // A picture that is wider than the world is high shows what is beyond it at both sides, of no class.
    let wide = Size { width: 200, height: 100 };
    let picture = painter.picture(WHOLE, wide, &moment(&state)).unwrap();
    assert_eq!(pixel(&picture, wide, 60, 10), TerrainClass::Grass.colour());
    for col in [40, 160] {
        let beyond = pixel(&picture, wide, col, 50);
        assert!(classes.iter().all(|c| c.colour() != beyond), "{beyond:?}");
    }
}

#[test]
fn a_window_follows_the_vehicle_and_has_the_size_that_it_is_asked_for() {
    let painter = Painter::new(&Arc::new(level(TerrainClass::Snow)), &model("hmmwv"));
    let size = square(200);
    let view = View::Top { window: Some(20.0) };
    for (x, y, yaw) in [(0.0, 0.0, 0.0), (6.0, -3.0, 1.0)] {
        let state = state(x, y, 0.7, yaw);
        let picture = painter.picture(view, size, &moment(&state)).unwrap();
        // 10 pixels a metre: the blue of the bonnet lies within 3.5 m of the middle, ahead of it.
        let (s, c) = vb_math::sin_cos(yaw);
        let at = |ahead: f64| {
            let (col, row) = (100.0 + 10.0 * ahead * c, 100.0 - 10.0 * ahead * s);
            pixel(&picture, size, col as usize, row as usize)
        };
        assert!(blue(at(1.6)), "{:?}", at(1.6));
        assert!(!blue(at(3.5)) && !blue(at(-4.5)));
    }
}

#[test]
fn a_box_in_front_hides_what_is_behind_it() {
    let model = model("hmmwv");
    let seen = |obstacles: Vec<Obstacle>| {
        let world = World { obstacles, ..level(TerrainClass::Snow) };
        let state = state(-12.0, 0.0, 0.7, 0.0);
        let moment = Moment { goal: [18.0, 0.0], ..moment(&state) };
        let size = Size { width: 320, height: 240 };
        let picture = Painter::new(&Arc::new(world), &model).picture(View::Chase, size, &moment).unwrap();
        count(&picture, golden)
    };
    let wall = |x: f64| Obstacle {
        x,
        y: 0.0,
        yaw: 0.0,
        buried: 0.5,
        kind: ObstacleKind::Box { size: [1.0, 12.0, 12.0] },
    };
    let free = seen(vec![]);
    assert!(free > 15, "{free}");
    assert_eq!(seen(vec![wall(10.0)]), 0);
    assert!(seen(vec![wall(25.0)]) >= free, "a wall behind the goal hides nothing");
}

#[test]
fn path_and_trail_lie_where_their_points_are() {
    let painter = Painter::new(&Arc::new(level(TerrainClass::Grass)), &model("hmmwv"));
    let state = state(0.0, -15.0, 0.7, 0.0);
    let (path, trail) = ([[-15.0, 5.0], [15.0, 5.0]], [[-15.0, -5.0, 0.0], [15.0, -5.0, 0.0]]);
    let moment =
        Moment { path: &path, trail: &trail, goal: [-10.0, 12.0], goal_radius: 3.0, ..moment(&state) };
    let size = square(800);
    let picture = painter.picture(WHOLE, size, &moment).unwrap();
    // 20 pixels a metre.
    let at = |x: f64, y: f64| pixel(&picture, size, (400.0 + 20.0 * x) as usize, (400.0 - 20.0 * y) as usize);
    let grass = TerrainClass::Grass.colour();
    assert!(at(3.0, 5.0).iter().all(|c| *c > 220), "white: {:?}", at(3.0, 5.0));
    assert!(blue(at(3.0, -5.0)), "{:?}", at(3.0, -5.0));
    for (x, y) in [(3.0, 6.0), (3.0, 4.0), (3.0, -4.0), (3.0, -6.0), (16.0, 5.0), (-16.0, -5.0)] {
        assert_eq!(at(x, y), grass, "{x} {y}");
    }
    // The ring around the goal, and nothing between it and the pole.
    for (x, y) in [(-7.0, 12.0), (-13.0, 12.0), (-10.0, 9.0)] {
        assert!(golden(at(x, y)), "{x} {y}: {:?}", at(x, y));
    }
    assert_eq!(at(-8.5, 12.0), grass);
    assert!(golden(at(-10.3, 12.0)), "the jewel from above");
}

#[test]
fn ruts_darken_ground_that_yields_and_no_other() {
    let model = model("hmmwv");
    let state = state(0.0, -15.0, 0.7, 0.0);
    let rut = |x: f64, y: f64| (x.abs() < 2.0 && y.abs() < 2.0).then_some(-0.1);
    let change: &Change<'_> = &rut;
    let size = square(80);
    for class in [TerrainClass::Snow, TerrainClass::Rock] {
        let painter = Painter::new(&Arc::new(level(class)), &model);
        let moment = Moment { change: Some(change), ..moment(&state) };
        let picture = painter.picture(WHOLE, size, &moment).unwrap();
        let middle = pixel(&picture, size, 40, 40);
        if class.is_deformable() {
            // 0.22 + 1.8 · 0.1 of the light are gone.
            let expected = class.colour().map(|c| 0.6 * f64::from(c));
            assert!(middle.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1.0), "{middle:?}");
        } else {
            assert_eq!(middle, class.colour());
        }
        assert_eq!(pixel(&picture, size, 46, 40), class.colour());
    }
}

#[test]
fn wheels_are_shown_at_their_steering_travel_and_angle() {
    let painter = Painter::new(&Arc::new(level(TerrainClass::Snow)), &model("hmmwv"));
    let size = Size { width: 320, height: 240 };
    // On its roof one sees the wheels.
    let mut over = state(0.0, 0.0, 1.5, 0.0);
    over.attitude *= nalgebra::UnitQuaternion::from_axis_angle(&V3::x_axis(), std::f64::consts::PI);
    let draw = |state: &VehicleState, turned: &[f64]| {
        let moment = Moment { turned, ..moment(state) };
        painter.picture(View::Chase, size, &moment).unwrap()
    };
    let straight = draw(&over, &[]);
    let steered = draw(&VehicleState { steering: 1.0, ..over.clone() }, &[]);
    let mut sprung = over.clone();
    sprung.wheels[0].deflection = 0.1;
    assert!(straight != steered && straight != draw(&sprung, &[]));
    assert!(straight != draw(&over, &[0.3; 4]));
    // Angles that are not given are 0.
    assert!(straight == draw(&over, &[0.0; 4]));
}

#[test]
fn every_vehicle_can_be_drawn_at_its_scale_and_looks_alike_at_another() {
    let world = level(TerrainClass::Grass);
    let mut drawn = 0;
    for entry in std::fs::read_dir(vehicles()).unwrap() {
        let model = VehicleModel::new(VehicleSpec::load(&entry.unwrap().path()).unwrap()).unwrap();
        let scale = model.spec().scale;
        let painter = Painter::new(&Arc::new(world.scaled(scale)), &model);
        let size = Size { width: 160, height: 120 };
        let state = VehicleState {
            wheels: vec![WheelState::default(); 2 * model.axles().len()],
            ..state(0.0, 0.0, 0.7 * scale, 0.5)
        };
        for view in [View::Chase, WHOLE, View::Top { window: Some(12.0 * scale) }] {
            let picture = painter.picture(view, size, &moment(&state)).unwrap();
            let share = count(&picture, blue) as f64 / f64::from(size.width * size.height);
            assert!(share > 0.0005 && share < 0.5, "{} {view:?}: {share}", model.spec().name);
        }
        drawn += 1;
    }
    assert!(drawn > 0);
}

#[test]
fn the_same_moment_gives_the_same_bytes() {
    let world = Arc::new(World {
        obstacles: vec![Obstacle {
            x: 8.0,
            y: 1.0,
            yaw: 0.3,
            buried: 1.0,
            kind: ObstacleKind::Boulder { size: [4.0, 3.0, 3.0], seed: 5 },
        }],
        ..level(TerrainClass::Mud)
    });
    let (model, state) = (model("m113"), state(0.0, 0.0, 1.0, 0.2));
    let size = Size { width: 317, height: 203 };
    let one = Painter::new(&world, &model);
    let first = one.picture(View::Chase, size, &moment(&state)).unwrap();
    // Again, from a painter of its own, and in another thread.
    assert!(first == one.picture(View::Chase, size, &moment(&state)).unwrap());
    let other = Painter::new(&world, &model);
    let picture = std::thread::scope(|s| {
        s.spawn(|| other.picture(View::Chase, size, &moment(&state)).unwrap()).join().unwrap()
    });
    assert!(first == picture);
}

#[test]
fn sizes_windows_and_poses_that_cannot_be_drawn_are_refused() {
    let painter = Painter::new(&Arc::new(level(TerrainClass::Clay)), &model("hmmwv"));
    let at = state(0.0, 0.0, 0.7, 0.0);
    let draw =
        |view, width, height| painter.picture(view, Size { width, height }, &moment(&at)).map(|p| p.len());
    for (width, height) in [(0, 10), (10, 0), (4097, 10), (10, 4097), (u32::MAX, u32::MAX)] {
        assert_eq!(draw(View::Chase, width, height), Err(RenderError::Size { width, height, most: 4096 }));
    }
    assert_eq!(draw(View::Chase, 1, 1), Ok(3));
    assert_eq!(draw(View::Chase, 4096, 2), Ok(3 * 4096 * 2));
    assert_eq!(draw(WHOLE, 2, 4096), Ok(3 * 4096 * 2));
    for side in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(draw(View::Top { window: Some(side) }, 10, 10), Err(RenderError::Window(side)));
    }
    assert!(matches!(draw(View::Top { window: Some(f64::NAN) }, 10, 10), Err(RenderError::Window(_))));
    let lost = state(f64::NAN, 0.0, 0.0, 0.0);
    assert_eq!(painter.picture(View::Chase, square(10), &moment(&lost)), Err(RenderError::Pose));
}
