//! `vb-harness terrain`.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::{Args, ValueEnum};
use vb_suite::generate::GeneratorParams;
use vb_terrain::read::{Options, survey};
use vb_terrain::repair::repair;
use vb_terrain::stats::{Spectrum, deviation, exponent, percentile, slopes_of_rows, windows};
use vb_terrain::write::{Kind, shaded};
use vb_terrain::{Model, Request, fit, fraction};
use vb_world::Elevation;

use crate::args::ForceArgs;
use crate::args::exit_codes::codes;
use crate::args::values::positive;
use crate::command::suite;
use crate::error::{self, CliError, INTERRUPTED};
use crate::{output, places};

commands! {
    TerrainCommand

    /// Train a terrain model on a folder of elevation data; train --help lists its options
    #[command(disable_help_flag = true, override_usage = "vb-harness terrain train <OPTIONS>...", after_help = codes(&[INTERRUPTED]))]
    Train(TrainArgs) => train,
    /// Generate a surface from a terrain model
    Generate(SurfaceArgs) => generate,
    /// Print height standard deviation, slopes and spectral exponent of elevation files
    Measure(MeasureArgs) => measure,
    /// Fit elevation.shape of the generator rules to the height spectrum of a suite's worlds
    Fit(FitArgs) => fit,
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
fn nodes(text: &str) -> Result<(usize, usize), String> {
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

/// The model that surfaces are drawn from where none is named.
const DEFAULT_MODEL: &str = "rocks";
/// The program that trains.
const TRAINER: &str = "vb-terrain-train";

/// Runs the program that trains, which lies beside this one: what it computes with takes longer to build than the harness.
pub(crate) fn train(args: &TrainArgs) -> Result<(), CliError> {
    let name = format!("{TRAINER}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|p| Some(p.parent()?.join(&name)));
    let Some(program) = beside.filter(|p| p.is_file()) else {
        return Err(CliError::input(format!(
            "{name} is not next to vb-harness (build it with: cargo build --release --package {TRAINER})"
        )));
    };
    let mut command = Command::new(&program);
    command.args(&args.args);
    // Blocks of memory as large as its tensors come and go: kept by the allocator they are much faster.
    for (key, value) in [("MALLOC_MMAP_THRESHOLD_", "1073741824"), ("MALLOC_TRIM_THRESHOLD_", "8589934592")] {
        if std::env::var_os(key).is_none() {
            command.env(key, value);
        }
    }
    let status = command.status().map_err(|e| CliError::input(format!("{}: {e}", program.display())))?;
    match status.code() {
        Some(0) => Ok(()),
        // It said what is wrong.
        Some(code) => Err(CliError::told(u8::try_from(code).unwrap_or(error::INTERNAL))),
        None => Err(CliError::interrupted("the training was stopped; continue with --resume")),
    }
}

/// The model in a file, or the one that comes with the harness.
fn model(file: Option<&Path>) -> Result<Model, CliError> {
    let path = match file {
        Some(path) => path.to_owned(),
        None => places::catalog().terrain_model(DEFAULT_MODEL)?,
    };
    Model::read(&path).map_err(CliError::input)
}

/// Fits a shaping to the worlds of a suite and prints it as a section of the generator's rules.
pub(crate) fn fit(args: &FitArgs) -> Result<(), CliError> {
    let suite = suite::open(&args.like)?;
    let model = model(args.model.as_deref())?;
    let mut surfaces = Vec::new();
    for info in suite.worlds() {
        let fraction = match info.elevation {
            Elevation::Low => args.relief[0],
            Elevation::Medium => args.relief[1],
            Elevation::High => args.relief[2],
        };
        surfaces.push((suite.load_world(&info.id)?.heightfield, fraction));
    }
    let rules = suite::rules::<GeneratorParams>(args.params.as_deref())?;
    let start = rules.elevation.shape.ok_or_else(|| {
        CliError::input(
            "the rules have no elevation.shape, whose curve is needed (give other rules with --params)",
        )
    })?;
    let wanted = fit::of_surfaces(&surfaces).map_err(CliError::input)?;
    let round = |k: usize, ratios: &[f64]| {
        let ratios: Vec<_> = ratios.iter().map(|r| format!("{r:.3}")).collect();
        output::note(&format!(
            "iteration {k}: root mean square relative to the target by band: {}",
            ratios.join(" ")
        ));
    };
    let shape = fit::fit(&model, &wanted, &start, args.seed, args.surfaces as usize, round)
        .map_err(CliError::input)?;
    let list = |v: &[f64]| v.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let swells: Vec<_> =
        shape.swells.iter().map(|s| format!("{{spacing: {}, std: {}}}", s.spacing, s.std)).collect();
    output::text(&format!(
        "  shape:\n    std: {}\n    wavelengths: [{}]\n    gains: [{}]\n    from: [{}]\n    to: [{}]\n    swells: [{}]\n",
        shape.std,
        list(&shape.wavelengths),
        list(&shape.gains),
        list(&shape.from),
        list(&shape.to),
        swells.join(", ")
    ));
    Ok(())
}

/// Draws a surface and writes it.
pub(crate) fn generate(args: &SurfaceArgs) -> Result<(), CliError> {
    let kind = Kind::of(&args.out)
        .ok_or_else(|| CliError::usage(format!("--out {}: must end in .npy or .png", args.out.display())))?;
    for path in [&args.out].into_iter().chain(&args.preview) {
        output::must_not_replace(path, args.force)?;
    }
    let model = model(args.model.as_deref())?;
    let level = Elevation::from(args.level);
    let request = Request {
        seed: args.seed,
        rows: args.size.1,
        cols: args.size.0,
        resolution: args.resolution,
        fraction: fraction(level),
    };
    let surface = model.surface(&request).map_err(CliError::usage)?;
    let put = |path: &Path, bytes: std::io::Result<Vec<u8>>| {
        let bytes = bytes.map_err(|e| CliError::output(format!("{}: {e}", path.display())))?;
        output::write(path, bytes)
    };
    put(&args.out, kind.encode(&surface))?;
    if let Some(preview) = &args.preview {
        put(preview, shaded(&surface))?;
    }
    let (low, high) = surface.range();
    output::text(&format!(
        "{}: {} x {} nodes, spacing {} m, heights {low:.3} to {high:.3} m, standard deviation {:.3} m\n",
        args.out.display(),
        surface.cols(),
        surface.rows(),
        surface.resolution(),
        deviation(surface.heights())
    ));
    Ok(())
}

/// Samples along the windows whose power is measured, and the waves in one that its exponent is fitted over.
const WINDOW: usize = 32;
const WAVES: RangeInclusive<usize> = 1..=10;

/// Slopes that are computed of a file at most.
const MOST_SLOPES: usize = 1 << 24;

/// Tells heights, slopes and the spectrum's exponent of elevation files.
pub(crate) fn measure(args: &MeasureArgs) -> Result<(), CliError> {
    let head = ["file", "samples", "resolution", "std", "slope p50", "p90", "p95", "p99", "p99.5", "power"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let (mut steep, mut deviations, mut power) = (Vec::new(), Vec::new(), Vec::new());
    let row =
        |name: String, size: String, resolution: f64, std: f64, steep: &mut [f64], power: &[Vec<f64>]| {
            let degrees = [0.5, 0.9, 0.95, 0.99, 0.995].map(|s| format!("{:.1}", percentile(steep, s)));
            let start = [name, size, format!("{resolution} m"), format!("{std:.3} m")];
            start.into_iter().chain(degrees).chain([law(power)]).collect::<Vec<_>>()
        };
    for path in &args.files {
        let options = Options { unit: args.height_unit, resolution: args.resolution, ..Options::default() };
        let mut raster = survey(path, &options).map_err(CliError::input)?.heights;
        if args.repair {
            repair(&mut raster);
        }
        let resolution = raster.resolution().unwrap_or(1.0);
        let heights = raster.values();
        // Of a large file, slopes of every so many-th row and spectra of every so many-th window.
        let every = heights.len().div_ceil(MOST_SLOPES).max(1);
        let mut own = slopes_of_rows(heights, raster.cols(), resolution, every);
        let std = deviation(heights);
        // Each file's power over its variance: a steep file counts as much as a level one.
        let mut parts: Vec<Vec<f64>> = windows(heights, raster.cols(), WINDOW).step_by(every).collect();
        for v in parts.iter_mut().flatten() {
            *v /= std;
        }
        let size = format!("{} x {}", raster.cols(), raster.rows());
        if !args.summary {
            rows.push(row(path.display().to_string(), size, resolution, std, &mut own, &parts));
        }
        steep.append(&mut own);
        power.append(&mut parts);
        deviations.push(std);
    }
    let mean = deviations.iter().sum::<f64>() / deviations.len().max(1) as f64;
    if args.summary || args.files.len() > 1 {
        let resolution = args.resolution.unwrap_or(1.0);
        rows.push(row(format!("all {}", args.files.len()), "-".into(), resolution, mean, &mut steep, &power));
    }
    output::text(&output::columns(&rows));
    Ok(())
}

/// The power law of these windows; none where there is no window, or nothing rises or falls.
fn law(windows: &[Vec<f64>]) -> String {
    let mut spectrum = Spectrum::new(WINDOW);
    windows.iter().for_each(|w| spectrum.add(w));
    let exponent = exponent(&spectrum.radial(), WAVES);
    if exponent.is_finite() { format!("k^{exponent:.2}") } else { "-".into() }
}

#[cfg(test)]
mod tests {
    use super::nodes;

    #[test]
    fn nodes_are_one_number_or_two() {
        assert_eq!((nodes("129"), nodes("200x100")), (Ok((129, 129)), Ok((200, 100))));
        assert!(nodes("").is_err() && nodes("3x").is_err() && nodes("-1").is_err());
    }
}
