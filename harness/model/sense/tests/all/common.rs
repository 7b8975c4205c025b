//! Worlds, vehicles and profiles that the tests share.

use std::sync::Arc;
use vb_sdk::metadata::Need;
use vb_sense::rays::Scene;
use vb_sense::{Perception, Profile, Readings, Seed, Truth};
use vb_sim::{Gear, VehicleState, WheelState};
use vb_vehicle::VehicleSpec;
use vb_world::{Heightfield, Obstacle, ObstacleKind, TerrainClass, World};

pub type V3 = nalgebra::Vector3<f64>;
pub type Quat = nalgebra::UnitQuaternion<f64>;

pub fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv.yaml").unwrap()
}

pub fn seed(run: u64, task: &str) -> Seed {
    Seed { run, task: task.to_owned() }
}

pub fn world(field: Heightfield, obstacles: Vec<Obstacle>) -> World {
    World { obstacles, ..World::uniform("w", field, TerrainClass::Dirt, 0.8) }
}

pub fn scene(field: Heightfield, obstacles: Vec<Obstacle>) -> Arc<Scene> {
    Arc::new(Scene::new(Arc::new(world(field, obstacles))))
}

/// Flat ground of 80 m by 80 m at height 0.
pub fn flat() -> Heightfield {
    Heightfield::flat(81, 81, 1.0, 0.0)
}

/// z = a + b x + c y, over 80 m by 80 m.
pub fn tilted(a: f64, b: f64, c: f64) -> Heightfield {
    let height = |i: usize| a + b * ((i % 81) as f64 - 40.0) + c * ((i / 81) as f64 - 40.0);
    Heightfield::new(81, 81, 1.0, (0..81 * 81).map(height).collect())
}

/// An upright box that stands on the ground.
pub fn upright(x: f64, y: f64, yaw: f64, size: [f64; 3]) -> Obstacle {
    Obstacle { x, y, yaw, buried: 0.0, kind: ObstacleKind::Box { size } }
}

/// A shipped profile with one text in place of another, which must be there.
pub fn altered(name: &str, changes: &[(&str, &str)]) -> Profile {
    Profile::parse(&altered_text(name, changes), name).unwrap()
}

pub fn altered_text(name: &str, changes: &[(&str, &str)]) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/perception");
    let mut text = std::fs::read_to_string(folder.join(format!("{name}.yaml"))).unwrap();
    for (old, new) in changes {
        assert!(text.contains(old), "{name} has no {old:?}");
        text = text.replace(old, new);
    }
    text
}

pub fn needs(names: &[&str]) -> Vec<Need> {
    names.iter().map(|n| Need::parse(n).unwrap()).collect()
}

/// A vehicle at rest with four wheels.
pub fn at(position: V3, attitude: Quat) -> VehicleState {
    VehicleState {
        time: 0.0,
        position,
        attitude,
        velocity_body: V3::zeros(),
        angular_velocity_body: V3::zeros(),
        wheels: vec![WheelState::default(); 4],
        steering: 0.0,
        gear: Gear::Forward,
        engine_speed: 0.0,
    }
}

/// A vehicle at rest at a height, looking along a heading.
pub fn standing(x: f64, y: f64, z: f64, yaw: f64) -> VehicleState {
    at(V3::new(x, y, z), Quat::from_axis_angle(&V3::z_axis(), yaw))
}

/// Lets a perception see states at samples 0, 1, … `last` and gives the readings at the end.
pub fn watch(p: &mut Perception, last: u64, state: impl Fn(f64) -> VehicleState) -> Readings {
    for k in 0..=last {
        let time = k as f64 * 0.01;
        let now = VehicleState { time, ..state(time) };
        p.sample(Truth { state: &now, ruts: None });
    }
    let time = last as f64 * 0.01;
    p.read(&VehicleState { time, ..state(time) })
}

/// A perception of the HMMWV.
pub fn perceive(profile: &Profile, names: &[&str], scene: &Arc<Scene>, seed: &Seed) -> Perception {
    Perception::new(profile, &needs(names), scene, &hmmwv(), seed).unwrap()
}
