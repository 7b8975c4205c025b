//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod beds;
mod model;
mod selector;
mod suite_on_disk;
