//! Replays of a program that is built without them.

use std::collections::BTreeSet;
use std::path::Path;

use vb_report::Runs;
use vb_world::TaskId;

use crate::args::ReplayData;
use crate::error::CliError;

/// Refuses to write replays.
pub(crate) fn pages(
    _: &Runs,
    _: &ReplayData,
    _: &BTreeSet<TaskId>,
    _: &str,
    _: &Path,
    _: (&Path, &str),
) -> Result<BTreeSet<TaskId>, CliError> {
    Err(CliError::usage(crate::missing("replays", "replay")))
}
