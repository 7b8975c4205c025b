//! `vb-harness sweep`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use vb_world::Shard;

use super::exit_codes::{codes, resumed};
use super::values::shard;
use super::{FormatArgs, JobsArgs, ResumeArgs};
use crate::error::{FAILED_START, HOST_ERRORS, INCOMPLETE, INTERRUPTED, SIM_ERRORS};

#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Run all runs of a sweep, or with --resume those that are not finished
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Run(SweepRunArgs),
    /// Print the progress of each run of a sweep
    Status(SweepArgs),
    /// Join the shards of complete runs, and compare all runs in HTML reports and tables
    #[command(after_help = codes(&[INCOMPLETE]))]
    Report(SweepArgs),
}

/// The sweep and where it lies.
#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// Sweep: a YAML file with planners, parameters, vehicles, perception profiles and seeds (docs/scale.md)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Directory for the runs of the sweep
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    #[command(flatten)]
    pub(crate) sweep: SweepArgs,
    #[command(flatten)]
    pub(crate) resume: ResumeArgs,
    /// Run one shard of all runs, e.g. 3/8 for the third of eight
    ///
    /// With auto, shard and number of shards come from the job array of Slurm, Kubernetes or AWS Batch.
    #[arg(long, value_name = "I/N|auto", value_parser = shard)]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Disable the early end of a run whose first tasks all fail
    ///
    /// The early end has three causes. In all of the first 20 tasks, the planner fails with the same fault before its first
    /// command. In all of the first 3 tasks, the planner hangs before its first command. In all of the first 20 tasks, the
    /// simulation fails.
    #[arg(long)]
    pub(crate) keep_going: bool,
}
