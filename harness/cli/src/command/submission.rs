//! `vb-harness submit`, `verify` and `evaluate`.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_catalog::Data;
use vb_host::{Limits, PluginKind};
use vb_record::{LogMode, Recording, RunReader, TraceMode};
use vb_report::Runs;
use vb_runner::RunError;
use vb_score::Outcome;
use vb_submission::{
    Check, Division, Entrant, Expected, OpenReason, Request, Sampling, Scores, Shipped, ShippedSuite,
    ShippedVehicle, Submission, SubmissionError, Verification,
};
use vb_world::{Suite, TaskId};

use crate::args::values::{log_mode, planner};
use crate::args::{
    ForceArgs, FormatArgs, JobsArgs, MessageFormat, PERCEPTION, PluginArgs, SOIL_RESOLUTION, SOILS, VEHICLE,
};
use crate::command::run::{self, RunArgs};
use crate::command::suite;
use crate::error::{self, CliError};
use crate::{output, places, planner};

#[derive(Debug, Args)]
pub(crate) struct SubmitArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    /// Directory for the submission
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Continue the run that an interrupted call of submit left as the last runs/PLANNER-N, or begin if there is none
    #[arg(long)]
    pub(crate) resume: bool,
    /// Finished run of the planner; default: a new run over the suite, in runs/PLANNER-N
    #[arg(long, value_name = "DIR", conflicts_with_all = ["resume", "vehicle", "jobs", "keep_going", "logs"])]
    pub(crate) run: Option<PathBuf>,
    /// Suite: a directory, or the name of a shipped suite; default: vb-100, or the suite of --run
    #[arg(long, value_name = "NAME|DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Disable the early end of a run whose first tasks all fail
    ///
    /// The early end has three causes. In all of the first 20 tasks, the planner fails with the same fault before its first
    /// command. In all of the first 3 tasks, the planner hangs before its first command. In all of the first 20 tasks, the
    /// simulation fails.
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Tasks of which the planner's last log lines are recorded: all, failed or none
    #[arg(long, value_name = "all|failed|none", default_value = LogMode::default().name(), value_parser = log_mode)]
    pub(crate) logs: LogMode,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Tasks whose traces are included for replays (maximum 20), e.g. w001/t03,w007/t00; default: the first of each outcome
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Entrant: a person or a team
    #[arg(long, value_name = "NAME", default_value = "")]
    pub(crate) entrant: String,
    /// Page about the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) url: Option<String>,
    /// Source code of the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) code: Option<String>,
    /// Paper about the planner, https only
    #[arg(long, value_name = "URL")]
    pub(crate) paper: Option<String>,
    /// One sentence about the planner
    #[arg(long, value_name = "TEXT")]
    pub(crate) note: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Submission directory
    #[arg(value_name = "SUBMISSION")]
    pub(crate) submission: PathBuf,
    /// Submitted planner: a WASM file, a recording, or a native library with --allow-native
    #[arg(long, value_name = "FILE", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    /// Suite of the submission: a directory; default: the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle of the submission: a name or a file; default: the shipped vehicle of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Soil set of the submission: a name or a file; default: the shipped set of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
    /// Perception profile of the submission: a name or a file; default: the shipped profile of its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// Number of random tasks to re-run, in addition to those with traces; default: all tasks
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) sample: Option<u32>,
    /// Seed of the random tasks; default: an unpredictable seed
    #[arg(long, value_name = "N", requires = "sample")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Refuse submissions to the open division before any run
    #[arg(long)]
    pub(crate) ranked: bool,
    /// Also load native libraries, in their sandbox; default: only WASM and recordings
    #[arg(long, conflicts_with = "ranked")]
    pub(crate) allow_native: bool,
    /// File for the verdict; default: verification.json in the submission
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    /// Hidden suite: a directory
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: PathBuf,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Perception profile (maps, sensors and their errors): a name from list profiles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = PERCEPTION)]
    pub(crate) perception: String,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// File for the scores, e.g. holdout.json of an accepted submission
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Submission { out: &'a Path, division: Division, open_because: &'a [OpenReason], replays: &'a [TaskId] },
    Progress { done: usize, total: usize },
    Verification { verdict: &'a Verification, out: &'a Path },
    Scores { scores: &'a Scores },
}

pub(crate) fn submit(args: &SubmitArgs) -> Result<(), CliError> {
    let entrant = Entrant {
        name: args.entrant.clone(),
        url: args.url.clone(),
        code: args.code.clone(),
        paper: args.paper.clone(),
        note: args.note.clone(),
    };
    // What is wrong with the request is said before hours are spent.
    entrant.check()?;
    if planner::command(args.plugin.path()).is_some() {
        return Err(SubmissionError::NoFile.into());
    }
    if !output::is_free(&args.out) {
        return Err(SubmissionError::NotEmpty(args.out.clone()).into());
    }
    let suite = match &args.run {
        Some(dir) => {
            let reader = RunReader::open(dir)?;
            places::suite_of(reader.header(), args.suite.as_deref())?
        }
        None => suite::open(args.suite.as_deref().unwrap_or(Path::new(vb_catalog::DEFAULT_SUITE)))?,
    };
    let replays = match &args.replays {
        Some(selector) => {
            let tasks = suite::select(&suite, Some(selector))?;
            vb_submission::check_replays(&tasks)?;
            Some(tasks)
        }
        None => None,
    };
    let (dir, ended) = match &args.run {
        Some(dir) => (dir.clone(), Ok(())),
        None => {
            let mut wanted = RunArgs::new(args.plugin.path());
            if let Some(suite) = &args.suite {
                wanted.drive.suite.clone_from(suite);
            }
            wanted.drive.vehicle.clone_from(&args.vehicle);
            (wanted.jobs, wanted.drive.logs) = (args.jobs, args.logs);
            (wanted.format, wanted.drive.keep_going) = (args.format, args.keep_going);
            // The run is submitted when it is whole.
            wanted.drive.resume.resume = args.resume;
            run::drive(&wanted, &|_| "the same command and --resume".to_owned())?
        }
    };
    // Tasks whose simulation failed are results, too.
    if let Err(e) = &ended
        && e.code() != error::SIM_ERRORS
    {
        return ended;
    }
    let plugin = planner::load_quietly(args.plugin.path(), &Limits::default(), false)
        .map_err(|e| planner::unusable(&e))?;
    let shipped = shipped()?;
    let request = Request {
        suite: &suite,
        plugin: &plugin,
        shipped: &shipped,
        harness_version: env!("CARGO_PKG_VERSION"),
        entrant,
        replays,
    };
    let manifest = vb_submission::make(&dir, &args.out, &request)?;
    match args.format.get() {
        MessageFormat::Json => output::json(&Message::Submission {
            out: &args.out,
            division: manifest.division,
            open_because: &manifest.open_because,
            replays: &manifest.replays,
        }),
        MessageFormat::Human => {
            output::say(&format!(
                "submission: {} ({} division)",
                args.out.display(),
                manifest.division.name()
            ));
            for reason in &manifest.open_because {
                output::say(&format!("  not ranked, {}: {}", reason.field, vb_files::one_line(&reason.text)));
            }
            output::note(&format!(
                "check it with: vb-harness verify {} --plugin {} --sample 10{}",
                args.out.display(),
                args.plugin.path().display(),
                if plugin.kind() == PluginKind::Native { " --allow-native" } else { "" }
            ));
        }
    }
    ended
}

pub(crate) fn verify(args: &VerifyArgs) -> Result<(), CliError> {
    let submission = Submission::open(&args.submission)?;
    let m = submission.manifest();
    if args.ranked && m.division == Division::Open {
        let why = m
            .open_because
            .first()
            .map_or_else(String::new, |r| format!(", for its {}", vb_files::one_line(&r.field)));
        return Err(CliError::not_verified(format!(
            "{}: in the open division{why} (verify it without --ranked)",
            args.submission.display()
        )));
    }
    // What the submission names is looked up among what comes with the harness, never in the working folder, where a stranger's
    // files may lie.
    let suite = match &args.suite {
        Some(dir) => suite::open(dir)?,
        None => {
            let own = places::catalog().own_suite(plain("suite", &m.run.suite.name)?)?;
            Suite::open(own)?
        }
    };
    let vehicle = match &args.vehicle {
        Some(vehicle) => places::catalog().vehicle(vehicle)?,
        None => vb_catalog::vehicle_of(
            &places::catalog().own_data(Data::Vehicle, plain("vehicle", &m.run.vehicle.name)?)?,
        )?,
    };
    let pitch = m.run.soil_resolution;
    let soils = match &args.soils {
        Some(soils) => places::catalog().soils(soils, pitch)?,
        None => vb_catalog::soils_of(
            &places::catalog().own_data(Data::Soils, plain("soils", &m.run.soils.name)?)?,
            pitch,
        )?,
    };
    let perception = match &args.perception {
        Some(perception) => places::catalog().perception(perception)?,
        None => places::catalog().own_perception(plain("perception profile", &m.run.perception.name)?)?,
    };
    // Of a recording nothing is executed.
    if !is_wasm(&args.plugin)? && !Recording::is_one(&args.plugin) && !args.allow_native {
        return Err(CliError::input(format!(
            "{} is neither a WASM file nor a recording (--allow-native loads a native library \
             in its sandbox)",
            args.plugin.display()
        )));
    }
    let plugin_sha256 = vb_submission::sha256_file(&args.plugin)?;
    let out = args.out.clone().unwrap_or_else(|| args.submission.join("verification.json"));
    output::must_be_replaceable(&out)?;
    let draw = match (args.sample, args.seed) {
        (Some(count), Some(seed)) => Some((count as usize, seed)),
        (Some(count), None) => Some((count as usize, random()?)),
        (None, _) => None,
    };
    let shipped = shipped()?;
    let expected = Expected {
        suite: &suite,
        plugin_sha256: &plugin_sha256,
        vehicle: &vehicle,
        soils: &soils,
        perception: &perception,
        shipped: &shipped,
        harness_version: env!("CARGO_PKG_VERSION"),
    };
    let load = |limits: &Limits| planner::load_quietly(&args.plugin, limits, true);
    let cancel = run::stop_on_ctrl_c()?;
    let json = args.format.get() == MessageFormat::Json;
    let sampling = Sampling { draw, jobs: args.jobs.get() };
    let mut ended = |done: usize, total: usize, _: &vb_score::TaskRecord| {
        if json {
            output::json(&Message::Progress { done, total });
        } else if done.is_multiple_of(total.div_ceil(10)) || done == total {
            output::note(&format!("re-run: {done} of {total}"));
        }
    };
    let verdict = vb_submission::verify(&submission, &expected, &load, &sampling, &mut ended, &cancel)?;
    write_json(&out, &verdict)?;
    if json {
        output::json(&Message::Verification { verdict: &verdict, out: &out });
    } else {
        output::text(&told(&verdict, args.sample));
        output::say(&format!("verdict: {}", out.display()));
    }
    if verdict.verified {
        return Ok(());
    }
    let first = verdict.findings.first().map_or_else(String::new, |f| vb_files::one_line(&f.to_string()));
    let more = match verdict.findings.len() as u64 + verdict.more_findings {
        0 | 1 => String::new(),
        n => format!(" (and {} more, see {})", n - 1, out.display()),
    };
    Err(CliError::not_verified(format!("{} does not verify: {first}{more}", args.submission.display())))
}

/// A verdict for people, with the number of tasks that were to be drawn, if not all.
fn told(verdict: &Verification, drawn: Option<u32>) -> String {
    let mut by_check: BTreeMap<Check, usize> = BTreeMap::new();
    for f in &verdict.findings {
        *by_check.entry(f.check).or_default() += 1;
    }
    let mut rows: Vec<Vec<String>> = verdict
        .checks
        .iter()
        .map(|check| {
            let result = by_check.get(check).map_or_else(|| "good".to_owned(), |n| format!("{n} found"));
            vec![check.name().to_owned(), result]
        })
        .collect();
    if let (Some(sample), Some(row)) = (&verdict.sample, rows.last_mut()) {
        let seed = sample.seed.map_or_else(String::new, |s| format!(", seed {s}"));
        let more = match drawn {
            Some(n) if (n as usize) < sample.tasks.len() => format!(" ({n} sampled, and those with traces)"),
            _ => String::new(),
        };
        row.push(format!("{} of {} tasks{more}{seed}", sample.tasks.len(), sample.of));
    }
    let mut text = output::columns(&rows);
    for f in &verdict.findings {
        text += &format!("  {}\n", vb_files::one_line(&f.to_string()));
    }
    if verdict.more_findings > 0 {
        text += &format!("  and {} more\n", verdict.more_findings);
    }
    text
}

pub(crate) fn evaluate(args: &EvaluateArgs) -> Result<(), CliError> {
    // Nothing that is said here may tell of the suite, whoever reads it.
    let hidden = |_: &dyn std::fmt::Display| {
        CliError::input("the suite is invalid (for the reason run vb-harness suite validate)")
    };
    let suite = Suite::open(places::catalog().suite(Some(&args.suite)).map_err(|e| hidden(&e))?)
        .map_err(|e| hidden(&e))?;
    let plugin = args.plugin.path();
    if !is_wasm(plugin)? {
        return Err(CliError::input(format!(
            "{} is not a WASM file: only WASM planners cannot leak the hidden tasks",
            plugin.display()
        )));
    }
    if let Some(out) = &args.out {
        output::must_not_replace(out, args.force)?;
        output::must_be_replaceable(out)?;
    }
    let scratch = tempfile::tempdir().map_err(|e| CliError::output(format!("no temporary folder: {e}")))?;
    let mut wanted = RunArgs::new(plugin);
    wanted.drive.suite = suite.dir().to_owned();
    (wanted.drive.vehicle, wanted.jobs) = (args.vehicle.clone(), args.jobs);
    wanted.drive.perception.clone_from(&args.perception);
    (wanted.drive.trace, wanted.drive.out) = (TraceMode::None, Some(scratch.path().join("run")));
    // A planner's own words may tell of the suite, and one that fails in all tasks has its scores, too.
    wanted.drive.keep_going = true;
    let config = run::config(&wanted)?;
    // Stopped in good order, so that the folder with the run is removed.
    let cancel = run::stop_on_ctrl_c()?;
    let report = vb_runner::run(&config, &mut |_| {}, &cancel).map_err(|e| match e {
        RunError::Suite(e) => hidden(&e),
        RunError::Store(e) if !e.is_disk_full() => {
            CliError::output("results cannot be stored in the temporary folder")
        }
        e => e.into(),
    })?;
    if report.interrupted {
        return Err(CliError::interrupted("stopped without scores"));
    }
    if !report.summary.host_errors.is_empty() {
        return Err(CliError::host_errors(format!(
            "{} tasks failed because of the harness or the machine: there are no scores (evaluate again)",
            report.summary.host_errors.len()
        )));
    }
    let runs = Runs::read(std::slice::from_ref(&config.out)).map_err(|e| hidden(&e))?;
    let scores = Scores::new(&runs, &suite.meta().version);
    if let Some(out) = &args.out {
        write_json(out, &scores)?;
    }
    match args.format.get() {
        MessageFormat::Json => output::json(&Message::Scores { scores: &scores }),
        MessageFormat::Human => output::text(&scores.text()),
    }
    match scores.outcomes.get(&Outcome::SimError) {
        None | Some(0) => Ok(()),
        Some(n) => Err(CliError::sim_errors(format!("the simulation of {n} tasks failed"))),
    }
}

fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), CliError> {
    let fail = |e: &dyn std::fmt::Display| CliError::output(format!("cannot write {}: {e}", path.display()));
    let mut text = serde_json::to_vec_pretty(value).map_err(|e| fail(&e))?;
    text.push(b'\n');
    vb_files::write(path, &text).map_err(|e| fail(&e))
}

/// A name in a submission by which something that comes with the harness is looked up: strangers must not name files.
fn plain<'a>(what: &str, name: &'a str) -> Result<&'a str, CliError> {
    let good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !name.is_empty() && name.len() <= 100 && name.chars().all(good) {
        return Ok(name);
    }
    Err(CliError::input(format!(
        "{what} {:?} of the submission is not built in (give yours with --{what})",
        vb_files::one_line(name)
    )))
}

/// Whether a file is WASM, by its first bytes: of what strangers hand in nothing else is loaded unless one says so.
fn is_wasm(path: &Path) -> Result<bool, CliError> {
    let mut magic = [0; 4];
    let read = vb_files::open(path).and_then(|mut f| f.read(&mut magic));
    let n =
        read.map_err(|e| CliError::input(format!("cannot read {}: {e} (give a WASM file)", path.display())))?;
    Ok(magic[..n] == *b"\0asm")
}

/// A seed that nobody can foresee. It reaches no score: it chooses what is looked at.
fn random() -> Result<u64, CliError> {
    getrandom::u64().map_err(|e| CliError::internal(format!("no random number: {e} (give --seed)")))
}

/// What comes with the harness.
fn shipped() -> Result<Shipped, CliError> {
    let mut shipped = Shipped {
        soils: vb_catalog::soils_of(&places::catalog().own_data(Data::Soils, SOILS)?, SOIL_RESOLUTION)?.hash,
        ..Shipped::default()
    };
    for dir in places::catalog().suites()? {
        let suite = Suite::open(&dir)?;
        let (name, tasks) = (suite.meta().name.clone(), suite.task_count() as u64);
        shipped.suites.push(ShippedSuite { name, hash: suite.hash(), tasks });
    }
    for name in places::catalog().names(Data::Vehicle)? {
        let vehicle = vb_catalog::vehicle_of(&places::catalog().own_data(Data::Vehicle, &name)?)?;
        shipped.vehicles.insert(
            vehicle.spec.name.clone(),
            ShippedVehicle { hash: vehicle.hash, scale: vehicle.spec.scale },
        );
    }
    Ok(shipped)
}
