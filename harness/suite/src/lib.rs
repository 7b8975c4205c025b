//! Makes suites – the seeded generator, the global planner, beds for trials of one task, the import of the original data
//! and of surveys of real places –, measures them, draws them as a page, and checks whether they are fit to be driven.

pub mod album;
mod clearance;
pub mod generate;
pub mod import;
pub mod path;
pub mod proof;
pub mod rules;
pub mod site;
pub mod statistics;
mod surface;
pub mod testbed;
pub mod validate;
