//! `vb-harness run`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use clap::{Args, Parser};
use serde::Serialize;
use vb_host::{Limits, Plugin};
use vb_record::{LogMode, RunReader, ShardHeader, TraceMode};
use vb_runner::{FailedStart, RunConfig};
use vb_score::{Outcome, Rules, Summary, TaskRecord};
use vb_world::Shard;

use crate::args::values::{bytes, log_mode, scale, shard, soil_resolution, time_step, trace_mode};
use crate::args::{
    FormatArgs, JobsArgs, MessageFormat, PERCEPTION, PlannerArgs, PluginArgs, RULES, ResumeArgs,
    SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE,
};
use crate::command::suite;
use crate::error::{self, CliError};
use crate::progress::Progress;
use crate::{output, places, planner};

/// Arguments of `run`. Other commands that drive tasks begin with its defaults ([`RunArgs::new`]).
// A parser of its own for that purpose.
#[derive(Debug, Parser)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) drive: DriveArgs,
    /// Fuel limit of a WASM planner per step (about one unit per instruction); overrides --limits
    #[arg(long, value_name = "N")]
    pub(crate) fuel_per_step: Option<u64>,
    /// Memory limit of a WASM or native planner, bytes, or with suffix K, M or G; overrides --limits
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) memory: Option<u64>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Options of a run that do not depend on the kind of planner.
#[derive(Clone, Debug, Args)]
pub(crate) struct DriveArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(long, value_name = "NAME|DIR", default_value = vb_catalog::DEFAULT_SUITE)]
    pub(crate) suite: PathBuf,
    /// Tasks to run, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Run directory to write; default: runs/PLANNER-N, with --resume the last of them
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) resume: ResumeArgs,
    /// Run one shard of the tasks, e.g. 3/8 for the third of eight, in its own folder of --out
    ///
    /// With auto, shard and number of shards come from the job array of Slurm, Kubernetes or AWS Batch. The command merge joins all
    /// shards.
    #[arg(long, value_name = "I/N|auto", requires = "out", value_parser = shard)]
    pub(crate) shard: Option<Shard>,
    /// Disable the early end of a run whose first tasks all fail
    ///
    /// The early end has three causes. In all of the first 20 tasks, the planner fails with the same fault before its first
    /// command. In all of the first 3 tasks, the planner hangs before its first command. In all of the first 20 tasks, the
    /// simulation fails.
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Seed of the planner's randomness and of the sensor noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Samples in the traces: none, 10hz, or full (every 10 ms), which allows exact re-scoring
    #[arg(long, value_name = "none|10hz|full", default_value = TraceMode::default().name(), value_parser = trace_mode)]
    pub(crate) trace: TraceMode,
    /// Tasks of which the planner's last log lines are recorded: all, failed or none
    #[arg(long, value_name = "all|failed|none", default_value = LogMode::default().name(), value_parser = log_mode)]
    pub(crate) logs: LogMode,
    /// Rule profile: a name from list rules, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = RULES)]
    pub(crate) rules: String,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Soil set of deformable terrain: a name from list soils, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = SOILS)]
    pub(crate) soils: String,
    /// Perception profile (maps, sensors and their errors): a name from list profiles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = PERCEPTION)]
    pub(crate) perception: String,
    /// Cell size of ruts in soil at scale 1, m (0.01 to 0.5)
    #[arg(long, value_name = "METRES", default_value_t = SOIL_RESOLUTION, value_parser = soil_resolution)]
    pub(crate) soil_resolution: f64,
    /// Simulation step, s or with a unit (0.1ms to 5ms, a divisor of 10ms), for convergence studies; scores are comparable only with
    /// the default
    #[arg(long, value_name = "TIME", default_value_t = TIME_STEP, value_parser = time_step)]
    pub(crate) time_step: f64,
    /// Factor on all lengths of the world, 0.01 to 10, e.g. 1/6; default: the vehicle's scale
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
}

impl RunArgs {
    /// A run of a planner with the default of each option.
    pub(crate) fn new(plugin: &Path) -> Self {
        // After an equals sign, since a name may begin with a dash.
        let mut option = OsString::from("--plugin=");
        option.push(plugin);
        Self::parse_from([OsString::from("run"), option])
    }
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Finished { out: &'a Path, interrupted: bool, failed_start: Option<&'a FailedStart>, summary: &'a Summary },
}

pub(crate) fn run(args: &RunArgs) -> Result<(), CliError> {
    drive_and_tell(args, None)
}

/// Runs the selected tasks with this planner instead of the named one, and prints the next commands.
pub(crate) fn drive_and_tell(args: &RunArgs, planner: Option<Plugin>) -> Result<(), CliError> {
    let again = |out: &Path| match args.drive.shard {
        // Its folder is within that of --out.
        Some(_) => "the same command and --resume".to_owned(),
        None => format!("the same command and --out {} --resume", output::word(out)),
    };
    let (out, simulated) = drive_with(args, planner, &again)?;
    if args.format.get() == MessageFormat::Human {
        next(&out, args.drive.trace);
    }
    simulated
}

/// What one does next, as commands: look at all of it, and at the first task that failed.
fn next(out: &Path, trace: TraceMode) {
    let own = output::word(out);
    output::note(&format!("next:    vb-harness report {own}"));
    if trace == TraceMode::None {
        return;
    }
    let Ok(mut records) = RunReader::open(out).and_then(|run| run.records::<TaskRecord>()) else { return };
    records.retain(|r| !matches!(r.outcome, Outcome::Success | Outcome::HostError));
    if let Some(first) = records.iter().min_by(|a, b| a.task.cmp(&b.task)) {
        let why =
            first.cause.map_or_else(|| first.outcome.name().replace('_', " "), |c| c.title().to_owned());
        output::note(&format!("         vb-harness replay {own} --task {}    # {why}", first.task));
    }
}

/// Runs what is said, and returns the run's directory with whether all tasks could be simulated. `again` tells how one goes on with
/// the run in a directory.
pub(crate) fn drive(
    args: &RunArgs,
    again: &dyn Fn(&Path) -> String,
) -> Result<(PathBuf, Result<(), CliError>), CliError> {
    drive_with(args, None, again)
}

fn drive_with(
    args: &RunArgs,
    planner: Option<Plugin>,
    again: &dyn Fn(&Path) -> String,
) -> Result<(PathBuf, Result<(), CliError>), CliError> {
    let config = config_with(args, planner)?;
    let cancel = stop_on_ctrl_c()?;
    let mut progress = Progress::new(args.format.get());
    let result = vb_runner::run(&config, &mut |event| progress.hear(event), &cancel);
    progress.finish();
    let report = result?;
    match args.format.get() {
        MessageFormat::Json => output::json(&Message::Finished {
            out: &config.out,
            interrupted: report.interrupted,
            failed_start: report.failed_start.as_ref(),
            summary: &report.summary,
        }),
        MessageFormat::Human => {
            output::text(&vb_files::printable(&report.summary.table(output::width())));
            if let Some(clamped) = progress.clamped() {
                output::text(&format!("{clamped}\n"));
            }
            output::say(&format!("results: {}", config.out.display()));
        }
    }
    let again = again(&config.out);
    if let Some(start) = &report.failed_start {
        return Err(CliError::failed_start(format!(
            "{start} ({} tasks left; fix the cause and start again, or continue with {again}; --keep-going runs all tasks \
             regardless of errors)",
            report.summary.missing(),
        )));
    }
    if report.interrupted {
        return Err(CliError::interrupted(format!(
            "stopped, {} tasks left (continue with {again})",
            report.summary.missing(),
        )));
    }
    match report.summary.host_errors.len() {
        0 => {}
        n => {
            return Err(CliError::host_errors(format!(
                "{n} tasks failed because of the harness or the machine (see outcome host_error in {}; {again} re-runs them)",
                config.out.join("tasks.jsonl").display(),
            )));
        }
    }
    let simulated = match report.summary.sim_errors() {
        0 => Ok(()),
        n => Err(CliError::sim_errors(format!(
            "the simulation of {n} tasks failed (see outcome sim_error in {})",
            config.out.join("tasks.jsonl").display()
        ))),
    };
    Ok((config.out, simulated))
}

pub(crate) fn config(args: &RunArgs) -> Result<RunConfig, CliError> {
    config_with(args, None)
}

/// The configuration of a run, with this planner in place of the one that is named.
fn config_with(args: &RunArgs, planner: Option<Plugin>) -> Result<RunConfig, CliError> {
    // Cheap checks come first: nobody should wait for a plugin to be compiled to learn of a typing error.
    let suite = suite::open(&args.drive.suite)?;
    let tasks = suite::select(&suite, args.drive.tasks.as_deref())?;
    let rules = Rules::resolve(&args.drive.rules).map_err(CliError::input)?;
    let vehicle = places::catalog().vehicle(&args.drive.vehicle)?;
    let scale = args.drive.scale.unwrap_or(vehicle.spec.scale);
    if let Some(warning) = scale_warning(&vehicle.spec, scale) {
        output::say(&warning);
    }
    let soils = places::catalog().soils(&args.drive.soils, args.drive.soil_resolution)?;
    let perception = places::catalog().perception(&args.drive.perception)?;
    let mut limits = args.planner.limits.as_deref().map_or_else(|| Ok(Limits::default()), limits)?;
    if let Some(fuel) = args.fuel_per_step {
        limits.fuel_per_step = fuel;
    }
    if let Some(memory) = args.memory {
        limits.memory_bytes = usize::try_from(memory).map_err(|_| {
            CliError::usage(format!(
                "--memory {memory}: more than the address space of this machine (give less)"
            ))
        })?;
    }
    limits.validate().map_err(|e| CliError::usage(format!("--fuel-per-step or --memory: {e}")))?;
    let wanted = args.plugin.path();
    let plugin = match planner {
        Some(plugin) => plugin,
        None => {
            planner::can_be_confined(wanted, args.planner.require_sandbox)?;
            planner::load(wanted, &limits, args.planner.require_sandbox).map_err(|e| planner::unusable(&e))?
        }
    };
    let name = &plugin.metadata().name;
    let mut out = match &args.drive.out {
        Some(out) => out.clone(),
        None => {
            let last = args.drive.resume.resume.then(|| places::last_run_dir(name)).flatten();
            last.unwrap_or_else(|| places::new_run_dir(name))
        }
    };
    // One that selects all tasks is none: the run is one of the whole suite.
    let selector = args.drive.tasks.clone().filter(|_| tasks.len() < suite.task_count());
    let (mut tasks, mut shard) = (tasks, None);
    if let Some(part) = args.drive.shard {
        shard = Some(ShardHeader { index: part.index(), of: part.of(), tasks: tasks.len() as u64 });
        tasks = part.tasks(&tasks);
        out.push(part.folder());
    }
    // A scheduler gives the same command when it begins a job and when it begins the job again.
    let resume = args.drive.resume.resume && out.join("run.json").exists();
    Ok(RunConfig {
        suite,
        tasks,
        selector,
        shard,
        plugin,
        plugin_path: wanted.to_owned(),
        params: args.planner.params.clone(),
        vehicle,
        soils,
        perception,
        rules,
        time_step: args.drive.time_step,
        scale,
        seed: args.drive.seed,
        jobs: args.jobs.get(),
        trace: args.drive.trace,
        logs: args.drive.logs,
        out,
        resume,
        keep_going: args.drive.keep_going,
        started_at: started_at(),
        harness_version: env!("CARGO_PKG_VERSION").to_owned(),
        harness_commit: env!("VB_COMMIT").to_owned(),
    })
}

/// A line for users who drive a vehicle in worlds of another scale than it is made for.
fn scale_warning(vehicle: &vb_vehicle::VehicleSpec, scale: f64) -> Option<String> {
    let made_for = vehicle.scale;
    ((scale - made_for).abs() > 1e-9).then(|| {
        let shown = |scale: f64| if scale < 1.0 { format!("1/{}", rounded(1.0 / scale)) } else { rounded(scale) };
        format!(
            "warning: the vehicle {} is designed for worlds of scale {}, and these have scale {}: it has {} times the \
             appropriate size (omit --scale, or choose another --vehicle)",
            vehicle.name,
            shown(made_for),
            shown(scale),
            rounded(made_for / scale)
        )
    })
}

/// A number with two digits behind the point at most.
fn rounded(v: f64) -> String {
    ((100.0 * v).round() / 100.0).to_string()
}

/// The limits in a file: every field may be left out.
pub(crate) fn limits(path: &Path) -> Result<Limits, CliError> {
    Limits::load(path).map_err(CliError::input)
}

/// The first Ctrl-C sets what is returned: the run ends when it has put its results away. The second ends the process.
pub(crate) fn stop_on_ctrl_c() -> Result<Arc<AtomicBool>, CliError> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancel);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(error::INTERRUPTED));
        }
        output::note("stopping; press Ctrl-C again to stop at once");
    })
    .map_err(|e| CliError::internal(format!("cannot handle Ctrl-C: {e}")))?;
    Ok(cancel)
}

#[allow(clippy::disallowed_methods, reason = "for the record: nothing of it reaches a score")]
fn started_at() -> String {
    rfc3339(SystemTime::now())
}

/// A time as RFC 3339 has it. Boards without a battery start anywhere: a time that the format lacks is unknown.
fn rfc3339(time: SystemTime) -> String {
    /// 9999-12-31T23:59:59Z.
    const LAST: u64 = 253_402_300_799;
    match time.duration_since(SystemTime::UNIX_EPOCH) {
        Ok(since) if since.as_secs() <= LAST => humantime::format_rfc3339_seconds(time).to_string(),
        _ => "unknown".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vb_vehicle::VehicleSpec;

    use super::*;
    use crate::cli::parse;
    use crate::command::Command;

    #[test]
    fn a_clock_that_is_wrong_ends_nothing() {
        let at = |seconds: u64| rfc3339(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(253_402_300_799), "9999-12-31T23:59:59Z");
        assert_eq!(at(253_402_300_800), "unknown");
        assert_eq!(rfc3339(SystemTime::UNIX_EPOCH - Duration::from_secs(1)), "unknown");
    }

    #[test]
    fn a_vehicle_in_a_world_of_another_scale_is_warned_of() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks/vehicles");
        let vehicle = |name: &str| VehicleSpec::load(&file.join(format!("{name}.yaml"))).unwrap();
        let (full, small) = (vehicle("hmmwv"), vehicle("verti4wheeler"));
        assert_eq!((scale_warning(&full, 1.0), scale_warning(&small, small.scale)), (None, None));
        let told = scale_warning(&full, 0.1).unwrap();
        assert!(
            told.contains("hmmwv is designed for worlds of scale 1, and these have scale 1/10"),
            "{told}"
        );
        assert!(told.contains("it has 10 times the appropriate size"), "{told}");
    }

    fn parsed_run(args: &[&str]) -> RunArgs {
        match parse(args) {
            Ok(Command::Run(args)) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn run_is_the_command_before_a_first_option_and_not_in_the_help_of_the_program() {
        let long = parsed_run(&["run", "--plugin", "a.wasm", "--seed", "7"]);
        for short in [
            &["--plugin", "a.wasm", "--seed", "7"][..],
            &["-q", "--color", "never", "--seed", "7", "--plugin=a.wasm"],
        ] {
            assert_eq!(format!("{:?}", parsed_run(short)), format!("{long:?}"));
        }
        assert!(parse(&[]).is_err() && parse(&["run"]).is_err() && parse(&["a.wasm"]).is_err());
        assert!(matches!(parse(&["score", "runs/a"]), Ok(Command::Score(_))));
        assert_eq!(parse(&["-v", "vehicle", "validate", "a.yaml"]).is_ok(), cfg!(feature = "vehicle"));
        // No command has a second name that the help omits.
        for group in ["suite", "vehicle", "dataset"] {
            assert!(parse(&[group, "check", "a"]).is_err(), "{group}");
        }
        let help = parse(&["--help"]).unwrap_err().to_string();
        assert!(
            help.contains("Usage: vb-harness [OPTIONS] <COMMAND>") && !help.contains("--trace"),
            "{help}"
        );
    }

    #[test]
    fn a_planner_is_an_argument_or_an_option() {
        for command in ["run", "check", "inspect"] {
            assert!(parse(&[command, "a.wasm"]).is_ok() && parse(&[command, "--plugin", "a.wasm"]).is_ok());
            assert!(parse(&[command]).is_err() && parse(&[command, "a.wasm", "--plugin", "b.wasm"]).is_err());
        }
        assert!(parse(&["submit", "a.wasm", "-o", "s"]).is_ok());
        assert!(parse(&["evaluate", "a.wasm", "--suite", "hidden"]).is_ok());
        let plugin = |args: &[&str]| parsed_run(args).plugin.path().to_owned();
        assert_eq!(plugin(&["run", "./a.wasm"]), plugin(&["run", "--plugin", "./a.wasm"]));
    }

    /// The defaults of runs as the documentation has them, and as the benchmark's conditions want them.
    #[test]
    fn the_defaults_of_a_run_are_those_of_the_benchmark() {
        let run = RunArgs::new(Path::new("-a.wasm"));
        assert_eq!(run.plugin.path(), Path::new("-a.wasm"));
        let DriveArgs { rules, vehicle, soils, perception, .. } = &run.drive;
        let names = [rules, vehicle, soils, perception].map(String::as_str);
        assert_eq!(names, ["paper", "hmmwv", "default", "oracle"]);
        assert_eq!(run.drive.suite, Path::new("vb-100"));
        assert_eq!((run.drive.time_step, run.drive.soil_resolution, run.drive.seed), (0.001, 0.1, 0));
        assert_eq!((run.drive.trace, run.drive.logs), (TraceMode::TenHz, LogMode::Failed));
        assert!(
            run.drive.tasks.is_none()
                && run.drive.out.is_none()
                && run.drive.scale.is_none()
                && !run.drive.resume.resume
        );
        let parsed = parsed_run(&["run", "--plugin=-a.wasm"]);
        assert_eq!(format!("{run:?}"), format!("{parsed:?}"));
    }
}
