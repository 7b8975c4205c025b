//! `vb-harness dataset`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use vb_dataset::Part;

use super::exit_codes::{codes, resumed};
use super::values::{duration, key_value, planner, positive, scale};
use super::{ForceArgs, FormatArgs, JobsArgs, McapArgs, PERCEPTION, RULES, ResumeArgs, SOILS, VEHICLE};
use crate::error::{HOST_ERRORS, INTERRUPTED, NOT_VERIFIED};

#[derive(Debug, Subcommand)]
pub(crate) enum DatasetCommand {
    /// Record random exploration of training worlds: sinusoidal steering and random speeds
    #[command(
        after_help = resumed(&[HOST_ERRORS, INTERRUPTED]),
        mut_arg("jobs", |arg| arg.help("Number of episodes that are driven in parallel; default: number of cores")),
        mut_arg("worlds", |arg| {
            let text = "Number of generated training worlds; default: one per four episodes, 10 to 90";
            arg.help(text).long_help(text)
        })
    )]
    Explore(ExploreArgs),
    /// Record demonstrations by planners, in tasks of training worlds
    #[command(after_help = resumed(&[HOST_ERRORS, INTERRUPTED]))]
    Drive(DatasetDriveArgs),
    /// Record demonstrations by people, who drive in the browser with keyboard or gamepad
    #[cfg(feature = "teleop")]
    #[command(after_help = resumed(&[INTERRUPTED]))]
    Teleop(TeleopArgs),
    /// Extract the last seconds before each rollover or stuck end from a dataset or a run
    #[command(after_help = codes(&[HOST_ERRORS, INTERRUPTED]))]
    Failures(FailuresArgs),
    /// Write an HTML report of a dataset, with figures and replays of example episodes
    Show(DatasetShowArgs),
    /// Write episodes of a dataset as MCAP files for Foxglove
    Mcap(DatasetMcapArgs),
    /// Validate a dataset: hashes, gaps, ranges, totals, worlds
    #[command(after_help = codes(&[NOT_VERIFIED]))]
    Validate(DatasetValidateArgs),
    /// Merge several datasets
    Merge(MergeArgs),
    /// Split a dataset by world, so that no world is in two parts
    Split(SplitArgs),
}

#[cfg(feature = "teleop")]
#[derive(Debug, Args)]
pub(crate) struct TeleopArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Tasks to choose from, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Port on this machine; 0 for a free port
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub(crate) port: u16,
    /// Don't open the web page in the browser
    #[arg(long)]
    pub(crate) no_browser: bool,
}

#[derive(Debug, Args)]
pub(crate) struct FailuresArgs {
    /// Dataset directory or run directory
    #[arg(value_name = "DATASET|RUN")]
    pub(crate) of: PathBuf,
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Duration before each failure at scale 1, s or with a unit; proportional to the square root of the world's scale
    #[arg(long, value_name = "TIME", default_value_t = vb_dataset::SECONDS, value_parser = duration)]
    pub(crate) duration: f64,
    /// Dataset name; default: failures-of-NAME, with the name of the dataset or of the run's planner
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// For a run: accept a run on a shipped suite; such a dataset is marked as not for training
    #[arg(long)]
    pub(crate) of_a_suite: bool,
    /// For a run: rows and columns of the map crops around the vehicle in each frame; 0 for no crops
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=128))]
    pub(crate) crops: u16,
    #[command(flatten)]
    pub(crate) data: FailuresData,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Where the data of a run lie now whose failures are driven again, if not where they lay.
#[derive(Debug, Args)]
pub(crate) struct FailuresData {
    /// For a run: suite; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// For a run: vehicle, a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// For a run: soil set, a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetShowArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for index.html and the replays; default: a temporary directory, opened in the browser
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Number of example episodes, of each outcome in turn
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub(crate) clips: usize,
    /// Vehicle of the dataset: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetMcapArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the files, one per episode
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) profile: McapArgs,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Episode numbers, e.g. 3,10-19; default: all
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = episodes)]
    pub(crate) episodes: Vec<RangeInclusive<usize>>,
    /// Vehicle of the dataset: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Numbers of episodes, e.g. `7` or `10-19`.
fn episodes(text: &str) -> Result<RangeInclusive<usize>, String> {
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    match (from.parse(), to.parse()) {
        (Ok(from), Ok(to)) if from <= to => Ok(from..=to),
        _ => Err(format!("\"{text}\" is neither a number nor a range, e.g. 10-19")),
    }
}

#[derive(Debug, Args)]
pub(crate) struct DatasetValidateArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Another suite whose worlds must not be in the dataset, in addition to the shipped suites; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Dataset directories
    #[arg(value_name = "DATASET", required = true, num_args = 1..)]
    pub(crate) datasets: Vec<PathBuf>,
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Dataset name; default: merged-VEHICLE
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SplitArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the parts
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Parts and their fractions of the worlds; the sum must be 1
    #[arg(long, value_name = "NAME=FRACTION,…", default_value = "train=0.8,validation=0.1,test=0.1", value_delimiter = ',', value_parser = part)]
    pub(crate) parts: Vec<Part>,
    /// Seed of the random assignment of worlds to parts
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// A part of a dataset, e.g. `train=0.8`. Whether the parts make sense is told when they are all known.
fn part(text: &str) -> Result<Part, String> {
    let (name, fraction) = key_value(text)?;
    Ok(Part { name, fraction: positive(&fraction)? })
}

/// What the datasets that are driven have in common.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) resume: ResumeArgs,
    /// Dataset name; default: COMMAND-VEHICLE-SEED
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Random seed; equal options and seeds give equal bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Suite of training worlds, from vb-harness suite generate --training; default: generated worlds
    #[arg(long, value_name = "DIR", conflicts_with_all = ["worlds", "world_seed"])]
    pub(crate) suite: Option<PathBuf>,
    /// Number of generated training worlds; default: 90
    ///
    /// 90 worlds contain all combinations of elevation level, terrain type and obstacle density equally often.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=999))]
    pub(crate) worlds: Option<u32>,
    /// Seed of the generated training worlds, 7000 to 7999
    #[arg(long, value_name = "N", default_value_t = 7100)]
    pub(crate) world_seed: u64,
    /// Another suite whose worlds must not be in the dataset, in addition to the shipped suites; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Soil set of deformable terrain: a name from list soils, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = SOILS)]
    pub(crate) soils: String,
    /// Perception profile (maps, sensors and their errors): a name from list profiles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = PERCEPTION)]
    pub(crate) perception: String,
    /// Factor on all lengths of the world, 0.01 to 10, e.g. 1/6; default: the vehicle's scale
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Frames per second, 1 to 100
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) hz: u32,
    /// Rows and columns of the map crops around the vehicle in each frame; 0 for no crops
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=128))]
    pub(crate) crops: u16,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Exploration parameters: default (1 to 6 m/s), paper (2 m/s), or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) exploration: String,
    /// Duration of driving, s or with a unit
    #[arg(long, value_name = "TIME", default_value = "10h", value_parser = duration, conflicts_with = "episodes")]
    pub(crate) duration: f64,
    /// Number of episodes, instead of --duration
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) episodes: Option<u32>,
}

/// Which drives of planners become episodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Keeping {
    /// All drives.
    #[default]
    All,
    /// Drives that reach the goal.
    Success,
    /// Drives that don't reach the goal.
    Failure,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetDriveArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Planner: a WASM file, a native library, or a command; may be repeated
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), required = true)]
    pub(crate) plugin: Vec<PathBuf>,
    /// Planner parameter, with a single --plugin only; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Tasks to run, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Drives that become episodes
    #[arg(long, value_name = "WHICH", value_enum, default_value_t)]
    pub(crate) keep: Keeping,
    /// Rule profile: a name from list rules, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = RULES)]
    pub(crate) rules: String,
}
