//! `vb-harness terrain`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::ForceArgs;
use super::exit_codes::codes;
use super::values::positive;
use crate::error::INTERRUPTED;

#[derive(Debug, Subcommand)]
pub(crate) enum TerrainCommand {
    /// Train a terrain model on a folder of elevation data; train --help lists its options
    #[command(disable_help_flag = true, override_usage = "vb-harness terrain train <OPTIONS>...", after_help = codes(&[INTERRUPTED]))]
    Train(TrainArgs),
    /// Generate a surface from a terrain model
    Generate(SurfaceArgs),
    /// Print height standard deviation, slopes and spectral exponent of elevation files
    Measure(MeasureArgs),
    /// Fit elevation.shape of the generator rules to the height spectrum of a suite's worlds
    Fit(FitArgs),
}

#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// Options of the training program
    #[arg(value_name = "OPTIONS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) args: Vec<std::ffi::OsString>,
}

#[derive(Debug, Args)]
pub(crate) struct SurfaceArgs {
    /// Terrain model; default: the shipped model
    #[arg(long, value_name = "MODEL")]
    pub(crate) model: Option<PathBuf>,
    /// Random seed
    #[arg(long, value_name = "N")]
    pub(crate) seed: u64,
    /// Number of nodes per side: one number, or COLUMNSxROWS
    #[arg(long, value_name = "N", default_value = "129", value_parser = nodes)]
    pub(crate) size: (usize, usize),
    /// Distance between nodes, m
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    pub(crate) resolution: f64,
    /// Relief: low, medium or high (30, 60 or 100 % of the model's relief)
    #[arg(long, value_name = "LEVEL", value_enum, default_value_t)]
    pub(crate) level: Level,
    /// File for the heights: a NumPy array (.npy), m, or a 16-bit picture (.png), scaled to their range
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// File for a hill-shaded picture
    #[arg(long, value_name = "PNG")]
    pub(crate) preview: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
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
    /// Elevation files: GeoTIFF, ESRI grids, SRTM tiles, NumPy arrays, PNG or BMP
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Distance between samples, m; default: from the file, else 1
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(crate) resolution: Option<f64>,
    /// Metres per unit of the file's values; default: from the file, else 1
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(crate) height_unit: Option<f64>,
    /// Replace isolated pits and spikes first, as before training
    #[arg(long)]
    pub(crate) repair: bool,
    /// Print only the figures of all files together: mean standard deviation, pooled slopes
    #[arg(long)]
    pub(crate) summary: bool,
}

/// Fractions of three levels.
fn fractions(text: &str) -> Result<[f64; 3], String> {
    let all: Vec<f64> = text.split(',').map(positive).collect::<Result<_, _>>()?;
    all.try_into().map_err(|_| "want three fractions, of low, medium and high worlds, e.g. 0.3,0.6,1".into())
}

/// Nodes along two sides: columns, rows.
pub(super) fn nodes(text: &str) -> Result<(usize, usize), String> {
    let number = |s: &str| s.trim().parse::<usize>().ok();
    let sides = match text.split_once('x') {
        Some((a, b)) => number(a).zip(number(b)),
        None => number(text).map(|n| (n, n)),
    };
    sides.ok_or_else(|| "want a number of nodes, e.g. 129 or 200x100".into())
}

#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// Suite with the target height spectrum: a directory, or the name of a shipped suite
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) like: PathBuf,
    /// Generator rules whose height curve is kept; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// Terrain model; default: the shipped model
    #[arg(long, value_name = "MODEL")]
    pub(crate) model: Option<PathBuf>,
    /// Relief of the suite's low, medium and high worlds, as fractions of the full relief
    #[arg(long, value_name = "LOW,MEDIUM,HIGH", default_value = "0.3,0.6,1", value_parser = fractions)]
    pub(crate) relief: [f64; 3],
    /// Number of surfaces sampled from the model
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) surfaces: u32,
    /// Seed of the first surface
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}
