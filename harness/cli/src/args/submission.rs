//! The command line of submissions and leaderboards.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use vb_record::LogMode;

use super::values::{log_mode, planner};
use super::{FormatArgs, JobsArgs};

#[derive(Debug, Args)]
pub(crate) struct SubmitArgs {
    /// The planner: a WASM file; a native library can be entered in the open division only
    #[arg(long, value_name = "FILE", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    /// Directory for the submission
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// A finished run of the planner; default: the suite is run now
    #[arg(long, value_name = "DIR", conflicts_with_all = ["vehicle", "jobs", "keep_going", "logs"])]
    pub(crate) run: Option<PathBuf>,
    /// Suite to run: a directory, or the name of one that comes with the harness; default: vb-100, or with --run its own
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle: a name, or a file; default: hmmwv
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Drive all tasks even if the planner fails alike in the first 20, or hangs in the first 3, before its first command, or the
    /// simulation fails in the first 20
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Tasks whose results keep the last lines that the planner logged: all, those that failed, or none; default: failed
    #[arg(long, value_name = "all|failed|none", value_parser = log_mode)]
    pub(crate) logs: Option<LogMode>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Tasks whose traces are carried along for replays, 20 at most, e.g. w001/t03,w007/t00; default: the first of each outcome
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Who enters: a person, a team
    #[arg(long, value_name = "NAME", default_value = "")]
    pub(crate) entrant: String,
    /// Where to read more of the planner; https:// only
    #[arg(long, value_name = "URL")]
    pub(crate) url: Option<String>,
    /// Address of the planner's source, https://…
    #[arg(long)]
    pub(crate) code: Option<String>,
    /// Address of a paper on the planner, https://…
    #[arg(long)]
    pub(crate) paper: Option<String>,
    /// A sentence on the planner
    #[arg(long, value_name = "TEXT")]
    pub(crate) note: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Directory of the submission
    #[arg(value_name = "SUBMISSION")]
    pub(crate) submission: PathBuf,
    /// The planner that was submitted
    #[arg(long, value_name = "FILE", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    /// Suite of the submission: a directory; default: the one of its name that comes with the harness
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle of the submission: a name, or a file; default: the one of its name that comes with the harness
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Soils of the submission: a name, or a file; default: those of their name that come with the harness
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
    /// Perception profile of the submission, a name or a file; default: by its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// Number of tasks that are driven again, beside those with traces; default: all
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) sample: Option<u32>,
    /// Seed that draws them; default: a random one, which nobody can foresee
    #[arg(long, value_name = "N", requires = "sample")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Refuse submissions to the open division before anything of them is run
    #[arg(long)]
    pub(crate) ranked: bool,
    /// Load a native library too, in its sandbox; only WASM is loaded otherwise
    #[arg(long, conflicts_with = "ranked")]
    pub(crate) allow_native: bool,
    /// File for the verdict; default: verification.json in the submission
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// The planner: a WASM file
    #[arg(long, value_name = "FILE", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    /// The hidden suite: a directory
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// What the planner is told and how wrong it is: oracle, onboard, degraded, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "oracle")]
    pub(crate) perception: String,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// File for the scores, e.g. holdout.json of an accepted submission
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum LeaderboardCommand {
    /// Make a site of verified submissions
    Build(BuildArgs),
}

#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Directory with a folder for each accepted submission, with its verification.json
    #[arg(value_name = "DIR")]
    pub(crate) entries: PathBuf,
    /// Directory for the site; an earlier one is replaced
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// What the leaderboard is called
    #[arg(long, value_name = "TEXT", default_value = "Verti-Bench leaderboard")]
    pub(crate) title: String,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
