//! Submissions, as the owner of a leaderboard takes them from strangers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use vb_report::Runs;
use vb_submission::{Submission, SubmissionError, leaderboard};
use vb_world::{Suite, TaskId};

use crate::site::Site;

/// The entry's folder below the one that a leaderboard is built of.
const ENTRY: &str = "entries/pid";

/// A submission of one task on a suite of one world; its report is a stand-in.
const FILES: [(&str, &[u8]); 7] = [
    ("submission.json", include_bytes!("../seeds/submission/submission.json")),
    ("verification.json", include_bytes!("../seeds/submission/verification.json")),
    ("report.html", include_bytes!("../seeds/submission/report.html")),
    ("run/run.json", include_bytes!("../seeds/submission/run/run.json")),
    ("run/summary.json", include_bytes!("../seeds/submission/run/summary.json")),
    ("run/tasks.jsonl", include_bytes!("../seeds/submission/run/tasks.jsonl")),
    ("run/traces/w001/t00.parquet", include_bytes!("../seeds/submission/run/traces/w001/t00.parquet")),
];

fn site() -> Site {
    let files = FILES.map(|(name, bytes)| (PathBuf::from(ENTRY).join(name), bytes.to_vec()));
    Site::new().with(files.to_vec())
}

/// Where no suite is at hand.
struct NoSuite;

impl leaderboard::Source for NoSuite {
    fn suite(&mut self, _: &leaderboard::Entry, _: &Runs) -> Option<Suite> {
        None
    }

    fn replays(
        &mut self,
        _: &leaderboard::Entry,
        _: &Runs,
        _: &Path,
    ) -> Result<BTreeSet<TaskId>, SubmissionError> {
        Ok(BTreeSet::new())
    }
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            if let Ok(submission) = Submission::open(&dir.join(ENTRY)) {
                let manifest = submission.manifest();
                let _ = (manifest.rules(), manifest.limits(), manifest.entrant.check());
            }
            let out = dir.join("site");
            let _ = leaderboard::build(&dir.join("entries"), &out, "t", &mut NoSuite);
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The seed is a submission as the program wrote it, but for the report, which is a stand-in.
    #[test]
    fn a_submission_is_listed_on_a_leaderboard() {
        let site = site();
        let dir = site.path();
        let built = leaderboard::build(&dir.join("entries"), &dir.join("site"), "t", &mut NoSuite);
        let boards = built.expect("a site").boards;
        assert_eq!(boards.len(), 1);
        assert_eq!(boards[0].entries.len(), 1);
    }
}
