//! Makes suites: the seeded generator, the global planner, beds for trials of one task, the import of the original's data
//! and of surveys of real places. `vb-suite-report` tells what a suite is like.

pub mod generate;
pub mod import;
pub mod path;
pub mod rules;
pub mod site;
mod surface;
pub mod testbed;
