//! `vb-task-search`: which of the tasks that no planner does can be done at all, and what a planner could gain by an error of simulator
//! or rules.

mod aim;
mod search;
mod way;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use clap::Parser;
use serde_json::{Value, json};
use vb_catalog::Catalog;
use vb_env::{Arena, EnvError, Options};
use vb_score::Outcome;
use vb_sdk::policy::ActionKind;
use vb_suite::proof::{Proof, ProofError};
use vb_world::TaskId;

use crate::aim::Aim;
use crate::search::{SPEEDS, repeat, search};

/// Search for the best drives of tasks, with the simulator itself as the model
///
/// Each line of the output is a task with the greatest `value` of the aim that was found, its value at the start, and the `actions`
/// of that drive: steering and speed, as an environment has them, ten a second. A task with `done` can be done; of the others nothing
/// is proven. `diverged` has the actions of a drive that the simulator gives up.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The suite: its name or folder
    #[arg(long, value_name = "SUITE", default_value = "vb-100")]
    suite: PathBuf,
    /// The tasks, as for `vb-harness run`; without it, those that its proof lists as unproven
    #[arg(long, value_name = "SELECTOR")]
    tasks: Option<String>,
    /// Of these, only so many, evenly spread
    #[arg(long, value_name = "N")]
    sample: Option<usize>,
    /// The vehicle
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    vehicle: String,
    /// What to come as far as possible in
    #[arg(long, value_enum, default_value = "goal")]
    aim: Aim,
    /// Pieces of driving, of a second each, that are tried for a task
    #[arg(long, value_name = "N", default_value_t = 6000)]
    pieces: usize,
    /// Tasks at a time; changes no result
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

#[derive(Debug, thiserror::Error)]
enum SearchError {
    #[error(transparent)]
    Catalog(#[from] vb_catalog::CatalogError),
    #[error(transparent)]
    Env(#[from] EnvError),
    #[error(transparent)]
    Proof(#[from] ProofError),
    #[error("{0} has no proof.json, so that it must be told which tasks to search: --tasks SELECTOR")]
    NoProof(String),
    #[error("{task}: what was found is not done when it is driven anew: {reason}")]
    NotRepeated { task: TaskId, reason: String },
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            let _ = writeln!(std::io::stderr(), "error: {e}");
            ExitCode::from(3)
        }
    }
}

fn run(args: &Args) -> Result<(), SearchError> {
    let catalog = Catalog::find();
    let selector = match &args.tasks {
        Some(tasks) => tasks.clone(),
        None => {
            let suite = catalog.open_suite(Some(&args.suite))?;
            let proof = Proof::read(&suite)?;
            proof.ok_or_else(|| SearchError::NoProof(suite.meta().name.clone()))?.unproven.join(",")
        }
    };
    let options = Options {
        suite: Some(args.suite.clone()),
        tasks: Some(selector),
        vehicle: args.vehicle.clone(),
        action: ActionKind::Speed { slowest: SPEEDS[0], fastest: SPEEDS[SPEEDS.len() - 1] },
        observation: vec!["state".into()],
        ..Options::default()
    };
    let arena = Arc::new(Arena::new(&catalog, options, &mut || ())?);
    let all = arena.tasks();
    let count = args.sample.unwrap_or(all.len()).min(all.len());
    let tasks: Vec<&TaskId> = (0..count).map(|k| &all[k * all.len() / count.max(1)]).collect();
    let jobs = args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into)).max(1);
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    match one(&arena, task, args) {
                        Ok(line) => {
                            let _ = writeln!(std::io::stdout(), "{line}");
                        }
                        Err(e) => {
                            failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(e);
                            return;
                        }
                    }
                }
            });
        }
    });
    failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
}

/// Searches one task, and drives anew what was found.
fn one(arena: &Arc<Arena>, task: &TaskId, args: &Args) -> Result<Value, SearchError> {
    let found = search(arena, task, args.pieces, args.aim)?;
    let is_done = found.best.ended == Some(Outcome::Success);
    let mut line = json!({
        "task": task, "aim": args.aim, "done": is_done, "pieces": found.pieces, "start": found.start, "value": found.best.value,
    });
    if let Some(actions) = found.diverged {
        line["diverged"] = json!(actions);
    }
    // Of a search that hasn't come to the goal, how near it came is all that is of use.
    if args.aim == Aim::Goal && !is_done {
        return Ok(line);
    }
    let env = repeat(arena, task, &found.best.actions)?;
    let record = env.record();
    if is_done && record.is_none_or(|record| record.outcome != Outcome::Success) {
        let reason = record.map_or_else(|| "it doesn't end".to_owned(), |r| r.reason.clone());
        return Err(SearchError::NotRepeated { task: task.clone(), reason });
    }
    if let Some(record) = record {
        line["time_s"] = json!(record.time_s);
        line["state_hash"] = json!(record.state_hash);
    }
    line["actions"] = json!(found.best.actions);
    Ok(line)
}
