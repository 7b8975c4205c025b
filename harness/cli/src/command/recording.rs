//! `vb-harness commands`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_record::{Recording, RunReader};
use vb_score::{Outcome, TaskRecord};

use crate::args::{ForceArgs, FormatArgs, MessageFormat};
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
pub(crate) struct CommandsArgs {
    /// Run directory, with traces
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// File for the recording
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Recording { out: &'a Path, tasks: usize, commands: usize },
}

pub(crate) fn commands(args: &CommandsArgs) -> Result<(), CliError> {
    output::must_not_replace(&args.out, args.force)?;
    output::must_be_replaceable(&args.out)?;
    let reader = RunReader::open(&args.run)?;
    let (mut tasks, mut departures) = (Vec::new(), BTreeSet::new());
    reader.each_record(|record: TaskRecord| {
        // Such a task counts for nothing, and is to be run again.
        if record.outcome != Outcome::HostError {
            tasks.push(record.task);
            departures.extend(record.departures);
        }
    })?;
    let recording = Recording::of_run(&reader, &tasks, departures.into_iter().collect())?;
    recording.write(&args.out)?;
    let (tasks, commands) = (recording.tasks.len(), recording.tasks.values().map(Vec::len).sum());
    match args.format.get() {
        MessageFormat::Json => output::json(&Message::Recording { out: &args.out, tasks, commands }),
        MessageFormat::Human => {
            output::say(&format!("recording: {} ({commands} commands of {tasks} tasks)", args.out.display()));
            let planned = reader.header().tasks;
            if (tasks as u64) < planned {
                output::say(&format!(
                    "note: the run has {planned} tasks; tasks without results have no commands"
                ));
            }
        }
    }
    Ok(())
}
