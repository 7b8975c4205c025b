//! Makes suites: the seeded generator, the global planner, beds for trials of one task, granular beds, the import of the original's data
//! and of surveys of real places. And tells what a suite is like: measures it ([`statistics`]), draws it as a page with
//! a map of every world ([`album`]), checks whether it can be driven ([`validate`]), and keeps who has solved which task ([`proof`]).

pub mod album;
mod clearance;
pub mod generate;
pub mod granular;
#[cfg(feature = "site")]
pub mod import;
pub mod level;
pub mod path;
pub mod proof;
pub mod rules;
#[cfg(feature = "site")]
pub mod site;
pub mod statistics;
mod surface;
pub mod testbed;
pub mod validate;
