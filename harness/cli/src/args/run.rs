//! `vb-harness run`, `merge`, `score` and `check`.

use std::path::{Path, PathBuf};

use clap::Args;
use vb_record::{LogMode, TraceMode};
use vb_world::Shard;

use super::values::{bytes, log_mode, planner, scale, shard, soil_resolution, time_step, trace_mode};
use super::{FormatArgs, JobsArgs, PlannerArgs};

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    // Whether there is a run without a subcommand is seen by this: clap leaves the group of a struct with a flattened one empty.
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), group = "RunArgs")]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite: a directory, or the name of a shipped suite; default: vb-100
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks to run ("," is OR, ":" is AND), e.g. w001-w004,w007/t03 or elevation=high:terrain=rigid; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Run directory to write; default: runs/PLANNER-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Resume the run in --out; default: the last of runs/PLANNER-N
    #[arg(long)]
    pub(crate) resume: bool,
    /// Run one shard of the tasks, e.g. 3/8 for the third of eight, in its own folder of --out
    ///
    /// With auto, shard and number of shards come from the job array of Slurm, Kubernetes or AWS Batch. The same command resumes an
    /// interrupted shard. The command merge joins all shards.
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
    #[arg(long, value_name = "none|10hz|full", default_value = "10hz", value_parser = trace_mode)]
    pub(crate) trace: TraceMode,
    /// Tasks of which the planner's last log lines are recorded: all, failed or none
    #[arg(long, value_name = "all|failed|none", default_value = "failed", value_parser = log_mode)]
    pub(crate) logs: LogMode,
    /// Rule profile: paper, release, dev, exploration, training, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "paper")]
    pub(crate) rules: String,
    /// Vehicle: a name or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Soil set of deformable terrain: default, original, wong, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) soils: String,
    /// Perception profile (maps, sensors and their errors): oracle, onboard, degraded, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "oracle")]
    pub(crate) perception: String,
    /// Cell size of ruts in soil at scale 1, m (0.01 to 0.5)
    #[arg(long, value_name = "METRES", default_value = "0.1", value_parser = soil_resolution)]
    pub(crate) soil_resolution: f64,
    /// Simulation step, ms (0.1 to 5, a divisor of 10), for convergence studies; scores are comparable only at 1
    #[arg(long, value_name = "MS", default_value = "1", value_parser = time_step)]
    pub(crate) time_step: f64,
    /// Factor on all lengths of the world, 0.01 to 10, e.g. 1/6; default: the vehicle's scale
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Fuel limit of a WASM planner per step (about one unit per instruction); overrides --limits
    #[arg(long, value_name = "N")]
    pub(crate) fuel_per_step: Option<u64>,
    /// Memory limit of a WASM or native planner, bytes, or with suffix K, M or G; overrides --limits
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) memory: Option<u64>,
    /// Print the backtrace of a trapped planner, and all recorded logs instead of only those of tasks with errors
    #[arg(long)]
    pub(crate) debug: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

impl RunArgs {
    /// A run of a planner as it is if nothing else is said.
    pub(crate) fn new(plugin: &Path) -> Self {
        Self {
            plugin: plugin.to_owned(),
            planner: PlannerArgs::default(),
            suite: None,
            tasks: None,
            jobs: JobsArgs::default(),
            out: None,
            resume: false,
            shard: None,
            keep_going: false,
            seed: 0,
            trace: TraceMode::default(),
            logs: LogMode::default(),
            rules: "paper".into(),
            vehicle: "hmmwv".into(),
            soils: "default".into(),
            perception: "oracle".into(),
            soil_resolution: 0.1,
            time_step: 0.001,
            scale: None,
            fuel_per_step: None,
            memory: None,
            debug: false,
            format: FormatArgs::default(),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct MergeRunArgs {
    /// Shard directories from run --shard, or a directory that contains them
    #[arg(value_name = "DIR", required = true)]
    pub(crate) shards: Vec<PathBuf>,
    /// Directory for the joined run
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Suite of the shards; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rule profile: paper, release, dev, exploration, training, or a file; default: the run's profile
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite: a directory, or the name of a shipped suite; default: vb-100
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks of which the first, the middle and the last are run; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
