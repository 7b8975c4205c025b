//! Options that several commands have.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::key_value;

/// How results are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// Text for people.
    #[default]
    Human,
    /// One JSON object per line on stdout.
    Json,
}

/// How results are told, with a short name for programs: the same options on every command that has results.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct FormatArgs {
    /// Output format
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    message_format: MessageFormat,
    /// Short form of --message-format json
    #[arg(long, conflicts_with = "message_format")]
    json: bool,
}

impl FormatArgs {
    /// What the user chose by either option.
    pub(crate) fn get(self) -> MessageFormat {
        if self.json { MessageFormat::Json } else { self.message_format }
    }

    pub(crate) fn is_json(self) -> bool {
        self.get() == MessageFormat::Json
    }
}

/// How much is done at a time.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct JobsArgs {
    /// Number of parallel jobs; default: number of cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
}

impl JobsArgs {
    /// The number that the user chose, or that of the cores.
    pub(crate) fn get(self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.jobs.map_or_else(cores, usize::from)
    }
}

/// How a planner is loaded.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct PlannerArgs {
    /// Refuse commands, and native planners that the system can't confine completely
    #[arg(long)]
    pub(crate) require_sandbox: bool,
    /// Planner parameter; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// YAML file with limits of the planner; docs/abi.md lists names and defaults
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
}
