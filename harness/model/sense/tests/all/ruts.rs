//! Ruts on soft soil.

use crate::common::{V3, flat, hmmwv, perceive, scene, seed};
use std::sync::Arc;
use vb_sense::rays::{Ruts, Scene};
use vb_sense::{Profile, Truth};
use vb_sim::{Controls, SimOptions, Simulation, SoilSet};
use vb_vehicle::VehicleModel;
use vb_world::{Heightfield, Pose2, TerrainClass, World};

/// A rut of 0.2 m from x = 5 to x = 6, and a heap of 0.1 m from x = 8 to x = 8.5.
struct Trench;

impl Ruts for Trench {
    fn change(&self, x: f64, _: f64) -> Option<f64> {
        let change = if (5.0..6.0).contains(&x) {
            -0.2
        } else if (8.0..8.5).contains(&x) {
            0.1
        } else {
            0.0
        };
        (x > 0.0 && x < 12.8).then_some(change)
    }

    fn cell(&self) -> f64 {
        0.1
    }
}

#[test]
fn a_ray_ends_on_the_floor_and_the_walls_of_ruts_and_on_heaps() {
    let s = scene(flat(), vec![]);
    // From 1 m over the ground, to where it would come down without ruts, and where it does.
    let cases = [
        // Before and after all of it.
        (4.0, 4.0),
        (11.0, 11.0),
        // Into the rut: on its floor, 1.2 m below.
        (5.0, 6.0),
        // On its floor from above the far edge would be beyond it: its wall is at x = 6.
        (5.5, 6.0),
        // On the heap, 0.9 m below.
        (9.2, 0.9 * 9.2),
        // On the front of the heap, at x = 8, where it is 0.05 m high.
        (8.0 / 0.95, 8.0),
    ];
    for (plain, expected) in cases {
        let direction = V3::new(plain, 0.0, -1.0).normalize();
        let hit = s.cast(&V3::new(0.0, 0.3, 1.0), &direction, 100.0, Some(&Trench)).unwrap();
        let x = hit.distance * direction.x;
        assert!((x - expected).abs() < 1e-3, "{plain}: {x}, expected {expected}");
    }
    let down = |x: f64| s.cast(&V3::new(x, 0.0, 1.0), &-V3::z(), 10.0, Some(&Trench)).unwrap().distance;
    assert!(
        (down(5.55) - 1.2).abs() < 1e-9
            && (down(8.25) - 0.9).abs() < 1e-9
            && (down(-3.0) - 1.0).abs() < 1e-12
    );
}

#[test]
fn the_wheels_of_a_vehicle_leave_ruts_that_its_lidar_sees() {
    let world = Arc::new(World::uniform("w", Heightfield::flat(129, 129, 1.0, 0.0), TerrainClass::Mud, 0.0));
    let soils =
        SoilSet::parse(include_str!("../../../../../tasks/soils/default.yaml"), "default.yaml").unwrap();
    let model = VehicleModel::new(hmmwv()).unwrap();
    let start = Pose2 { x: -20.0, y: 0.0, yaw: 0.0 };
    let mut sim = Simulation::new(world.clone(), &model, &soils, start, SimOptions::default()).unwrap();
    let oracle = Profile::built_in("oracle").unwrap();
    let scene = Arc::new(Scene::new(world));
    let mut sees = perceive(&oracle, &["lidar"], &scene, &seed(1, "t"));
    let mut ignores = perceive(&oracle, &["lidar"], &scene, &seed(1, "t"));
    let mut sample = |sim: &Simulation| {
        let state = sim.state();
        sees.sample(Truth { state: &state, ruts: Some(sim) });
        ignores.sample(Truth { state: &state, ruts: None });
    };
    sample(&sim);
    for _ in 0..600 {
        let throttle = (3.0 - sim.state().velocity_body.x).clamp(0.0, 1.0);
        sim.advance(Controls { throttle, ..Controls::default() }, 10).unwrap();
        sample(&sim);
    }
    let state = sim.state();
    // The wheels run 0.91 m to the left and to the right.
    let (x, y) = (state.position.x - 6.0, state.position.y + 0.91);
    assert!(x > -15.0, "it drove to {x}");
    let rut = sim.soil_change(x, y).unwrap();
    assert!(rut < -0.02, "{rut} m");
    let down = scene.cast(&V3::new(x, y, 3.0), &-V3::z(), 10.0, Some(&sim)).unwrap();
    assert!((down.distance - (3.0 - rut)).abs() < 1e-9, "{down:?} in a rut of {rut} m");
    let (with, without) = (sees.read(&state).lidar.unwrap(), ignores.read(&state).lidar.unwrap());
    let changed = with.ranges.iter().zip(&without.ranges).filter(|(a, b)| a != b);
    // Behind the vehicle two ruts of some 0.3 m run through the beams of rows that reach the ground, and the first beams
    // come down 6 m behind it.
    let (mut longer, mut most) = (0, 0.0_f32);
    for (a, b) in changed {
        longer += u32::from(a > b);
        most = most.max(a - b);
    }
    assert!(longer > 20 && f64::from(most) > -rut, "{longer} beams are longer, by up to {most} m");
    // Ahead, where no wheel has been, nothing has changed.
    let ahead = |r: &[f32]| r.iter().skip(256 - 20).step_by(512).copied().collect::<Vec<_>>();
    assert_eq!(ahead(&with.ranges), ahead(&without.ranges));
}
