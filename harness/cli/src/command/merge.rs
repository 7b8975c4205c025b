//! `vb-harness merge`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_record::RunReader;
use vb_runner::shards_in;
use vb_score::Summary;
use vb_world::TaskId;

use crate::args::{FormatArgs, MessageFormat};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct MergeRunArgs {
    /// Shard directories from run --shard, or a directory that contains them
    #[arg(value_name = "DIR", required = true)]
    pub(crate) shards: Vec<PathBuf>,
    /// Directory for the joined run
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Suite of the shards; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// So many tasks are named in a message.
const NAMED: usize = 10;

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Merged {
        out: &'a Path,
        shards: usize,
        missing: &'a [TaskId],
        twice: &'a [TaskId],
        untraced: &'a [TaskId],
        summary: &'a Summary,
    },
}

pub(crate) fn merge(args: &MergeRunArgs) -> Result<(), CliError> {
    let mut shards: Vec<PathBuf> = Vec::new();
    for dir in &args.shards {
        shards.extend(shards_in(dir)?);
    }
    shards.sort();
    shards.dedup();
    let first = RunReader::open(&shards[0])?;
    let suite = places::suite_of(first.header(), args.suite.as_deref())?;
    let merged = vb_runner::merge(&shards, &suite, &args.out)?;
    let summary = &merged.summary;
    match args.format.get() {
        MessageFormat::Json => output::json(&Message::Merged {
            out: &args.out,
            shards: shards.len(),
            missing: &merged.missing,
            twice: &merged.twice,
            untraced: &merged.untraced,
            summary,
        }),
        MessageFormat::Human => {
            output::text(&vb_files::printable(&summary.table(output::width())));
            if !merged.twice.is_empty() {
                let (n, which) = (merged.twice.len(), some(&merged.twice));
                output::say(&format!("{n} tasks were run twice, with equal results: {which}"));
            }
            if !merged.untraced.is_empty() {
                let (n, which) = (merged.untraced.len(), some(&merged.untraced));
                output::say(&format!(
                    "{n} tasks have no trace, because their shards lost it: {which} (they can't be scored again or replayed)"
                ));
            }
            output::say(&format!("results: {}", args.out.display()));
        }
    }
    if !merged.missing.is_empty() {
        return Err(CliError::incomplete(format!(
            "{} of {} tasks are missing: {} (run them with the command of the shards without --shard, but with --out {} --resume)",
            merged.missing.len(),
            summary.planned,
            some(&merged.missing),
            args.out.display()
        )));
    }
    match summary.sim_errors() {
        0 => Ok(()),
        n => Err(CliError::sim_errors(format!(
            "the simulation of {n} tasks failed (see outcome sim_error in {})",
            args.out.join("tasks.jsonl").display()
        ))),
    }
}

/// The names of some tasks.
fn some(tasks: &[TaskId]) -> String {
    let named = tasks.iter().take(NAMED).map(TaskId::as_str).collect::<Vec<_>>().join(", ");
    match tasks.len().saturating_sub(NAMED) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}
