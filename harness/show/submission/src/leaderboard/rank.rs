//! The order of entries, and which of them can't be told apart.

use vb_report::{Comparison, Difference, Estimate, Measure, Runs, Verdict};

use super::entries::Entry;
use crate::SubmissionError;
use crate::division::Division;
use crate::files::RUN;

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RankedBy {
    /// The entries are ranked by the results on the board's suite, which everybody has.
    Suite,
    /// The entries are ranked by the scores on the owner's hidden suite, which all entries have.
    Holdout,
}

/// Entries under the same conditions, best first.
#[derive(Clone, Debug)]
pub struct Board {
    pub division: Division,
    pub ranked_by: RankedBy,
    /// The entries, at least one.
    pub entries: Vec<Ranked>,
}

#[derive(Clone, Debug)]
pub struct Ranked {
    pub entry: Entry,
    /// One more than the number of entries above the first of this rank, which is worse for certain than the first of the rank
    /// above.
    pub rank: usize,
    /// Whether other entries share the rank.
    pub tied: bool,
    /// The success rate less that of the first entry of this rank, with its interval over worlds; `None` for that first
    /// entry itself.
    pub behind: Option<Estimate>,
}

/// What entries of a board have in common. Results of other conditions, or of another version of the harness, are not
/// comparable.
fn conditions(e: &Entry) -> [String; 11] {
    let (m, r) = (&e.manifest, &e.manifest.run);
    [
        m.division.name().to_owned(),
        r.suite.name.clone(),
        m.suite_version.clone(),
        r.suite.hash.clone(),
        r.vehicle.name.clone(),
        r.vehicle.hash.clone(),
        r.scale.to_string(),
        r.rules.hash.clone(),
        r.soils.hash.clone(),
        r.selector.clone().unwrap_or_default(),
        r.harness_version.clone(),
    ]
}

/// The boards: ranked before open ones, then by number of entries, suite, vehicle and what else differs.
pub(super) fn boards(mut entries: Vec<Entry>) -> Result<Vec<Board>, SubmissionError> {
    // A stable sort of what is sorted by names.
    entries.sort_by_cached_key(|e| (e.manifest.division, conditions(e)));
    let mut boards: Vec<Vec<Entry>> = Vec::new();
    for entry in entries {
        match boards.last_mut() {
            Some(board) if conditions(&board[0]) == conditions(&entry) => {
                let same = |other: &&Entry| {
                    let (a, b) = (&other.manifest.run, &entry.manifest.run);
                    (&a.plugin.sha256, &a.params, &a.limits, a.seed)
                        == (&b.plugin.sha256, &b.params, &b.limits, b.seed)
                };
                if let Some(other) = board.iter().find(same) {
                    let problem =
                        format!("the same plugin and conditions as entry {} (remove one of them)", other.id);
                    return Err(SubmissionError::Entry { dir: entry.dir, problem });
                }
                board.push(entry);
            }
            _ => boards.push(vec![entry]),
        }
    }
    // What most have entered comes first.
    boards.sort_by_key(|b| (b[0].manifest.division, std::cmp::Reverse(b.len())));
    boards.into_iter().map(board).collect()
}

fn board(mut entries: Vec<Entry>) -> Result<Board, SubmissionError> {
    let division = entries[0].manifest.division;
    let ranked_by = ranked_by(&entries);
    let value = |e: &Entry, m| match (ranked_by, &e.holdout) {
        (RankedBy::Holdout, Some(h)) if m == Measure::Success => h.success_percent,
        (RankedBy::Holdout, Some(h)) => h.time_mean_s.unwrap_or(f64::INFINITY),
        _ => e.figures.mean(m).map_or(f64::INFINITY, |e| e.mean),
    };
    entries.sort_by(|a, b| {
        let rate = |e| value(e, Measure::Success);
        rate(b)
            .total_cmp(&rate(a))
            .then(value(a, Measure::Time).total_cmp(&value(b, Measure::Time)))
            .then_with(|| a.id.cmp(&b.id))
    });
    let mut ranked: Vec<Ranked> = Vec::with_capacity(entries.len());
    let mut first = 0;
    for (k, entry) in entries.into_iter().enumerate() {
        let (behind, tied) = match (ranked.get(first), ranked_by) {
            (None, _) => (None, false),
            (Some(best), RankedBy::Holdout) => (None, overlap(&best.entry, &entry)),
            (Some(best), RankedBy::Suite) => {
                let d = difference(&best.entry, &entry)?;
                let apart = d.as_ref().and_then(|d| d.verdict).is_some_and(Verdict::is_certain);
                (d.and_then(|d| d.difference), !apart)
            }
        };
        if tied {
            ranked[first].tied = true;
            ranked.push(Ranked { entry, rank: first + 1, tied, behind });
        } else {
            first = k;
            ranked.push(Ranked { entry, rank: k + 1, tied, behind: None });
        }
    }
    Ok(Board { division, ranked_by, entries: ranked })
}

/// By the hidden suite if all have scores on the same one: public tasks can be learnt by heart.
fn ranked_by(entries: &[Entry]) -> RankedBy {
    let suite = |e: &Entry| e.holdout.as_ref().map(|h| (h.suite.clone(), h.suite_version.clone(), h.tasks));
    match suite(&entries[0]) {
        Some(first) if entries.iter().all(|e| suite(e).as_ref() == Some(&first)) => RankedBy::Holdout,
        _ => RankedBy::Suite,
    }
}

/// Whether the intervals of two entries on the hidden suite overlap. Nothing is known of single tasks there, so nothing can be
/// paired; without an interval nothing is known at all.
fn overlap(a: &Entry, b: &Entry) -> bool {
    let interval = |e: &Entry| e.holdout.as_ref().and_then(|h| h.success_interval_percent);
    match (interval(a), interval(b)) {
        (Some([a_low, a_high]), Some([b_low, b_high])) => a_low <= b_high && b_low <= a_high,
        _ => true,
    }
}

/// How much higher the success rate of `b` is, paired by tasks, with what the deciding test of reports says of it.
fn difference(a: &Entry, b: &Entry) -> Result<Option<Difference>, SubmissionError> {
    let runs = Runs::read(&[a.dir.join(RUN), b.dir.join(RUN)])?;
    let comparison = Comparison::new(&runs);
    Ok(comparison.and_then(|c| c.between(1, 0, Measure::Success)))
}
