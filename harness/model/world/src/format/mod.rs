//! Suites on disk, schema version 1. `docs/worlds.md` describes the format for people.

mod documents;
mod elevation;
mod error;
mod suite;
mod text;
mod world_files;

pub use error::SuiteError;
pub(crate) use error::list;
pub use suite::{Georeference, Provenance, Suite, SuiteMeta, SuiteWriter, WorldInfo};

/// Reads a file of obstacles in the form of a world's `obstacles.yaml`.
///
/// # Errors
/// Returns an error if the file can't be read or isn't of that form. Whether the obstacles lie in a world is for
/// [`crate::World::check`] to say.
pub fn read_obstacles(file: &std::path::Path) -> Result<Vec<crate::Obstacle>, SuiteError> {
    let yaml = vb_files::read_text(file, vb_files::DOCUMENT).map_err(|source| SuiteError::Read {
        path: file.to_owned(),
        source,
        hint: "give a YAML file of obstacles",
    })?;
    text::parse::<documents::ObstaclesDocument>(file, &yaml)?
        .into_obstacles()
        .map_err(|flaw| SuiteError::invalid(file, flaw.field, flaw.problem))
}

/// The version of the format that this build writes and reads.
pub const SCHEMA: u32 = 1;
