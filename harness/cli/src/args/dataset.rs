//! `vb-harness dataset`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use vb_dataset::Part;

use super::values::{key_value, planner, positive, scale};
use super::{FormatArgs, JobsArgs};

#[derive(Debug, Subcommand)]
pub(crate) enum DatasetCommand {
    /// Explore training worlds: sinusoidal steering and random speeds
    Explore(ExploreArgs),
    /// Let planners drive the tasks of training worlds: demonstrations
    Drive(DatasetDriveArgs),
    /// Drive yourself, in the browser, with keyboard or gamepad: demonstrations by people
    Teleop(TeleopArgs),
    /// Cut the last seconds before each rollover, or getting stuck, out of a dataset or a run
    Failures(FailuresArgs),
    /// Look at a dataset: a page with its figures, and replays of example episodes
    Show(DatasetShowArgs),
    /// Write episodes of a dataset as MCAP files, which Foxglove shows
    Mcap(DatasetMcapArgs),
    /// Check whether a dataset is what it should be: hashes, gaps, ranges, totals, worlds
    #[command(alias = "check")]
    Validate(DatasetValidateArgs),
    /// Put several datasets into one
    Merge(MergeArgs),
    /// Split a dataset by its worlds, so that no world is in two parts
    Split(SplitArgs),
}

#[derive(Debug, Args)]
pub(crate) struct TeleopArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Tasks to choose from, e.g. w001-w004,w007 (either) or elevation=high:terrain=rigid (both); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Port of this machine; 0 for any
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub(crate) port: u16,
    /// Don't open the page in the browser
    #[arg(long)]
    pub(crate) no_browser: bool,
}

#[derive(Debug, Args)]
pub(crate) struct FailuresArgs {
    /// The directory of a dataset, or of a run
    #[arg(value_name = "DATASET|RUN")]
    pub(crate) of: PathBuf,
    /// Directory for the dataset
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Seconds before each failure, in a world of scale 1; in others by the square root of the scale fewer or more
    #[arg(long, value_name = "S", default_value_t = vb_dataset::SECONDS, value_parser = positive)]
    pub(crate) seconds: f64,
    /// What the dataset is called; default: failures-of- and the name of the dataset, or of the run's planner
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// For failures of a run: take one on a suite that comes with the harness, to be looked at; nothing may be trained on it
    #[arg(long)]
    pub(crate) of_a_suite: bool,
    /// For failures of a run: rows and columns of crops of the maps about the vehicle that each frame has; none for 0
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
    /// For failures of a run: its suite; default: where it was, or the one of its name that comes with the harness
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// For failures of a run: its vehicle, a name or a file; default: by its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// For failures of a run: its soils, a name or a file; default: by their name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetShowArgs {
    /// The directory of the dataset
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for index.html and the replays; default: a temporary one, which is opened in the browser
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Number of example episodes, of each outcome in turn
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub(crate) clips: usize,
    /// Vehicle, if it is not at hand by the name that the dataset has: a name, or a file
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetMcapArgs {
    /// The directory of the dataset
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the files, one an episode
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Episodes, e.g. 3,10-19; default: all
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = episodes)]
    pub(crate) episodes: Vec<RangeInclusive<usize>>,
    /// Vehicle, if it is not at hand by the name that the dataset has: a name, or a file
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
        _ => Err(format!("\"{text}\" is no number, and no range as 10-19")),
    }
}

#[derive(Debug, Args)]
pub(crate) struct DatasetValidateArgs {
    /// The directory of the dataset
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Another suite whose worlds must not be in the dataset, beside those that come with the harness; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// The directories of the datasets
    #[arg(value_name = "DATASET", required = true, num_args = 1..)]
    pub(crate) datasets: Vec<PathBuf>,
    /// Directory for the dataset
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// What the dataset is called; default: merged and the vehicle
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SplitArgs {
    /// The directory of the dataset
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the parts
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// The parts and their fractions of the worlds, which sum to 1
    #[arg(long, value_name = "NAME=FRACTION,…", default_value = "train=0.8,validation=0.1,test=0.1", value_delimiter = ',', value_parser = part)]
    pub(crate) parts: Vec<Part>,
    /// Seed by which worlds are dealt out
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
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Go on with the dataset in --out
    #[arg(long)]
    pub(crate) resume: bool,
    /// What the dataset is called; default: what it is of, the vehicle and the seed
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Seed of all that is random; the same seed makes the same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Suite of training worlds, as `vb-harness suite generate --training` makes them; default: they are made
    #[arg(long, value_name = "DIR", conflicts_with_all = ["worlds", "world_seed"])]
    pub(crate) suite: Option<PathBuf>,
    /// Number of training worlds that are made; 90 cover all combinations of relief, terrain and obstacles equally; default: 90, but for
    /// explore one for each four episodes, 10 to 90
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=999))]
    pub(crate) worlds: Option<u32>,
    /// Seed of the training worlds that are made, from 7000 to 7999
    #[arg(long, value_name = "N", default_value_t = 7100)]
    pub(crate) world_seed: u64,
    /// Another suite whose worlds must not be in the dataset, beside those that come with the harness; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    /// Vehicle: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Soils of deformable ground: default, original, wong, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) soils: String,
    /// What the driver is told and how wrong it is: oracle, onboard, degraded, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "oracle")]
    pub(crate) perception: String,
    /// Factor on every length of the world, 0.01 to 10, e.g. 1/6; default: the scale that the vehicle is made for
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Frames a second
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) hz: u32,
    /// Rows and columns of crops of the maps about the vehicle that each frame has; none for 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=128))]
    pub(crate) crops: u16,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// How the vehicle explores: default (1 to 6 m/s), paper (2 m/s), or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) exploration: String,
    /// Hours of driving
    #[arg(long, value_name = "HOURS", default_value_t = 10.0, value_parser = positive, conflicts_with = "episodes")]
    pub(crate) hours: f64,
    /// Number of episodes, instead of hours
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) episodes: Option<u32>,
}

/// Which drives of planners become episodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Keeping {
    /// Every one.
    #[default]
    All,
    /// Those that reach their goal.
    Success,
    /// Those that don't.
    Failure,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetDriveArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// A planner: a WASM file, a native library, or a command; may be repeated
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), required = true)]
    pub(crate) plugin: Vec<PathBuf>,
    /// Parameter of the planner, if there is but one; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Tasks to drive, e.g. w001/t03, w001-w004,w007 (either) or elevation=high:terrain=rigid (both); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Which drives become episodes
    #[arg(long, value_name = "WHICH", value_enum, default_value_t)]
    pub(crate) keep: Keeping,
    /// Rules: paper, release, dev, exploration, training, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "paper")]
    pub(crate) rules: String,
}
