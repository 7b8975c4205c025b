//! `vb-harness vehicle`.

mod bag;
mod compare;
#[cfg_attr(not(feature = "terrain"), path = "without_course.rs")]
mod course;
mod picture;
mod standing;
mod table;

use std::path::Path;

use serde::Serialize;
use vb_sim::SoilSet;
use vb_validate::{Characteristics, Check, Counts, EventResult, References, RunOptions, Verdict};
use vb_vehicle::VehicleSpec;

use crate::args::{
    MessageFormat, VehicleArgs, VehicleCommand, VehicleImportArgs, VehicleShowArgs, VehicleTestArgs,
};
use crate::error::CliError;
use crate::{output, places};
use standing::Standing;
use table::Specification;

impl VehicleCommand {
    /// Does what it says.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        match self {
            Self::Show(args) => show(args),
            Self::Validate(args) => validate(args),
            Self::Test(args) => test(args),
            Self::Compare(args) => compare::compare(args),
            Self::Bag(args) => bag::convert(args),
            Self::Import(args) => import(args),
        }
    }
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
