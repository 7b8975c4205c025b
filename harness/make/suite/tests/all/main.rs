//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;
mod generate;
mod import;
mod path;
mod site;
mod testbed;
