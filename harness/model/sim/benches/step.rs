//! Cost of simulating one vehicle, as a multiple of real time: `cargo bench -p vb-sim`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use vb_sim::SimOptions;
use vb_world::TerrainClass;

#[path = "../tests/common/mod.rs"]
mod common;

fn rugged(deviation: f64) -> std::sync::Arc<vb_world::World> {
    let n = 129;
    let mut s = vb_math::rng::Stream::new(2, &["bench"]);
    let h = (0..n * n).map(|_| s.normal(0.0, deviation)).collect();
    common::world(vb_world::Heightfield::new(n, n, 1.0, h), 0.6, vec![])
}

fn on_soil(class: TerrainClass) -> std::sync::Arc<vb_world::World> {
    common::soil_world(vb_world::Heightfield::flat(301, 301, 1.0, 0.0), class)
}

/// One element of throughput is one simulated millisecond: 1 Melem/s is 1000 times real time.
fn step(c: &mut Criterion) {
    let mut group = c.benchmark_group("simulate 1 s at 1 ms");
    group.throughput(Throughput::Elements(1000)).sample_size(20);
    let soft = {
        let mut w = std::sync::Arc::unwrap_or_clone(rugged(0.15));
        w.terrain = vb_world::Terrain::Deformable;
        w.semantics.classes = vec![TerrainClass::Mud];
        std::sync::Arc::new(w)
    };
    for (name, world, soil_resolution) in [
        ("rigid, flat", common::flat(0.8), 0.1),
        ("rigid, rough", rugged(0.15), 0.1),
        ("mud at 0.1 m, flat", on_soil(TerrainClass::Mud), 0.1),
        ("sand at 0.1 m, flat", on_soil(TerrainClass::Sand), 0.1),
        ("snow at 0.1 m, flat", on_soil(TerrainClass::Snow), 0.1),
        ("mud at 0.1 m, rough", soft, 0.1),
        ("mud at 0.05 m, flat", on_soil(TerrainClass::Mud), 0.05),
    ] {
        let options = SimOptions { soil_resolution, ..SimOptions::default() };
        let (model, soils) = (common::model(common::hmmwv()), common::soils());
        let start = || {
            let start = vb_world::Pose2 { x: -50.0, y: 0.0, yaw: 0.0 };
            vb_sim::Simulation::new(world.clone(), &model, &soils, start, options).expect("it settles")
        };
        group.bench_function(name, |b| {
            let mut sim = start();
            b.iter(|| {
                let mut sim = &mut sim;
                if sim.state().position.x.abs() > 55.0 || sim.time() > 25.0 {
                    *sim = start();
                }
                for _ in 0..100 {
                    let controls = common::hold_speed(sim, 3.0, 0.0);
                    sim.advance(controls, 10).expect("finite");
                }
                black_box(&mut sim);
            });
        });
    }
    group.finish();
}

/// A hull that touches: what a step costs in which the contact solver runs.
fn hull(c: &mut Criterion) {
    let mut group = c.benchmark_group("hull on the ground, 1 s at 1 ms");
    group.throughput(Throughput::Elements(1000)).sample_size(20);
    let start = |world: &std::sync::Arc<vb_world::World>, overturned: bool| {
        let mut sim = common::start(world, -50.0, 0.0, 0.0);
        if overturned {
            sim.rig().overturn(1.5, 1.2);
        }
        sim
    };
    // A ridge under the belly, on which the wheels spin.
    let ridge = {
        let heights =
            (0..129 * 129).map(|i| if (13..=14).contains(&(i % 129)) { 0.9 } else { 0.0 }).collect();
        common::world(vb_world::Heightfield::new(129, 129, 1.0, heights), 0.6, vec![])
    };
    let flat = common::flat(0.8);
    for (name, world, overturned) in
        [("belly on a ridge", ridge, false), ("on its side", flat, true), ("very rough", rugged(0.45), false)]
    {
        group.bench_function(name, |b| {
            let mut sim = start(&world, overturned);
            b.iter(|| {
                let sim = &mut sim;
                if sim.state().position.x.abs() > 55.0 || sim.time() > 25.0 {
                    *sim = start(&world, overturned);
                }
                for _ in 0..100 {
                    let controls = common::hold_speed(sim, 3.0, 0.0);
                    sim.advance(controls, 10).expect("finite");
                }
            });
        });
    }
    group.finish();
}

/// Every vehicle that comes with the harness on flat and on rough rigid ground of its scale, at the speed of 3 m/s at full
/// size.
fn vehicles(c: &mut Criterion) {
    let mut group = c.benchmark_group("vehicles, 1 s at 1 ms");
    group.throughput(Throughput::Elements(1000)).sample_size(10);
    for (name, text) in [
        ("gator 4x2", include_str!("../../../../tasks/vehicles/gator.yaml")),
        ("hmmwv 4x4", include_str!("../../../../tasks/vehicles/hmmwv.yaml")),
        ("feda 4x4", include_str!("../../../../tasks/vehicles/feda.yaml")),
        ("man5t 4x4", include_str!("../../../../tasks/vehicles/man5t.yaml")),
        ("man7t 6x6", include_str!("../../../../tasks/vehicles/man7t.yaml")),
        ("man10t 8x8", include_str!("../../../../tasks/vehicles/man10t.yaml")),
        ("m113 tracked", include_str!("../../../../tasks/vehicles/m113.yaml")),
        ("artcar 1/6", include_str!("../../../../tasks/vehicles/artcar.yaml")),
        ("verti4wheeler 1/10", include_str!("../../../../tasks/vehicles/verti4wheeler.yaml")),
    ] {
        let spec = vb_vehicle::VehicleSpec::parse(text, name).expect("the shipped vehicle is valid");
        let (scale, pace) = (spec.scale, spec.scale.sqrt());
        let model = common::model(spec);
        for (ground, world) in [("flat", common::flat(0.8)), ("rough", rugged(0.15))] {
            let world = std::sync::Arc::new(world.scaled(scale));
            let start = || {
                let start = vb_world::Pose2 { x: -50.0 * scale, y: 0.0, yaw: 0.0 };
                vb_sim::Simulation::new(world.clone(), &model, &common::soils(), start, SimOptions::default())
                    .expect("it settles")
            };
            group.bench_function(format!("{name}, {ground}"), |b| {
                let mut sim = start();
                b.iter(|| {
                    if sim.state().position.x.abs() > 55.0 * scale || sim.time() > 25.0 {
                        sim = start();
                    }
                    for _ in 0..100 {
                        let e = 3.0 - sim.state().velocity_body.x / pace;
                        let controls = common::controls(0.0, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0));
                        sim.advance(controls, 10).expect("finite");
                    }
                    black_box(&mut sim);
                });
            });
        }
    }
    group.finish();
}

/// What every start of a simulation pays for its suspension.
fn linkages(c: &mut Criterion) {
    let spec = common::hmmwv();
    c.bench_function("solve the linkages", |b| {
        b.iter(|| {
            for axle in &spec.axles {
                black_box(vb_vehicle::kinematics::AxleKinematics::solve(axle).expect("it closes"));
            }
        });
    });
}

criterion_group!(benches, step, hull, vehicles, linkages);
criterion_main!(benches);
