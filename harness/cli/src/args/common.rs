//! Options that several commands have.

use std::path::{Path, PathBuf};

use clap::{Args, ColorChoice, ValueEnum};

use super::values::{key_value, planner};

// Where an option of any command is absent, and in commands without it.
pub(crate) use vb_trial::defaults::{PERCEPTION, RULES, SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE};

/// The heading of the options of every command.
const EVERYWHERE: &str = "Global options";

/// The options of every command.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct GlobalArgs {
    /// Print no progress and no hints, only results, warnings and errors
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = EVERYWHERE)]
    pub(crate) quiet: bool,
    /// Print more: the log lines of every task, and the backtrace of a trapped planner
    #[arg(short, long, global = true, help_heading = EVERYWHERE)]
    pub(crate) verbose: bool,
    /// Colours; auto uses them on terminals, unless the variable NO_COLOR is set
    #[arg(long, value_name = "WHEN", global = true, default_value_t, help_heading = EVERYWHERE)]
    pub(crate) color: ColorChoice,
}

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
    /// Number of tasks that are run in parallel; default: number of cores
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
}

impl JobsArgs {
    /// The number that the user chose, or that of the cores.
    pub(crate) fn get(self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.jobs.map_or_else(cores, usize::from)
    }
}

/// The planner of a command: an argument, or an option for command lines that begin with an option.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct PluginArgs {
    /// Planner: a WASM file, a native library, a recording (see commands), or a command such as "python3 my_planner.py"
    #[arg(value_name = "PLANNER", value_parser = planner())]
    planner: Option<PathBuf>,
    /// Planner, as an option instead of an argument
    #[arg(long, value_name = "PLANNER", value_parser = planner())]
    plugin: Option<PathBuf>,
}

impl PluginArgs {
    /// The file or the command.
    pub(crate) fn path(&self) -> &Path {
        // One of both is there: clap demands it.
        self.planner.as_deref().or(self.plugin.as_deref()).unwrap_or(Path::new(""))
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

/// Whether a command continues what it began.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct ResumeArgs {
    /// Continue what an interrupted command left in --out, or begin if nothing is there
    ///
    /// Without this option, a folder that is not empty is refused.
    #[arg(long)]
    pub(crate) resume: bool,
}

/// Whether files of an earlier call may be replaced.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct ForceArgs {
    /// Replace what an earlier call wrote to the same place
    #[arg(long)]
    pub(crate) force: bool,
}

/// Where the data of a run lie now, if not where they lay.
#[derive(Debug, Default, Args)]
pub(crate) struct ReplayData {
    /// Suite of the runs; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle of the runs, for replays: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Soil set of the runs, for replays: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}
