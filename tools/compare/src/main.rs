//! `vb-compare`: drives the tasks that Project Chrono was recorded on, with the original's planner, speed and rules,
//! and puts both results side by side. `cargo xtask compare-chrono` builds what it needs and runs it.

mod cost;
mod gap;
mod mode;
mod reference;
mod table;
mod wall;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use cost::Cost;
use mode::Mode;
use reference::Run;
use table::{Ours, Row};
use vb_files::DocumentError;
use vb_score::TaskRecord;
use vb_sim::{SimError, SoilSet};
use vb_suite::import::{Ground, ImportError, Source};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{SuiteError, SuiteMeta, SuiteWriter, TaskId, Terrain, World};

/// Drives the tasks that Project Chrono was recorded on and puts both results side by side.
#[derive(Debug, Parser)]
struct Args {
    /// The harness' binary
    #[arg(long, value_name = "FILE")]
    harness: PathBuf,
    /// Folder of the planners: pid.wasm, pid-release.wasm
    #[arg(long, value_name = "DIR")]
    plugins: PathBuf,
    /// Our vehicle
    #[arg(long, value_name = "FILE")]
    vehicle: PathBuf,
    /// The recorded vehicle
    #[arg(long, value_name = "FILE")]
    recorded_vehicle: PathBuf,
    /// Soils of the original
    #[arg(long, value_name = "FILE")]
    soils: PathBuf,
    /// Folder of the recorded runs: wW_P.txt and .csv
    #[arg(long, value_name = "DIR", required_unless_present = "all")]
    recorded: Option<PathBuf>,
    /// Table of many runs, a line each: they are driven with the recorded vehicle alone, from one start
    #[arg(long, value_name = "FILE", conflicts_with = "recorded")]
    all: Option<PathBuf>,
    /// The original's BenchMaps folder, or one of its parents
    #[arg(long, value_name = "DIR")]
    original: PathBuf,
    /// Folder for suites, runs and the table, compare.md; must not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Debug, thiserror::Error)]
enum CompareError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: line {line}: {problem}", file.display())]
    Reference {
        file: PathBuf,
        /// The line, counted from 1.
        line: usize,
        problem: String,
    },
    /// The original's worlds can't be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The recorded vehicle can't be read.
    #[error(transparent)]
    Vehicle(#[from] DocumentError),
    /// Its soils can't be read.
    #[error(transparent)]
    Soils(#[from] SimError),
    /// The recorded vehicle can't be driven at a wall.
    #[error("{}: {source}", file.display())]
    Simulation { file: PathBuf, source: SimError },
    #[error(transparent)]
    Suite(#[from] SuiteError),
    #[error("{}: {source}: harness and comparison must be built from the same source", file.display())]
    Record { file: PathBuf, source: serde_json::Error },
}

impl CompareError {
    fn reference(file: &Path, line: usize, problem: impl Into<String>) -> Self {
        Self::Reference { file: file.into(), line, problem: problem.into() }
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    let runs = args.recorded.iter().chain(&args.all).map(|p| ("recorded runs", p));
    for (what, path) in runs.chain([("original worlds", &args.original)]) {
        if !path.exists() {
            eprintln!("skipped: no {what} at {}; nothing to compare with", path.display());
            return ExitCode::SUCCESS;
        }
    }
    match compare(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

/// Speed at which the recorded vehicles drove, m/s.
const SPEED: f64 = 4.0;

fn compare(args: &Args) -> Result<(), CompareError> {
    let source = Source::find(&args.original)?.ground(Ground::AsSimulated);
    let recorded = match (&args.recorded, &args.all) {
        (_, Some(file)) => reference::table(file)?,
        (Some(dir), None) => reference::runs(dir)?,
        (None, None) => Vec::new(),
    };
    let (runs, missing): (Vec<Run>, Vec<Run>) =
        recorded.into_iter().partition(|r| source.ids().any(|id| id == r.world));
    for run in missing {
        eprintln!("skipped: {}: the original's world {} is not there", run.task(), run.world);
    }
    // A table has enough runs that chance evens out.
    let (modes, moved): (&[Mode], &[_]) =
        if args.all.is_some() { (&[Mode::Physics], &[]) } else { (&Mode::ALL, &MOVED) };
    eprintln!("importing the worlds of {} recorded runs", runs.len());
    let mut worlds: BTreeMap<u32, World> = BTreeMap::new();
    for run in &runs {
        if let Entry::Vacant(place) = worlds.entry(run.world) {
            place.insert(source.world(run.world)?);
        }
    }
    let suite = args.out.join("suite");
    write_suite(&suite, source.meta(), &runs, &worlds, moved)?;
    let mut records: Vec<BTreeMap<TaskId, TaskRecord>> = Vec::new();
    let mut costs: BTreeMap<Terrain, Cost> = BTreeMap::new();
    for &mode in modes {
        eprintln!("driving: {}", mode.title());
        let mut of_mode = BTreeMap::new();
        let mut refused: BTreeMap<Terrain, String> = BTreeMap::new();
        for world in worlds.values() {
            if refused.contains_key(&world.terrain) {
                continue;
            }
            let chosen = if mode == Mode::Physics { &args.recorded_vehicle } else { &args.vehicle };
            let before = vb_testing::processor_time_of_children();
            let driven = drive(args, &suite, world, mode, chosen)?;
            if let (Mode::Shipped, Ok(list), Some(before), Some(after)) =
                (mode, &driven, before, vb_testing::processor_time_of_children())
            {
                let simulated = list.iter().map(|r| r.time_s).sum();
                costs.entry(world.terrain).or_default().add(Cost { processor: after - before, simulated });
            }
            match driven {
                Ok(list) => of_mode.extend(list.into_iter().map(|r| (r.task.clone(), r))),
                Err(message) => drop(refused.insert(world.terrain, message)),
            }
        }
        for (terrain, message) in refused {
            eprintln!("skipped: {} ground: {message}", terrain.name());
        }
        records.push(of_mode);
    }
    let rows: Vec<Row> = runs
        .into_iter()
        .map(|run| Row { ours: records.iter().map(|of_mode| ours(&run, of_mode)).collect(), run })
        .collect();
    let mut report = String::from("# Whole tasks: Project Chrono and here\n");
    if args.all.is_some() {
        report += &format!("\n{}\n{}", table::ends(&rows), table::tasks(&rows, modes));
        let beside = |name: &str| args.all.as_ref().map(|f| f.with_file_name(name)).filter(|d| d.is_dir());
        if let Some(dir) = beside("diverging") {
            report += &format!("\n## The gap under Chrono's wheels\n\n{}", gap::table(&gaps(&dir, &worlds)?));
        }
        if let Some(dir) = beside("self-agreement/win") {
            let model = VehicleModel::new(VehicleSpec::load(&args.recorded_vehicle)?)?;
            let walls = wall::walls(&dir, &worlds, &model, &SoilSet::load(&args.soils)?)?;
            report += &format!("\n## At walls\n\n{}", wall::table(&walls));
        }
        return write_report(&args.out, &report);
    }
    for mode in Mode::ALL {
        report += &format!("\n## {}\n\n{}", mode.title(), table::aggregate(&rows, mode));
    }
    report += &format!("\n## Tasks\n\n{}", table::tasks(&rows, modes));
    let runs: Vec<&Run> = rows.iter().map(|r| &r.run).collect();
    let lean = match &args.recorded {
        // Beside them, where it is at hand.
        Some(dir) if dir.join("../all-tasks.csv").exists() => {
            cost::without_fixed_pairs(&reference::table(&dir.join("../all-tasks.csv"))?)
        }
        _ => BTreeMap::new(),
    };
    report += &format!("\n## Processor time a simulated second\n\n{}", cost::table(&runs, &lean, &costs));
    write_report(&args.out, &report)
}

/// The wheels that carry in Chrono's records over rigid worlds, wWORLD_PAIR.csv.
fn gaps(dir: &Path, worlds: &BTreeMap<u32, World>) -> Result<Vec<gap::Sample>, CompareError> {
    let mut samples = Vec::new();
    for file in &reference::files(dir, "csv")? {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let id = name.strip_prefix('w').and_then(|n| n.split('_').next()).and_then(|n| n.parse().ok());
        if let Some(world) = id.and_then(|id: u32| worlds.get(&id)).filter(|w| w.terrain == Terrain::Rigid) {
            samples.extend(gap::samples(file, &reference::Series::read(file)?, &world.heightfield)?);
        }
    }
    Ok(samples)
}

fn write_report(out: &Path, report: &str) -> Result<(), CompareError> {
    let file = out.join("compare.md");
    std::fs::write(&file, report).map_err(|source| CompareError::Io { path: file.clone(), source })?;
    eprintln!("results: {}", file.display());
    Ok(())
}

/// Marks of the tasks whose start is moved, and by how much along x and y, m: all around it, by less than what the lines
/// of the two vehicles part in the first seconds.
const MOVED: [(&str, [f64; 2]); 8] = [
    ("_e", [0.1, 0.0]),
    ("_ne", [0.07, 0.07]),
    ("_n", [0.0, 0.1]),
    ("_nw", [-0.07, 0.07]),
    ("_w", [-0.1, 0.0]),
    ("_sw", [-0.07, -0.07]),
    ("_s", [0.0, -0.1]),
    ("_se", [0.07, -0.07]),
];

/// Writes the worlds with the recorded tasks alone, each as it is and with its start moved.
fn write_suite(
    dir: &Path,
    meta: SuiteMeta,
    runs: &[Run],
    worlds: &BTreeMap<u32, World>,
    starts: &[(&str, [f64; 2])],
) -> Result<(), CompareError> {
    let mut writer = SuiteWriter::create(dir, meta)?;
    for (id, world) in worlds {
        let mut world = world.clone();
        world.tasks.retain(|t| runs.iter().any(|r| r.world == *id && r.task_id() == t.id));
        for task in world.tasks.clone() {
            for (mark, [east, north]) in starts {
                let mut moved = task.clone();
                moved.id += *mark;
                moved.start.x += east;
                moved.start.y += north;
                moved.path[0][0] += east;
                moved.path[0][1] += north;
                world.tasks.push(moved);
            }
        }
        writer.add(&world)?;
    }
    writer.finish()?;
    Ok(())
}

/// Runs the harness over the tasks of a world; its records, or what it says if it refuses.
fn drive(
    args: &Args,
    suite: &Path,
    world: &World,
    mode: Mode,
    vehicle: &Path,
) -> Result<Result<Vec<TaskRecord>, String>, CompareError> {
    let out = args.out.join(mode.name()).join(&world.id);
    let plugin = args.plugins.join(format!("{}.wasm", mode.planner()));
    let mut command = Command::new(&args.harness);
    command.arg("--plugin").arg(&plugin).arg("--suite").arg(suite).arg("--out").arg(&out);
    command.arg("--vehicle").arg(vehicle).args(["--tasks", &world.id, "--rules", "release"]);
    command.arg("--soils").arg(&args.soils).args(["--param", &format!("speed={SPEED}")]);
    if mode.planner() == "pid-release" {
        command.args(["--param", &format!("obstacles={}", mode::obstacle_squares(world))]);
        // The recorded planner had a plan when it started.
        command.args(["--param", "first_plan=0"]);
    }
    let output =
        command.output().map_err(|source| CompareError::Io { path: args.harness.clone(), source })?;
    let file = out.join("tasks.jsonl");
    // With tasks whose simulation failed the harness ends with an error, too, but all have their records.
    if !file.is_file() {
        return Ok(Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
    }
    let text =
        std::fs::read_to_string(&file).map_err(|source| CompareError::Io { path: file.clone(), source })?;
    let records = text.lines().map(serde_json::from_str).collect::<Result<_, _>>();
    records.map(Ok).map_err(|source| CompareError::Record { file, source })
}

/// Our records of a recorded run's task, if there are any.
fn ours(run: &Run, records: &BTreeMap<TaskId, TaskRecord>) -> Option<Ours> {
    let nominal = records.get(run.task().as_str())?.clone();
    let moved =
        MOVED.iter().filter_map(|(mark, _)| records.get(format!("{}{mark}", run.task()).as_str()).cloned());
    Some(Ours { nominal, moved: moved.collect() })
}
