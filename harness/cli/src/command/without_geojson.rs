//! Trajectories as GeoJSON, of a program that is built without coordinate systems.

use std::path::Path;

use vb_report::Report;

use crate::error::CliError;

/// Refuses to write them.
pub(crate) fn write(_: &Report, _: Option<&Path>, _: &Path) -> Result<(), CliError> {
    Err(CliError::usage(crate::missing("GeoJSON files", "terrain")))
}
