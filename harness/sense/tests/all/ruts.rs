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
    let soils = SoilSet::parse(include_str!("../../../../tasks/soils/default.yaml"), "default.yaml").unwrap();
    let model = VehicleModel::new(hmmwv()).unwrap();
    let start = Pose2 { x: -20.0, y: 0.0, yaw: 0.0 };
    let mut sim = Simulation::new(world.clone(), &model, &soils, start, SimOptions::default()).unwrap();
    let oracle = Profile::built_in("oracle").unwrap();
    let scene = Arc::new(Scene::new(world));
    let mut p = perceive(&oracle, &["local-map"], &scene, &seed(1, "t"));
    p.sample(Truth { state: &sim.state(), ruts: Some(&sim) });
    for _ in 0..600 {
        let throttle = (3.0 - sim.state().velocity.x).clamp(0.0, 1.0);
        sim.advance(Controls { throttle, ..Controls::default() }, 10).unwrap();
        let state = sim.state();
        p.sample(Truth { state: &state, ruts: Some(&sim) });
    }
    let state = sim.state();
    let m = p.read(&state).local_map.unwrap();
    let x = state.position.x - 6.0;
    assert!(x > -15.0, "it drove {x}");
    // The wheels run 0.91 m to the left and to the right.
    let rut = sim.soil_change(x, state.position.y + 0.91).unwrap();
    assert!(rut < -0.02, "{rut} m");
    let lowest = (0..12).map(|k| m.elevation.nearest(x + 0.25 * f64::from(k) - 1.5, state.position.y + 0.91));
    let lowest = lowest.filter(|z| !z.is_nan()).fold(f32::INFINITY, f32::min);
    assert!(f64::from(lowest) < 0.4 * rut, "{lowest} m in a rut of {rut} m");
    let beside = m.elevation.nearest(x, state.position.y + 4.0);
    assert!(beside.abs() < 1e-4, "{beside} m");
}
