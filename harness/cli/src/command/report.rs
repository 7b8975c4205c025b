//! `vb-harness report`.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Parser;
use serde::Serialize;
use vb_figure::Figure;
use vb_report::{Beside, MapLinks, Paper, Report, Runs, write_csv, write_parquet};
use vb_world::{Suite, TaskId, World};

use crate::args::values::{figure_width, positive};
use crate::args::{ForceArgs, FormatArgs, MessageFormat, ReplayData};
use crate::command::{geojson, replay, suite};
use crate::error::CliError;
use crate::output;
use crate::places::suite_of;

// A parser of its own for ReportArgs::new.
#[derive(Debug, Parser)]
pub(crate) struct ReportArgs {
    /// Run directories of one suite; several runs are compared task by task
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Directory for the HTML report, index.html; default without another output: RUN/report for a single run, else report
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Write the results as Markdown tables; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) markdown: Option<PathBuf>,
    /// Write all tasks of all runs as CSV
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write all tasks of all runs as Parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) parquet: Option<PathBuf>,
    /// Write the trajectories of runs over a real place (suite site) as GeoJSON
    #[arg(long, value_name = "FILE")]
    pub(crate) geojson: Option<PathBuf>,
    /// Directory for paper figures (SVG, PDF, PNG) and tables (LaTeX)
    #[arg(long, value_name = "DIR")]
    pub(crate) figures: Option<PathBuf>,
    /// Title of the HTML report, and above each figure; default: no title above figures
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Name of a run in all outputs; RUN is its directory or the last part of it; may be repeated
    #[arg(long = "label", value_name = "RUN=TEXT")]
    pub(crate) labels: Vec<String>,
    /// Widths of figures, inches: of a column and of a page, or one number for both
    #[arg(long, value_name = "IN,IN", default_value = "3.5,7.16", value_parser = figure_width)]
    pub(crate) figure_width: [f64; 2],
    /// Text size in figures, points
    #[arg(long, value_name = "PT", default_value_t = 8.0, value_parser = positive)]
    pub(crate) figure_font: f64,
    /// Write replays of these tasks, linked from the HTML report, e.g. w001/t03 or elevation=high
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Write maps of the worlds of these tasks, with all trajectories and failures, e.g. w001 or elevation=high: as HTML with
    /// --out, as figures with --figures
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) maps: Option<String>,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

impl ReportArgs {
    /// A report of runs with the default of each option.
    pub(crate) fn new(runs: &[PathBuf]) -> Self {
        let words = ["report", "--"].map(OsString::from);
        Self::parse_from(words.into_iter().chain(runs.iter().map(OsString::from)))
    }
}

/// The report's file.
const PAGE: &str = "index.html";
/// Dots per inch of figures as PNG: what journals want of pictures.
#[cfg(feature = "print")]
const DPI: f64 = 300.0;

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Report {
        runs: Vec<&'a str>,
        files: &'a [PathBuf],
    },
    Statistics {
        #[serde(flatten)]
        statistics: serde_json::Value,
    },
}

pub(crate) fn report(args: &ReportArgs) -> Result<(), CliError> {
    let (report, files) = make(args)?;
    if args.format.get() == MessageFormat::Json {
        let labels = report.runs().runs.iter().map(|r| r.label.as_str()).collect();
        output::json(&Message::Statistics { statistics: report.statistics() });
        output::json(&Message::Report { runs: labels, files: &files });
        return Ok(());
    }
    if args.markdown.as_deref() == Some(Path::new("-")) {
        output::text(&report.markdown());
    } else if let Some(told) = report.headline() {
        output::say(&told);
    }
    for file in files {
        output::say(&format!("wrote {}", file.display()));
    }
    Ok(())
}

/// Where the page goes: into the folder that was named, or, if nothing else is asked for, into one in the run, or in the working directory
/// if there are several.
fn page_dir(args: &ReportArgs) -> Option<PathBuf> {
    let other = [&args.figures, &args.markdown, &args.csv, &args.parquet, &args.geojson]
        .into_iter()
        .any(Option::is_some);
    args.out.clone().or_else(|| match &args.runs[..] {
        _ if other => None,
        [run] => Some(run.join("report")),
        _ => Some(PathBuf::from("report")),
    })
}

/// Writes what is asked for, and returns it with the names of the files.
pub(crate) fn make(args: &ReportArgs) -> Result<(Report, Vec<PathBuf>), CliError> {
    let page_dir = page_dir(args);
    if args.figures.as_deref() == Some(Path::new("-")) {
        return Err(CliError::usage("--figures - : figures are several files (give a directory)"));
    }
    if args.replays.is_some() && page_dir.is_none() {
        return Err(CliError::usage("--replays: replays are linked from the HTML report (add --out DIR)"));
    }
    if args.maps.is_some() && page_dir.is_none() && args.figures.is_none() {
        return Err(CliError::usage(
            "--maps: maps are HTML files or figures (add --out DIR or --figures DIR)",
        ));
    }
    let figures_in = match &args.figures {
        Some(dir) => Some((dir, Paper::new(args.figure_width, args.figure_font).map_err(CliError::usage)?)),
        None => None,
    };
    let page = page_dir.as_ref().map(|dir| dir.join(PAGE));
    let markdown = args.markdown.iter().filter(|path| path.as_path() != Path::new("-"));
    let tables = args.csv.iter().chain(&args.parquet).chain(&args.geojson).chain(markdown);
    let all = tables.clone().chain(&page).map(PathBuf::as_path);
    output::must_spare(&all.collect::<Vec<_>>(), &args.runs)?;
    // The folder within a run is the program's own.
    let own = args.out.is_none() && args.runs.len() == 1;
    if let Some(page) = page.as_ref().filter(|_| !own) {
        output::must_not_replace(page, args.force)?;
    }
    tables.clone().try_for_each(|path| output::must_not_replace(path, args.force))?;
    if let Some(dir) = &args.figures {
        output::must_be_empty(dir, args.force)?;
    }
    // A folder that isn't there yet is made only where there is a run.
    if args.out.is_none() && page_dir.is_some() {
        args.runs.iter().try_for_each(|run| vb_record::RunReader::open(run).map(drop))?;
    }
    for dir in page_dir.iter().chain(&args.figures) {
        // What can't be written is said before all runs are read, not after.
        let failed = |e| CliError::output(format!("cannot make the directory {}: {e}", dir.display()));
        std::fs::create_dir_all(dir).map_err(failed)?;
    }
    tables.into_iter().try_for_each(|path| output::must_be_writable(path))?;
    let mut runs = Runs::read(&args.runs)?;
    runs.relabel(&args.labels)?;
    let report = Report::new(runs).titled(args.title.as_deref().unwrap_or_default());
    let mut files = Vec::new();
    if let Some(path) = &args.csv {
        output::whole(path, |file| Ok(write_csv(report.runs(), file, path)?))?;
        files.push(path.clone());
    }
    if let Some(path) = &args.parquet {
        output::whole(path, |file| Ok(write_parquet(report.runs(), file, path)?))?;
        files.push(path.clone());
    }
    if let Some(path) = &args.geojson {
        geojson::write(&report, args.data.suite.as_deref(), path)?;
        files.push(path.clone());
    }
    if let Some(path) = args.markdown.as_ref().filter(|path| path.as_path() != Path::new("-")) {
        output::write(path, report.markdown())?;
        files.push(path.clone());
    }
    if let Some(out) = &page_dir {
        // Only what lies beside the page can be linked wherever it is copied to.
        let beside = files.iter().filter(|f| f.parent() == Some(out)).filter_map(|f| f.file_name()?.to_str());
        let beside: Vec<String> = beside.map(str::to_owned).collect();
        let replays = match &args.replays {
            Some(selector) => replays(&report, args, selector, out)?,
            None => BTreeSet::new(),
        };
        let maps = match &args.maps {
            Some(selector) => maps(&report, args, selector, &replays, out)?,
            None => BTreeSet::new(),
        };
        let page = report.page(&Beside { replays, maps, files: beside });
        let path = out.join(PAGE);
        output::write(&path, &page)?;
        files.push(path);
    }
    if let Some((dir, paper)) = figures_in {
        files.extend(figures(&report, args, &paper, dir)?);
    }
    Ok((report, files))
}

/// Writes the figures and tables for a paper, and returns the names of their files.
fn figures(report: &Report, args: &ReportArgs, paper: &Paper, dir: &Path) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    let mut keep = |name: &str, ending: &str, bytes: &[u8]| {
        let path = dir.join(format!("{name}.{ending}"));
        output::write(&path, bytes)?;
        files.push(path);
        Ok::<(), CliError>(())
    };
    let mut figures: Vec<(String, Figure)> =
        report.paper_figures(paper).into_iter().map(|f| (f.name.to_owned(), f.figure)).collect();
    if let Some(selector) = &args.maps {
        let worlds = Worlds::of(report, args, selector)?;
        for id in &worlds.ids {
            let world = worlds.load(id)?;
            figures.push((format!("map-{id}"), report.map(&world)?.paper_figure(paper)));
        }
    }
    for (name, figure) in &figures {
        keep(name, "svg", figure.svg().as_bytes())?;
        #[cfg(feature = "print")]
        {
            keep(name, "pdf", &figure.pdf().map_err(CliError::output)?)?;
            keep(name, "png", &figure.png(DPI).map_err(CliError::output)?)?;
        }
    }
    if cfg!(not(feature = "print")) {
        output::say(&crate::missing("PDF and PNG files", "print"));
    }
    for (name, table) in report.latex() {
        keep(name, "tex", table.as_bytes())?;
    }
    Ok(files)
}

/// Makes replays of the chosen tasks that all runs have done, as `replays/WORLD/TASK.html` with the
/// script of all beside them, and returns their names.
fn replays(
    report: &Report,
    args: &ReportArgs,
    selector: &str,
    out: &Path,
) -> Result<BTreeSet<TaskId>, CliError> {
    let suite = suite_of(&report.runs().runs[0].header, args.data.suite.as_deref())?;
    let chosen: BTreeSet<TaskId> = suite::select(&suite, Some(selector))?.into_iter().collect();
    let folder = out.join("replays");
    replay::pages(report.runs(), &args.data, &chosen, PAGE, &folder, (&folder, ".."))
}

/// The worlds of which maps are made.
struct Worlds {
    suite: Suite,
    /// The scale at which the runs had them.
    scale: f64,
    /// Their names, in order.
    ids: Vec<String>,
}

impl Worlds {
    /// The worlds of the chosen tasks of which a run has done one.
    fn of(report: &Report, args: &ReportArgs, selector: &str) -> Result<Self, CliError> {
        let runs = &report.runs().runs;
        let first = &runs[0];
        if let Some(other) = runs.iter().find(|r| r.header.scale != first.header.scale) {
            return Err(CliError::usage(format!(
                "--maps: runs {} and {} have worlds of different scale, which have no common map (report them one by one)",
                first.dir.display(),
                other.dir.display()
            )));
        }
        let suite = suite_of(&first.header, args.data.suite.as_deref())?;
        let done: BTreeSet<&str> = report.runs().worlds.iter().map(|w| w.name.as_str()).collect();
        let chosen = suite::select(&suite, Some(selector))?;
        let ids: BTreeSet<String> =
            chosen.iter().map(TaskId::world).filter(|w| done.contains(w)).map(str::to_owned).collect();
        Ok(Self { suite, scale: first.header.scale, ids: ids.into_iter().collect() })
    }

    fn load(&self, id: &str) -> Result<World, CliError> {
        Ok(self.suite.load_world(id)?.at_scale(self.scale))
    }
}

/// Makes maps of the worlds of the chosen tasks that a run has done, as `maps/WORLD.html`, and returns their names.
fn maps(
    report: &Report,
    args: &ReportArgs,
    selector: &str,
    replays: &BTreeSet<TaskId>,
    out: &Path,
) -> Result<BTreeSet<String>, CliError> {
    let worlds = Worlds::of(report, args, selector)?;
    let folder = out.join("maps");
    output::create_dir(&folder)?;
    for (k, id) in worlds.ids.iter().enumerate() {
        let links = MapLinks {
            report: "../index.html",
            above: Vec::new(),
            previous: k.checked_sub(1).map(|k| worlds.ids[k].as_str()),
            next: worlds.ids.get(k + 1).map(String::as_str),
            replays: replays.clone(),
            pictures: None,
        };
        let page = report.map(&worlds.load(id)?)?.page(&links);
        output::write(&folder.join(format!("{id}.html")), &page)?;
    }
    Ok(worlds.ids.into_iter().collect())
}
