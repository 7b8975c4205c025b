//! A fleet: many simulations of one vehicle, stepped together. What each kernel does is a function here.
//!
//! A launch calls a function for each number from 0 on, in any order and at the same time. [`prepare`] comes first, once,
//! then [`start`] for each task, and then [`reset`], [`drive`], [`look`], [`collide`] and [`observe`] as often as one likes. A
//! step of all is [`drive`] followed by [`look`] and [`collide`]: few vehicles have their hulls near to something at a time,
//! to find out what they may touch and to solve the contacts takes longer than the rest of a step, and the threads that run
//! together on a GPU wait for the slowest. So those that are near are gathered, and so are those of them that touch: threads
//! are full again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use vb_sim::{Controls, Gear, SAMPLE_PERIOD, SimOptions, Simulation, SoilSet, StateHash, Surroundings};
use vb_vehicle::VehicleModel;
use vb_world::{Pose2, World};

use crate::heap::{Heap, Pool};
use crate::wire::Setting;

/// What is told of each vehicle: the name of each number, with its unit, in order.
pub const STATE: [(&str, &str); 20] = [
    ("time", "s"),
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("qw", "1"),
    ("vx", "m/s"),
    ("vy", "m/s"),
    ("vz", "m/s"),
    ("wx", "rad/s"),
    ("wy", "rad/s"),
    ("wz", "rad/s"),
    ("roll", "rad"),
    ("pitch", "rad"),
    ("yaw", "rad"),
    ("steering", "1"),
    ("gear", "1"),
    ("engine_speed", "rad/s"),
];

/// A simulation gets on as it should.
pub const FINE: u32 = 0;
/// A vehicle couldn't be put at its start.
pub const NO_START: u32 = 1;
/// A simulation has come into a state that no vehicle can have.
pub const DIVERGED: u32 = 2;
/// A vehicle was told to begin a task that there isn't.
pub const NO_TASK: u32 = 3;
/// A vehicle was told a number that isn't finite.
pub const NO_CONTROLS: u32 = 4;
/// What [`Fleet::faults`] says: the name of each number.
pub const FAULTS: [(&str, u32); 5] = [
    ("fine", FINE),
    ("no_start", NO_START),
    ("diverged", DIVERGED),
    ("no_task", NO_TASK),
    ("no_controls", NO_CONTROLS),
];
/// No task: the vehicle drives on.
pub const GO_ON: u32 = u32::MAX;

/// Where everything of a fleet is, in memory of the GPU.
///
/// All arrays have a row for each vehicle, but for those of which something else is said.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Fleet {
    pub vehicles: u64,
    pub tasks: u64,
    /// The heaps: one for what all share, one for each task, and one for each vehicle.
    pub heaps: [*mut u8; 3],
    /// The size of a heap of each kind, bytes.
    pub heap_sizes: [u64; 3],
    /// Memory for heaps that are full, whatever their kind.
    pub pool_memory: *const Pool,
    /// A [`Setting`] as bytes, and how many.
    pub setting: *const u8,
    /// How many bytes the setting has.
    pub setting_size: u64,
    /// What all share: written by [`prepare`].
    pub shared: *mut *const Shared,
    /// Of each task: the number of its world, and x, y (m) and yaw (rad) of the start.
    pub starts: *const [f64; 4],
    /// Of each task: the vehicle as it stands at the start, written by [`start`].
    pub pool: *mut *const Simulation,
    /// The vehicles, written by [`reset`].
    pub envs: *mut *mut Env,
    /// The task that a vehicle begins anew with the next [`reset`], which makes it [`GO_ON`].
    pub resets: *mut u32,
    /// Steering, throttle, brake, and the gear: 1, 0 or −1.
    pub controls: *const [f64; 4],
    /// The vehicles whose hulls may be near to something in this step, and those that may touch something, in any order.
    pub gathered: [*mut u32; 2],
    /// How many those are: two numbers each, used in turn.
    pub counts: *const [[AtomicU32; 2]; 2],
    /// [`FINE`], or what is wrong.
    pub faults: *mut u32,
    /// [`STATE`], written by [`observe`].
    pub states: *mut [f64; STATE.len()],
    /// The hash of all states since the start, as records of runs have it, written by [`observe`].
    pub hashes: *mut u64,
}

/// What the simulations of a fleet share.
pub struct Shared {
    model: VehicleModel,
    soils: SoilSet,
    options: SimOptions,
    worlds: Vec<Surroundings>,
}

/// One vehicle on its way.
pub struct Env {
    sim: Simulation,
    hash: StateHash,
    /// Steps at which the hash last took the state.
    hashed: Option<u64>,
}

impl Env {
    fn take_sample(&mut self, every: u64) {
        let now = self.sim.steps();
        if now.is_multiple_of(every) && self.hashed != Some(now) {
            self.sim.visit_state(|x| self.hash.push(x));
            self.hashed = Some(now);
        }
    }
}

/// Which heap a thread works with.
#[derive(Clone, Copy)]
enum Of {
    All,
    Task(usize),
    Vehicle(usize),
}

impl Fleet {
    fn heap(&self, of: Of) -> (*mut u8, u64) {
        let (kind, number) = match of {
            Of::All => (0, 0),
            Of::Task(number) => (1, number),
            Of::Vehicle(number) => (2, number),
        };
        let size = self.heap_sizes[kind];
        // SAFETY: there is one for each.
        (unsafe { self.heaps[kind].add(number * size as usize) }, size)
    }

    /// From now on this thread takes memory from an emptied heap.
    ///
    /// # Safety
    /// Nothing in it is used any more.
    unsafe fn empty(&self, of: Of) {
        let (at, size) = self.heap(of);
        // SAFETY: as the caller promises.
        unsafe { Heap::place(at, size, self.pool_memory) };
        self.enter(of);
    }

    /// Puts a vehicle on a list of this turn.
    ///
    /// # Safety
    /// The fleet's addresses are right, and the vehicle isn't on the list.
    unsafe fn gather(&self, list: usize, turn: usize, vehicle: usize) {
        // SAFETY: as the caller promises.
        unsafe {
            let place = (&(*self.counts))[list][turn].fetch_add(1, Ordering::Relaxed);
            self.gathered[list].add(place as usize).write(vehicle as u32);
        }
    }

    /// The vehicle at this place of a list of this turn, if nothing is wrong with it.
    ///
    /// # Safety
    /// The fleet's addresses are right, and no other thread has this number.
    unsafe fn gathered<'a>(&self, list: usize, turn: usize, number: usize) -> Option<(usize, &'a mut Env)> {
        // SAFETY: as the caller promises.
        unsafe {
            if number >= (&(*self.counts))[list][turn].load(Ordering::Relaxed) as usize {
                return None;
            }
            let vehicle = *self.gathered[list].add(number) as usize;
            env(self, vehicle).map(|env| (vehicle, env))
        }
    }

    /// From now on this thread takes memory from this heap.
    fn enter(&self, of: Of) {
        let (at, _) = self.heap(of);
        enter(at.cast());
    }
}

#[cfg(target_arch = "nvptx64")]
use crate::memory::enter;

/// Here all memory is the system's.
#[cfg(not(target_arch = "nvptx64"))]
fn enter(_: *mut Heap) {}

/// Reads the setting, and solves the vehicle's linkages. One thread does it; `shared` stays null if it can't be done.
///
/// # Safety
/// The fleet's addresses are right.
pub unsafe fn prepare(fleet: &Fleet) {
    // SAFETY: as the caller promises.
    let bytes = unsafe {
        fleet.empty(Of::All);
        std::slice::from_raw_parts(fleet.setting, fleet.setting_size as usize)
    };
    let Some(setting) = Setting::from_bytes(bytes) else { return };
    let Ok(model) = VehicleModel::new(setting.vehicle) else { return };
    let worlds = setting.worlds.into_iter().map(|w| Surroundings::from(Arc::new(World::from(w)))).collect();
    let shared = Shared { model, soils: setting.soils, options: setting.options, worlds };
    // SAFETY: as the caller promises.
    unsafe { fleet.shared.write(Box::into_raw(Box::new(shared))) };
}

/// Puts a vehicle at the start of this task, for all that begin it. `pool` has null where that can't be done.
///
/// # Safety
/// The fleet's addresses are right, [`prepare`] has been, and no other thread has this number.
pub unsafe fn start(fleet: &Fleet, task: usize) {
    // SAFETY: as the caller promises.
    let (shared, start) = unsafe {
        fleet.empty(Of::Task(task));
        (&**fleet.shared, *fleet.starts.add(task))
    };
    let [world, x, y, yaw] = start;
    let world = shared.worlds.get(world as usize).cloned();
    let sim = world.and_then(|world| {
        Simulation::new(world, &shared.model, &shared.soils, Pose2 { x, y, yaw }, shared.options).ok()
    });
    let stands = sim.map_or(std::ptr::null(), |sim| Box::into_raw(Box::new(sim)).cast_const());
    // SAFETY: as the caller promises.
    unsafe { fleet.pool.add(task).write(stands) };
}

/// Lets a vehicle begin the task that `resets` has for it, if there is one.
///
/// # Safety
/// The fleet's addresses are right, [`start`] has been, and no other thread has this number.
pub unsafe fn reset(fleet: &Fleet, vehicle: usize) {
    // SAFETY: as the caller promises. What the vehicle was before is forgotten with its whole heap; it has nothing of others
    // but counted references, which only keep the shared things from being freed.
    unsafe {
        let task = fleet.resets.add(vehicle).replace(GO_ON);
        if task == GO_ON {
            return;
        }
        fleet.empty(Of::Vehicle(vehicle));
        let is_there = u64::from(task) < fleet.tasks;
        let sim = if is_there { (*fleet.pool.add(task as usize)).as_ref() } else { None };
        let env = sim.map(|sim| Env { sim: sim.clone(), hash: StateHash::default(), hashed: None });
        fleet.faults.add(vehicle).write(match &env {
            Some(_) => FINE,
            None if is_there => NO_START,
            None => NO_TASK,
        });
        fleet.envs.add(vehicle).write(env.map_or(std::ptr::null_mut(), |env| Box::into_raw(Box::new(env))));
    }
}

/// The vehicle, if nothing is wrong with it.
///
/// # Safety
/// The fleet's addresses are right, [`reset`] has been, and no other thread has this number.
unsafe fn env<'a>(fleet: &Fleet, vehicle: usize) -> Option<&'a mut Env> {
    // SAFETY: as the caller promises.
    unsafe {
        fleet.enter(Of::Vehicle(vehicle));
        (*fleet.envs.add(vehicle)).as_mut().filter(|_| *fleet.faults.add(vehicle) == FINE)
    }
}

/// The list of vehicles that may be near to something, and that of those that may touch something.
const NEAR: usize = 0;
const TOUCHING: usize = 1;

/// The first part of a step: forces. A vehicle whose hull may be near to something waits for [`look`] of the same `turn`, which
/// is 0 and 1 by turns.
///
/// # Safety
/// The fleet's addresses are right, [`reset`] has been, and no other thread has this number.
pub unsafe fn drive(fleet: &Fleet, vehicle: usize, turn: usize) {
    // SAFETY: as the caller promises.
    unsafe {
        let Some(env) = env(fleet, vehicle) else { return };
        let controls = *fleet.controls.add(vehicle);
        if !controls.iter().all(|x| x.is_finite()) {
            fleet.faults.add(vehicle).write(NO_CONTROLS);
            return;
        }
        env.take_sample(sample_every(fleet));
        let [steering, throttle, brake, gear] = controls;
        // As a planner's commands are brought within range.
        let (steering, throttle, brake) =
            (steering.clamp(-1.0, 1.0), throttle.clamp(0.0, 1.0), brake.clamp(0.0, 1.0));
        let gear = match gear {
            g if g > 0.0 => Gear::Forward,
            g if g < 0.0 => Gear::Reverse,
            _ => Gear::Neutral,
        };
        if env.sim.begin_step(Controls { steering, throttle, brake, gear }) {
            env.sim.finish_step(false);
        } else {
            fleet.gather(NEAR, turn, vehicle);
        }
    }
}

/// The second part of a step, for those that may be near to something: whether they may touch it. There may be more threads than
/// those.
///
/// # Safety
/// The fleet's addresses are right, [`drive`] has been, and no other thread has this number.
pub unsafe fn look(fleet: &Fleet, number: usize, turn: usize) {
    // SAFETY: as the caller promises.
    unsafe {
        let Some((vehicle, env)) = fleet.gathered(NEAR, turn, number) else { return };
        if env.sim.look() {
            fleet.gather(TOUCHING, turn, vehicle);
        } else {
            env.sim.finish_step(false);
        }
    }
}

/// The last part of a step, for those that may touch something: the contact solver. There may be more threads than those.
///
/// # Safety
/// The fleet's addresses are right, [`look`] has been, and no other thread has this number.
pub unsafe fn collide(fleet: &Fleet, number: usize, turn: usize) {
    // SAFETY: as the caller promises.
    unsafe {
        if number == 0 {
            (*fleet.counts).iter().for_each(|list| list[1 - turn].store(0, Ordering::Relaxed));
        }
        if let Some((_, env)) = fleet.gathered(TOUCHING, turn, number) {
            env.sim.finish_step(true);
        }
    }
}

/// Tells where a vehicle is, and looks whether it can be there.
///
/// # Safety
/// The fleet's addresses are right, [`reset`] has been, and no other thread has this number.
pub unsafe fn observe(fleet: &Fleet, vehicle: usize) {
    // SAFETY: as the caller promises.
    unsafe {
        let Some(env) = env(fleet, vehicle) else { return };
        env.take_sample(sample_every(fleet));
        if env.sim.check().is_err() {
            fleet.faults.add(vehicle).write(DIVERGED);
        }
        fleet.states.add(vehicle).write(state(&env.sim));
        fleet.hashes.add(vehicle).write(env.hash.value());
    }
}

/// The numbers of [`STATE`].
fn state(sim: &Simulation) -> [f64; STATE.len()] {
    let s = sim.state();
    let (roll, pitch, yaw) = s.roll_pitch_yaw();
    let gear = match s.gear {
        Gear::Forward => 1.0,
        Gear::Neutral => 0.0,
        Gear::Reverse => -1.0,
    };
    let (p, q, v, w) = (s.position, s.attitude.coords, s.velocity_body, s.angular_velocity_body);
    [
        s.time,
        p.x,
        p.y,
        p.z,
        q.x,
        q.y,
        q.z,
        q.w,
        v.x,
        v.y,
        v.z,
        w.x,
        w.y,
        w.z,
        roll,
        pitch,
        yaw,
        s.steering,
        gear,
        s.engine_speed,
    ]
}

/// Steps between two samples.
///
/// # Safety
/// The fleet's addresses are right, and [`prepare`] has been.
unsafe fn sample_every(fleet: &Fleet) -> u64 {
    // SAFETY: as the caller promises.
    let step = unsafe { (**fleet.shared).options.step };
    (SAMPLE_PERIOD / step).round() as u64
}
