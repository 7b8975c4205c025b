//! `vb-harness run`, `merge`, `score` and `check`.

use std::path::{Path, PathBuf};

use clap::Args;
use vb_record::{LogMode, TraceMode};
use vb_world::Shard;

use super::values::{bytes, log_mode, planner, scale, shard, soil_resolution, time_step, trace_mode};
use super::{FormatArgs, JobsArgs, PlannerArgs};

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    // Whether there is a run without a subcommand is seen by this: clap leaves the group of a struct with a flattened one empty.
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), group = "RunArgs")]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite to run: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks to run, e.g. w001/t03, w001-w004,w007 (either) or elevation=high:terrain=rigid (both); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Directory for the results; default: runs/PLANNER-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run in --out; default: the last of runs/PLANNER-N
    #[arg(long)]
    pub(crate) resume: bool,
    /// Drive one of several parts of the tasks, e.g. 3/8 for the third of eight, into a folder of its own in --out; auto takes the
    /// numbers from Slurm's, Kubernetes' or AWS Batch's array. The same command goes on where it was stopped; merge joins all parts
    #[arg(long, value_name = "I/N|auto", requires = "out", value_parser = shard)]
    pub(crate) shard: Option<Shard>,
    /// Drive all tasks even if the planner fails alike in the first 20, or hangs in the first 3, before its first command, or the
    /// simulation fails in the first 20
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Seed of the planner's randomness and of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Samples to keep: none, 10hz, or full, which allows exact re-scoring
    #[arg(long, value_name = "none|10hz|full", default_value = "10hz", value_parser = trace_mode)]
    pub(crate) trace: TraceMode,
    /// Tasks whose results keep the last lines that the planner logged: all, those that failed, or none
    #[arg(long, value_name = "all|failed|none", default_value = "failed", value_parser = log_mode)]
    pub(crate) logs: LogMode,
    /// Rules: paper, release, dev, exploration, training, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "paper")]
    pub(crate) rules: String,
    /// Vehicle: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Soils of deformable ground: default, original, wong, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) soils: String,
    /// What the planner is told and how wrong it is: oracle, onboard, degraded, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "oracle")]
    pub(crate) perception: String,
    /// Side of the cells in which soil remembers ruts, in metres; scaled with the world
    #[arg(long, value_name = "METRES", default_value = "0.1", value_parser = soil_resolution)]
    pub(crate) soil_resolution: f64,
    /// Step of the simulation in milliseconds, for studies of convergence; scores are comparable at 1 only
    #[arg(long, value_name = "MS", default_value = "1", value_parser = time_step)]
    pub(crate) time_step: f64,
    /// Factor on every length of the world, 0.01 to 10, e.g. 1/6; default: the scale that the vehicle is made for
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Fuel of a WASM planner for one step (about one unit an instruction), whatever --limits says
    #[arg(long, value_name = "N")]
    pub(crate) fuel_per_step: Option<u64>,
    /// Memory of a WASM or native planner in bytes, or with a suffix K, M or G, whatever --limits says
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) memory: Option<u64>,
    /// Show the functions in which a planner trapped, and every log that is kept, not those of errors alone
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
    /// Directories of shards, or a directory with shards in it, as run --shard makes them
    #[arg(value_name = "DIR", required = true)]
    pub(crate) shards: Vec<PathBuf>,
    /// Directory for the whole run
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// The suite of the shards; default: where it was, or the one of its name that comes with the harness
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Directory of the run
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rules: paper, release, dev, exploration, training, or a file; default: those of the run
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite to take tasks from: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks of which three are driven: the first, the middle and the last; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
