//! Suites on disk, schema version 1. `docs/worlds.md` describes the format for people.

mod documents;
mod elevation;
mod error;
mod suite;
mod text;
mod world_files;

pub use error::SuiteError;
pub(crate) use error::list;
pub use suite::{Provenance, Suite, SuiteMeta, SuiteWriter, WorldInfo};

/// The version of the format that this build writes and reads.
pub const SCHEMA: u32 = 1;
