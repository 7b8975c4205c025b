//! `vb-harness suite prove`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use serde::Serialize;
use vb_record::{RunHeader, RunReader};
use vb_score::{Outcome, TaskRecord};
use vb_suite::proof::{Conditions, Named, Proof, Prover};
use vb_world::{Suite, TaskId};

use crate::args::FormatArgs;
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("place").required(true)))]
pub(crate) struct ProveArgs {
    /// Suite: a directory, or the name of a shipped suite
    #[arg(value_name = "NAME|DIR")]
    pub(crate) suite: PathBuf,
    /// Run directories; the first run that solved a task is recorded
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// File for the certificate
    #[arg(short, long, value_name = "FILE", group = "place")]
    pub(crate) out: Option<PathBuf>,
    /// Write the certificate to proof.json in the suite's directory, unless the one there proves tasks that these runs don't
    #[arg(long, group = "place")]
    pub(crate) in_place: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Run { run: &'a Path, planner: &'a str, proven: usize },
    Proof { path: &'a Path, proven: usize, tasks: usize, unproven: &'a [TaskId] },
}

/// Collects from runs which tasks of a suite have been done.
pub(crate) fn prove(args: &ProveArgs) -> Result<(), CliError> {
    let suite = super::open(&args.suite)?;
    let hash = suite.hash();
    let mut proof: Option<Proof> = None;
    for dir in &args.runs {
        let run = RunReader::open(dir)?;
        let header = run.header();
        let wrong =
            |problem: String| CliError::input(format!("{}: {problem}", dir.join("run.json").display()));
        if header.suite.hash != hash {
            return Err(wrong(format!(
                "belongs to a suite with hash {}, but {} has {hash}: run the planner on this suite",
                header.suite.hash,
                suite.dir().display()
            )));
        }
        let conditions = conditions(header);
        let proof = proof.get_or_insert_with(|| Proof::new(&suite, conditions.clone()));
        if proof.conditions != conditions {
            return Err(wrong(
                "differs from the first run in harness, vehicle, soils, rules, scale or step: use separate certificate files (--out)"
                    .into(),
            ));
        }
        let records: Vec<TaskRecord> = run.records()?;
        let done = records.into_iter().filter(|r| r.outcome == Outcome::Success);
        let proven = proof.add(prover(header), done.map(|r| (r.task, r.time_s, r.state_hash)));
        if args.format.is_json() {
            output::json(&Message::Run { run: dir, planner: &header.plugin.name, proven });
        } else {
            output::text(&format!(
                "{}: {proven} more certificates with {}\n",
                dir.display(),
                header.plugin.name
            ));
        }
    }
    // The arguments demand a run.
    let Some(proof) = proof else { return Ok(()) };
    let path = match &args.out {
        Some(path) => path.clone(),
        // In place: clap demands one of both.
        None => {
            keep(&suite, &proof)?;
            Proof::path(&suite)
        }
    };
    proof.write(&path)?;
    let (proven, tasks) = (proof.tasks.len(), suite.task_count());
    if args.format.is_json() {
        output::json(&Message::Proof { path: &path, proven, tasks, unproven: &proof.unproven });
    } else {
        output::text(&format!("{}: {proven} of {tasks} tasks have certificates\n", path.display()));
    }
    Ok(())
}

/// Sees to it that the suite's own proof names no task that the new one doesn't.
fn keep(suite: &Suite, new: &Proof) -> Result<(), CliError> {
    // One that is damaged, or of another suite, proves nothing.
    let Ok(Some(old)) = Proof::read(suite) else { return Ok(()) };
    let lost = old.tasks.keys().filter(|task| !new.tasks.contains_key(*task)).count();
    if lost == 0 {
        return Ok(());
    }
    Err(CliError::usage(format!(
        "{} has certificates of {lost} tasks that these runs do not solve: add the runs that solve them, or give another file with --out",
        Proof::path(suite).display()
    )))
}

fn conditions(header: &RunHeader) -> Conditions {
    let named = |name: &str, hash: &str| Named { name: name.into(), hash: hash.into() };
    Conditions {
        harness_version: header.harness_version.clone(),
        vehicle: named(&header.vehicle.name, &header.vehicle.hash),
        soils: named(&header.soils.name, &header.soils.hash),
        rules: named(&header.rules.name, &header.rules.hash),
        scale: header.scale,
        time_step: header.time_step,
        soil_resolution: header.soil_resolution,
    }
}

fn prover(header: &RunHeader) -> Prover {
    let plugin = &header.plugin;
    Prover {
        planner: plugin.name.clone(),
        version: plugin.version.clone(),
        sha256: plugin.sha256.clone(),
        params: header.params.clone(),
        seed: header.seed,
    }
}
