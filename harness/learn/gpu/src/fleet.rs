//! A fleet, as the program that has it sees it.

use std::path::Path;
use std::sync::Arc;

use cudarc::driver::sys::{CUlimit_enum, CUresult};
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaSlice, CudaStream, DevicePtr, DeviceRepr, LaunchConfig,
    PushKernelArg,
};
use cudarc::nvrtc::Ptx;
use vb_kernel::fleet::{self, GO_ON, STATE};
use vb_kernel::heap::Pool;
use vb_kernel::wire::Setting;
use vb_world::Pose2;

use crate::code::{self, Gpu};
use crate::drive::{self, Drive};
use crate::error::cuda;
use crate::{Course, GpuError};

/// Threads of a block, at most: those that a GPU runs together.
const BLOCK: u32 = 32;
/// What is being done where a fleet is made.
const START: &str = "putting vehicles at their starts";
/// Memory that a task has to itself, bytes, and that what all share has.
const TASK_MEMORY: u64 = 256 << 10;
const SHARED_MEMORY: u64 = 1 << 20;
/// Memory that a vehicle, a task and a world beside its bytes may need of what is spare, bytes.
const SPARE: [u64; 3] = [8 << 20, 4 << 20, 8 << 20];

/// How a fleet uses a GPU. None of it changes a state.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The number of the GPU.
    pub device: usize,
    /// Memory that a vehicle has to itself, bytes. An HMMWV on rigid ground needs no more than this.
    pub vehicle_memory: u64,
    /// Memory for all that need more, bytes: the ruts that a vehicle makes in soft soil, which take up to 5 MB in a minute,
    /// worlds, and starts. By default as much as all of them may need, but half of what is free at most.
    pub spare_memory: Option<u64>,
    /// Memory on the stack of each thread, bytes.
    pub stack: usize,
    /// Groups of vehicles that are stepped beside each other, so that while those of one that touch something are a few long
    /// threads, others drive.
    pub groups: usize,
    /// Threads of a block: when vehicles start, when they drive, when hulls are near to something, and when they touch it. Threads
    /// of a block wait for each other where they do different things.
    pub lanes: [u32; 4],
}

impl Default for Options {
    fn default() -> Self {
        Self {
            device: 0,
            vehicle_memory: 128 << 10,
            spare_memory: None,
            stack: 96 << 10,
            groups: 4,
            lanes: [4, 32, 32, 16],
        }
    }
}

/// Addresses on the GPU, for those who compute there too. All arrays have a row for each vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Arrays {
    /// The numbers of [`STATE`], `f64`, written by [`Fleet::advance`].
    pub states: u64,
    /// Steering, throttle, brake and gear, `f64`, as for [`Fleet::control`]. A vehicle that is told a number that isn't finite is
    /// [`vb_kernel::fleet::NO_CONTROLS`] from then on.
    pub controls: u64,
    /// The number of the task that a vehicle begins with the next [`Fleet::reset_as_told`], `i32`, which makes it −1: to go on.
    pub resets: u64,
    /// [`vb_kernel::fleet::FINE`], or what is wrong, `u32`.
    pub faults: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The number of its world among those of the setting.
    pub world: usize,
    pub pose: Pose2,
}

struct Kernels {
    start: CudaFunction,
    reset: CudaFunction,
    drive: CudaFunction,
    look: CudaFunction,
    collide: CudaFunction,
    observe: CudaFunction,
}

/// Vehicles of a fleet that are stepped beside others, all launches one after another.
struct Group {
    stream: Arc<CudaStream>,
    /// The `vb_kernel::fleet::Fleet` of these vehicles over there.
    fleet: CudaSlice<u8>,
    vehicles: usize,
}

/// A fleet: vehicles of one kind on a GPU, which are stepped together.
pub struct Fleet {
    stream: Arc<CudaStream>,
    kernels: Kernels,
    options: Options,
    vehicles: usize,
    tasks: usize,
    groups: Vec<Group>,
    resets: CudaSlice<u32>,
    controls: CudaSlice<f64>,
    faults: CudaSlice<u32>,
    states: CudaSlice<f64>,
    hashes: CudaSlice<u64>,
    /// Steps since the beginning, for the kernels' turns.
    steps: u64,
    /// What only the kernels use.
    _held: (Arc<CudaModule>, Vec<CudaSlice<u8>>),
}

impl Fleet {
    /// A fleet of so many vehicles by the kernels in this file, or by those for the GPU in this folder (`cargo xtask kernel`). Each
    /// task's vehicle is put at its start now; [`Self::reset`] tells each vehicle which task it begins.
    ///
    /// # Errors
    /// Returns an error without a GPU that the kernels are for, and if its memory doesn't do.
    pub fn new(
        kernel: &Path,
        setting: &Setting,
        starts: &[Start],
        vehicles: usize,
        options: Options,
    ) -> Result<Self, GpuError> {
        if starts.is_empty() || vehicles == 0 {
            return Err(GpuError::Empty);
        }
        if !crate::is_there() {
            return Err(GpuError::NoDriver);
        }
        let context = open(options.device)?;
        let code = code::read(kernel, &kind(&context)?)?;
        let stream = context.default_stream();
        context.set_limit(CUlimit_enum::CU_LIMIT_STACK_SIZE, options.stack).map_err(cuda("stacks"))?;
        // SAFETY: what a group uses is used on its stream alone; whatever is for several is waited for before others go on.
        unsafe { context.disable_event_tracking() };
        let module = context.load_module(Ptx::from_binary(code)).map_err(cuda("loading the kernels"))?;
        let function = |name| module.load_function(name).map_err(cuda("looking for the kernels"));
        let kernels = Kernels {
            start: function("vb_start")?,
            reset: function("vb_reset")?,
            drive: function("vb_drive")?,
            look: function("vb_look")?,
            collide: function("vb_collide")?,
            observe: function("vb_observe")?,
        };

        let bytes = setting.to_bytes().map_err(|e| GpuError::Encode(e.to_string()))?;
        let tasks = starts.len();
        let sizes = [SHARED_MEMORY, TASK_MEMORY, options.vehicle_memory].map(|n| n.next_multiple_of(256));
        let counts = [1, tasks as u64, vehicles as u64];
        let (free, _) = context.mem_get_info().map_err(cuda("asking for memory"))?;
        let free = free as u64;
        let own = sizes.iter().zip(counts).map(|(size, count)| size * count).sum::<u64>();
        let spare = options.spare_memory.unwrap_or_else(|| {
            let parts = [vehicles, tasks, setting.worlds.len()];
            let most = SPARE.iter().zip(parts).map(|(size, count)| size * count as u64).sum::<u64>();
            // What is sent is kept in other forms, and grows by doubling while it is read.
            (most + 4 * bytes.len() as u64).min(free / 2)
        });
        if own + spare > free {
            let mb = |bytes| bytes >> 20;
            return Err(GpuError::Memory { vehicles, tasks, needed: mb(own + spare), free: mb(free) });
        }
        let memory = Memory { stream: &stream };
        let shared = memory.zeros::<u8>(8)?;
        let (resets, controls) = (memory.copy(&vec![GO_ON; vehicles])?, memory.zeros(4 * vehicles)?);
        let (faults, states) =
            (memory.copy(&vec![fleet::NO_START; vehicles])?, memory.zeros(STATE.len() * vehicles)?);
        let hashes = memory.zeros(vehicles)?;
        let mut held = Vec::new();
        let mut keep = |part: CudaSlice<u8>| {
            let at = address(&stream, &part);
            held.push(part);
            at
        };
        // CUDA gives no memory of no size.
        let pool = Pool::new(keep(memory.raw(spare.max(1))?), spare);
        let near = [keep(memory.zeros(4 * vehicles)?), keep(memory.zeros(4 * vehicles)?)];
        let all = fleet::Fleet {
            vehicles: vehicles as u64,
            tasks: tasks as u64,
            heaps: [
                keep(memory.zeros((sizes[0] * counts[0]) as usize)?) as *mut u8,
                keep(memory.zeros((sizes[1] * counts[1]) as usize)?) as *mut u8,
                keep(memory.zeros((sizes[2] * counts[2]) as usize)?) as *mut u8,
            ],
            heap_sizes: sizes,
            pool_memory: keep(memory.copy(bytes_of(&pool))?) as *const _,
            setting: keep(memory.copy(&bytes)?) as *const u8,
            setting_size: bytes.len() as u64,
            shared: address(&stream, &shared) as *mut _,
            starts: keep(memory.copy(&rows(starts))?) as *const _,
            pool: keep(memory.zeros(8 * tasks)?) as *mut _,
            envs: keep(memory.zeros(8 * vehicles)?) as *mut _,
            resets: address(&stream, &resets) as *mut _,
            controls: address(&stream, &controls) as *const _,
            gathered: near.map(|list| list as *mut _),
            counts: std::ptr::null(),
            faults: address(&stream, &faults) as *mut _,
            states: address(&stream, &states) as *mut _,
            hashes: address(&stream, &hashes) as *mut _,
        };
        let size = vehicles.div_ceil(options.groups.clamp(1, vehicles));
        let mut groups = Vec::new();
        for first in (0..vehicles).step_by(size) {
            let mut told = all;
            told.vehicles = size.min(vehicles - first) as u64;
            // SAFETY: all arrays have a row for each vehicle. Nothing is read or written here.
            unsafe {
                told.heaps[2] = told.heaps[2].add(first * sizes[2] as usize);
                told.envs = told.envs.add(first);
                told.resets = told.resets.add(first);
                told.controls = told.controls.add(first);
                told.gathered = told.gathered.map(|list| list.add(first));
                told.faults = told.faults.add(first);
                told.states = told.states.add(first);
                told.hashes = told.hashes.add(first);
            }
            told.counts = keep(memory.zeros(16)?) as *const _;
            groups.push(Group {
                stream: context.new_stream().map_err(cuda("opening the GPU"))?,
                fleet: memory.copy(bytes_of(&told))?,
                vehicles: told.vehicles as usize,
            });
        }

        let place = address(&stream, &groups[0].fleet);
        let prepare = function("vb_prepare")?;
        // SAFETY: this kernel takes an address.
        unsafe { stream.launch_builder(&prepare).arg(&place).launch(shape(1, 1)) }
            .map_err(cuda("preparing the fleet"))?;
        let prepared = stream.clone_dtoh(&shared).map_err(cuda("preparing the fleet"))?;
        if prepared == [0; 8] {
            return Err(GpuError::Setting);
        }
        held.push(shared);
        let fleet = Self {
            stream,
            kernels,
            options,
            vehicles,
            tasks,
            groups,
            resets,
            controls,
            faults,
            states,
            hashes,
            steps: 0,
            _held: (module, held),
        };
        fleet.launch(&fleet.groups[0], &fleet.kernels.start, tasks, options.lanes[0], None, START)?;
        fleet.wait(START)?;
        Ok(fleet)
    }

    #[must_use]
    pub fn vehicles(&self) -> usize {
        self.vehicles
    }

    /// Lets vehicles begin tasks anew, those with `None` go on.
    ///
    /// # Errors
    /// Returns an error for tasks that aren't there, and if the GPU fails.
    pub fn reset(&mut self, tasks: &[Option<usize>]) -> Result<(), GpuError> {
        self.expect("tasks", tasks.len())?;
        for (vehicle, task) in tasks.iter().enumerate() {
            if let Some(task) = task.filter(|task| *task >= self.tasks) {
                return Err(GpuError::Task { vehicle, task, tasks: self.tasks });
            }
        }
        let told: Vec<u32> = tasks.iter().map(|task| task.map_or(GO_ON, |task| task as u32)).collect();
        self.stream.memcpy_htod(&told, &mut self.resets).map_err(cuda("a reset"))?;
        self.reset_as_told()
    }

    /// Lets vehicles begin the tasks that have been written to [`Arrays::resets`]. What else this process does on the GPU is
    /// waited for.
    pub fn reset_as_told(&mut self) -> Result<(), GpuError> {
        self.wait("a reset")?;
        self.each_group(&self.kernels.reset, 0, None, "a reset")?;
        self.wait("a reset")
    }

    /// Tells all vehicles their controls until they are told others: steering in [−1, 1], throttle and brake in [0, 1], and the
    /// gear, which is 1 for forward, 0 for neutral and −1 for reverse. What is beyond a range is brought to its end.
    ///
    /// # Errors
    /// Returns an error for numbers that aren't finite, and if the GPU fails.
    pub fn control(&mut self, controls: &[[f64; 4]]) -> Result<(), GpuError> {
        self.expect("controls", controls.len())?;
        if let Some(vehicle) = controls.iter().position(|row| row.iter().any(|x| !x.is_finite())) {
            return Err(GpuError::Controls { vehicle });
        }
        self.stream.memcpy_htod(controls.as_flattened(), &mut self.controls).map_err(cuda("controls"))
    }

    /// Drives all vehicles on by so many steps, and looks where they are then. What else this process does on the GPU is waited
    /// for, so that controls may be written there.
    pub fn advance(&mut self, steps: u64) -> Result<(), GpuError> {
        self.wait("a step")?;
        let Kernels { drive, look, collide, observe, .. } = &self.kernels;
        for _ in 0..steps {
            let turn = Some(self.steps % 2);
            for (kernel, lanes) in [(drive, 1), (look, 2), (collide, 3)] {
                self.each_group(kernel, lanes, turn, "a step")?;
            }
            self.steps += 1;
        }
        self.each_group(observe, 1, None, "a look at the vehicles")?;
        self.wait("a step")
    }

    /// The state of each vehicle when it was last looked at: the numbers of [`STATE`].
    pub fn states(&self) -> Result<Vec<[f64; STATE.len()]>, GpuError> {
        let numbers = self.stream.clone_dtoh(&self.states).map_err(cuda("reading states"))?;
        let (rows, _) = numbers.as_chunks();
        Ok(rows.to_vec())
    }

    /// Drives the first `vehicles` vehicles (or all, if they are fewer) through this course, of which the fleet was made, for some
    /// time (s), here and on the CPU, and looks whether they come to the same states. Returns how many were compared. All
    /// vehicles have to be reset after it.
    ///
    /// # Errors
    /// Returns an error if a vehicle's states differ, and if the fleet can't go on.
    pub fn verify(&mut self, course: &Course, vehicles: usize, seconds: f64) -> Result<usize, GpuError> {
        let drive = Drive::new(course, seconds);
        let vehicles = vehicles.min(self.vehicles);
        let on_cpu = drive.on_cpu(&drive.starts_on_cpu(vehicles), vehicles);
        self.reset(&drive.tasks(self.vehicles))?;
        drive.on_gpu(self)?;
        let (same, of) = drive::same(&on_cpu, &self.hashes()?);
        if same == of { Ok(of) } else { Err(GpuError::Differ { differ: of - same, of }) }
    }

    /// [`vb_kernel::fleet::FINE`] for each vehicle, or what is wrong with it.
    pub fn faults(&self) -> Result<Vec<u32>, GpuError> {
        self.stream.clone_dtoh(&self.faults).map_err(cuda("reading faults"))
    }

    /// The hash of all states of each vehicle since it began its task, every 10 ms, as records of runs have it.
    pub fn hashes(&self) -> Result<Vec<u64>, GpuError> {
        self.stream.clone_dtoh(&self.hashes).map_err(cuda("reading hashes"))
    }

    /// Where what others may read and write is on the GPU. It stays there as long as the fleet.
    #[must_use]
    pub fn arrays(&self) -> Arrays {
        Arrays {
            states: address(&self.stream, &self.states),
            controls: address(&self.stream, &self.controls),
            resets: address(&self.stream, &self.resets),
            faults: address(&self.stream, &self.faults),
        }
    }

    /// Waits for all that this process has launched on the GPU.
    fn wait(&self, doing: &'static str) -> Result<(), GpuError> {
        self.stream.context().synchronize().map_err(cuda(doing))
    }

    fn expect(&self, what: &'static str, given: usize) -> Result<(), GpuError> {
        if given == self.vehicles {
            Ok(())
        } else {
            Err(GpuError::Length { what, given, wanted: self.vehicles })
        }
    }

    /// Launches a kernel for all vehicles, each group's behind what was launched for it before. The number of its lanes is the
    /// place in [`Options::lanes`].
    fn each_group(
        &self,
        kernel: &CudaFunction,
        lanes: usize,
        turn: Option<u64>,
        doing: &'static str,
    ) -> Result<(), GpuError> {
        let lanes = self.options.lanes[lanes];
        let mut groups = self.groups.iter();
        groups.try_for_each(|group| self.launch(group, kernel, group.vehicles, lanes, turn, doing))
    }

    /// Launches a kernel for the numbers below `count`.
    fn launch(
        &self,
        group: &Group,
        kernel: &CudaFunction,
        count: usize,
        lanes: u32,
        turn: Option<u64>,
        doing: &'static str,
    ) -> Result<(), GpuError> {
        let (fleet, count) = (address(&group.stream, &group.fleet), count as u64);
        let mut launch = group.stream.launch_builder(kernel);
        launch.arg(&fleet).arg(&count);
        if let Some(turn) = &turn {
            launch.arg(turn);
        }
        // SAFETY: the kernels take the fleet, whose addresses stay as long as it, the number of threads, and some the turn.
        unsafe { launch.launch(shape(count, lanes)) }.map(|_| ()).map_err(cuda(doing))
    }
}

/// Blocks of so many threads, with at least `count` of them together.
fn shape(count: u64, lanes: u32) -> LaunchConfig {
    let lanes = lanes.clamp(1, BLOCK);
    let blocks = count.div_ceil(u64::from(lanes)) as u32;
    // Each thread notes there where its heap is.
    let slots = lanes * size_of::<*const u8>() as u32;
    LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (lanes, 1, 1), shared_mem_bytes: slots }
}

fn open(device: usize) -> Result<Arc<CudaContext>, GpuError> {
    // The first call of all: CUDA is initialised by it.
    let found = match CudaContext::new(0) {
        Ok(_) => CudaContext::device_count().map_err(cuda("looking for GPUs"))?,
        Err(e) if e.0 == CUresult::CUDA_ERROR_NO_DEVICE => 0,
        Err(e) => return Err(cuda("looking for GPUs")(e)),
    };
    if device as i64 >= i64::from(found) {
        return Err(GpuError::NoDevice { wanted: device, found });
    }
    CudaContext::new(device).map_err(cuda("opening the GPU"))
}

fn kind(context: &CudaContext) -> Result<Gpu, GpuError> {
    let capability = context.compute_capability().map_err(cuda("asking for the GPU's kind"))?;
    Ok(Gpu { name: context.name().unwrap_or_default(), capability })
}

/// The starts as the kernels read them.
fn rows(starts: &[Start]) -> Vec<u8> {
    let numbers = starts.iter().flat_map(|s| [s.world as f64, s.pose.x, s.pose.y, s.pose.yaw]);
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// What the kernels read a value from: its bytes.
fn bytes_of<T>(value: &T) -> &[u8] {
    // SAFETY: only what is made of numbers alone, without gaps, is sent.
    unsafe { std::slice::from_raw_parts(std::ptr::from_ref(value).cast::<u8>(), size_of::<T>()) }
}

fn address<T>(stream: &CudaStream, part: &CudaSlice<T>) -> u64 {
    part.device_ptr(stream).0
}

/// Memory of the GPU.
struct Memory<'a> {
    stream: &'a Arc<CudaStream>,
}

impl Memory<'_> {
    /// Bytes that say nothing yet.
    fn raw(&self, size: u64) -> Result<CudaSlice<u8>, GpuError> {
        // SAFETY: the kernels write it before they read it.
        unsafe { self.stream.alloc(size as usize) }.map_err(cuda("taking memory"))
    }

    fn zeros<T: DeviceRepr + cudarc::driver::ValidAsZeroBits>(
        &self,
        count: usize,
    ) -> Result<CudaSlice<T>, GpuError> {
        self.stream.alloc_zeros(count.max(1)).map_err(cuda("taking memory"))
    }

    fn copy<T: DeviceRepr>(&self, values: &[T]) -> Result<CudaSlice<T>, GpuError> {
        self.stream.clone_htod(values).map_err(cuda("taking memory"))
    }
}
