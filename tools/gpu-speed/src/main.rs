//! `vb-gpu-speed`: how fast fleets are on a GPU, and whether their states are those of the CPU.

mod cpu;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use vb_catalog::Catalog;
use vb_gpu::{Course, FINE, Fleet, GpuError, Options, Setting};
use vb_sim::Controls;

/// The time from one command to the next, s: that of the benchmark's environments.
const CONTROL_PERIOD: f64 = 0.1;

/// Drive fleets of simulations on a GPU, and compare their states with the CPU's
///
/// Each vehicle begins one of the tasks and keeps its steering and throttle, which differ from vehicle to vehicle, for the
/// whole time. Each line of the table is a fleet.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The kernels, as `cargo xtask kernel` makes them
    #[arg(long, value_name = "FILE", default_value = "target/kernel/vb-kernel-sm_90.cubin")]
    kernel: PathBuf,
    /// The suite: its name or folder
    #[arg(long, value_name = "SUITE", default_value = "smoke")]
    suite: PathBuf,
    /// The tasks, as for `vb-harness run`
    #[arg(long, value_name = "SELECTOR")]
    tasks: Option<String>,
    /// The vehicle
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    vehicle: String,
    /// Vehicles of each fleet
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1024,4096")]
    vehicles: Vec<usize>,
    /// Simulated time, s
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    seconds: f64,
    /// Vehicles whose states are compared with those of the CPU
    #[arg(long, value_name = "N", default_value_t = 200)]
    compare: usize,
    /// Memory that each vehicle has to itself, kB
    #[arg(long, value_name = "KB", default_value_t = Options::default().vehicle_memory >> 10)]
    memory: u64,
    /// Memory for all that need more, MB
    #[arg(long, value_name = "MB")]
    spare_memory: Option<u64>,
    /// Groups of vehicles that are stepped beside each other
    #[arg(long, value_name = "N", default_value_t = Options::default().groups)]
    groups: usize,
    /// Stack of each thread, kB
    #[arg(long, value_name = "KB", default_value_t = 96)]
    stack: usize,
    /// Threads of a block when vehicles start, drive, are near to something, and touch it
    #[arg(long, value_names = ["START", "DRIVE", "NEAR", "TOUCH"], num_args = 4, default_values_t = Options::default().lanes)]
    lanes: Vec<u32>,
}

#[derive(Debug, thiserror::Error)]
enum SpeedError {
    #[error(transparent)]
    Course(#[from] vb_gpu::CourseError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("{0} of {1} vehicles have other states on the GPU than on the CPU")]
    Differ(usize, usize),
    #[error("can't print: {0}")]
    Print(#[from] std::io::Error),
}

/// What is driven.
struct Drive {
    course: Course,
    /// Commands.
    periods: u64,
}

impl Drive {
    fn new(args: &Args) -> Result<Self, SpeedError> {
        let course = Course::new(&Catalog::find(), &args.suite, args.tasks.as_deref(), &args.vehicle)?;
        let periods = (args.seconds / CONTROL_PERIOD).round().max(1.0) as u64;
        Ok(Self { course, periods })
    }

    /// What a vehicle is told.
    fn controls(vehicle: usize) -> Controls {
        let part = |primes: usize| (vehicle * primes % 101) as f64 / 100.0;
        Controls { steering: part(37) - 0.5, throttle: 0.2 + 0.6 * part(53), ..Controls::default() }
    }

    /// The number of the task that a vehicle begins.
    fn task(&self, vehicle: usize) -> usize {
        vehicle % self.course.tasks.len()
    }

    fn steps(&self) -> u64 {
        (CONTROL_PERIOD / self.course.setting.options.step).round() as u64
    }
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            let _ = writeln!(std::io::stderr(), "vb-gpu-speed: {e}");
            ExitCode::FAILURE
        }
    }
}

/// What a function makes, and how long it takes, s.
#[allow(clippy::disallowed_methods, reason = "the time is what is measured: no state depends on it")]
fn timed<T>(of: impl FnOnce() -> T) -> (T, f64) {
    let clock = std::time::Instant::now();
    let made = of();
    (made, clock.elapsed().as_secs_f64())
}

fn run(args: &Args) -> Result<(), SpeedError> {
    let drive = Drive::new(args)?;
    let setting = drive.course.sent();
    let mut out = std::io::stdout();
    let most = args.vehicles.iter().copied().max().unwrap_or(0);
    let cpu = cpu::drive(&drive, args.compare.min(most));
    let steps_a_second = |vehicles: usize, seconds: f64| vehicles as f64 * drive.periods as f64 / seconds;
    writeln!(
        out,
        "| vehicles | starts, s | resets, s | drives, s | steps of {CONTROL_PERIOD} s a second | same states as the CPU | faults |"
    )?;
    writeln!(out, "|---|---|---|---|---|---|---|")?;
    writeln!(
        out,
        "| {}, CPU, {} threads | {:.2} | | {:.2} | {:.0} | | {} |",
        cpu.hashes.len(),
        cpu.threads,
        cpu.starts,
        cpu.drives,
        steps_a_second(cpu.hashes.len(), cpu.drives),
        cpu.hashes.iter().filter(|hash| hash.is_none()).count(),
    )?;
    let mut differ = 0;
    for &vehicles in &args.vehicles {
        let on_gpu = on_gpu(args, &drive, &setting, vehicles)?;
        // A vehicle that has diverged on the CPU has no hash.
        let compared =
            cpu.hashes.iter().zip(&on_gpu.hashes).filter_map(|(cpu, gpu)| cpu.map(|cpu| cpu == *gpu));
        let (same, of) = compared.fold((0, 0), |(same, of), is| (same + usize::from(is), of + 1));
        differ = differ.max(of - same);
        let OnGpu { starts, resets, drives, faults, .. } = on_gpu;
        let speed = steps_a_second(vehicles, drives);
        writeln!(
            out,
            "| {vehicles} | {starts:.2} | {resets:.2} | {drives:.2} | {speed:.0} | {same} of {of} | {faults} |"
        )?;
        out.flush()?;
    }
    if differ > 0 { Err(SpeedError::Differ(differ, cpu.hashes.len())) } else { Ok(()) }
}

/// What became of a fleet on the GPU.
struct OnGpu {
    /// Time that starts, resets and drives took, s.
    starts: f64,
    resets: f64,
    drives: f64,
    hashes: Vec<u64>,
    /// Vehicles with which something is wrong.
    faults: usize,
}

/// Drives a fleet on the GPU.
fn on_gpu(args: &Args, drive: &Drive, setting: &Setting, vehicles: usize) -> Result<OnGpu, GpuError> {
    let options = Options {
        vehicle_memory: args.memory << 10,
        spare_memory: args.spare_memory.map(|mb| mb << 20),
        groups: args.groups,
        stack: args.stack << 10,
        lanes: std::array::from_fn(|k| args.lanes.get(k).copied().unwrap_or(1)),
        ..Options::default()
    };
    let (fleet, starts) =
        timed(|| Fleet::new(&args.kernel, setting, &drive.course.starts(), vehicles, options));
    let mut fleet = fleet?;
    let tasks: Vec<_> = (0..vehicles).map(|vehicle| Some(drive.task(vehicle))).collect();
    let (reset, resets) = timed(|| fleet.reset(&tasks));
    reset?;
    let controls = (0..vehicles).map(Drive::controls).map(|c| [c.steering, c.throttle, c.brake, 1.0]);
    let controls: Vec<[f64; 4]> = controls.collect();
    let (driven, drives) = timed(|| {
        (0..drive.periods).try_for_each(|_| {
            fleet.control(&controls)?;
            fleet.advance(drive.steps())
        })
    });
    driven?;
    let faults = fleet.faults()?.iter().filter(|fault| **fault != FINE).count();
    Ok(OnGpu { starts, resets, drives, hashes: fleet.hashes()?, faults })
}
