//! The site of a leaderboard, made of verified submissions.
//!
//! Of an entry the figures are kept, not its tasks; records are read for two entries at a time. So the number of entries and
//! the size of suites don't matter for memory.

mod data;
mod entries;
mod entry_page;
mod index_page;
mod rank;
mod worlds;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use vb_report::{Beside, Report, Runs};
use vb_world::{Suite, TaskId};

pub use data::LEADERBOARD_SCHEMA;
pub use entries::Entry;
pub use rank::{Board, Ranked};
use worlds::{Maps, Painter};

use crate::SubmissionError;
use crate::files::{self, MANIFEST, RUN, VERDICT};

/// The machine-readable leaderboard.
pub const DATA: &str = "leaderboard.json";
/// Folder of the entries' pages.
const ENTRIES: &str = "entries";
/// The name of an entry's report in the entry's folder. Its replays are in the folder `replays` beside it.
pub const REPORT: &str = files::REPORT;

/// What a site is made of beside submissions. It isn't asked for entries on a hidden suite.
pub trait Source {
    /// The suite of an entry, if its worlds are at hand. The run is that of the entry, read from its folder.
    fn suite(&mut self, entry: &Entry, runs: &Runs) -> Option<Suite>;

    /// Makes pages of replays of an entry's run into a folder, as `WORLD/TASK.html`, and returns the tasks that it made pages of.
    ///
    /// # Errors
    /// Returns an error if no site can be made because of it; what just can't be shown is left out.
    fn replays(
        &mut self,
        entry: &Entry,
        runs: &Runs,
        out: &Path,
    ) -> Result<BTreeSet<TaskId>, SubmissionError>;
}

#[derive(Clone, Debug)]
pub struct Site {
    /// The boards, each with its entries in order.
    pub boards: Vec<Board>,
    /// The files of the front page, for messages.
    pub files: Vec<PathBuf>,
}

/// Builds the site of the submissions in `dir`, which has a folder for each, in `out`. That must be empty or hold such
/// a site, which is replaced. `title` is the name of the site. Of entries on a suite on which an entry has scores of an evaluation
/// there are neither maps nor replays: the suite is hidden, and its worlds stay so.
///
/// # Errors
/// Returns an error if a folder holds no verified submission, a plugin was submitted twice under the same conditions,
/// or something can't be read or written. Nothing is written before all entries were looked at.
pub fn build(dir: &Path, out: &Path, title: &str, source: &mut dyn Source) -> Result<Site, SubmissionError> {
    let entries = entries::read(dir)?;
    let boards = rank::boards(entries)?;
    clear(out)?;
    let hidden = worlds::hidden(&boards);
    let mut painter = Painter::new(out, title);
    for board in &boards {
        for ranked in &board.entries {
            let entry = &ranked.entry;
            let own = out.join(ENTRIES).join(&entry.id);
            let runs = Runs::read(&[entry.dir.join(RUN)])?;
            let secret = hidden.contains(&entry.manifest.run.suite.name);
            let replays = match secret {
                true => BTreeSet::new(),
                false => source.replays(entry, &runs, &own.join("replays"))?,
            };
            let suite = if secret { None } else { source.suite(entry, &runs) };
            let report = Report::new(runs);
            let maps = match &suite {
                _ if secret => Maps::Hidden,
                Some(suite) => painter.maps(entry, suite, &report, &replays, &own)?,
                None => Maps::Missing,
            };
            // Where the submission lies is the owner's affair.
            let report = report.placed(Path::new(RUN));
            // Never the entrant's own page: it is made anew of his records.
            let beside = Beside { replays: replays.clone(), maps: maps.names(), files: Vec::new() };
            files::write(&own.join(REPORT), report.page(&beside).as_bytes())?;
            for name in [MANIFEST, VERDICT] {
                files::write(&own.join(name), &files::read(&entry.dir.join(name), files::DOCUMENT)?)?;
            }
            let page = entry_page::page(title, board, ranked, &replays, &maps);
            files::write(&own.join("index.html"), page.as_bytes())?;
        }
    }
    let index = out.join("index.html");
    files::write(&index, index_page::page(title, &boards).as_bytes())?;
    // Last: a site that has it is whole.
    let data = out.join(DATA);
    files::write(&data, &files::pretty(&data, &data::document(title, &boards))?)?;
    Ok(Site { boards, files: vec![index, data] })
}

/// Makes room in a folder that is empty or holds an earlier site.
fn clear(out: &Path) -> Result<(), SubmissionError> {
    fs::create_dir_all(out).map_err(SubmissionError::write(out))?;
    let entries = out.join(ENTRIES);
    let data = out.join(DATA);
    if !data.is_file() {
        return files::empty_dir(out);
    }
    if entries.exists() {
        fs::remove_dir_all(&entries).map_err(SubmissionError::write(&entries))?;
    }
    worlds::clear(out)
}
