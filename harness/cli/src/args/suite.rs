//! `vb-harness suite`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};
use vb_suite::validate::{Limits, Vehicle};

use super::exit_codes::resumed;
use super::values::planner;
use super::{ForceArgs, FormatArgs, JobsArgs, VEHICLE};
use crate::error::{HOST_ERRORS, INTERRUPTED};

#[derive(Debug, Subcommand)]
pub(crate) enum SuiteCommand {
    /// Show the figures of a suite; with --out, write an HTML report with a map of every world
    Show(ShowArgs),
    /// Validate a suite: files, hashes, starts, goals, paths, obstacles, labels
    Validate(ValidateArgs),
    /// Record the tasks that runs have solved, as a solvability certificate
    Prove(ProveArgs),
    /// Import the worlds of the original benchmark (its BenchMaps folder)
    #[cfg(feature = "terrain")]
    Import(super::ImportArgs),
    /// Generate a suite from a seed
    #[command(after_help = resumed(&[HOST_ERRORS, INTERRUPTED]))]
    Generate(GenerateArgs),
    /// Make a suite of a real place from an elevation raster
    #[cfg(feature = "terrain")]
    Site(super::SiteArgs),
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
    #[arg(
        long, value_name = "N", required_unless_present = "granular",
        value_parser = clap::value_parser!(u32).range(1..=999)
    )]
    pub(crate) worlds: Option<u32>,
    /// Generator rules; default: tasks/generator/default.yaml, or granular.yaml there with --granular
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// Generate granular beds that two tasks each cross; the rules list the beds
    #[arg(long, conflicts_with_all = ["worlds", "calibrate"])]
    pub(crate) granular: bool,
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

impl GenerateArgs {
    /// The number of worlds, which clap requires where it is used.
    pub(crate) fn worlds(&self) -> u32 {
        self.worlds.unwrap_or(0)
    }
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
