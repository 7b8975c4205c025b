//! Vehicles on granular beds.

use crate::common::{controls, hmmwv, model, soils};
use std::sync::Arc;
use vb_granular::MaterialFile;
use vb_sim::{SimOptions, Simulation, Surroundings};
use vb_vehicle::VehicleSpec;
use vb_world::{GranularBed, Heightfield, Pose2, Semantics, SoilLevels, TerrainClass, World};

/// A level world of 32 × 8 m with one bed in its middle.
fn bed(material: &str, length: f64, depth: f64) -> Arc<World> {
    let grains = MaterialFile::resolve(material).unwrap().grains;
    let (rows, cols) = (16, 64);
    let bed = GranularBed {
        name: material.into(),
        x: 0.0,
        y: 0.0,
        length,
        width: 4.0,
        depth,
        seed: 1,
        material: grains.clone(),
    };
    let patch = |k: usize| {
        let (x, y) = ((k % cols) as f64 * 0.5 - 15.75, (k / cols) as f64 * 0.5 - 3.75);
        if bed.contains(x, y) { grains.class } else { TerrainClass::Concrete }
    };
    let classes: Vec<_> = (0..rows * cols).map(patch).collect();
    let friction = classes.iter().map(|c| if c.is_deformable() { 0.0 } else { 0.8 }).collect();
    let ground = World::uniform("test", Heightfield::flat(9, 33, 1.0, 2.0), TerrainClass::Concrete, 0.8);
    let semantics = Semantics { rows, cols, patch: 0.5, classes, friction, soil: SoilLevels::default() };
    let terrain =
        if grains.class.is_deformable() { vb_world::Terrain::Mixed } else { vb_world::Terrain::Rigid };
    let world = World { terrain, semantics, beds: vec![bed], ..ground };
    world.check().unwrap();
    Arc::new(world)
}

fn start(spec: VehicleSpec, around: &Surroundings, x: f64) -> Simulation {
    let start = Pose2 { x, y: 0.0, yaw: 0.0 };
    let options = SimOptions { settle_time: 0.6, ..SimOptions::default() };
    Simulation::new(around.clone(), &model(spec), &soils(), start, options).unwrap()
}

/// The weight of the whole vehicle, N, from its loads on level rigid ground.
fn weight(spec: VehicleSpec) -> f64 {
    let rigid = World::uniform("rigid", Heightfield::flat(9, 33, 1.0, 0.0), TerrainClass::Concrete, 0.8);
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let sim = Simulation::new(Arc::new(rigid), &model(spec), &soils(), start, SimOptions::default()).unwrap();
    sim.state().wheels.iter().map(|w| w.load).sum()
}

fn loads(sim: &Simulation) -> f64 {
    sim.state().wheels.iter().map(|w| w.load).sum()
}

/// Advances the simulation, and returns the mean of the sum of the wheels' loads over the time, N.
fn mean_load(sim: &mut Simulation, throttle: f64, brake: f64, steps: u64) -> f64 {
    let mut sum = 0.0;
    sim.advance_watched(controls(0.0, throttle, brake), steps, |sim| sum += loads(sim)).unwrap();
    sum / steps as f64
}

#[test]
fn a_car_stands_on_gravel_with_its_weight_and_drives() {
    let around: Surroundings = bed("gravel", 8.0, 0.2).into();
    let mut sim = start(hmmwv(), &around, -1.5);
    mean_load(&mut sim, 0.0, 1.0, 600);
    let load = mean_load(&mut sim, 0.0, 1.0, 400);
    assert!((load / weight(hmmwv()) - 1.0).abs() < 0.02, "{load} of {} N", weight(hmmwv()));
    // A wheel of 6 kN sinks by 0.04 m where it is rigid (docs/granular.md); a tyre yields as well.
    let deepest = sim.state().wheels.iter().map(|w| w.sinkage).fold(0.0, f64::max);
    assert!((0.02..0.15).contains(&deepest), "{deepest} m");
    let before = sim.state().position;
    mean_load(&mut sim, 0.5, 0.0, 1200);
    let s = sim.state();
    assert!(s.position.x - before.x > 0.3 && s.velocity_body.x > 0.5, "{s:?}");
    assert!((s.position.z - before.z).abs() < 0.03 && s.position.y.abs() < 0.05, "{s:?}");
}

#[test]
fn a_car_drives_from_rigid_ground_over_a_bed_and_out_of_it() {
    let around: Surroundings = bed("gravel", 2.0, 0.2).into();
    let mut sim = start(hmmwv(), &around, -3.5);
    let mut deepest = 0.0_f64;
    let mut rises = 0.0_f64;
    let z = sim.state().position.z;
    while sim.state().position.x < 4.0 && sim.time() < 12.0 {
        sim.advance(controls(0.0, 0.5, 0.0), 20).unwrap();
        let s = sim.state();
        deepest = s.wheels.iter().map(|w| w.sinkage).fold(deepest, f64::max);
        rises = rises.max((s.position.z - z).abs());
    }
    assert!(sim.state().position.x >= 4.0, "{:?}", sim.state());
    assert!(deepest > 0.05, "{deepest} m");
    // No wheel is thrown out at the edge.
    assert!(rises < 0.15, "{rises} m");
}

#[test]
fn a_drive_over_grains_has_equal_bits_and_a_clone_goes_on_as_its_original() {
    let around: Surroundings = bed("gravel", 6.0, 0.2).into();
    let bits = |sim: &Simulation| {
        let mut bits = Vec::new();
        sim.visit_state(|x| bits.push(x.to_bits()));
        bits.extend(sim.grains().flat_map(|(at, _)| at).map(f64::to_bits));
        bits
    };
    let drive = || {
        // A second packing of the same bed.
        let again: Surroundings = around.world().clone().into();
        let mut sim = start(hmmwv(), &again, -0.5);
        sim.advance(controls(0.2, 0.4, 0.0), 200).unwrap();
        sim
    };
    let (mut first, second) = (drive(), drive());
    assert_eq!(bits(&first), bits(&second));
    let mut clone = first.clone();
    for sim in [&mut first, &mut clone] {
        sim.advance(controls(-0.2, 0.2, 0.0), 100).unwrap();
    }
    assert_eq!(bits(&first), bits(&clone));
}

#[test]
fn a_hull_lies_on_grains() {
    let around: Surroundings = bed("gravel", 6.0, 0.2).into();
    let mut sim = start(hmmwv(), &around, 0.0);
    sim.rig().overturn(std::f64::consts::PI, 1.4);
    sim.advance(controls(0.0, 0.0, 1.0), 1000).unwrap();
    let s = sim.state();
    assert!(sim.upward() < -0.9 && s.velocity_body.norm() < 0.3, "{s:?}");
    // rapier, which knows nothing of grains, would hold it on the ground beside: all of the roof is over the bed.
    let lowest = sim.grains().map(|(at, _)| at[2]).fold(f64::INFINITY, f64::min);
    assert!(lowest > 1.8, "grains stay in the bin: {lowest}");
    assert!((2.5..3.6).contains(&s.position.z), "{}", s.position.z);
}

#[test]
fn belts_press_and_pull_on_grains() {
    let m113 =
        || VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/m113.yaml"), "m113.yaml").unwrap();
    let around: Surroundings = bed("gravel", 8.0, 0.2).into();
    let mut sim = start(m113(), &around, 0.0);
    let load = mean_load(&mut sim, 0.0, 1.0, 200);
    assert!((load / weight(m113()) - 1.0).abs() < 0.05, "{load} N of {} N", weight(m113()));
    mean_load(&mut sim, 0.6, 0.0, 1000);
    let s = sim.state();
    assert!(s.velocity_body.x > 0.5 && s.position.y.abs() < 0.1, "{s:?}");
}

#[test]
fn grains_larger_than_a_wheel_are_refused() {
    let mut world = (*bed("gravel", 6.0, 0.3)).clone();
    world.beds[0].material.radius = [0.4, 0.5];
    let around: Surroundings = Arc::new(world).into();
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let made = Simulation::new(around, &model(hmmwv()), &soils(), start, SimOptions::default());
    let message = made.err().unwrap().to_string();
    assert!(message.contains("radius 0.5 m, larger than the vehicle's wheels of radius 0.4"), "{message}");
}

#[test]
fn a_car_drives_from_deformable_soil_onto_grains() {
    let mut world = (*bed("gravel", 2.0, 0.2)).clone();
    world.terrain = vb_world::Terrain::Mixed;
    for (class, friction) in world.semantics.classes.iter_mut().zip(&mut world.semantics.friction) {
        if *class == TerrainClass::Concrete {
            (*class, *friction) = (TerrainClass::Sand, 0.0);
        }
    }
    world.check().unwrap();
    let around: Surroundings = Arc::new(world).into();
    let mut sim = start(hmmwv(), &around, -4.0);
    let rut = sim.state().wheels.iter().map(|w| w.sinkage).fold(f64::INFINITY, f64::min);
    assert!(rut > 0.005, "all wheels stand in soil, the least by {rut} m");
    while sim.state().position.x < 0.0 && sim.time() < 12.0 {
        sim.advance(controls(0.0, 0.7, 0.0), 20).unwrap();
    }
    // All wheels bear the weight together, wherever they are.
    let load = mean_load(&mut sim, 0.3, 0.0, 400);
    assert!((load / weight(hmmwv()) - 1.0).abs() < 0.05, "{load} of {} N", weight(hmmwv()));
    assert!(sim.state().position.x > 0.0, "{:?}", sim.state());
}

#[test]
fn a_bed_at_scale_one_tenth_bears_a_vehicle_of_this_scale_as_the_bed_does_one_of_full_size() {
    let spec = include_str!("../../../../../tasks/vehicles/verti4wheeler.yaml");
    let small = || VehicleSpec::parse(spec, "verti4wheeler.yaml").unwrap();
    let scale = small().scale;
    let around: Surroundings = Arc::new(World::clone(&bed("gravel", 8.0, 0.2)).at_scale(scale)).into();
    let radius = around.world().beds[0].material.radius[1];
    assert!((radius - 0.045 * scale).abs() < 1e-12, "{radius}");
    let mut sim = start(small(), &around, -scale);
    mean_load(&mut sim, 0.0, 1.0, 300);
    let load = mean_load(&mut sim, 0.0, 1.0, 200);
    assert!((load / weight(small()) - 1.0).abs() < 0.02, "{load} of {} N", weight(small()));
    let deepest = sim.state().wheels.iter().map(|w| w.sinkage).fold(0.0, f64::max);
    assert!(deepest < 0.15 * scale, "{deepest} m");
    let before = sim.state().position.x;
    mean_load(&mut sim, 0.6, 0.0, 800);
    assert!(sim.state().position.x - before > 0.3 * scale, "{:?}", sim.state());
}
