//! `vb-gpu-speed`: how fast fleets are on a GPU, and whether their states are those of the CPU.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use vb_catalog::Catalog;
use vb_gpu::{CONTROL_PERIOD, Course, Drive, FINE, Fleet, GpuError, Options, TIME_STEP, same};

/// Drive fleets of simulations on a GPU, and compare their states with the CPU's
///
/// Each vehicle begins one of the tasks and keeps its steering and throttle, which differ from vehicle to vehicle, for the
/// whole time. Each line of the table is a fleet.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The kernels, as `cargo xtask kernel` makes them: a file, or the folder of those for several kinds of GPUs
    #[arg(long, value_name = "PATH", default_value = "target/kernel")]
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
    /// The time step, ms; only with 1 the states are the benchmark's
    #[arg(long, value_name = "MS", default_value_t = 1e3 * TIME_STEP)]
    time_step: f64,
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
    #[error("can't print: {0}")]
    Print(#[from] std::io::Error),
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
    let course = Course::new(
        &Catalog::find(),
        &args.suite,
        args.tasks.as_deref(),
        &args.vehicle,
        1e-3 * args.time_step,
    )?;
    let drive = Drive::new(&course, args.seconds);
    let mut out = std::io::stdout();
    let compared = args.vehicles.iter().copied().max().unwrap_or(0).min(args.compare);
    let (at_starts, starts) = timed(|| drive.starts_on_cpu(compared));
    let (on_cpu, drives) = timed(|| drive.on_cpu(&at_starts, compared));
    let steps_a_second = |vehicles: usize, seconds: f64| vehicles as f64 * drive.periods() as f64 / seconds;
    writeln!(
        out,
        "| vehicles | starts, s | resets, s | drives, s | steps of {CONTROL_PERIOD} s a second | same states as the CPU | faults |"
    )?;
    writeln!(out, "|---|---|---|---|---|---|---|")?;
    writeln!(
        out,
        "| {compared}, CPU, {} threads | {starts:.2} | | {drives:.2} | {:.0} | | {} |",
        std::thread::available_parallelism().map_or(1, usize::from),
        steps_a_second(compared, drives),
        on_cpu.iter().filter(|hash| hash.is_none()).count(),
    )?;
    let mut differs = None;
    for &vehicles in &args.vehicles {
        let OnGpu { starts, resets, drives, hashes, faults } = on_gpu(args, &course, &drive, vehicles)?;
        let (same, of) = same(&on_cpu, &hashes);
        if same < of {
            differs = Some(GpuError::Differ { differ: of - same, of });
        }
        let speed = steps_a_second(vehicles, drives);
        writeln!(
            out,
            "| {vehicles} | {starts:.2} | {resets:.2} | {drives:.2} | {speed:.0} | {same} of {of} | {faults} |"
        )?;
        out.flush()?;
    }
    differs.map_or(Ok(()), |differs| Err(differs.into()))
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

fn on_gpu(args: &Args, course: &Course, drive: &Drive<'_>, vehicles: usize) -> Result<OnGpu, GpuError> {
    let options = Options {
        vehicle_memory: args.memory << 10,
        spare_memory: args.spare_memory.map(|mb| mb << 20),
        groups: args.groups,
        stack: args.stack << 10,
        lanes: std::array::from_fn(|k| args.lanes.get(k).copied().unwrap_or(1)),
        ..Options::default()
    };
    let (setting, at_starts) = (course.sent(), course.starts());
    let (fleet, starts) = timed(|| Fleet::new(&args.kernel, &setting, &at_starts, vehicles, options));
    let mut fleet = fleet?;
    let (reset, resets) = timed(|| fleet.reset(&drive.tasks(vehicles)));
    reset?;
    let (driven, drives) = timed(|| drive.on_gpu(&mut fleet));
    driven?;
    let faults = fleet.faults()?.iter().filter(|fault| **fault != FINE).count();
    Ok(OnGpu { starts, resets, drives, hashes: fleet.hashes()?, faults })
}
