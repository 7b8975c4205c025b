//! The submissions of a leaderboard.

use std::fs;
use std::path::{Path, PathBuf};

use vb_report::{Figures, Measure, RunFigures, Runs, Split, WorldLabels};

use crate::SubmissionError;
use crate::check::Submission;
use crate::files::{self, HOLDOUT, SMALL, VERDICT};
use crate::manifest::Manifest;
use crate::scores::{SCORES_SCHEMA, Scores};
use crate::verdict::{VERIFICATION_SCHEMA, Verification};

/// An accepted submission.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name of the entry's folder, and of that of its pages.
    pub id: String,
    pub dir: PathBuf,
    /// The entry's manifest, without tasks and files.
    pub manifest: Manifest,
    pub verification: Verification,
    /// The figures over all tasks.
    pub figures: Figures,
    /// The success rate by elevation level, from low to high, in [0, 1]; levels without tasks are left out.
    pub levels: Vec<(&'static str, f64)>,
    /// The worlds by their names, each with the number of tasks that were done and of all that count.
    pub worlds: Vec<(WorldLabels, (u64, u64))>,
    /// The fuel of the most costly step of all tasks as a share of the limit; `None` for planners that aren't metered.
    pub fuel: Option<f64>,
    /// The scores on the hidden suite, if the owner had the entry evaluated.
    pub holdout: Option<Scores>,
}

/// The entries in `dir` by their names.
pub(super) fn read(dir: &Path) -> Result<Vec<Entry>, SubmissionError> {
    let mut folders = Vec::new();
    for entry in fs::read_dir(dir).map_err(SubmissionError::read(dir))? {
        let entry = entry.map_err(SubmissionError::read(dir))?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        if !hidden && entry.path().is_dir() {
            folders.push(entry.path());
        }
    }
    folders.sort();
    folders.into_iter().map(|folder| read_entry(&folder)).collect()
}

fn read_entry(dir: &Path) -> Result<Entry, SubmissionError> {
    let fail = |problem: String| Err(SubmissionError::Entry { dir: dir.to_owned(), problem });
    let Some(id) = dir.file_name().and_then(|n| n.to_str()).filter(|n| files::is_plain(n)) else {
        return fail(
            "its name contains characters other than letters, digits, '-', '_' and '.' (rename the folder)"
                .into(),
        );
    };
    let path = dir.join(VERDICT);
    if !path.exists() {
        return fail(format!("{VERDICT} is missing (run vb-harness verify first)"));
    }
    let (verification, _): (Verification, _) =
        files::read_json(&path, files::DOCUMENT, VERIFICATION_SCHEMA, |_| Ok(()))?;
    let submission = Submission::open(dir)?;
    if !verification.verified {
        let first = verification.findings.first().map_or_else(String::new, |f| format!(": {f}"));
        return fail(format!("its verification failed{first} (remove it)"));
    }
    // A verdict is of one manifest, and that of all other files.
    if verification.submission_sha256 != submission.sha256() {
        return fail(format!("{VERDICT} belongs to another submission.json (verify again)"));
    }
    if let Some(finding) = submission.check_files()?.iter().next() {
        return fail(format!("changed after its verification: {finding} (verify again)"));
    }
    submission.manifest().entrant.check()?;
    let runs = Runs::read(&[submission.run_dir()])?;
    let figures = RunFigures::new(&runs, &runs.runs[0]);
    let by_elevation = &figures.splits[Split::Elevation as usize];
    let levels =
        by_elevation.iter().filter_map(|(name, f)| Some((*name, f.mean(Measure::Success)?.mean))).collect();
    let used = runs.runs[0].counted().filter_map(|row| row.fuel);
    let fuel = used.map(|f| f.max_fraction).reduce(f64::max);
    let worlds = runs.worlds.iter().cloned().zip(figures.worlds.iter().copied()).collect();
    let figures = figures.all;
    let holdout = match dir.join(HOLDOUT) {
        path if path.exists() => {
            let (scores, _): (Scores, _) = files::read_json(&path, SMALL, SCORES_SCHEMA, |_| Ok(()))?;
            let run = &submission.manifest().run;
            let own = [&run.plugin.sha256, &run.vehicle.name, &run.perception.name, &run.harness_version];
            let theirs =
                [&scores.plugin_sha256, &scores.vehicle, &scores.perception, &scores.harness_version];
            if own != theirs {
                let what = "another plugin, vehicle, perception profile or version of the harness";
                return fail(format!("{HOLDOUT} belongs to {what} (evaluate this submission)"));
            }
            Some(scores)
        }
        _ => None,
    };
    let mut manifest = submission.into_manifest();
    manifest.tasks.clear();
    manifest.files.clear();
    let verification = Verification { division: manifest.division, ..verification };
    Ok(Entry {
        id: id.to_owned(),
        dir: dir.to_owned(),
        manifest,
        verification,
        figures,
        levels,
        worlds,
        fuel,
        holdout,
    })
}
