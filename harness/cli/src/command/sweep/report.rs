//! `vb-harness sweep report`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vb_record::RunReader;
use vb_report::SweepRow;
use vb_runner::shards_in;
use vb_runner::sweep::PlannedRun;
use vb_score::{Rules, Summary, TaskRecord};

use super::{Sweep, SweepArgs};
use crate::args::ForceArgs;
use crate::command::report as pages;
use crate::command::report::ReportArgs;
use crate::error::CliError;
use crate::output;

/// The most runs that are compared in a page of their own: more can't be told apart in its figures.
const COMPARED: usize = 12;

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    SweepReport { runs: usize, missing: &'a [&'a str], files: &'a [PathBuf] },
}

pub(crate) fn report(args: &SweepArgs) -> Result<(), CliError> {
    let sweep = Sweep::open(args)?;
    let (mut rows, mut missing) = (Vec::new(), Vec::new());
    let mut groups: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for planned in sweep.spec.runs() {
        let Some(dir) = whole(&sweep, planned)? else {
            missing.push(planned.name.as_str());
            continue;
        };
        let row = row(planned, &dir)?;
        groups.entry(row.setting()).or_default().push(dir);
        rows.push(row);
    }
    let out = sweep.layout.root().join("report");
    std::fs::create_dir_all(&out).map_err(|e| CliError::output(format!("{}: {e}", out.display())))?;
    let mut files = Vec::new();
    let mut compared = Vec::new();
    for (setting, runs) in groups.iter().filter(|(_, runs)| (2..=COMPARED).contains(&runs.len())) {
        pages::make(&page_of(runs, &out.join(setting)))?;
        files.push(out.join(setting).join("index.html"));
        compared.push(setting.as_str());
    }
    let told = vb_report::Sweep::new(&sweep.spec.name, rows).map_err(CliError::input)?;
    let texts = [
        ("runs.csv", told.csv().map_err(CliError::internal)?),
        ("sweep.md", told.markdown()),
        ("index.html", told.page(&compared)),
    ];
    for (file, text) in texts {
        let path = out.join(file);
        vb_files::write(&path, text.as_bytes())
            .map_err(|e| CliError::output(format!("cannot write {}: {e}", path.display())))?;
        files.push(path);
    }
    if args.format.is_json() {
        output::json(&Message::SweepReport { runs: told.rows().len(), missing: &missing, files: &files });
    } else {
        output::text(&vb_files::printable(&told.table(output::width())));
        told.headlines().iter().for_each(|line| output::say(line));
        files.iter().for_each(|file| output::say(&format!("wrote {}", file.display())));
    }
    match missing.first() {
        None => Ok(()),
        Some(first) => Err(CliError::incomplete(format!(
            "{} of {} runs are unfinished and omitted: {first}{} (see sweep status; sweep run --resume continues)",
            missing.len(),
            sweep.spec.runs().len(),
            if missing.len() > 1 { " and others" } else { "" }
        ))),
    }
}

/// The folder of a run that is done, after its shards were joined if need be.
fn whole(sweep: &Sweep, planned: &PlannedRun) -> Result<Option<PathBuf>, CliError> {
    let state = sweep.layout.state(&planned.name)?;
    if state.tasks() < sweep.tasks.len() as u64 {
        return Ok(None);
    }
    let dir = sweep.layout.run(&planned.name);
    if !state.is_whole {
        let shards = shards_in(&sweep.layout.shards(&planned.name))?;
        let merged = vb_runner::merge(&shards, &sweep.suite, &dir)?;
        if !merged.missing.is_empty() {
            // The same tasks more than once, and others not at all.
            return Ok(None);
        }
    }
    Ok(Some(dir))
}

fn row(planned: &PlannedRun, dir: &Path) -> Result<SweepRow, CliError> {
    let run = RunReader::open(dir)?;
    let records: Vec<TaskRecord> = run.records()?;
    let rules = Rules::recorded(run.header())
        .map_err(|e| CliError::input(format!("{}: rules.profile: {e}", dir.join("run.json").display())))?;
    Ok(SweepRow {
        run: planned.name.clone(),
        dir: dir.to_owned(),
        planner: planned.planner.clone(),
        vehicle: run.header().vehicle.name.clone(),
        perception: run.header().perception.name.clone(),
        seed: planned.seed,
        summary: Summary::new(run.header(), &rules, &records, Vec::new()),
    })
}

fn page_of(runs: &[PathBuf], out: &Path) -> ReportArgs {
    // The folder within that of the sweep is the program's own.
    let force = ForceArgs { force: true };
    ReportArgs { out: Some(out.to_owned()), force, ..ReportArgs::new(runs) }
}
