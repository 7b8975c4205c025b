//! `vb-harness run`, `merge`, `score` and `check`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use vb_record::{LogMode, TraceMode};
use vb_world::Shard;

use super::values::{bytes, log_mode, scale, shard, soil_resolution, time_step, trace_mode};
use super::{
    ForceArgs, FormatArgs, JobsArgs, PERCEPTION, PlannerArgs, PluginArgs, RULES, ResumeArgs, SOIL_RESOLUTION,
    SOILS, TIME_STEP, VEHICLE,
};

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

#[derive(Debug, Args)]
pub(crate) struct MergeRunArgs {
    /// Shard directories from run --shard, or a directory that contains them
    #[arg(value_name = "DIR", required = true)]
    pub(crate) shards: Vec<PathBuf>,
    /// Directory for the joined run
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Suite of the shards; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CommandsArgs {
    /// Run directory, with traces
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// File for the recording
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rule profile: a name from list rules, or a file; default: the run's profile
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite: a directory, or the name of a shipped suite
    #[arg(long, value_name = "NAME|DIR", default_value = vb_catalog::DEFAULT_SUITE)]
    pub(crate) suite: PathBuf,
    /// Tasks of which the first, the middle and the last are run, e.g. w001-w004 or elevation=high,terrain=rigid; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
