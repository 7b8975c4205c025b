//! Worlds and drives that the physics tests share.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::sync::Arc;
use vb_sim::{Controls, SimOptions, Simulation, SoilSet, VehicleSpec};
use vb_world::{Density, Elevation, Heightfield, Obstacle, Pose2, Semantics, Terrain, TerrainClass, World};

pub fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv.yaml")
        .expect("the shipped vehicle is valid")
}

/// The soils that come with the harness.
pub fn soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../tasks/soils/default.yaml"), "default.yaml")
        .expect("the shipped soils are valid")
}

/// A world of one friction value over the given heights.
pub fn world(heightfield: Heightfield, friction: f64, obstacles: Vec<Obstacle>) -> Arc<World> {
    let side = 2.0 * heightfield.half_x().max(heightfield.half_y());
    Arc::new(World {
        id: "test".to_owned(),
        elevation: Elevation::Low,
        terrain: Terrain::Rigid,
        density: Density::Sparse,
        scale: 1.0,
        heightfield,
        semantics: Semantics {
            rows: 1,
            cols: 1,
            patch: side,
            classes: vec![TerrainClass::Concrete],
            friction: vec![friction],
            soil: vb_world::SoilLevels::default(),
        },
        obstacles,
        tasks: vec![],
    })
}

/// A world of one soil over the given heights.
pub fn soil_world(heightfield: Heightfield, class: TerrainClass) -> Arc<World> {
    let mut w = Arc::unwrap_or_clone(world(heightfield, 0.0, vec![]));
    w.terrain = Terrain::Deformable;
    w.semantics.classes = vec![class];
    Arc::new(w)
}

/// The original's three soils.
pub fn original_soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../tasks/soils/original.yaml"), "original.yaml")
        .expect("the shipped soils are valid")
}

/// Published soils.
pub fn wong_soils() -> SoilSet {
    SoilSet::parse(include_str!("../../../../tasks/soils/wong.yaml"), "wong.yaml")
        .expect("the shipped soils are valid")
}

pub fn soil_start(
    world: &Arc<World>,
    soils: &SoilSet,
    [x, y]: [f64; 2],
    yaw: f64,
    options: SimOptions,
) -> Simulation {
    Simulation::new(world.clone(), &hmmwv(), soils, Pose2 { x, y, yaw }, options).expect("it settles")
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
    Simulation::new(world.clone(), &hmmwv(), &soils(), Pose2 { x, y, yaw }, SimOptions::default())
        .expect("it settles")
}

pub fn controls(steering: f64, throttle: f64, brake: f64) -> Controls {
    Controls { steering, throttle, brake }
}

/// The original's speed controller: P gain 1 on the speed error, throttle and brake in [0, 1] (facts §6.1).
pub fn hold_speed(sim: &Simulation, target: f64, steering: f64) -> Controls {
    let e = target - sim.state().velocity.x;
    controls(steering, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0))
}
