//! Worlds and drives that the physics tests share.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::sync::Arc;
use vb_sim::{Controls, SimOptions, Simulation, SoilSet};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Obstacle, Pose2, TerrainClass, World};

pub fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv.yaml")
        .expect("the shipped vehicle is valid")
}

/// The vehicle of Project Chrono's reference runs of standard events, on pneumatic tyres.
pub fn reference_hmmwv() -> VehicleSpec {
    let released = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");
    VehicleSpec::parse(released, "hmmwv-released.yaml")
        .expect("the shipped vehicle is valid")
        .with_tyre("brush")
        .expect("it has this tyre")
}

pub fn model(vehicle: VehicleSpec) -> VehicleModel {
    VehicleModel::new(vehicle).expect("its linkages close")
}

/// The soils that come with the harness.
pub fn soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../../tasks/soils/default.yaml"), "default.yaml")
        .expect("the shipped soils are valid")
}

/// A world of one friction value over the given heights.
pub fn world(heightfield: Heightfield, friction: f64, obstacles: Vec<Obstacle>) -> Arc<World> {
    let ground = World::uniform("test", heightfield, TerrainClass::Concrete, friction);
    Arc::new(World { obstacles, ..ground })
}

/// A world of one soil over the given heights.
pub fn soil_world(heightfield: Heightfield, class: TerrainClass) -> Arc<World> {
    Arc::new(World::uniform("test", heightfield, class, 0.0))
}

/// The original's three soils.
pub fn original_soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../../tasks/soils/original.yaml"), "original.yaml")
        .expect("the shipped soils are valid")
}

pub fn wong_soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../../tasks/soils/wong.yaml"), "wong.yaml")
        .expect("the shipped soils are valid")
}

pub fn soil_start(
    world: &Arc<World>,
    soils: &SoilSet,
    [x, y]: [f64; 2],
    yaw: f64,
    options: SimOptions,
) -> Simulation {
    Simulation::new(world.clone(), &model(hmmwv()), soils, Pose2 { x, y, yaw }, options).expect("it settles")
}

/// The vehicle of Chrono's reference runs on the original's soils, heading along x.
pub fn reference_soil_start(world: &Arc<World>, x: f64) -> Simulation {
    let start = Pose2 { x, y: 0.0, yaw: 0.0 };
    let vehicle = model(reference_hmmwv());
    Simulation::new(world.clone(), &vehicle, &original_soils(), start, SimOptions::default())
        .expect("it settles")
}

pub fn flat(friction: f64) -> Arc<World> {
    world(Heightfield::flat(301, 301, 1.0, 0.0), friction, vec![])
}

/// A plane that rises along x by `degrees`.
pub fn grade(degrees: f64, friction: f64) -> Arc<World> {
    let slope = vb_math::tan(degrees.to_radians());
    let (rows, cols) = (101, 401);
    let heights = (0..rows * cols).map(|i| slope * (i % cols) as f64).collect();
    world(Heightfield::new(rows, cols, 1.0, heights), friction, vec![])
}

pub fn start(world: &Arc<World>, x: f64, y: f64, yaw: f64) -> Simulation {
    Simulation::new(world.clone(), &model(hmmwv()), &soils(), Pose2 { x, y, yaw }, SimOptions::default())
        .expect("it settles")
}

pub fn controls(steering: f64, throttle: f64, brake: f64) -> Controls {
    Controls { steering, throttle, brake, ..Controls::default() }
}

/// The original's speed controller: P gain 1 on the speed error, throttle and brake in [0, 1] (`compute_throttle` in
/// its systems/PID/PID.py).
pub fn hold_speed(sim: &Simulation, target: f64, steering: f64) -> Controls {
    let e = target - sim.state().velocity_body.x;
    controls(steering, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0))
}
