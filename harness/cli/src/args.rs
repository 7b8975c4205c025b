//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use vb_record::TraceMode;
use vb_runner::SAMPLE_PERIOD;

const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  a fault of the harness
    2  the command line makes no sense, or names an unknown task, world or parameter
    3  a suite, plugin, rule file, vehicle file or recorded run can't be used
    4  results can't be written (disk full, no permission, directory not empty or in use)
    5  completed, but the simulation of some tasks failed
    6  completed, but the vehicle failed some checks of its test
    7  completed, but the harness or the machine failed some tasks; --resume runs them again
    8  completed, but the planner failed some checks of check
  130  stopped by Ctrl-C; go on with --resume";

/// Benchmark for off-road mobility planners: runs a planner over the tasks of a suite and scores it.
#[derive(Debug, Parser)]
#[command(
    name = "vb-harness",
    version,
    after_help = EXIT_CODES,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    override_usage = "vb-harness --plugin FILE [OPTIONS]\n       vb-harness COMMAND"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) run: Option<RunArgs>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a planner over a suite; the default command
    Run(RunArgs),
    /// Score a finished run again from its traces, without simulating
    Score(ScoreArgs),
    /// Show what a plugin says of itself, without running it
    Inspect(InspectArgs),
    /// Check what planners promise: determinism, hygiene, head-room, and more
    Check(CheckArgs),
    /// Start a planner's project, and describe planners that are not written in Rust
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// List, show, check, import and generate suites
    #[command(subcommand)]
    Suite(SuiteCommand),
    /// List tasks
    #[command(subcommand)]
    Tasks(TasksCommand),
    /// List, show, check and test vehicles
    #[command(subcommand)]
    Vehicle(VehicleCommand),
    /// Train terrain models on elevation data, draw surfaces from them, measure elevation
    #[command(subcommand)]
    Terrain(TerrainCommand),
}

#[derive(Debug, Subcommand)]
pub(crate) enum TerrainCommand {
    /// Train a model on a folder of elevation data; train --help tells its options
    #[command(disable_help_flag = true)]
    Train(TrainArgs),
    /// Draw a surface from a model
    Generate(SurfaceArgs),
    /// Tell heights and slopes of elevation files
    Measure(MeasureArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// Make a project for a planner: source, build, README and CI
    New(NewArgs),
    /// Write a planner's name, version and parameters into its WASM file; Rust's export_planner! does it by itself
    Stamp(StampArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum SuiteCommand {
    /// List the suites that come with the harness
    List,
    /// Show what a suite holds, in figures and as a page with a map of every world
    Show(ShowArgs),
    /// Check whether a suite is fit to be driven: files, hashes, starts, goals, paths, obstacles, labels
    Validate(ValidateArgs),
    /// Make a suite of the original's data (its BenchMaps folder)
    Import(ImportArgs),
    /// Make a suite from a seed
    Generate(GenerateArgs),
    /// Make a suite of a real place, from a raster of its heights
    Site(SiteArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum TasksCommand {
    /// List the tasks of a suite, or those that a selector chooses
    List(TasksArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum VehicleCommand {
    /// List the vehicles that come with the harness
    List,
    /// Show what a vehicle is made of
    Show(VehicleArgs),
    /// Read a vehicle file and check every value
    Validate(VehicleArgs),
    /// Drive a vehicle through standard events and hold it against theory, published figures and Project Chrono
    Test(VehicleTestArgs),
}

/// How results are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// For people.
    #[default]
    Human,
    /// One JSON object a line on stdout.
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    #[arg(long, value_name = "FILE|COMMAND")]
    pub(crate) plugin: PathBuf,
    /// Refuse a native planner where the system can't confine it in every way, and any command
    #[arg(long)]
    pub(crate) require_sandbox: bool,
    /// Suite to run: a directory, or the name of one that comes with the harness; default: vb-mini
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks to run, e.g. w001/t03 or w001-w004,elevation=high; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Tasks run at a time; default: number of cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Directory for the results; default: runs/PLANNER-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run in --out
    #[arg(long, requires = "out")]
    pub(crate) resume: bool,
    /// Seed of the planner's randomness
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Parameter of the planner; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Samples to keep: none, 10hz, or full, which allows exact re-scoring
    #[arg(long, value_name = "none|10hz|full", default_value = "10hz", value_parser = trace_mode)]
    pub(crate) trace: TraceMode,
    /// Rules: paper, release, dev, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "paper")]
    pub(crate) rules: String,
    /// Vehicle: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Soils of deformable ground: default, original, wong, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) soils: String,
    /// Side of the cells in which soil remembers ruts, in metres; scaled with the world
    #[arg(long, value_name = "METRES", default_value = "0.1", value_parser = soil_pitch)]
    pub(crate) soil_pitch: f64,
    /// Step of the simulation in milliseconds, for studies of convergence; scores are comparable at 1 only
    #[arg(long, value_name = "MS", default_value = "1", value_parser = time_step)]
    pub(crate) time_step: f64,
    /// Factor on every length of the world: 1, 1/6, 1/10
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = scale)]
    pub(crate) scale: f64,
    /// Limits of the planner, by name as in docs/abi.md; default: those documented there
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Fuel of a WASM planner for one step (about one unit an instruction), whatever --limits says
    #[arg(long, value_name = "N")]
    pub(crate) fuel_per_step: Option<u64>,
    /// Memory of a WASM planner in bytes, or with a suffix K, M or G, whatever --limits says
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) memory: Option<u64>,
    /// Show the functions in which a planner trapped
    #[arg(long)]
    pub(crate) debug: bool,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Directory of the run
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rules: paper, release, dev, or a file; default: those of the run
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// The planner: a WASM file, a native library, or a command, which is started for it
    #[arg(long, value_name = "FILE|COMMAND")]
    pub(crate) plugin: PathBuf,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    #[arg(long, value_name = "FILE|COMMAND")]
    pub(crate) plugin: PathBuf,
    /// Refuse a native planner where the system can't confine it in every way, and any command
    #[arg(long)]
    pub(crate) require_sandbox: bool,
    /// Limits of the planner, by name as in docs/abi.md; default: those documented there
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Parameter of the planner; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Suite to take tasks from: a directory, or the name of one that comes with the harness; default: vb-mini
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks of which three are driven: the first, the middle and the last; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Name of the planner: a-z, 0-9, - and _
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Language that it is written in
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub(crate) lang: Language,
    /// Folder for the project; default: NAME
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
    /// For Rust, where the SDK is: a folder or a git URL; default: the folder sdk beside the built-in tasks
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) sdk: Option<String>,
}

/// The language of a planner's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Rust, with the SDK.
    Rust,
    /// C, by zig's compiler.
    C,
    /// Python, with its interpreter in the plugin.
    Python,
    /// JavaScript, with the QuickJS engine in the plugin.
    Js,
}

#[derive(Debug, Args)]
pub(crate) struct StampArgs {
    /// The planner: a WASM component, or a core module as wit-bindgen leaves it
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// What the planner says of itself, as YAML: name, version, authors, about, control_period, params
    #[arg(long, value_name = "FILE")]
    pub(crate) meta: PathBuf,
    /// Where to write it; default: in place
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// How results are told, with a short name for programs.
#[derive(Debug, Args)]
pub(crate) struct FormatArgs {
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    message_format: MessageFormat,
    /// The same as --message-format json
    #[arg(long, conflicts_with = "message_format")]
    json: bool,
}

impl FormatArgs {
    pub(crate) fn json(&self) -> bool {
        self.json || self.message_format == MessageFormat::Json
    }
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
    /// Vehicle that must have room at starts and goals and along paths: a name, or a file; default: hmmwv
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
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

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// The same seed makes the same bytes
    #[arg(long, value_name = "N")]
    pub(crate) seed: u64,
    /// Number of worlds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=999))]
    pub(crate) worlds: u32,
    /// Directory for the suite
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Parameters of the generator; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct SiteArgs {
    /// Heights: GeoTIFF, .npy, PNG or BMP, first row in the north
    #[arg(value_name = "RASTER")]
    pub(crate) raster: PathBuf,
    /// Directory for the suite
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Distance between the raster's samples, m; default: what the file says
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) sample_pitch: Option<f64>,
    /// Metres that one unit of the raster's values is high, such as a grey level of a picture
    #[arg(long, value_name = "M", default_value_t = 1.0, value_parser = positive)]
    pub(crate) unit: f64,
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
pub(crate) struct TasksArgs {
    /// The suite: a directory, or the name of one that comes with the harness; default: vb-mini
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Which tasks, e.g. w001/t03 or w001-w004,elevation=high; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE", required_unless_present = "list")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Tyre to put on: the name of one of the vehicle's, e.g. rigid
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// List the events and do nothing else
    #[arg(long)]
    pub(crate) list: bool,
    /// Figures to hold the vehicle against beside theory; default: tasks/validation/VEHICLE.yaml, if it is there
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Step of the simulation in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 1.0)]
    pub(crate) step: f64,
    /// Events run at a time; default: number of cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}

#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Options of the training program
    #[arg(value_name = "OPTIONS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) args: Vec<std::ffi::OsString>,
}

#[derive(Debug, Args)]
pub(crate) struct SurfaceArgs {
    /// The model; default: the one that comes with the harness
    #[arg(long, value_name = "MODEL")]
    pub(crate) model: Option<PathBuf>,
    /// Names the terrain
    #[arg(long, value_name = "N")]
    pub(crate) seed: u64,
    /// Nodes along the sides: one number, or COLUMNSxROWS
    #[arg(long, value_name = "N", default_value = "129", value_parser = nodes)]
    pub(crate) size: (usize, usize),
    /// Distance between nodes in metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    pub(crate) pitch: f64,
    /// Relief: 30, 60 or 100 % of the model's
    #[arg(long, value_name = "LEVEL", value_enum, default_value_t)]
    pub(crate) level: Level,
    /// Where the heights go: a NumPy array (.npy) in metres, or a 16-bit picture (.png) over their range
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Where a hill-shaded picture goes
    #[arg(long, value_name = "PNG")]
    pub(crate) preview: Option<PathBuf>,
}

/// The relief of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Level {
    /// 30 %.
    Low,
    /// 60 %.
    Medium,
    /// 100 %.
    #[default]
    High,
}

impl From<Level> for vb_world::Elevation {
    fn from(level: Level) -> Self {
        match level {
            Level::Low => Self::Low,
            Level::Medium => Self::Medium,
            Level::High => Self::High,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct MeasureArgs {
    /// Elevation files: BMP, PNG, NumPy arrays or GeoTIFF
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Distance between samples in metres; default: as the file says, else 1
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(crate) pitch: Option<f64>,
    /// Metres that one unit of the file's values stands for
    #[arg(long, value_name = "METRES", default_value = "1", value_parser = positive)]
    pub(crate) height_unit: f64,
    /// Only the figures of all files together: their mean standard deviation, and their slopes in one set
    #[arg(long)]
    pub(crate) summary: bool,
}

/// A number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "want a number above 0".into())
}

/// Nodes along two sides: columns, rows.
fn nodes(text: &str) -> Result<(usize, usize), String> {
    let number = |s: &str| s.trim().parse::<usize>().ok();
    let sides = match text.split_once('x') {
        Some((a, b)) => number(a).zip(number(b)),
        None => number(text).map(|n| (n, n)),
    };
    sides.ok_or_else(|| "want a number of nodes, e.g. 129 or 200x100".into())
}

fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("want KEY=VALUE, e.g. speed=5".into()),
    }
}

fn trace_mode(text: &str) -> Result<TraceMode, String> {
    [TraceMode::None, TraceMode::TenHz, TraceMode::Full]
        .into_iter()
        .find(|mode| mode.name() == text)
        .ok_or_else(|| "want none, 10hz or full".into())
}

/// A number or a fraction.
fn scale(text: &str) -> Result<f64, String> {
    let number = |s: &str| s.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
        None => number(text),
    };
    value
        .filter(|v| v.is_finite() && *v >= 0.01 && *v <= 10.0)
        .ok_or_else(|| "want a number or a fraction from 1/100 to 10, e.g. 1, 1/6 or 1/10".into())
}

/// A step in milliseconds, of which a whole number makes the time between two samples; returns seconds.
fn time_step(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| (0.1..=5.0).contains(v));
    value
        .map(|ms| 1e-3 * ms)
        .filter(|s| ((SAMPLE_PERIOD / s).round() * s - SAMPLE_PERIOD).abs() < 1e-9)
        .ok_or_else(|| "want milliseconds from 0.1 to 5 that divide 10, e.g. 0.5".into())
}

/// A length in metres that a soil's memory can have.
fn soil_pitch(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.01..=0.5).contains(v)).ok_or_else(|| "want metres from 0.01 to 0.5, e.g. 0.05".into())
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

/// A number of bytes with an optional binary suffix.
fn bytes(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.chars().last() {
        Some('K' | 'k') => (&text[..text.len() - 1], 10),
        Some('M' | 'm') => (&text[..text.len() - 1], 20),
        Some('G' | 'g') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    digits
        .parse::<u64>()
        .ok()
        .and_then(|n| n.checked_mul(1 << shift))
        .filter(|n| *n > 0)
        .ok_or_else(|| "want a number of bytes, e.g. 268435456 or 256M".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn an_import_takes_each_ground_by_its_name_and_the_described_one_without() {
        use vb_suite::import::Ground;
        let ground = |more: &[&str]| {
            let args = [&["vb-harness", "suite", "import", "BenchMaps", "--out", "original"], more].concat();
            match Cli::try_parse_from(args).unwrap().command {
                Some(Command::Suite(SuiteCommand::Import(args))) => Ground::from(args.ground),
                other => panic!("{other:?}"),
            }
        };
        for wanted in Ground::ALL {
            assert_eq!(ground(&["--ground", wanted.name()]), wanted);
        }
        assert_eq!(ground(&[]), Ground::AsDescribed);
    }

    #[test]
    fn run_is_the_default_command() {
        let with = |args: &[&str]| Cli::try_parse_from([&["vb-harness"], args].concat());
        let short = with(&["--plugin", "a.wasm", "--seed", "7"]).unwrap();
        assert!(short.command.is_none());
        let Some(Command::Run(long)) = with(&["run", "--plugin", "a.wasm", "--seed", "7"]).unwrap().command
        else {
            panic!("run is a command")
        };
        let short = short.run.unwrap();
        assert_eq!(format!("{short:?}"), format!("{long:?}"));
        assert!(with(&[]).is_err() && with(&["run"]).is_err());
        assert!(with(&["score", "runs/a"]).unwrap().run.is_none());
        assert!(with(&["--plugin", "a.wasm", "--resume"]).is_err());
    }

    #[test]
    fn values_are_read_as_people_write_them() {
        assert_eq!((scale("1"), scale("1/10"), scale("0.25")), (Ok(1.0), Ok(0.1), Ok(0.25)));
        assert!(
            scale("1/0").is_err() && scale("-1").is_err() && scale("nan").is_err() && scale("big").is_err()
        );
        assert_eq!((bytes("4096"), bytes("256M"), bytes("1g")), (Ok(4096), Ok(256 << 20), Ok(1 << 30)));
        assert!(bytes("").is_err() && bytes("M").is_err() && bytes("-1").is_err());
        assert!(
            bytes("99999999999999999999G").is_err()
                && bytes("18446744073709551615K").is_err()
                && bytes("é").is_err()
        );
        assert_eq!(key_value("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(key_value("a").is_err() && key_value("=b").is_err());
        assert_eq!((nodes("129"), nodes("200x100")), (Ok((129, 129)), Ok((200, 100))));
        assert!(nodes("").is_err() && nodes("3x").is_err() && nodes("-1").is_err());
        assert!(positive("0").is_err() && positive("inf").is_err() && positive("0.5") == Ok(0.5));
        assert_eq!(trace_mode("10hz"), Ok(TraceMode::TenHz));
        assert!(trace_mode("20hz").is_err());
    }
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let both = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    both.ok_or_else(|| format!("{text:?} is not two numbers, such as 120,-35.5"))
}

fn density(text: &str) -> Result<vb_world::Density, String> {
    let found = vb_world::Density::ALL.into_iter().find(|d| d.name() == text);
    found.ok_or_else(|| "want sparse, medium or dense".to_owned())
}
