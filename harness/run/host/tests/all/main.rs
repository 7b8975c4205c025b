//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

#[path = "../common/mod.rs"]
mod common;
mod golden;
mod limits;
mod loading;
mod native;
mod real_planners;
mod sessions;
mod wasi;
