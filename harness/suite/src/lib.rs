//! Makes suites: the seeded generator, the global planner, the import of the original data.

pub mod generate;
pub mod import;
pub mod path;
