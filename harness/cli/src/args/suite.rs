//! `vb-harness suite`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand, ValueEnum};
use vb_suite::validate::{Limits, Vehicle};

use super::exit_codes::resumed;
use super::values::{planner, positive};
use super::{ForceArgs, FormatArgs, JobsArgs, VEHICLE};
use crate::error::{HOST_ERRORS, INTERRUPTED};

#[derive(Debug, Subcommand)]
pub(crate) enum SuiteCommand {
    /// Show the figures of a suite; with --out, write an HTML report with a map of every world
    Show(ShowArgs),
    /// Validate a suite: files, hashes, starts, goals, paths, obstacles, labels
    #[command(alias = "check")]
    Validate(ValidateArgs),
    /// Record the tasks that runs have solved, as a solvability certificate
    Prove(ProveArgs),
    /// Import the worlds of the original benchmark (its BenchMaps folder)
    Import(ImportArgs),
    /// Generate a suite from a seed
    #[command(after_help = resumed(&[HOST_ERRORS, INTERRUPTED]))]
    Generate(GenerateArgs),
    /// Make a suite of a real place from an elevation raster
    Site(SiteArgs),
    /// Make a suite like the paper's physical testbed: beds of a few materials, each with several trials of one task
    Testbed(TestbedArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum TasksCommand {
    /// List all or selected tasks of a suite
    List(TasksArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ShowArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Directory for the HTML report (index.html, with a map of every world) and statistics.json
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle that must fit at starts and goals and along paths: a name or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Minimum distance of paths from obstacles, m; smaller distances are warnings
    #[arg(long, value_name = "METRES", default_value_t = limits().clearance, value_parser = length)]
    pub(crate) clearance: f64,
    /// Maximum tilt of the ground under the vehicle, degrees; more is a warning along paths, and an error at starts and goals
    #[arg(long, value_name = "DEGREES", default_value_t = limits().tilt, value_parser = tilt)]
    pub(crate) max_tilt: f64,
    /// Treat warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("place").required(true)))]
pub(crate) struct ProveArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Run directories; the first run that solved a task is recorded
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// File for the certificate
    #[arg(short, long, value_name = "FILE", group = "place")]
    pub(crate) out: Option<PathBuf>,
    /// Write the certificate to proof.json in the suite's directory, unless the one there proves tasks that these runs don't
    #[arg(long, group = "place")]
    pub(crate) in_place: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// BenchMaps folder of the original benchmark, or a parent folder
    #[arg(value_name = "DIR")]
    pub(crate) from: PathBuf,
    /// Directory for the suite
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Terrain to build: as described by paper and labels, or as simulated by the original's code
    #[arg(long, value_name = "GROUND", value_enum, default_value_t)]
    pub(crate) ground: Ground,
}

/// Which ground an import makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Ground {
    /// Friction and soil per patch, obstacles on the ground.
    #[default]
    AsDescribed,
    /// Friction per merged section, soil in bands and rectangles, obstacles as boxes at their stored height.
    AsSimulated,
}

impl From<Ground> for vb_suite::import::Ground {
    fn from(ground: Ground) -> Self {
        match ground {
            Ground::AsDescribed => Self::AsDescribed,
            Ground::AsSimulated => Self::AsSimulated,
        }
    }
}

/// The seed of a suite whose worlds are drawn, where it goes, and what it is called.
#[derive(Debug, Args)]
pub(crate) struct DrawnArgs {
    /// Random seed; equal options and seeds give equal bytes
    #[arg(long, value_name = "N")]
    pub(crate) seed: u64,
    /// Directory for the suite
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Suite name; default: the directory's name
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Suite version
    #[arg(long, value_name = "VERSION", default_value = "1")]
    pub(crate) suite_version: String,
}

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    #[command(flatten)]
    pub(crate) drawn: DrawnArgs,
    /// Number of worlds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=999))]
    pub(crate) worlds: u32,
    /// Generator rules; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// Generate training worlds, with a seed from 7000 to 7999; other suites can't use these seeds
    #[arg(long)]
    pub(crate) training: bool,
    /// Calibrate the relief of each elevation level with this vehicle (a name or a file), instead of making a suite
    ///
    /// Calibration finds the relief at which the planner of --plugin has the success rates of --targets. --worlds is the number of
    /// worlds per level, preferably a multiple of 10. The seed must be one for training worlds. --out receives params.yaml
    /// (--params with the new relief), calibration.json and all runs.
    #[arg(long, value_name = "VEHICLE", requires = "plugin")]
    pub(crate) calibrate: Option<String>,
    #[command(flatten)]
    pub(crate) calibration: CalibrationArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CalibrationArgs {
    /// Planner for --calibrate: a WASM file, a native library, or a command
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), requires = "calibrate")]
    pub(crate) plugin: Option<PathBuf>,
    /// Continue an interrupted calibration in --out, or begin if nothing is there
    #[arg(long, requires = "calibrate")]
    pub(crate) resume: bool,
    // The speed that the traversal times of the paper's PID imply, m/s.
    /// Parameter of this planner; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", default_value = "speed=5", value_parser = super::values::key_value, requires = "calibrate")]
    pub(crate) plugin_params: Vec<(String, String)>,
    /// Target success rates of low, medium and high tasks, %; the default is that of PID in the paper
    #[arg(long, value_name = "LOW,MEDIUM,HIGH", default_value = "86,50,8", value_parser = percentages)]
    pub(crate) targets: [f64; 3],
    /// Difference from the target at which a level's search ends, percentage points
    #[arg(long, value_name = "POINTS", default_value_t = 2.0, value_parser = percentage)]
    pub(crate) tolerance: f64,
    /// Maximum number of relief values per level
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=50))]
    pub(crate) evaluations: u32,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SiteArgs {
    /// Elevation raster: GeoTIFF, ESRI grid (.asc, .bil, .flt), SRTM tile (.hgt), NumPy (.npy, .npz), PNG or BMP, detected by
    /// content
    #[arg(value_name = "RASTER")]
    pub(crate) raster: PathBuf,
    /// Directory for the suite
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Distance between the raster's samples, m; default: from the file
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) sample_resolution: Option<f64>,
    /// Metres per unit of the raster's values, e.g. per grey level; default: the file's unit, or 1
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) unit: Option<f64>,
    /// Value of places without a height; default: from the file
    #[arg(long, value_name = "VALUE", value_parser = any_number, allow_hyphen_values = true)]
    pub(crate) no_data: Option<f64>,
    /// Keep values that look like unmarked no-data values, e.g. a single -9999, as heights
    #[arg(long)]
    pub(crate) keep_values: bool,
    /// Accept a relief too high or too steep for driving, which otherwise counts as a wrong unit
    #[arg(long)]
    pub(crate) any_relief: bool,
    /// Coordinate reference system of the raster, e.g. EPSG:32632; default: from the file
    #[arg(long, value_name = "EPSG:CODE", value_parser = system, allow_hyphen_values = true)]
    pub(crate) crs: Option<vb_terrain::crs::Crs>,
    /// Centre of the single world, m east and north of the raster's middle
    #[arg(long, value_name = "X,Y", default_value = "0,0", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) at: [f64; 2],
    /// Make as many adjacent worlds as fit
    #[arg(long, conflicts_with = "at")]
    pub(crate) tiles: bool,
    /// Raster of terrain classes over the same rectangle; the legend is in the rules of --site
    #[arg(long, value_name = "RASTER")]
    pub(crate) labels: Option<PathBuf>,
    /// Obstacles in the format of a world's obstacles.yaml, relative to the raster's middle; default: random obstacles
    #[arg(long, value_name = "FILE")]
    pub(crate) obstacles: Option<PathBuf>,
    /// Number of random obstacles: sparse, medium or dense; with --obstacles, the density label of the suite
    #[arg(long, value_name = "DENSITY", default_value = "sparse", value_parser = density)]
    pub(crate) density: vb_world::Density,
    /// Rules for grid and terrain classes; default: tasks/generator/site.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) site: Option<PathBuf>,
    /// Generator rules for friction, starts, obstacles, tasks and paths; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// Random seed; equal options and seeds give equal bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
}

#[derive(Debug, Args)]
pub(crate) struct TestbedArgs {
    #[command(flatten)]
    pub(crate) drawn: DrawnArgs,
    /// Rules of the beds; default: tasks/generator/testbed.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
}

/// The limits of a validation, which are those of any vehicle.
fn limits() -> Limits {
    Limits::of(Vehicle { length: 0.0, width: 0.0 })
}

/// Two numbers, x and y.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let both = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    both.ok_or_else(|| format!("{text:?} is not two numbers, such as 120,-35.5"))
}

/// A number, which may be NaN.
fn any_number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().map_err(|_| format!("{text:?} is no number, such as -9999 or nan"))
}

/// A coordinate reference system.
fn system(text: &str) -> Result<vb_terrain::crs::Crs, String> {
    vb_terrain::crs::Crs::parse(text)
}

/// The name of a density.
fn density(text: &str) -> Result<vb_world::Density, String> {
    let found = vb_world::Density::ALL.into_iter().find(|d| d.name() == text);
    found.ok_or_else(|| "want sparse, medium or dense".to_owned())
}

/// Percentages of three levels.
fn percentages(text: &str) -> Result<[f64; 3], String> {
    let all: Vec<f64> = text.split(',').map(percentage).collect::<Result<_, _>>()?;
    all.try_into().map_err(|_| "want three percentages, of low, medium and high tasks, e.g. 86,50,8".into())
}

/// A percentage between 0 and 100.
fn percentage(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value
        .filter(|v| *v > 0.0 && *v < 100.0)
        .ok_or_else(|| "want a percentage above 0 and below 100, e.g. 86".into())
}

/// A length in metres, 0 or more.
fn length(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.0..=1e3).contains(v)).ok_or_else(|| "want metres from 0 to 1000, e.g. 3.5".into())
}

/// An angle of the ground in degrees.
fn tilt(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.0..=90.0).contains(v)).ok_or_else(|| "want degrees from 0 to 90, e.g. 31".into())
}

#[derive(Debug, Args)]
pub(crate) struct TasksArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(long, value_name = "NAME|DIR", default_value = vb_catalog::DEFAULT_SUITE)]
    pub(crate) suite: PathBuf,
    /// Tasks to list, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
