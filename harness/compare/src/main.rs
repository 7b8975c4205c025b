//! `vb-compare`: drives the tasks that Project Chrono was recorded on, with the original's planner, speed and rules,
//! and puts both results side by side. `cargo xtask compare-chrono` builds what it needs and runs it.

mod reference;
mod route;
mod table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use reference::Run;
use route::Route;
use table::Pair;
use vb_score::TaskRecord;
use vb_suite::import::{Ground, ImportError, Source};
use vb_world::{SuiteError, SuiteMeta, SuiteWriter, Terrain, World};

/// Drives the tasks that Project Chrono was recorded on and puts both results side by side.
#[derive(Debug, Parser)]
struct Args {
    /// The harness' binary
    #[arg(long, value_name = "FILE")]
    harness: PathBuf,
    /// The PID planner
    #[arg(long, value_name = "FILE")]
    plugin: PathBuf,
    /// Folder of the recorded runs: wW_P.txt and .csv
    #[arg(long, value_name = "DIR")]
    recorded: PathBuf,
    /// The original's BenchMaps folder, or one of its parents
    #[arg(long, value_name = "DIR")]
    original: PathBuf,
    /// Folder for suites, runs and the table, compare.md; must not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
enum CompareError {
    /// A file or folder can't be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A recorded run is not as it must be.
    #[error("{}: line {line}: {problem}", file.display())]
    Reference {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The original's worlds can't be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The suite of the comparison can't be written.
    #[error(transparent)]
    Suite(#[from] SuiteError),
    /// What the harness wrote is not understood.
    #[error("{}: {source}: harness and comparison must be built from the same source", file.display())]
    Record {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
}

impl CompareError {
    fn reference(file: &Path, line: usize, problem: impl Into<String>) -> Self {
        Self::Reference { file: file.into(), line, problem: problem.into() }
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    for (what, dir) in [("recorded runs", &args.recorded), ("original worlds", &args.original)] {
        if !dir.is_dir() {
            eprintln!("skipped: no {what} at {}; nothing to compare with", dir.display());
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
    let (runs, missing): (Vec<Run>, Vec<Run>) =
        reference::runs(&args.recorded)?.into_iter().partition(|r| source.ids().any(|id| id == r.world));
    for run in missing {
        eprintln!("skipped: {}: the original's world {} is not there", run.task(), run.world);
    }
    eprintln!("importing the worlds of {} recorded runs", runs.len());
    let mut worlds: BTreeMap<u32, World> = BTreeMap::new();
    for run in &runs {
        if !worlds.contains_key(&run.world) {
            worlds.insert(run.world, source.world(run.world)?);
        }
    }
    let mut report = String::from("# Whole tasks: Project Chrono and here\n");
    for route in Route::ALL {
        let dir = args.out.join(route.name());
        let suite = dir.join("suite");
        write_suite(&suite, source.meta(), &runs, &worlds, route)?;
        let mut pairs: Vec<Pair> = Vec::new();
        for terrain in [Terrain::Rigid, Terrain::Mixed, Terrain::Deformable] {
            let recorded: Vec<&Run> = runs.iter().filter(|r| r.terrain == terrain).collect();
            if recorded.is_empty() {
                continue;
            }
            eprintln!("driving {} {} tasks on {} paths", recorded.len(), terrain.name(), route.name());
            let out = dir.join(terrain.name());
            match drive(args, &suite, terrain, route, &out)? {
                Ok(records) => pairs.extend(join(&recorded, &records)),
                Err(message) => eprintln!("skipped: {} ground: {message}", terrain.name()),
            }
        }
        report +=
            &format!("\n## {} paths\n\n{}\n{}", route.name(), table::aggregate(&pairs), table::tasks(&pairs));
    }
    let file = args.out.join("compare.md");
    std::fs::write(&file, &report).map_err(|source| CompareError::Io { path: file.clone(), source })?;
    eprintln!("results: {}", file.display());
    Ok(())
}

/// Writes the worlds with the recorded tasks alone, and the paths to be driven.
fn write_suite(
    dir: &Path,
    meta: SuiteMeta,
    runs: &[Run],
    worlds: &BTreeMap<u32, World>,
    route: Route,
) -> Result<(), CompareError> {
    let mut writer = SuiteWriter::create(dir, meta)?;
    for (id, world) in worlds {
        let mut world = world.clone();
        let half = [world.heightfield.half_x(), world.heightfield.half_y()];
        let mut tasks = Vec::new();
        for mut task in std::mem::take(&mut world.tasks) {
            let Some(run) = runs.iter().find(|r| r.world == *id && r.task_id() == task.id) else { continue };
            if route == Route::Driven {
                task.path = route::driven(&task, &run.trajectory()?, half);
            }
            tasks.push(task);
        }
        world.tasks = tasks;
        writer.add(&world)?;
    }
    writer.finish()?;
    Ok(())
}

/// Runs the harness over the tasks of a ground; its records, or what it says if it refuses.
fn drive(
    args: &Args,
    suite: &Path,
    terrain: Terrain,
    route: Route,
    out: &Path,
) -> Result<Result<Vec<TaskRecord>, String>, CompareError> {
    let mut command = Command::new(&args.harness);
    command.arg("--plugin").arg(&args.plugin).arg("--suite").arg(suite).arg("--out").arg(out);
    command.args(["--tasks", &format!("terrain={}", terrain.name()), "--rules", "release"]);
    command.args(["--param", &format!("speed={SPEED}")]);
    command.args(["--param", &format!("lookahead={}", route.look_ahead())]);
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

/// Each recorded run with our record of its task, if there is one.
fn join(runs: &[&Run], records: &[TaskRecord]) -> Vec<Pair> {
    let record = |run: &Run| records.iter().find(|r| r.task == run.task()).cloned();
    runs.iter().filter_map(|&run| Some((run.clone(), record(run)?))).collect()
}
