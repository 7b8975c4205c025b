//! The command line of submissions and leaderboards.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use vb_record::LogMode;

use super::values::{log_mode, planner};
use super::{ForceArgs, FormatArgs, JobsArgs, PERCEPTION, PluginArgs, VEHICLE};

#[derive(Debug, Args)]
pub(crate) struct SubmitArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    /// Directory for the submission
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Continue the run that an interrupted call of submit left as the last runs/PLANNER-N, or begin if there is none
    #[arg(long)]
    pub(crate) resume: bool,
    /// Finished run of the planner; default: a new run over the suite, in runs/PLANNER-N
    #[arg(long, value_name = "DIR", conflicts_with_all = ["resume", "vehicle", "jobs", "keep_going", "logs"])]
    pub(crate) run: Option<PathBuf>,
    /// Suite: a directory, or the name of a shipped suite; default: vb-100, or the suite of --run
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Disable the early end of a run whose first tasks all fail
    ///
    /// The early end has three causes. In all of the first 20 tasks, the planner fails with the same fault before its first
    /// command. In all of the first 3 tasks, the planner hangs before its first command. In all of the first 20 tasks, the
    /// simulation fails.
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Tasks of which the planner's last log lines are recorded: all, failed or none
    #[arg(long, value_name = "all|failed|none", default_value = LogMode::default().name(), value_parser = log_mode)]
    pub(crate) logs: LogMode,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Tasks whose traces are included for replays (maximum 20), e.g. w001/t03,w007/t00; default: the first of each outcome
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Entrant: a person or a team
    #[arg(long, value_name = "NAME", default_value = "")]
    pub(crate) entrant: String,
    /// Page about the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) url: Option<String>,
    /// Source code of the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) code: Option<String>,
    /// Paper about the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) paper: Option<String>,
    /// One sentence about the planner
    #[arg(long, value_name = "TEXT")]
    pub(crate) note: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Submission directory
    #[arg(value_name = "SUBMISSION")]
    pub(crate) submission: PathBuf,
    /// Submitted planner: a WASM file, a recording, or a native library with --allow-native
    #[arg(long, value_name = "FILE", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    /// Suite of the submission: a directory; default: the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle of the submission: a name or a file; default: the shipped vehicle of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Soil set of the submission: a name or a file; default: the shipped set of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
    /// Perception profile of the submission: a name or a file; default: the shipped profile of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// Number of random tasks to re-run, in addition to those with traces; default: all tasks
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) sample: Option<u32>,
    /// Seed of the random tasks; default: an unpredictable seed
    #[arg(long, value_name = "N", requires = "sample")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Refuse submissions to the open division before any run
    #[arg(long)]
    pub(crate) ranked: bool,
    /// Also load native libraries, in their sandbox; default: only WASM and recordings
    #[arg(long, conflicts_with = "ranked")]
    pub(crate) allow_native: bool,
    /// File for the verdict; default: verification.json in the submission
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    /// Hidden suite: a directory
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Perception profile (maps, sensors and their errors): a name from list profiles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = PERCEPTION)]
    pub(crate) perception: String,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// File for the scores, e.g. holdout.json of an accepted submission
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum LeaderboardCommand {
    /// Build a static site from verified submissions
    Build(BuildArgs),
}

#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Directory with one folder per accepted submission, each with its verification.json
    #[arg(value_name = "DIR")]
    pub(crate) entries: PathBuf,
    /// Directory for the site
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Title of the leaderboard
    #[arg(long, value_name = "TEXT", default_value = "Verti-Bench leaderboard")]
    pub(crate) title: String,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
