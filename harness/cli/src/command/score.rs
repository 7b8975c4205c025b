//! `vb-harness score`.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use vb_record::RunReader;
use vb_score::{Rules, Summary, TaskRecord, rescore};

use crate::args::{FormatArgs, MessageFormat};
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rule profile: a name from list rules, or a file; default: the run's profile
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Task { record: &'a TaskRecord },
    Summary { resolution_s: f64, exact: bool, summary: &'a Summary },
}

pub(crate) fn score(args: &ScoreArgs) -> Result<(), CliError> {
    let rules = match &args.rules {
        Some(name) => Rules::resolve(name).map_err(CliError::input)?,
        None => own_rules(args)?,
    };
    let result = rescore(&args.run, &rules)?;
    match args.format.get() {
        MessageFormat::Json => {
            for record in &result.records {
                output::json(&Message::Task { record });
            }
            let (resolution_s, exact) = (result.resolution_s, result.exact);
            output::json(&Message::Summary { resolution_s, exact, summary: &result.summary });
        }
        MessageFormat::Human => {
            output::text(&vb_files::printable(&result.summary.table(output::width())));
            if !result.exact {
                output::say(&format!(
                    "scored from samples every {} s, with corresponding accuracy (run with --trace full for exact values)",
                    result.resolution_s
                ));
            }
        }
    }
    Ok(())
}

/// The rules as recorded in run.json.
fn own_rules(args: &ScoreArgs) -> Result<Rules, CliError> {
    let run = RunReader::open(&args.run)?;
    Rules::recorded(run.header()).map_err(|e| {
        let file = args.run.join("run.json");
        CliError::input(format!("{}: rules.profile: {e} (give rules with --rules)", file.display()))
    })
}
