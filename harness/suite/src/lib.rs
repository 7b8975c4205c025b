//! Makes suites: the seeded generator, the global planner, the import of the original data and of
//! surveys of real places.

pub mod generate;
pub mod import;
pub mod path;
pub mod site;
