//! `vb-harness leaderboard`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use vb_report::Runs;
use vb_submission::SubmissionError;
use vb_submission::leaderboard::{self, Entry};
use vb_world::{Suite, TaskId};

use crate::args::{ForceArgs, FormatArgs, MessageFormat, ReplayData};
use crate::command::replay;
use crate::error::CliError;
use crate::output;
use crate::places::suite_of;

commands! {
    LeaderboardCommand

    /// Build a static site from verified submissions
    Build(BuildArgs) => build,
}

#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Directory with one folder per accepted submission, each with its verification.json
    #[arg(value_name = "DIR")]
    pub(crate) entries: PathBuf,
    /// Directory for the site
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Title of the leaderboard
    #[arg(long, value_name = "TEXT", default_value = "Verti-Bench leaderboard")]
    pub(crate) title: String,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// The file that makes a folder a submission.
const MANIFEST: &str = "submission.json";

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Leaderboard { boards: usize, entries: usize, files: &'a [PathBuf] },
}

pub(crate) fn build(args: &BuildArgs) -> Result<(), CliError> {
    must_hold_submissions(&args.entries)?;
    // A folder with anything but an earlier site is refused in any case.
    output::must_not_replace(&args.out.join(leaderboard::DATA), args.force)?;
    let site = leaderboard::build(&args.entries, &args.out, &args.title, &mut Shown { site: &args.out })?;
    let entries = site.boards.iter().map(|b| b.entries.len()).sum();
    match args.format.get() {
        MessageFormat::Json => {
            output::json(&Message::Leaderboard { boards: site.boards.len(), entries, files: &site.files });
        }
        MessageFormat::Human => {
            let count = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
            output::say(&format!(
                "{} on {}",
                count(entries, "entry", "entries"),
                count(site.boards.len(), "board", "boards")
            ));
            for file in &site.files {
                output::say(&format!("wrote {}", file.display()));
            }
        }
    }
    Ok(())
}

/// Refuses a submission where the folder of submissions is wanted.
fn must_hold_submissions(dir: &Path) -> Result<(), CliError> {
    if !dir.join(MANIFEST).is_file() {
        return Ok(());
    }
    let real = std::fs::canonicalize(dir).unwrap_or_else(|_| dir.to_owned());
    let parent = real.parent().map_or_else(|| "its parent".to_owned(), |p| p.display().to_string());
    Err(CliError::usage(format!(
        "{} is itself a submission, not a directory of submissions (give its parent directory: {parent})",
        dir.display()
    )))
}

/// Suites and replays by what comes with the harness. The site stands without them, where a suite isn't at hand for instance.
struct Shown<'a> {
    /// The folder of the site, which has the script of all replays.
    site: &'a Path,
}

impl leaderboard::Source for Shown<'_> {
    fn suite(&mut self, entry: &Entry, runs: &Runs) -> Option<Suite> {
        let found = suite_of(&runs.runs[0].header, None);
        found.map_err(|e| output::say(&format!("entry {}: no maps: {e}", entry.id))).ok()
    }

    fn replays(
        &mut self,
        entry: &Entry,
        runs: &Runs,
        out: &Path,
    ) -> Result<BTreeSet<TaskId>, SubmissionError> {
        Ok(replays(entry, runs, out, self.site).unwrap_or_else(|e| {
            output::say(&format!("entry {}: no replays: {e}", entry.id));
            BTreeSet::new()
        }))
    }
}

fn replays(entry: &Entry, runs: &Runs, out: &Path, site: &Path) -> Result<BTreeSet<TaskId>, CliError> {
    let tasks: BTreeSet<TaskId> = entry.manifest.replays.iter().cloned().collect();
    if tasks.is_empty() {
        return Ok(tasks);
    }
    // From entries/ENTRY/replays/WORLD/TASK.html.
    let script = (site, "../../../..");
    replay::pages(runs, &ReplayData::default(), &tasks, leaderboard::REPORT, out, script)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_submission_is_not_a_folder_of_submissions() {
        let dir = tempfile::tempdir().unwrap();
        let own = dir.path().join("fox");
        std::fs::create_dir(&own).unwrap();
        std::fs::write(own.join(MANIFEST), "{}").unwrap();
        must_hold_submissions(dir.path()).unwrap();
        let e = must_hold_submissions(&own).unwrap_err().to_string();
        let parent = std::fs::canonicalize(dir.path()).unwrap();
        assert!(e.contains("is itself a submission") && e.contains(&parent.display().to_string()), "{e}");
    }
}
