//! The tests of this crate, in one program.

mod common;
mod leaderboard;
mod make;
mod tamper;
