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
use vb_kernel::wire::Setting;
use vb_world::Pose2;

use crate::GpuError;
use crate::error::cuda;

/// The compute capability that kernels are built for (`cargo xtask kernel`).
const CAPABILITY: (i32, i32) = (9, 0);
/// Threads of a block, at most: those that a GPU runs together.
const BLOCK: u64 = 32;

/// How a fleet uses a GPU. None of it changes a state.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The number of the GPU.
    pub device: usize,
    /// Memory that a vehicle has, bytes: for its state, and for the ruts that it makes in soft soil, which take up to 5 MB in a
    /// minute. On rigid ground 1 MB does.
    pub vehicle_memory: u64,
    /// Memory that a task has, bytes: the vehicle at its start, and what its copies share, of which the ground is the largest
    /// part.
    pub task_memory: u64,
    /// Memory for the worlds, bytes beside what they have as they are sent.
    pub shared_memory: u64,
    /// Memory on the stack of each thread, bytes.
    pub stack: usize,
    /// Threads of a block: when vehicles start, when they drive, and when hulls touch something. Threads of a block wait for
    /// each other where they do different things.
    pub lanes: [u32; 3],
}

impl Default for Options {
    fn default() -> Self {
        Self {
            device: 0,
            vehicle_memory: 8 << 20,
            task_memory: 4 << 20,
            shared_memory: 64 << 20,
            stack: 96 << 10,
            lanes: [4, 32, 4],
        }
    }
}

/// Where a task begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The number of its world among those of the setting.
    pub world: usize,
    /// The vehicle's pose.
    pub pose: Pose2,
}

/// The kernels.
struct Kernels {
    start: CudaFunction,
    reset: CudaFunction,
    drive: CudaFunction,
    collide: CudaFunction,
    observe: CudaFunction,
}

/// A fleet: vehicles of one kind on a GPU, which are stepped together.
pub struct Fleet {
    stream: Arc<CudaStream>,
    kernels: Kernels,
    options: Options,
    vehicles: usize,
    tasks: usize,
    /// The `vb_kernel::fleet::Fleet` over there.
    fleet: CudaSlice<u8>,
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
    /// A fleet of so many vehicles by the kernels in this file. Each task's vehicle is put at its start now; [`Self::reset`]
    /// tells each vehicle which task it begins.
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
        let code =
            std::fs::read(kernel).map_err(|source| GpuError::Kernel { path: kernel.to_owned(), source })?;
        let context = open(options.device)?;
        let stream = context.default_stream();
        context.set_limit(CUlimit_enum::CU_LIMIT_STACK_SIZE, options.stack).map_err(cuda("stacks"))?;
        // SAFETY: all launches are on one stream, one after another.
        unsafe { context.disable_event_tracking() };
        let module = context.load_module(Ptx::from_binary(code)).map_err(cuda("loading the kernels"))?;
        let function = |name| module.load_function(name).map_err(cuda("looking for the kernels"));
        let kernels = Kernels {
            start: function("vb_start")?,
            reset: function("vb_reset")?,
            drive: function("vb_drive")?,
            collide: function("vb_collide")?,
            observe: function("vb_observe")?,
        };

        let bytes = setting.to_bytes().map_err(|e| GpuError::Encode(e.to_string()))?;
        let tasks = starts.len();
        // What is sent is kept in other forms, and grows by doubling while it is read.
        let shared_memory = options.shared_memory + 4 * bytes.len() as u64;
        let sizes =
            [shared_memory, options.task_memory, options.vehicle_memory].map(|n| n.next_multiple_of(256));
        let counts = [1, tasks as u64, vehicles as u64];
        let needed = sizes.iter().zip(counts).map(|(size, count)| size * count).sum::<u64>();
        let (free, _) = context.mem_get_info().map_err(cuda("asking for memory"))?;
        if needed > free as u64 {
            let mb = |bytes| bytes >> 20;
            return Err(GpuError::Memory { vehicles, tasks, needed: mb(needed), free: mb(free as u64) });
        }
        let memory = Memory { stream: &stream };
        let threads = (vehicles.max(tasks) as u64 + 2 * BLOCK).next_multiple_of(BLOCK);
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
        let slots = keep(memory.zeros(8 * threads as usize)?);
        let told = fleet::Fleet {
            vehicles: vehicles as u64,
            tasks: tasks as u64,
            heaps: [
                keep(memory.raw(sizes[0] * counts[0])?) as *mut u8,
                keep(memory.raw(sizes[1] * counts[1])?) as *mut u8,
                keep(memory.raw(sizes[2] * counts[2])?) as *mut u8,
            ],
            heap_sizes: sizes,
            setting: keep(memory.copy(&bytes)?) as *const u8,
            setting_size: bytes.len() as u64,
            shared: address(&stream, &shared) as *mut _,
            starts: keep(memory.copy(&rows(starts))?) as *const _,
            pool: keep(memory.zeros(8 * tasks)?) as *mut _,
            envs: keep(memory.zeros(8 * vehicles)?) as *mut _,
            near: keep(memory.zeros(4 * vehicles)?) as *mut _,
            near_count: keep(memory.zeros(8)?) as *const _,
            resets: address(&stream, &resets) as *const _,
            controls: address(&stream, &controls) as *const _,
            faults: address(&stream, &faults) as *mut _,
            states: address(&stream, &states) as *mut _,
            hashes: address(&stream, &hashes) as *mut _,
        };
        // SAFETY: it is made of numbers alone, without gaps.
        let told =
            unsafe { std::slice::from_raw_parts((&raw const told).cast::<u8>(), size_of::<fleet::Fleet>()) };
        let fleet = memory.copy(told)?;

        let one = LaunchConfig { grid_dim: (1, 1, 1), block_dim: (1, 1, 1), shared_mem_bytes: 0 };
        let place = address(&stream, &fleet);
        for (name, argument) in [("vb_memory", &slots), ("vb_prepare", &place)] {
            let kernel = function(name)?;
            // SAFETY: these kernels take an address each.
            unsafe { stream.launch_builder(&kernel).arg(argument).launch(one) }
                .map_err(cuda("preparing the fleet"))?;
        }
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
            fleet,
            resets,
            controls,
            faults,
            states,
            hashes,
            steps: 0,
            _held: (module, held),
        };
        fleet.launch(
            &fleet.kernels.start,
            tasks,
            options.lanes[0],
            None,
            "putting vehicles at their starts",
        )?;
        fleet.stream.synchronize().map_err(cuda("putting vehicles at their starts"))?;
        Ok(fleet)
    }

    /// The number of vehicles.
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
        self.launch(&self.kernels.reset, self.vehicles, self.options.lanes[0], None, "a reset")?;
        self.stream.synchronize().map_err(cuda("a reset"))
    }

    /// Tells all vehicles their controls until they are told others: steering in [−1, 1], throttle and brake in [0, 1], and the
    /// gear, which is 1 for forward, 0 for neutral and −1 for reverse.
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

    /// Drives all vehicles on by so many steps, and looks where they are then.
    ///
    /// # Errors
    /// Returns an error if the GPU fails.
    pub fn advance(&mut self, steps: u64) -> Result<(), GpuError> {
        let [_, drive, collide] = self.options.lanes;
        for _ in 0..steps {
            let turn = self.steps % 2;
            self.launch(&self.kernels.drive, self.vehicles, drive, Some(turn), "a step")?;
            self.launch(&self.kernels.collide, self.vehicles, collide, Some(turn), "a step")?;
            self.steps += 1;
        }
        self.launch(&self.kernels.observe, self.vehicles, drive, None, "a look at the vehicles")?;
        self.stream.synchronize().map_err(cuda("a step"))
    }

    /// The state of each vehicle when it was last looked at: the numbers of [`STATE`].
    ///
    /// # Errors
    /// Returns an error if the GPU fails.
    pub fn states(&self) -> Result<Vec<[f64; STATE.len()]>, GpuError> {
        let numbers = self.stream.clone_dtoh(&self.states).map_err(cuda("reading states"))?;
        let (rows, _) = numbers.as_chunks();
        Ok(rows.to_vec())
    }

    /// [`vb_kernel::fleet::FINE`] for each vehicle, or what is wrong with it.
    ///
    /// # Errors
    /// Returns an error if the GPU fails.
    pub fn faults(&self) -> Result<Vec<u32>, GpuError> {
        self.stream.clone_dtoh(&self.faults).map_err(cuda("reading faults"))
    }

    /// The hash of all states of each vehicle since it began its task, every 10 ms, as records of runs have it.
    ///
    /// # Errors
    /// Returns an error if the GPU fails.
    pub fn hashes(&self) -> Result<Vec<u64>, GpuError> {
        self.stream.clone_dtoh(&self.hashes).map_err(cuda("reading hashes"))
    }

    /// Where on the GPU the states are, and where the controls: rows of 64-bit numbers, for those who compute there too.
    #[must_use]
    pub fn addresses(&self) -> [u64; 2] {
        [address(&self.stream, &self.states), address(&self.stream, &self.controls)]
    }

    fn expect(&self, what: &'static str, given: usize) -> Result<(), GpuError> {
        if given == self.vehicles {
            Ok(())
        } else {
            Err(GpuError::Length { what, given, wanted: self.vehicles })
        }
    }

    /// Launches a kernel for the numbers below `count`.
    fn launch(
        &self,
        kernel: &CudaFunction,
        count: usize,
        lanes: u32,
        turn: Option<u64>,
        doing: &'static str,
    ) -> Result<(), GpuError> {
        let lanes = lanes.clamp(1, BLOCK as u32);
        let (fleet, count) = (address(&self.stream, &self.fleet), count as u64);
        let blocks = count.div_ceil(u64::from(lanes)) as u32;
        let shape = LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (lanes, 1, 1), shared_mem_bytes: 0 };
        let mut launch = self.stream.launch_builder(kernel);
        launch.arg(&fleet).arg(&count);
        if let Some(turn) = &turn {
            launch.arg(turn);
        }
        // SAFETY: the kernels take the fleet, whose addresses stay as long as it, the number of threads, and some the turn.
        unsafe { launch.launch(shape) }.map(|_| ()).map_err(cuda(doing))
    }
}

/// The GPU of this number, if the kernels are for it.
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
    let context = CudaContext::new(device).map_err(cuda("opening the GPU"))?;
    let (major, minor) = context.compute_capability().map_err(cuda("asking for the GPU's kind"))?;
    if (major, minor) != CAPABILITY {
        let name = context.name().unwrap_or_default();
        return Err(GpuError::Architecture { name, major, minor });
    }
    Ok(context)
}

/// The starts as the kernels read them.
fn rows(starts: &[Start]) -> Vec<u8> {
    let numbers = starts.iter().flat_map(|s| [s.world as f64, s.pose.x, s.pose.y, s.pose.yaw]);
    numbers.flat_map(f64::to_le_bytes).collect()
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
