//! `vb-harness sweep`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use vb_world::Shard;

use super::values::shard;
use super::{FormatArgs, JobsArgs};

#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Drive all runs of a sweep, or what is left of them
    Run(SweepRunArgs),
    /// Tell how far the runs of a sweep are
    Status(SweepArgs),
    /// Join the shards of the runs that are done, and compare all runs in pages and tables
    Report(SweepArgs),
}

/// The sweep and where it lies.
#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// The sweep: a YAML file of planners, parameters, vehicles, perception profiles and seeds (docs/scale.md)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Directory of the sweep's runs
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    #[command(flatten)]
    pub(crate) sweep: SweepArgs,
    /// Drive one of several parts of all runs, e.g. 3/8 for the third of eight; auto takes the numbers from Slurm's, Kubernetes' or
    /// AWS Batch's array. The same command goes on where it was stopped
    #[arg(long, value_name = "I/N|auto", value_parser = shard)]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Drive all tasks of a run even if its planner fails alike in the first 20, or hangs in the first 3, before its first command,
    /// or the simulation fails in the first 20
    #[arg(long)]
    pub(crate) keep_going: bool,
}
