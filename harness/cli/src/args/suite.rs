//! `vb-harness suite`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::values::{planner, positive};
use super::{FormatArgs, JobsArgs};

#[derive(Debug, Subcommand)]
pub(crate) enum SuiteCommand {
    /// List the suites that come with the harness
    List(SuiteListArgs),
    /// Show what a suite holds, in figures and as a page with a map of every world
    Show(ShowArgs),
    /// Check whether a suite is fit to be driven: files, hashes, starts, goals, paths, obstacles, labels
    #[command(alias = "check")]
    Validate(ValidateArgs),
    /// Collect from runs who has done which tasks, as proof that they can be done
    Prove(ProveArgs),
    /// Make a suite of the original's data (its BenchMaps folder)
    Import(ImportArgs),
    /// Make a suite from a seed
    Generate(GenerateArgs),
    /// Make a suite of a real place, from a raster of its heights
    Site(SiteArgs),
    /// Make a suite like the paper's physical testbed: beds of a few materials, several trials of one task on each
    Testbed(TestbedArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum TasksCommand {
    /// List the tasks of a suite, or those that a selector chooses
    List(TasksArgs),
}

#[derive(Debug, Args)]
pub(crate) struct SuiteListArgs {
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ShowArgs {
    /// The suite: a directory, or the name of one that comes with the harness
    #[arg(value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Directory for index.html, a page with a map of every world, and statistics.json
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    /// The suite: a directory, or the name of one that comes with the harness
    #[arg(value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle that must have room at starts and goals and along paths: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Distance from a path to obstacles in metres below which it is warned of; default: that of the generator's rules
    #[arg(long, value_name = "METRES", value_parser = length)]
    pub(crate) clearance: Option<f64>,
    /// Tilt of the ground under the vehicle in degrees that is warned of along paths and refused at starts and goals;
    /// default: 45
    #[arg(long, value_name = "DEGREES", value_parser = tilt)]
    pub(crate) max_tilt: Option<f64>,
    /// Take warnings for errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ProveArgs {
    /// The suite: a directory, or the name of one that comes with the harness
    #[arg(value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Run directories; of several that did a task the first proves it
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// The file to write; default: proof.json in the suite's directory
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// The original's BenchMaps folder, or one of its parents
    #[arg(value_name = "DIR")]
    pub(crate) from: PathBuf,
    /// Directory for the suite
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Which ground to make: as paper and labels describe it, or as the original's simulator builds it
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
    /// The same seed makes the same bytes
    #[arg(long, value_name = "N")]
    pub(crate) seed: u64,
    /// Directory for the suite
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// What the suite is called; default: the directory's name
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// The suite's version
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
    /// Parameters of the generator; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// The worlds are for training: the seed must be one of 7000 to 7999, which other suites must not have
    #[arg(long)]
    pub(crate) training: bool,
    /// Make no suite, but search the relief of each level with which the planner of --plugin completes the fractions of --targets in this
    /// vehicle (a name, or a file). --worlds is the number of worlds a level, best a multiple of 10; the seed must be one of training worlds.
    /// Into --out go params.yaml (--params with that relief), calibration.json, and all runs; the same command goes on where it was stopped
    #[arg(long, value_name = "VEHICLE", requires = "plugin")]
    pub(crate) calibrate: Option<String>,
    #[command(flatten)]
    pub(crate) calibration: CalibrationArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CalibrationArgs {
    /// The planner that --calibrate lets drive
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), requires = "calibrate")]
    pub(crate) plugin: Option<PathBuf>,
    /// Parameter of this planner; may be repeated; default: speed=5
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = super::values::key_value, requires = "calibrate")]
    pub(crate) plugin_params: Vec<(String, String)>,
    /// Percentages of low, medium and high tasks that it is to complete: by default those of PID in the paper
    #[arg(long, value_name = "LOW,MEDIUM,HIGH", default_value = "86,50,8", value_parser = percentages)]
    pub(crate) targets: [f64; 3],
    /// Points of percentage within which a level's search ends
    #[arg(long, value_name = "POINTS", default_value_t = 2.0, value_parser = percentage)]
    pub(crate) tolerance: f64,
    /// Most reliefs that are tried for a level
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=50))]
    pub(crate) evaluations: u32,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SiteArgs {
    /// Heights: GeoTIFF, ESRI grid (.asc, .bil, .flt), SRTM tile (.hgt), NumPy (.npy, .npz), PNG or BMP; the content decides, not the
    /// ending
    #[arg(value_name = "RASTER")]
    pub(crate) raster: PathBuf,
    /// Directory for the suite
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Distance between the raster's samples, m; default: what the file says
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) sample_resolution: Option<f64>,
    /// Metres that one unit of the raster's values is high, such as a grey level of a picture; default: the file's unit, or 1
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) unit: Option<f64>,
    /// Value that marks places without a height; default: what the file says
    #[arg(long, value_name = "VALUE", value_parser = any_number, allow_hyphen_values = true)]
    pub(crate) no_data: Option<f64>,
    /// Take values for heights that look like unmarked no data, such as a lone -9999
    #[arg(long)]
    pub(crate) keep_values: bool,
    /// Take heights that rise by more than a vehicle can drive on, which otherwise means a wrong unit
    #[arg(long)]
    pub(crate) any_relief: bool,
    /// Coordinate reference system of the raster, e.g. EPSG:32632; default: what the file says
    #[arg(long, value_name = "EPSG:CODE", value_parser = system, allow_hyphen_values = true)]
    pub(crate) crs: Option<vb_terrain::crs::Crs>,
    /// Middle of the one world that is made, m east and north of the raster's middle; default: 0,0
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) at: Option<[f64; 2]>,
    /// Make as many worlds side by side as fit
    #[arg(long, conflicts_with = "at")]
    pub(crate) tiles: bool,
    /// Labels of the ground over the same rectangle; the site rules' legend says what they mean
    #[arg(long, value_name = "RASTER")]
    pub(crate) labels: Option<PathBuf>,
    /// Obstacles as in a world's obstacles.yaml, from the raster's middle; default: drawn
    #[arg(long, value_name = "FILE")]
    pub(crate) obstacles: Option<PathBuf>,
    /// Number of drawn obstacles: sparse, medium or dense; with --obstacles, what the suite calls them
    #[arg(long, value_name = "DENSITY", default_value = "sparse", value_parser = density)]
    pub(crate) density: vb_world::Density,
    /// Rules for grid, ground and starts; default: tasks/generator/site.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) site: Option<PathBuf>,
    /// Rules for friction, obstacles, tasks and paths; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// The same seed makes the same bytes
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
    /// The suite: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Which tasks, e.g. w001/t03, w001-w004,w007 (either) or elevation=high:terrain=rigid (both); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
