//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod course;
mod data;
mod formats;
mod generate;
mod read;
mod sidecar;
mod survey;
mod tif;
