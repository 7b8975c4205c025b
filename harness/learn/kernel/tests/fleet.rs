//! What the kernels do, called here one number after another: the same states as those of single simulations.

use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use vb_kernel::fleet::{self, FINE, Fleet, GO_ON, NO_CONTROLS, NO_START, NO_TASK, STATE};
use vb_kernel::heap::Pool;
use vb_kernel::wire::{Place, Setting};
use vb_math::rng::Stream;
use vb_sim::{Controls, Gear, SimOptions, Simulation, SoilSet, StateHash};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Obstacle, ObstacleKind, Pose2, Terrain, TerrainClass, World};

/// Rough ground of concrete and of mud, each with a boulder.
fn worlds() -> Vec<World> {
    let mut random = Stream::new(5, &["fleet"]);
    let heights: Vec<f64> = (0..65 * 65).map(|_| random.normal(0.0, 0.15)).collect();
    let ground = Heightfield::new(65, 65, 1.0, heights);
    [TerrainClass::Concrete, TerrainClass::Mud]
        .map(|class| {
            let mut world = World::uniform("w", ground.clone(), class, 0.6);
            let kind = ObstacleKind::Boulder { size: [1.5, 1.2, 1.0], seed: 7 };
            world.obstacles.push(Obstacle { x: 6.0, y: 0.3, yaw: 0.4, buried: 0.2, kind });
            world
        })
        .into()
}

fn vehicle(name: &str) -> VehicleSpec {
    let file = format!("{}/../../../tasks/vehicles/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    VehicleSpec::load(file.as_ref()).expect("it is valid")
}

fn soils() -> SoilSet {
    SoilSet::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/soils/default.yaml").as_ref())
        .expect("they are valid")
}

fn controls(vehicle: usize) -> Controls {
    if vehicle == 1 {
        return Controls { steering: 1.0, throttle: 1.0, brake: 0.0, gear: Gear::Forward };
    }
    let steering = 0.3 - 0.1 * vehicle as f64;
    let gear = if vehicle == 3 { Gear::Reverse } else { Gear::Forward };
    Controls { steering, throttle: 0.6, brake: 0.0, gear }
}

#[test]
fn a_fleet_has_the_states_of_single_simulations() {
    let worlds = worlds();
    let options = SimOptions::default();
    let spec = vehicle("hmmwv");
    let starts = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.1], [0.0, -5.0, 4.0, 2.0], [7.0, 0.0, 0.0, 0.0]];
    // Two of one task, one of a world that isn't there, one of no task, and one that is told what isn't a number.
    let tasks = [0, 1, 2, 2, 3, 9, 0];
    let (n, steps) = (tasks.len(), 1500);
    let setting = Setting {
        vehicle: spec.clone(),
        soils: soils(),
        options,
        worlds: worlds.iter().map(Place::from).collect(),
    };
    let bytes = setting.to_bytes().unwrap();
    assert_eq!(Setting::from_bytes(&bytes).unwrap().vehicle, spec);

    const HEAP: u64 = 1 << 12;
    let mut heaps = [1, starts.len(), n].map(|count| vec![[0_u128; 8]; count * HEAP as usize / 128]);
    let (mut shared, mut pool, mut envs) =
        (std::ptr::null(), vec![std::ptr::null(); starts.len()], vec![std::ptr::null_mut(); n]);
    let mut resets = tasks.map(|t| t as u32);
    let mut asked = std::array::from_fn::<_, 7, _>(|i| {
        let c = controls(i);
        [c.steering, c.throttle, c.brake, if c.gear == Gear::Reverse { -1.0 } else { 1.0 }]
    });
    asked[6][1] = f64::NAN;
    // What is beyond a range is brought to its end.
    asked[1] = [7.0, 1.5, -3.0, 1.0];
    let mut gathered = [vec![0; n], vec![0; n]];
    let counts = std::array::from_fn(|_| [AtomicU32::new(0), AtomicU32::new(0)]);
    let no_pool = Pool::new(0, 0);
    let (mut faults, mut states, mut hashes) = (vec![9; n], vec![[0.0; STATE.len()]; n], vec![0; n]);
    let fleet = Fleet {
        vehicles: n as u64,
        tasks: starts.len() as u64,
        heaps: heaps.each_mut().map(|h| h.as_mut_ptr().cast()),
        heap_sizes: [HEAP; 3],
        pool_memory: &no_pool,
        setting: bytes.as_ptr(),
        setting_size: bytes.len() as u64,
        shared: &mut shared,
        starts: starts.as_ptr(),
        pool: pool.as_mut_ptr(),
        envs: envs.as_mut_ptr(),
        resets: resets.as_mut_ptr(),
        controls: asked.as_ptr(),
        gathered: gathered.each_mut().map(|list| list.as_mut_ptr()),
        counts: &counts,
        faults: faults.as_mut_ptr(),
        states: states.as_mut_ptr(),
        hashes: hashes.as_mut_ptr(),
    };
    // SAFETY: all addresses are those of what stays here.
    unsafe {
        fleet::prepare(&fleet);
        assert!(!shared.is_null());
        (0..starts.len()).for_each(|task| fleet::start(&fleet, task));
        (0..n).for_each(|vehicle| fleet::reset(&fleet, vehicle));
        assert_eq!(resets, [GO_ON; 7], "they go on from now on");
        (0..n).for_each(|vehicle| fleet::reset(&fleet, vehicle));
        for step in 0..steps {
            (0..n).rev().for_each(|vehicle| fleet::drive(&fleet, vehicle, step % 2));
            (0..n + 1).for_each(|number| fleet::look(&fleet, number, step % 2));
            (0..n + 3).for_each(|number| fleet::collide(&fleet, number, step % 2));
        }
        (0..n).for_each(|vehicle| fleet::observe(&fleet, vehicle));
    }
    assert_eq!(faults, [FINE, FINE, FINE, FINE, NO_START, NO_TASK, NO_CONTROLS]);
    let model = VehicleModel::new(spec).unwrap();
    let mut touched = 0;
    for (vehicle, task) in tasks.into_iter().take(4).enumerate() {
        let [world, x, y, yaw] = starts[task];
        let world = Arc::new(worlds[world as usize].clone());
        let mut sim = Simulation::new(world, &model, &soils(), Pose2 { x, y, yaw }, options).unwrap();
        let mut hash = StateHash::default();
        sim.visit_state(|v| hash.push(v));
        for _ in 0..steps / 10 {
            sim.advance(controls(vehicle), 10).unwrap();
            sim.visit_state(|v| hash.push(v));
        }
        let state = sim.state();
        assert_eq!(hashes[vehicle], hash.value(), "vehicle {vehicle}");
        assert_eq!(states[vehicle][1..4], *state.position.as_slice());
        assert_eq!(states[vehicle][0], state.time);
        touched += sim.contact_steps();
    }
    assert!(touched > 100, "hulls touched something in {touched} steps");
    assert_eq!(worlds[1].terrain, Terrain::Deformable);
}

#[test]
fn every_vehicle_and_a_world_keep_all_bits_on_their_way() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/vehicles");
    let mut count = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_none_or(|e| e != "yaml") {
            continue;
        }
        let vehicle = VehicleSpec::load(&path).unwrap();
        let worlds: Vec<World> = worlds().iter().map(|w| w.scaled(1.0 / 6.0)).collect();
        let setting = Setting {
            vehicle: vehicle.clone(),
            soils: soils(),
            options: SimOptions::default(),
            worlds: worlds.iter().map(Place::from).collect(),
        };
        let back = Setting::from_bytes(&setting.to_bytes().unwrap()).unwrap();
        assert_eq!(back.vehicle, vehicle, "{}", path.display());
        assert_eq!(back.soils, setting.soils);
        let back: Vec<World> = back.worlds.into_iter().map(World::from).collect();
        for (back, world) in back.iter().zip(&worlds) {
            assert_eq!(back.heightfield, world.heightfield);
            assert_eq!((&back.semantics, &back.obstacles), (&world.semantics, &world.obstacles));
        }
        count += 1;
    }
    assert!(count >= 9, "{count} vehicles");
    assert!(Setting::from_bytes(b"nothing").is_none());
}
