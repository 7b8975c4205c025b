//! The step loop takes no memory: what a step needs exists from the start.
//!
//! Two exceptions. Where the hull may touch something, rapier's solver runs and takes memory of its own. And a tile of
//! soil comes into being when something first stands on it.

mod common;
use common::{flat, hold_speed, soil_start, soil_world, soils, start, world};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use vb_math::rng::Stream;
use vb_sim::{SimOptions, Simulation};
use vb_world::{Heightfield, Obstacle, ObstacleKind, TerrainClass};

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, which counts what each thread asks of it.
struct Counting;

// SAFETY: all work is the system allocator's; the counter is a constant-initialised cell without a destructor, so that
// counting takes no memory itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = TAKEN.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller keeps to the contract of `alloc`, which is this one's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Requests for memory by steps in which the contact solver ran, by the others, and the number of the latter.
fn requests(sim: &mut Simulation, steps: u64, speed: f64, steering: f64) -> (u64, u64, u64) {
    let (mut solver, mut ours, mut alone) = (0, 0, 0);
    for _ in 0..steps {
        let controls = hold_speed(sim, speed, steering);
        let contacts = sim.contact_steps();
        let before = TAKEN.with(Cell::get);
        sim.advance(controls, 1).expect("it goes on");
        let taken = TAKEN.with(Cell::get) - before;
        if sim.contact_steps() == contacts {
            ours += taken;
            alone += 1;
        } else {
            solver += taken;
        }
    }
    (solver, ours, alone)
}

#[test]
fn a_request_for_memory_is_counted() {
    let before = TAKEN.with(Cell::get);
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(TAKEN.with(Cell::get), before + 1);
}

#[test]
fn steps_on_level_ground_take_no_memory() {
    let mut sim = start(&flat(0.8), -100.0, 0.0, 0.0);
    requests(&mut sim, 1000, 8.0, 0.2);
    let (_, ours, alone) = requests(&mut sim, 2000, 8.0, 0.2);
    assert_eq!((ours, alone), (0, 2000));
}

#[test]
fn steps_on_rough_ground_over_rocks_take_no_memory_but_the_contact_solvers() {
    let n = 129;
    let mut s = Stream::new(5, &["allocation"]);
    let heights = (0..n * n).map(|_| s.normal(0.0, 0.08)).collect();
    // Rocks that wheels roll over and the hull clears.
    let rocks = (0..400).map(|k| Obstacle {
        x: -50.0 + 0.5 * f64::from(k / 4),
        y: -1.5 + f64::from(k % 4),
        yaw: 0.1 * f64::from(k),
        buried: 0.4,
        kind: ObstacleKind::Boulder { size: [0.5, 0.4, 0.3], seed: k as u64 },
    });
    let mut sim = start(&world(Heightfield::new(n, n, 1.0, heights), 0.8, rocks.collect()), -48.0, 0.0, 0.0);
    requests(&mut sim, 1000, 4.0, 0.0);
    let (_, ours, alone) = requests(&mut sim, 4000, 4.0, 0.0);
    assert!(alone >= 1000, "the hull touches nothing in {alone} of 4000 steps");
    assert_eq!(ours, 0);
    assert!(sim.state().position.x > -46.0, "it went over some of the rocks: {}", sim.state().position.x);
}

#[test]
fn steps_in_its_own_rut_take_no_memory() {
    let ground = soil_world(Heightfield::flat(129, 129, 1.0, 0.0), TerrainClass::Mud);
    let mut sim = soil_start(&ground, &soils(), [0.0, -9.0], 0.0, SimOptions::default());
    // Once round takes 20 s.
    let (_, first, _) = requests(&mut sim, 25_000, 3.0, 1.0);
    let (_, second, alone) = requests(&mut sim, 2000, 3.0, 1.0);
    assert_eq!((second, alone), (0, 2000));
    assert!(first > 0, "tiles came into being on the first round");
}

#[test]
fn steps_of_a_tracked_vehicle_take_no_memory() {
    let text = include_str!("../../../../tasks/vehicles/m113.yaml");
    let model = common::model(vb_vehicle::VehicleSpec::parse(text, "m113.yaml").expect("it is valid"));
    let start = |world, x| {
        let at = vb_world::Pose2 { x, y: 0.0, yaw: 0.0 };
        Simulation::new(world, &model, &soils(), at, SimOptions::default()).expect("it settles")
    };
    let mut sim = start(flat(0.8), -100.0);
    requests(&mut sim, 1000, 4.0, 0.3);
    assert_eq!(requests(&mut sim, 2000, 4.0, 0.3).1, 0);
    // On soil tiles come into being ahead of it, at most one a track and step.
    let mut sim = start(soil_world(Heightfield::flat(129, 129, 1.0, 0.0), TerrainClass::Sand), -40.0);
    requests(&mut sim, 1000, 4.0, 0.0);
    let (_, ours, alone) = requests(&mut sim, 2000, 4.0, 0.0);
    assert!(ours <= 6 && alone == 2000, "{ours} in {alone} steps over 8 m");
}
