//! `vb-harness terrain`.

use std::ops::RangeInclusive;
use std::path::Path;
use std::process::Command;

use vb_suite::generate::GeneratorParams;
use vb_terrain::read::{Options, survey};
use vb_terrain::repair::repair;
use vb_terrain::stats::{Spectrum, deviation, exponent, percentile, slopes_of_rows, windows};
use vb_terrain::write::{Kind, shaded};
use vb_terrain::{Model, Request, fit, fraction};
use vb_world::Elevation;

use crate::args::{FitArgs, MeasureArgs, SurfaceArgs, TerrainCommand, TrainArgs};
use crate::error::{self, CliError};
use crate::{output, places, suite};

impl TerrainCommand {
    /// Does what it says.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        match self {
            Self::Train(args) => train(args),
            Self::Generate(args) => generate(args),
            Self::Measure(args) => measure(args),
            Self::Fit(args) => fit(args),
        }
    }
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
