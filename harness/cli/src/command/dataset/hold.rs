//! `vb-harness dataset validate`, `merge` and `split`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_dataset::{Dataset, Part};
use vb_world::Suite;

use super::{scene, tell};
use crate::args::values::{key_value, positive};
use crate::args::{FormatArgs, MessageFormat};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct DatasetValidateArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Another suite whose worlds must not be in the dataset, in addition to the shipped suites; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Dataset directories
    #[arg(value_name = "DATASET", required = true, num_args = 1..)]
    pub(crate) datasets: Vec<PathBuf>,
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Dataset name; default: merged-VEHICLE
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct SplitArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the parts
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Parts and their fractions of the worlds; the sum must be 1
    #[arg(long, value_name = "NAME=FRACTION,…", default_value = "train=0.8,validation=0.1,test=0.1", value_delimiter = ',', value_parser = part)]
    pub(crate) parts: Vec<Part>,
    /// Seed of the random assignment of worlds to parts
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Parses a part of a dataset, e.g. `train=0.8`. `vb_dataset::split` validates the parts together.
fn part(text: &str) -> Result<Part, String> {
    let (name, fraction) = key_value(text)?;
    Ok(Part { name, fraction: positive(&fraction)? })
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Validated { dataset: &'a Path, findings: &'a [String] },
}

pub(super) fn validate(args: &DatasetValidateArgs) -> Result<(), CliError> {
    let mut suites = Vec::new();
    for dir in places::catalog().suites()?.iter().chain(&args.apart_from) {
        suites.push(Suite::open(dir)?);
    }
    let findings = vb_dataset::validate(&args.dataset, &suites)?.0;
    match args.format.get() {
        MessageFormat::Json => {
            output::json(&Message::Validated { dataset: &args.dataset, findings: &findings });
        }
        MessageFormat::Human => {
            for finding in &findings {
                output::text(&format!("{}\n", vb_files::one_line(finding)));
            }
        }
    }
    match findings.len() {
        0 => {
            if args.format.get() == MessageFormat::Human {
                output::text(&format!("{}: valid\n", args.dataset.display()));
            }
            Ok(())
        }
        n => Err(CliError::not_verified(format!(
            "{}: {n} {} (copy the dataset from its source again, or re-create it with the command in its README.md)",
            args.dataset.display(),
            if n == 1 { "finding" } else { "findings" }
        ))),
    }
}

pub(super) fn merge(args: &MergeArgs) -> Result<(), CliError> {
    let mut datasets = Vec::new();
    for dir in &args.datasets {
        datasets.push(Dataset::open_whole(dir)?);
    }
    let merged = vb_dataset::merge(&datasets, &args.out, args.name.as_deref(), scene::command());
    tell(&merged?, &args.out, args.format.get());
    match vb_dataset::repeated(&datasets) {
        0 => {}
        n => output::say(&format!("{n} episodes are in several of the datasets, and are duplicates")),
    }
    Ok(())
}

pub(super) fn split(args: &SplitArgs) -> Result<(), CliError> {
    let dataset = Dataset::open_whole(&args.dataset)?;
    let parts = vb_dataset::split(&dataset, &args.parts, args.seed, &args.out, &scene::command());
    let parts = parts?;
    for (part, finished) in args.parts.iter().zip(&parts) {
        tell(finished, &args.out.join(&part.name), args.format.get());
    }
    Ok(())
}
