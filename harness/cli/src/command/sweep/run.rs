//! `vb-harness sweep run`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use serde::Serialize;
use vb_runner::RunConfig;
use vb_runner::sweep::PlannedRun;
use vb_world::Shard;

use super::{Sweep, SweepArgs};
use crate::args::values::shard;
use crate::args::{JobsArgs, MessageFormat, ResumeArgs};
use crate::command::run::{RunArgs, config, stop_on_ctrl_c};
use crate::error::{self, CliError};
use crate::output;
use crate::progress::Progress;

#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    #[command(flatten)]
    pub(crate) sweep: SweepArgs,
    #[command(flatten)]
    pub(crate) resume: ResumeArgs,
    /// Run one shard of all runs, e.g. 3/8 for the third of eight
    ///
    /// With auto, shard and number of shards come from the job array of Slurm, Kubernetes or AWS Batch.
    #[arg(long, value_name = "I/N|auto", value_parser = shard)]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Disable the early end of a run whose first tasks all fail
    ///
    /// The early end has three causes. In all of the first 20 tasks, the planner fails with the same fault before its first
    /// command. In all of the first 3 tasks, the planner hangs before its first command. In all of the first 20 tasks, the
    /// simulation fails.
    #[arg(long)]
    pub(crate) keep_going: bool,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    RunFinished { run: &'a str, flaw: Option<&'a str> },
}

/// A run of the sweep that is to be driven by this process.
struct Part<'a> {
    planned: &'a PlannedRun,
    args: RunArgs,
    /// Where its results lie.
    dir: PathBuf,
    tasks: u64,
}

pub(crate) fn run(args: &SweepRunArgs) -> Result<(), CliError> {
    let sweep = Sweep::open(&args.sweep)?;
    let parts = parts(&sweep, args);
    if !args.resume.resume {
        must_begin(&sweep, &parts, args)?;
    }
    check(&parts)?;
    keep_plan(&sweep, args)?;
    let cancel = stop_on_ctrl_c()?;
    let total = parts.iter().map(|p| p.tasks).sum();
    let format = args.sweep.format.get();
    let mut progress = Progress::of_many(format, total);
    // What is done takes no time.
    let mut left = Vec::new();
    for part in parts {
        let state = sweep.layout.state_of(&part.dir)?;
        if state.failed == 0 && state.tasks() == part.tasks {
            progress.done_before(part.tasks);
        } else {
            left.push(part);
        }
    }
    let mut flaws: Vec<(String, CliError)> = Vec::new();
    for part in left {
        progress.enter(&part.planned.name);
        let flaw = drive(&config(&part.args)?, &mut progress, &cancel)?;
        if format == MessageFormat::Json {
            let told = flaw.as_ref().map(ToString::to_string);
            output::json(&Message::RunFinished { run: &part.planned.name, flaw: told.as_deref() });
        }
        if let Some(flaw) = flaw {
            if flaw.code() == error::INTERRUPTED {
                progress.finish();
                return Err(flaw);
            }
            progress.say(&format!("{}: {flaw}", part.planned.name));
            flaws.push((part.planned.name.clone(), flaw));
        }
    }
    progress.finish();
    if format == MessageFormat::Human {
        output::say(&format!("results: {}", sweep.layout.root().display()));
    }
    summed_up(flaws, sweep.spec.runs().len())
}

/// What this process is to drive.
fn parts<'a>(sweep: &'a Sweep, args: &SweepRunArgs) -> Vec<Part<'a>> {
    let worlds = sweep.worlds();
    let mut parts = Vec::new();
    for (planned, k) in sweep.spec.runs().iter().zip(0u64..) {
        let mut run = sweep.args(planned);
        run.jobs = args.jobs;
        run.drive.keep_going = args.keep_going;
        // Runs that are not begun yet are begun.
        run.drive.resume.resume = true;
        let (dir, tasks) = match args.shard {
            None => {
                let dir = sweep.layout.run(&planned.name);
                run.drive.out = Some(dir.clone());
                (dir, sweep.tasks.len())
            }
            Some(shard) => {
                // Dealt on where the run before ended, so that shards of many small runs are of one size.
                let shard: Shard = shard.after(k * worlds);
                let tasks = shard.tasks(&sweep.tasks).len();
                if tasks == 0 {
                    continue;
                }
                run.drive.shard = Some(shard);
                run.drive.out = Some(sweep.layout.shards(&planned.name));
                (sweep.layout.shards(&planned.name).join(shard.folder()), tasks)
            }
        };
        parts.push(Part { planned, args: run, dir, tasks: tasks as u64 });
    }
    parts
}

/// Refuses what an earlier call left: of a shard in its own folders, since other shards write to the others at the same time.
fn must_begin(sweep: &Sweep, parts: &[Part<'_>], args: &SweepRunArgs) -> Result<(), CliError> {
    let root = sweep.layout.root();
    let taken = match args.shard {
        None => Some(root).filter(|root| !output::is_free(root)),
        Some(_) => parts.iter().map(|part| part.dir.as_path()).find(|dir| !output::is_free(dir)),
    };
    match taken {
        None => Ok(()),
        Some(dir) => Err(CliError::output(format!(
            "output directory {} is not empty (choose another with --out, or continue the sweep in it with --resume)",
            dir.display()
        ))),
    }
}

/// Checks what would make whole runs fail, before the first one begins: each planner with its parameters under each profile, and
/// each vehicle.
fn check(parts: &[Part<'_>]) -> Result<(), CliError> {
    let mut seen = BTreeSet::new();
    for part in parts {
        let p = part.planned;
        let planner = seen.insert(format!("{}\n{}", p.planner, p.perception));
        let vehicle = seen.insert(format!("{}\n", p.vehicle));
        if planner || vehicle {
            let config = config(&part.args).map_err(|e| e.within(&p.name))?;
            vb_runner::check(&config).map_err(|e| CliError::from(e).within(&p.name))?;
        }
    }
    Ok(())
}

/// Puts the plan beside its runs. Shards of two plans in one folder would not make whole runs.
fn keep_plan(sweep: &Sweep, args: &SweepRunArgs) -> Result<(), CliError> {
    let plan = sweep.layout.plan();
    let read = |path| vb_files::read(path, vb_files::DOCUMENT);
    let own =
        read(&args.sweep.file).map_err(|e| CliError::input(format!("{}: {e}", args.sweep.file.display())))?;
    let kept = read(&plan).ok();
    if kept.as_ref() == Some(&own) {
        return Ok(());
    }
    if kept.is_some() && (args.shard.is_some() || sweep.layout.is_sharded()) {
        return Err(CliError::output(format!(
            "{} was started with another plan, and its shards do not match this plan (give another --out, or the plan in {})",
            sweep.layout.root().display(),
            plan.display()
        )));
    }
    std::fs::create_dir_all(sweep.layout.root())
        .and_then(|()| vb_files::write(&plan, &own))
        .map_err(|e| CliError::output(format!("cannot write {}: {e}", plan.display())))
}

/// Drives a run. What ends the sweep is an error; what is wrong with this run alone is returned.
fn drive(
    config: &RunConfig,
    progress: &mut Progress,
    cancel: &AtomicBool,
) -> Result<Option<CliError>, CliError> {
    let report = vb_runner::run(config, &mut |event| progress.hear(event), cancel)?;
    if let Some(start) = &report.failed_start {
        return Ok(Some(CliError::failed_start(start)));
    }
    if report.interrupted || cancel.load(Ordering::Relaxed) {
        return Ok(Some(CliError::interrupted("stopped (continue with the same command and --resume)")));
    }
    let (host, sim) = (report.summary.host_errors.len(), report.summary.sim_errors());
    Ok(match (host, sim) {
        (0, 0) => None,
        (0, n) => Some(CliError::sim_errors(format!("the simulation of {n} tasks failed"))),
        (n, _) => {
            Some(CliError::host_errors(format!("{n} tasks failed because of the harness or the machine")))
        }
    })
}

/// One error of many: the one that the same command mends comes first, then the one that somebody has to mend.
fn summed_up(flaws: Vec<(String, CliError)>, runs: usize) -> Result<(), CliError> {
    let rank = |e: &CliError| {
        [error::HOST_ERRORS, error::FAILED_START]
            .iter()
            .position(|code| *code == e.code())
            .unwrap_or(usize::MAX)
    };
    let n = flaws.len();
    match flaws.into_iter().min_by_key(|(_, flaw)| rank(flaw)) {
        None => Ok(()),
        Some((name, flaw)) => Err(flaw.within(&format!("{n} of {runs} runs have failures; {name}"))),
    }
}
