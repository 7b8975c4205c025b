//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;
mod leaderboard;
mod make;
mod size;
mod tamper;
