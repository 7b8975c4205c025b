//! `vb-harness vehicle`.

mod bag;
mod compare;
#[cfg_attr(not(feature = "terrain"), path = "without_course.rs")]
mod course;
mod picture;
mod standing;
mod table;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use serde::Serialize;
use vb_sim::SoilSet;
use vb_validate::{Characteristics, Check, Counts, EventResult, References, RunOptions, Verdict};
use vb_vehicle::VehicleSpec;

use crate::args::exit_codes::codes;
use crate::args::values::{duration, key_value, scale};
use crate::args::{ForceArgs, FormatArgs, JobsArgs, MessageFormat, TIME_STEP};
use crate::error::{CHECKS_FAILED, CliError};
use crate::{output, places};
use bag::VehicleBagArgs;
use compare::VehicleCompareArgs;
use standing::Standing;
use table::Specification;

commands! {
    VehicleCommand

    /// Show a vehicle's data, and draw it
    Show(VehicleShowArgs) => show,
    /// Validate all values of a vehicle file
    Validate(VehicleArgs) => validate,
    /// Drive a vehicle through standard events, and compare it with theory, published figures and Project Chrono
    #[command(
        after_help = codes(&[CHECKS_FAILED]),
        mut_arg("jobs", |arg| arg.help("Number of events that are driven in parallel; default: number of cores"))
    )]
    Test(VehicleTestArgs) => test,
    /// Replay recorded wheel speeds of a skid-steered vehicle, and compare its motion with the recording
    Compare(VehicleCompareArgs) => compare::compare,
    /// Convert a bag of ROS 2 (odometry, wheel speeds or velocity commands) into a recording for vehicle compare
    Bag(VehicleBagArgs) => bag::convert,
    /// Convert a vehicle of another program (JSON set of Project Chrono, URDF, xacro) into a vehicle file
    Import(VehicleImportArgs) => import,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleImportArgs {
    /// File of the vehicle: Chrono's JSON with "Type": "Vehicle", URDF or xacro
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Vehicle file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Name of the vehicle; default: the name in FILE
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Scale of the worlds that the vehicle is made for; default: chosen from its length
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Directory to which paths in FILE are relative; default: searched above FILE
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Chrono: file of the engine; default: the one that the vehicle names, else chosen from the set
    #[arg(long, value_name = "FILE")]
    pub(crate) engine: Option<PathBuf>,
    /// Chrono: file of the transmission; default: chosen from the set
    #[arg(long, value_name = "FILE")]
    pub(crate) transmission: Option<PathBuf>,
    /// Chrono: file of the tyre; once for all axles, or once per axle in the order of the file; default: chosen from the set
    #[arg(long = "tyre", value_name = "FILE")]
    pub(crate) tyres: Vec<PathBuf>,
    /// xacro: value of an argument; may be repeated
    #[arg(long = "arg", value_name = "NAME=VALUE", value_parser = key_value)]
    pub(crate) arguments: Vec<(String, String)>,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleShowArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// File for a drawing of side and top view (SVG)
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("what").required(true)))]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE", group = "what")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Tyre to fit, by its name in the vehicle file, e.g. rigid; drives in a reference's set-up don't depend on it
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// OpenCRG file that the events ride-course and half-round drive instead of their courses; without --event, only these run
    #[arg(long, value_name = "FILE")]
    pub(crate) course: Option<PathBuf>,
    /// List the events and exit
    #[arg(long, group = "what")]
    pub(crate) list: bool,
    /// Reference figures in addition to theory; default: tasks/validation/VEHICLE.yaml, if it exists
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Simulation step, s or with a unit (0.01ms to 10ms)
    #[arg(long, value_name = "TIME", default_value_t = TIME_STEP, value_parser = duration)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

pub(crate) fn validate(args: &VehicleArgs) -> Result<(), CliError> {
    let (path, spec) = places::vehicle(&args.vehicle)?;
    let warnings = characteristics(&spec)?.warnings();
    for warning in &warnings {
        output::say(&format!("warning: {}: {warning}", path.display()));
    }
    let verdict = match warnings.len() {
        0 => "all valid".to_owned(),
        1 => "valid, 1 warning".to_owned(),
        n => format!("valid, {n} warnings"),
    };
    output::text(&format!(
        "{}: {}, {} axles, {:.0} kg, {verdict}\n",
        path.display(),
        spec.name,
        spec.axles.len(),
        spec.total_mass()
    ));
    Ok(())
}

/// Characteristics of a vehicle, computed from its file.
fn characteristics(spec: &VehicleSpec) -> Result<Characteristics, CliError> {
    let bench = vb_validate::Bench::new(spec, &[], vb_sim::SimOptions::default().step);
    Ok(bench.map_err(CliError::input)?.characteristics())
}

pub(crate) fn show(args: &VehicleShowArgs) -> Result<(), CliError> {
    let (path, spec) = places::vehicle(&args.vehicle)?;
    let characteristics = characteristics(&spec)?;
    let standing = Standing::new(spec).map_err(CliError::input)?;
    if let Some(file) = &args.svg {
        output::write(file, picture::draw(&standing))?;
    }
    let table = Specification::new(&standing, characteristics);
    if args.format.is_json() {
        output::json(&ShowMessage { event: "vehicle", file: &path, specification: &table });
    } else {
        output::text(&table.text());
    }
    Ok(())
}

/// Converts a vehicle of another program; what it approximates, assumes and leaves out goes to the standard error and into the file.
fn import(args: &VehicleImportArgs) -> Result<(), CliError> {
    output::must_not_replace(&args.out, args.force)?;
    let options = vb_import::Options {
        name: args.name.clone(),
        scale: args.scale,
        data: args.data.clone(),
        engine: args.engine.clone(),
        transmission: args.transmission.clone(),
        tyres: args.tyres.clone(),
        arguments: args.arguments.clone(),
    };
    let imported = vb_import::import(&args.file, &options).map_err(CliError::input)?;
    for note in imported.notes.iter() {
        output::say(&note.to_string());
    }
    output::write(&args.out, imported.file())?;
    let spec = &imported.spec;
    output::text(&format!(
        "{}: {}, {} axles, {:.0} kg, scale {:.4}; {} notes above and in the file; next: vb-harness vehicle validate, show and test\n",
        args.out.display(),
        spec.name,
        spec.axles.len(),
        spec.total_mass(),
        spec.scale,
        imported.notes.iter().count()
    ));
    Ok(())
}

#[derive(Serialize)]
struct ShowMessage<'a> {
    event: &'static str,
    file: &'a Path,
    #[serde(flatten)]
    specification: &'a Specification,
}

#[derive(Serialize)]
struct EventMessage<'a> {
    event: &'static str,
    name: &'a str,
    passed: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<String>,
    checks: &'a [Check],
}

#[derive(Serialize)]
struct SummaryMessage<'a> {
    event: &'static str,
    vehicle: &'a str,
    passed: bool,
    checks: Counts,
    report: &'a Path,
}

pub(crate) fn test(args: &VehicleTestArgs) -> Result<(), CliError> {
    if args.list {
        let rows: Vec<_> =
            vb_validate::events().iter().map(|e| vec![e.name.to_owned(), e.title.to_owned()]).collect();
        output::text(&output::columns(&rows));
        return Ok(());
    }
    let Some(wanted) = &args.vehicle else {
        return Err(CliError::usage("no vehicle given (see vb-harness vehicle test --help)"));
    };
    let (_, mut spec) = places::vehicle(wanted)?;
    let references = match args.references.clone().or_else(|| places::catalog().references(&spec.name)) {
        Some(path) => References::load(&path, &spec).map_err(CliError::input)?,
        None => References::default(),
    };
    if let Some(tyre) = &args.tyre {
        spec = spec.with_tyre(tyre).map_err(CliError::usage)?;
    }
    let mut soils = Vec::new();
    for name in places::catalog().names(vb_catalog::Data::Soils)? {
        let path = places::catalog().data(vb_catalog::Data::Soils, &name)?;
        soils.push(SoilSet::load(&path).map_err(CliError::input)?);
    }
    let course = args.course.as_deref().map(course::read).transpose()?;
    let options =
        RunOptions { events: args.events.clone(), step: args.time_step, jobs: args.jobs.get(), course };
    let out = args.out.clone().unwrap_or_else(|| places::new_run_dir(&format!("test-{}", spec.name)));
    output::must_not_replace(&out.join("report.html"), args.force)?;
    // What can't be written is said before a minute of driving, not after.
    std::fs::create_dir_all(&out).map_err(|e| CliError::output(format!("{}: {e}", out.display())))?;
    let told = |r: &EventResult| {
        if args.format.get() == MessageFormat::Human {
            output::note(&format!("{} {}", if r.passed() { "pass" } else { "FAIL" }, r.event.name));
        }
    };
    let report = vb_validate::run(&spec, &soils, &references, &options, told)?;
    report.write(&out).map_err(CliError::output)?;
    let page = out.join("report.html");
    let counts = report.counts(None);
    match args.format.get() {
        MessageFormat::Json => {
            for r in &report.results {
                let broken: Vec<String> = r.broken().collect();
                output::json(&EventMessage {
                    event: "vehicle_event",
                    name: r.event.name,
                    passed: r.passed(),
                    failure: (!broken.is_empty()).then(|| broken.join("; ")),
                    checks: &r.checks,
                });
            }
            output::json(&SummaryMessage {
                event: "summary",
                vehicle: &spec.name,
                passed: report.passed(),
                checks: counts,
                report: &page,
            });
        }
        MessageFormat::Human => output::text(&table(&report.results)),
    }
    if args.format.get() == MessageFormat::Human {
        output::say(&format!("{} checks pass, {} fail; {}", counts.passed, counts.failed, page.display()));
    }
    if report.passed() {
        return Ok(());
    }
    let broken = report.results.iter().filter(|r| r.broken().next().is_some()).count();
    let also = if broken > 0 { format!(", and {broken} events failed") } else { String::new() };
    Err(CliError::checks_failed(format!(
        "{}: {} of {} checks failed{also}; see {}",
        spec.name,
        counts.failed,
        counts.passed + counts.failed,
        page.display()
    )))
}

/// Every check on a line, and why an event broke off.
fn table(results: &[EventResult]) -> String {
    let head = ["", "event", "figure", "measured", "expected", "unit", "against"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for r in results {
        for failure in r.broken() {
            rows.push(vec!["FAIL".to_owned(), r.event.name.to_owned(), failure]);
        }
        for c in &r.checks {
            let verdict = match c.verdict {
                Verdict::Pass => "pass",
                Verdict::Fail => "FAIL",
                Verdict::Shown => "-",
            };
            rows.push(vec![
                verdict.to_owned(),
                r.event.name.to_owned(),
                c.expectation.figure.clone(),
                c.measured.map_or_else(|| "not reached".to_owned(), vb_page::rounded),
                vb_validate::expected(c.expectation.expected),
                c.unit.clone(),
                c.against(),
            ]);
        }
    }
    output::columns(&rows)
}
