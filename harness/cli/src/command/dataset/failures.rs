//! `vb-harness dataset failures`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use vb_dataset::{
    DATASET_SCHEMA, Dataset, DatasetError, DatasetWriter, Format, Header, Kind, LICENCE, Layout, Making,
    PlannerHeader, keep_apart,
};
use vb_host::Limits;
use vb_record::{NewFolder, RunHeader, RunReader};
use vb_score::{Outcome, Rules, TaskRecord};
use vb_trial::Setting;
use vb_world::Suite;

use super::{Told, Total, finish, named, scene};
use crate::args::values::duration;
use crate::args::{FormatArgs, JobsArgs};
use crate::command::run;
use crate::error::CliError;
use crate::places;

#[derive(Debug, Args)]
pub(crate) struct FailuresArgs {
    /// Dataset directory or run directory
    #[arg(value_name = "DATASET|RUN")]
    pub(crate) of: PathBuf,
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Duration before each failure at scale 1, s or with a unit; proportional to the square root of the world's scale
    #[arg(long, value_name = "TIME", default_value_t = vb_dataset::SECONDS, value_parser = duration)]
    pub(crate) duration: f64,
    /// Dataset name; default: failures-of-NAME, with the name of the dataset or of the run's planner
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// For a run: accept a run on a shipped suite; such a dataset is marked as not for training
    #[arg(long)]
    pub(crate) of_a_suite: bool,
    /// For a run: rows and columns of the map crops around the vehicle in each frame; 0 for no crops
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=128))]
    pub(crate) crops: u16,
    #[command(flatten)]
    pub(crate) data: FailuresData,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Where the data of a run lie now whose failures are driven again, if not where they lay.
#[derive(Debug, Args)]
pub(crate) struct FailuresData {
    /// For a run: suite; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// For a run: vehicle, a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// For a run: soil set, a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}

/// Frames a second of the failures of a run.
const HZ: u32 = 10;

pub(super) fn failures(args: &FailuresArgs) -> Result<(), CliError> {
    if args.of.join("dataset.json").is_file() { of_dataset(args) } else { of_run(args) }
}

fn of_dataset(args: &FailuresArgs) -> Result<(), CliError> {
    let dataset = Dataset::open_whole(&args.of)?;
    dataset.must_not_hold(&args.out)?;
    let before = dataset.header();
    let of = json!({"name": before.name, "hash": dataset.hash()?});
    let header = Header {
        name: args.name.clone().unwrap_or_else(|| format!("failures-of-{}", before.name)),
        kind: Kind::Failures,
        command: scene::command(),
        options: [("of".to_owned(), of), ("seconds".to_owned(), json!(args.duration))].into(),
        ..before.clone()
    };
    let worlds = dataset.worlds()?;
    let frames = (args.duration * f64::from(before.hz)).ceil() as usize;
    let mut writer = begin(args, header, &worlds, frames)?;
    if vb_dataset::failures(&dataset, &mut writer, args.duration)? == 0 {
        return Err(CliError::input(format!("{}: it contains no failed episode", args.of.display())));
    }
    finish(writer, true, &args.out, args.format.get())
}

fn of_run(args: &FailuresArgs) -> Result<(), CliError> {
    let reader = RunReader::open(&args.of)?;
    let mut records: Vec<TaskRecord> = reader.records()?;
    records.retain(|r| [Outcome::Rollover, Outcome::Stuck].contains(&r.outcome));
    // Runs write their records as the tasks end.
    records.sort_by(|a, b| a.task.cmp(&b.task));
    if records.is_empty() {
        return Err(CliError::input(format!(
            "{}: it contains no task with a rollover or a stuck vehicle",
            args.of.display()
        )));
    }
    let header = reader.header();
    let suite = places::suite_of(header, args.data.suite.as_deref())?;
    let of_a_suite = match suite_world(&suite)? {
        None => false,
        Some(_) if args.of_a_suite => true,
        Some(e) => {
            return Err(CliError::usage(format!(
                "{e}; or give --of-a-suite if the failures are for inspection only"
            )));
        }
    };
    let setting = setting(args, header)?;
    let layout = Layout {
        wheels: setting.vehicle.wheels as usize,
        speed: false,
        goal: true,
        truth: !setting.perception.tells_the_truth(),
        crops: usize::from(args.crops),
    };
    let planner = PlannerHeader {
        name: header.plugin.name.clone(),
        version: header.plugin.version.clone(),
        sha256: header.plugin.sha256.clone(),
        params: header.params.clone().into_iter().collect::<BTreeMap<_, _>>(),
    };
    let own = Header {
        schema: DATASET_SCHEMA,
        format: Format::default(),
        name: args.name.clone().unwrap_or_else(|| format!("failures-of-{}", header.plugin.name)),
        kind: Kind::Failures,
        licence: LICENCE.to_owned(),
        harness_version: env!("CARGO_PKG_VERSION").to_owned(),
        harness_commit: env!("VB_COMMIT").to_owned(),
        command: scene::command(),
        seed: header.seed,
        hz: HZ,
        layout,
        vehicle: header.vehicle.clone(),
        soils: header.soils.clone(),
        rules: named(&header.rules.name, &header.rules.hash),
        perception: header.perception.clone(),
        scale: header.scale,
        time_step: header.time_step,
        worlds: named(&suite.meta().name, &suite.hash()),
        exploration: None,
        planners: vec![planner],
        of_a_suite,
        options: [("seconds".to_owned(), json!(args.duration))].into(),
    };
    let frames = (args.duration * f64::from(HZ)).ceil() as usize;
    let mut writer = begin(args, own, &suite, frames)?;
    let cancel = run::stop_on_ctrl_c()?;
    let jobs = args.jobs.get();
    let stack_bytes = Limits::default().thread_stack_bytes();
    let making = Making { setting: &setting, worlds: &suite, hz: HZ, jobs, stack_bytes, cancel: &cancel };
    let mut told = Told::new(args.format.get(), Total::Drives(records.len()), HZ);
    let done =
        making.failures_again(&mut writer, &reader, &records, args.duration, &mut |p| told.progress(p))?;
    if !done {
        return Err(CliError::interrupted("stopped without output (the same command starts again)"));
    }
    finish(writer, true, &args.out, args.format.get())
}

/// Begins the dataset, which is there only when it is whole: failures are cut out in one go.
fn begin(
    args: &FailuresArgs,
    header: Header,
    worlds: &Suite,
    frames: usize,
) -> Result<DatasetWriter, CliError> {
    let folder = NewFolder::new(&args.out).map_err(CliError::output)?;
    Ok(DatasetWriter::create_whole(folder, header, worlds, frames)?)
}

/// The error that names a world of the suite that a suite of the harness has, too; `None` if there is no such world.
fn suite_world(suite: &Suite) -> Result<Option<DatasetError>, CliError> {
    let mut others = Vec::new();
    for dir in places::catalog().suites()? {
        others.push(Suite::open(dir)?);
    }
    match keep_apart(suite, &others) {
        Ok(()) => Ok(None),
        Err(e @ DatasetError::SuiteWorld { .. }) => Ok(Some(e)),
        Err(e) => Err(e.into()),
    }
}

/// What a run's trials have in common, with the data at hand if they are those of the run.
fn setting(args: &FailuresArgs, header: &RunHeader) -> Result<Setting, CliError> {
    let vehicle = places::catalog().vehicle(args.data.vehicle.as_deref().unwrap_or(&header.vehicle.name))?;
    let soils = places::catalog()
        .soils(args.data.soils.as_deref().unwrap_or(&header.soils.name), header.soil_resolution)?;
    let perception = places::catalog().perception(&header.perception.name)?;
    let at_hand = [
        ("vehicle", &header.vehicle.name, &header.vehicle.hash, &vehicle.hash),
        ("soils", &header.soils.name, &header.soils.hash, &soils.hash),
        (
            "perception profile",
            &header.perception.name,
            &header.perception.hash,
            &perception.sha256().to_owned(),
        ),
    ];
    if let Some((what, name, ..)) = at_hand.iter().find(|(_, _, own, now)| own != now) {
        return Err(CliError::input(format!(
            "the available {what} {name} differs from that of the run (give the run's file with --vehicle or --soils, or re-run)"
        )));
    }
    let rules =
        Rules::recorded(header).map_err(|e| CliError::input(format!("{}: rules: {e}", args.of.display())))?;
    Setting::new(&vehicle, &soils, &rules, &perception, header.time_step, header.scale, header.seed)
        .map_err(CliError::from)
}
