//! `vb-harness suite` and `vb-harness tasks`.

mod calibrate;
mod prove;
mod show;
#[cfg(feature = "terrain")]
mod site;
mod testbed;
mod validate;

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use serde::Serialize;
use vb_catalog::CatalogError;
use vb_files::Document;
use vb_record::NewFolder;
use vb_suite::generate::{Generator, GeneratorParams, TRAINING_SEEDS};
use vb_suite::granular::{GranularParams, GranularSuite};
use vb_world::{Density, Elevation, Suite, SuiteMeta, SuiteWriter, TaskId, Terrain, World, WorldInfo};

use crate::args::exit_codes::resumed;
use crate::args::{FormatArgs, MessageFormat};
use crate::error::{CliError, HOST_ERRORS, INTERRUPTED};
use crate::{output, places};
use calibrate::CalibrationArgs;
use prove::ProveArgs;
use show::ShowArgs;
use testbed::TestbedArgs;
use validate::ValidateArgs;

commands! {
    SuiteCommand

    /// Show the figures of a suite; with --out, write an HTML report with a map of every world
    Show(ShowArgs) => show::show,
    /// Validate a suite: files, hashes, starts, goals, paths, obstacles, labels
    Validate(ValidateArgs) => validate::validate,
    /// Record the tasks that runs have solved, as a solvability certificate
    Prove(ProveArgs) => prove::prove,
    /// Import the worlds of the original benchmark (its BenchMaps folder)
    Import(site::ImportArgs) if feature = "terrain" => site::import,
    /// Generate a suite from a seed
    #[command(after_help = resumed(&[HOST_ERRORS, INTERRUPTED]))]
    Generate(GenerateArgs) => generate,
    /// Make a suite of a real place from an elevation raster
    Site(site::SiteArgs) if feature = "terrain" => site::make,
    /// Make a suite like the paper's physical testbed: beds of a few materials, each with several trials of one task
    Testbed(TestbedArgs) => testbed::testbed,
}

commands! {
    TasksCommand

    /// List all or selected tasks of a suite
    List(TasksArgs) => tasks,
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

/// The file that makes a folder a suite.
const INDEX: &str = "suite.yaml";

/// A suite to be read.
pub(crate) fn open(wanted: &Path) -> Result<Suite, CliError> {
    let found = places::catalog().suite(Some(wanted))?;
    if is_another(wanted, &found) {
        output::note(&format!(
            "note: {here} is the built-in suite; use ./{here} for the folder {here}",
            here = wanted.display()
        ));
    }
    Ok(Suite::open(found)?)
}

/// Whether what is named lies in the working directory, too, and is not the suite that was found.
fn is_another(wanted: &Path, found: &Path) -> bool {
    let same = wanted.canonicalize().ok() == found.canonicalize().ok();
    vb_catalog::is_name(wanted.as_os_str()) && wanted.join(INDEX).is_file() && !same
}

/// The tasks that a selector chooses, in the suite's order; without one, all.
pub(crate) fn select(suite: &Suite, selector: Option<&str>) -> Result<Vec<TaskId>, CliError> {
    let chosen = vb_catalog::select(suite, selector).map_err(CliError::usage)?;
    if selector.is_some() {
        tell_choice(chosen.len(), suite);
    }
    Ok(chosen)
}

/// Says how many tasks of a suite a selector chooses: once, however often a command looks tasks up.
pub(crate) fn tell_choice(chosen: usize, suite: &Suite) {
    static TOLD: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let note = format!("{chosen} of {} tasks selected", suite.task_count());
    if TOLD.lock().is_ok_and(|mut told| told.insert(note.clone())) {
        output::note(&note);
    }
}

/// Looks whether a suite can be written into a folder, before the work for it is done.
fn must_be_free(out: &Path) -> Result<(), CliError> {
    NewFolder::new(out).map(drop).map_err(CliError::output)
}

/// Writes worlds as a suite, one by one as they come, and says so.
pub(crate) fn write(
    out: &Path,
    meta: SuiteMeta,
    worlds: impl IntoIterator<Item = Result<World, CliError>>,
) -> Result<(), CliError> {
    make(out, |dir| {
        let mut writer = SuiteWriter::create(dir, meta)?;
        for world in worlds {
            writer.add(&world?)?;
        }
        Ok(writer.finish()?)
    })
}

/// Makes a suite in a folder of which nobody else makes one, where it is as a whole or not at all, and says so.
fn make(out: &Path, write: impl FnOnce(&Path) -> Result<Suite, CliError>) -> Result<(), CliError> {
    let folder = NewFolder::new(out).map_err(CliError::output)?;
    write(&folder.dir())?;
    folder.finish(INDEX).map_err(CliError::output)?;
    done(&Suite::open(out)?);
    Ok(())
}

/// Says what was written, and what to do with it.
fn done(suite: &Suite) {
    output::text(&format!(
        "{}: {} worlds, {} tasks; hash {}\n",
        suite.dir().display(),
        suite.worlds().len(),
        suite.task_count(),
        suite.hash()
    ));
    // A bare name would be that of a suite that comes with the harness, if there is one of this name.
    let dir = suite.dir();
    let path = if vb_catalog::is_name(dir.as_os_str()) { Path::new(".").join(dir) } else { dir.to_owned() };
    output::note(&format!("run it with: vb-harness run PLANNER --suite {}", path.display()));
}

/// Rules in a file, or the built-in ones.
pub(crate) fn rules<T: Default + Document>(file: Option<&Path>) -> Result<T, CliError> {
    file.map_or_else(|| Ok(T::default()), T::load).map_err(CliError::input)
}

pub(crate) fn generate(args: &GenerateArgs) -> Result<(), CliError> {
    if let Some(vehicle) = &args.calibrate {
        return calibrate::calibrate(args, vehicle);
    }
    if args.granular {
        return granular(args);
    }
    let params = rules::<GeneratorParams>(args.params.as_deref())?;
    let model = places::catalog().model(&params.elevation.model, args.params.as_deref())?;
    let (drawn, worlds) = (&args.drawn, args.worlds() as usize);
    keep_apart(drawn.seed, args.training)?;
    let generator = Generator { rules: &params, model: &model, seed: drawn.seed, worlds };
    let meta = generator.meta(&name(drawn), &drawn.suite_version);
    let told = |index, world: &WorldInfo| output::note(&format!("[{}/{worlds}] {}", index + 1, world.id));
    make(&drawn.out, |dir| Ok(generator.write(dir, meta, told)?))
}

fn granular(args: &GenerateArgs) -> Result<(), CliError> {
    let drawn = &args.drawn;
    must_be_free(&drawn.out)?;
    keep_apart(drawn.seed, args.training)?;
    let params = rules::<GranularParams>(args.params.as_deref())?;
    let suite = GranularSuite::new(&params, args.params.as_deref(), drawn.seed).map_err(CliError::input)?;
    let worlds = suite.worlds()?;
    write(&drawn.out, suite.meta(&name(drawn), &drawn.suite_version), worlds.into_iter().map(Ok))
}

/// Refuses a seed of training worlds for a suite that judges planners, and the other way round.
fn keep_apart(seed: u64, training: bool) -> Result<(), CatalogError> {
    match (TRAINING_SEEDS.contains(&seed), training) {
        (true, false) => Err(CatalogError::KeptForTraining(seed)),
        (false, true) => Err(CatalogError::NoTrainingSeed(seed)),
        _ => Ok(()),
    }
}

/// The suite of training worlds with this seed and number: where it was made before, or made now.
#[cfg(feature = "dataset")]
pub(crate) fn training(seed: u64, worlds: u32) -> Result<Suite, CliError> {
    let making = &mut || output::note(&format!("generating {worlds} training worlds of seed {seed}"));
    places::catalog().training(seed, worlds, making).map_err(|e| match e {
        // The option is another one than that of `suite generate`.
        CatalogError::NoTrainingSeed(_) => CliError::usage(format!("--world-{e}")),
        e => e.into(),
    })
}

/// What a suite is called: as is said, or by the directory that it goes to.
fn name(drawn: &DrawnArgs) -> String {
    let folder = || drawn.out.file_name().map_or_else(|| "generated".into(), OsStr::to_string_lossy);
    drawn.name.clone().unwrap_or_else(|| folder().into_owned())
}

#[derive(Serialize)]
struct TaskMessage<'a> {
    event: &'static str,
    task: &'a TaskId,
    elevation: Elevation,
    terrain: Terrain,
    density: Density,
}

pub(crate) fn tasks(args: &TasksArgs) -> Result<(), CliError> {
    let suite = open(&args.suite)?;
    let mut rows = Vec::new();
    for task in select(&suite, args.tasks.as_deref())? {
        let world = suite.world_info(task.world())?;
        match args.format.get() {
            MessageFormat::Json => output::json(&TaskMessage {
                event: "task",
                task: &task,
                elevation: world.elevation,
                terrain: world.terrain,
                density: world.density,
            }),
            MessageFormat::Human => {
                let levels = [world.elevation.name(), world.terrain.name(), world.density.name()];
                rows.push(std::iter::once(task.to_string()).chain(levels.map(str::to_owned)).collect());
            }
        }
    }
    output::text(&output::columns(&rows));
    Ok(())
}
