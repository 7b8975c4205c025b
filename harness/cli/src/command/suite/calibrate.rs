//! `vb-harness suite generate --calibrate`: the relief of each level with which a planner completes given fractions of the tasks.
//!
//! The worlds of a level are those that the generator makes of the seed, with the heights multiplied and starts, obstacles and paths made again
//! for them. All reliefs use the same seed. What was driven stays in the output folder, where --resume continues;
//! and since a trial is a function of its inputs, the result does not depend on the number of jobs.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_record::{LogMode, RunReader, TraceMode};
use vb_score::{Flag, Outcome, TILT_LIMIT_DEG, TaskRecord};
use vb_suite::generate::{Evaluation, Generator, GeneratorParams, Search};
use vb_suite::statistics::SuiteStatistics;
use vb_terrain::Model;
use vb_world::{Elevation, Suite};

use super::GenerateArgs;
use crate::args::JobsArgs;
use crate::args::values::{key_value, planner};
use crate::command::run::{self, RunArgs};
use crate::error::CliError;
use crate::{output, places};

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
    #[arg(long = "param", value_name = "KEY=VALUE", default_value = "speed=5", value_parser = key_value, requires = "calibrate")]
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

/// The measurements with one relief of a level.
#[derive(Clone, Debug, Serialize)]
struct Trial {
    level: Elevation,
    /// Factor on `elevation.std`.
    factor: f64,
    /// Standard deviation of height, m.
    std: f64,
    tasks: usize,
    completed: usize,
    /// Fraction of trials with a roll or pitch above 30° at any time.
    tilted: f64,
    /// 99th percentile of the slopes of the facets, degrees.
    facet_slope_p99: f64,
}

/// The outcome, as a file.
#[derive(Debug, Serialize)]
struct Calibration<'a> {
    schema: u32,
    vehicle: &'a str,
    plugin: &'a Path,
    plugin_params: &'a [(String, String)],
    seed: u64,
    worlds_per_level: u32,
    targets_percent: &'a [f64],
    /// The chosen relief of each level.
    chosen: Vec<&'a Trial>,
    /// Everything that was tried.
    tried: &'a [Trial],
}

pub(super) fn calibrate(args: &GenerateArgs, vehicle: &str) -> Result<(), CliError> {
    let params = super::rules::<GeneratorParams>(args.params.as_deref())?;
    let model = places::catalog().model(&params.elevation.model, args.params.as_deref())?;
    // Worlds that a calibration has seen must judge nobody.
    super::keep_apart(args.drawn.seed, true)?;
    let out = &args.drawn.out;
    if !args.calibration.resume && !output::is_free(out) {
        return Err(CliError::output(format!(
            "output directory {} is not empty (choose another with --out, or continue the calibration in it with --resume)",
            out.display()
        )));
    }
    std::fs::create_dir_all(out).map_err(|e| CliError::output(format!("{}: {e}", out.display())))?;
    let cancel = run::stop_on_ctrl_c()?;
    let mut tried = Vec::new();
    let mut chosen = Vec::new();
    for (level, target) in Elevation::ALL.into_iter().zip(&args.calibration.targets) {
        let tolerance = args.calibration.tolerance / 100.0;
        let mut search = Search::new(target / 100.0, tolerance, args.calibration.evaluations as usize);
        let first = tried.len();
        while let Some(factor) = search.next() {
            let trial = evaluate(args, vehicle, &params, &model, level, factor, &cancel)?;
            output::note(&line(&trial));
            search.add(Evaluation { factor, completed: trial.completed, tasks: trial.tasks });
            tried.push(trial);
        }
        let best = search.best().map_or(1.0, |e| e.factor);
        chosen.extend((first..tried.len()).find(|k| tried[*k].factor == best));
    }
    let chosen: Vec<&Trial> = chosen.into_iter().map(|k| &tried[k]).collect();
    let (low, medium, high) = match chosen[..] {
        [low, medium, high] => (low.std, medium.std, high.std),
        _ => return Err(CliError::internal("a level has no relief")),
    };
    let text = match &args.params {
        Some(path) => vb_files::read_text(path, vb_files::DOCUMENT).map_err(CliError::input)?,
        None => GeneratorParams::DEFAULT_YAML.to_owned(),
    };
    let text = with_std(&text, [low, medium, high])
        .ok_or_else(|| CliError::input("the rules have no line `std: {low: …}` for the relief"))?;
    GeneratorParams::parse(&text, "calibrated rules").map_err(CliError::internal)?;
    let calibration = Calibration {
        schema: 1,
        vehicle,
        plugin: plugin(args)?,
        plugin_params: &args.calibration.plugin_params,
        seed: args.drawn.seed,
        worlds_per_level: args.worlds(),
        targets_percent: &args.calibration.targets,
        chosen: chosen.clone(),
        tried: &tried,
    };
    let json = serde_json::to_string_pretty(&calibration).map_err(CliError::internal)?;
    output::write(&out.join("calibration.json"), json + "\n")?;
    output::write(&out.join("params.yaml"), text)?;
    let head =
        ["level", "factor", "std m", "tasks", "completed %", "target %", "tilt > 30° %", "facet slope p99 °"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (trial, target) in chosen.iter().zip(&args.calibration.targets) {
        let mut row = cells(trial);
        row.insert(5, format!("{target}"));
        rows.push(row);
    }
    let all: usize = chosen.iter().map(|t| t.tasks).sum();
    let tilted: f64 = chosen.iter().map(|t| t.tilted * t.tasks as f64).sum();
    let completed: usize = chosen.iter().map(|t| t.completed).sum();
    let percent = |v: f64| format!("{:.1}", 100.0 * v / all.max(1) as f64);
    rows.push(vec![
        "all".into(),
        String::new(),
        String::new(),
        all.to_string(),
        percent(completed as f64),
        String::new(),
        percent(tilted),
        String::new(),
    ]);
    output::text(&output::columns(&rows));
    output::note(&format!(
        "next: vb-harness suite generate --params {} --seed SEED --worlds N --out DIR",
        out.join("params.yaml").display()
    ));
    Ok(())
}

fn cells(t: &Trial) -> Vec<String> {
    vec![
        t.level.name().to_owned(),
        format!("{:.3}", t.factor),
        format!("{:.3}", t.std),
        t.tasks.to_string(),
        format!("{:.1}", 100.0 * t.completed as f64 / t.tasks.max(1) as f64),
        format!("{:.1}", 100.0 * t.tilted),
        format!("{:.1}", t.facet_slope_p99),
    ]
}

fn line(t: &Trial) -> String {
    format!(
        "{} x {:.3}: {} of {} tasks, tilt above {TILT_LIMIT_DEG}° in {:.1} %, facet slope p99 {:.1}°",
        t.level.name(),
        t.factor,
        t.completed,
        t.tasks,
        100.0 * t.tilted,
        t.facet_slope_p99
    )
}

fn plugin(args: &GenerateArgs) -> Result<&Path, CliError> {
    args.calibration.plugin.as_deref().ok_or_else(|| CliError::usage("--calibrate needs --plugin"))
}

/// Makes the worlds of a level with a relief, or takes those that were made, and lets the planner drive all that it did not drive before.
fn evaluate(
    args: &GenerateArgs,
    vehicle: &str,
    params: &GeneratorParams,
    model: &Model,
    level: Elevation,
    factor: f64,
    cancel: &std::sync::Arc<std::sync::atomic::AtomicBool>,
) -> Result<Trial, CliError> {
    let mut params = params.clone();
    let std = params.elevation.std.get(level) * factor;
    // Whole tenths of a millimetre, which the parameter file has, too.
    let std = (std * 1e4).round() / 1e4;
    params.elevation.std.set(level, std);
    let worlds = args.worlds() as usize;
    let generator = Generator { rules: &params, model, seed: args.drawn.seed, worlds: 3 * worlds };
    let name = format!("{}-{factor:.3}", level.name());
    // Other rules, and another generator, make other worlds: they have another name.
    let key =
        vb_files::sha256(format!("{params:?} {:?} {worlds}", generator.meta("", "").provenance).as_bytes());
    let dir = args.drawn.out.join("worlds").join(format!("{name}-{}", &key[..8]));
    if !dir.join(super::INDEX).is_file() {
        output::note(&format!("generating {worlds} {} worlds with the relief x {factor:.3}", level.name()));
        let indices: Vec<usize> = (0..worlds).map(|k| 3 * k + level as usize).collect();
        let folder = vb_record::NewFolder::new(&dir).map_err(CliError::output)?;
        generator.write_some(folder.dir(), generator.meta(&name, "1"), &indices, |_, _| {})?;
        folder.finish(super::INDEX).map_err(CliError::output)?;
    }
    let suite = Suite::open(&dir)?;
    let facets = SuiteStatistics::of(&suite)?;
    let facet_slope_p99 = facets.relief.first().map_or(0.0, |r| r.roughness.facets.p99);
    let out = args.drawn.out.join("runs").join(format!("{name}-{}", &key[..8]));
    let mut drive = RunArgs::new(plugin(args)?);
    drive.planner.params.clone_from(&args.calibration.plugin_params);
    drive.drive.suite = dir;
    drive.drive.vehicle = vehicle.to_owned();
    drive.jobs = args.calibration.jobs;
    drive.drive.trace = TraceMode::None;
    drive.drive.logs = LogMode::None;
    drive.drive.resume.resume = true;
    drive.drive.out = Some(out.clone());
    let config = run::config(&drive)?;
    let report = vb_runner::run(&config, &mut |_| {}, cancel)?;
    if report.interrupted {
        return Err(CliError::interrupted("stopped; continue with the same command and --resume"));
    }
    let records = RunReader::open(&out).and_then(|run| run.records::<TaskRecord>())?;
    let count = |is: &dyn Fn(&TaskRecord) -> bool| records.iter().filter(|r| is(r)).count();
    Ok(Trial {
        level,
        factor,
        std,
        tasks: records.len(),
        completed: count(&|r| r.outcome == Outcome::Success),
        tilted: count(&|r| r.judged().get(&Flag::Tilted) == Some(&true)) as f64 / records.len().max(1) as f64,
        facet_slope_p99,
    })
}

/// The rules with another relief.
fn with_std(text: &str, [low, medium, high]: [f64; 3]) -> Option<String> {
    let line = text.lines().find(|line| line.trim_start().starts_with("std: {low:"))?;
    let indent = &line[..line.len() - line.trim_start().len()];
    Some(text.replacen(line, &format!("{indent}std: {{low: {low}, medium: {medium}, high: {high}}}"), 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_relief_is_written_into_the_rules_and_nothing_else_changes() {
        let text = with_std(GeneratorParams::DEFAULT_YAML, [0.2, 0.5, 0.9]).unwrap();
        let params = GeneratorParams::parse(&text, "calibrated rules").unwrap();
        assert_eq!(Elevation::ALL.map(|e| params.elevation.std.get(e)), [0.2, 0.5, 0.9]);
        let lines = |t: &str| t.lines().map(str::to_owned).collect::<Vec<_>>();
        let changed =
            lines(&text).iter().zip(lines(GeneratorParams::DEFAULT_YAML)).filter(|(a, b)| *a != b).count();
        assert_eq!((changed, lines(&text).len()), (1, lines(GeneratorParams::DEFAULT_YAML).len()));
        assert_eq!(with_std("elevation: {}", [0.2, 0.5, 0.9]), None);
    }
}
