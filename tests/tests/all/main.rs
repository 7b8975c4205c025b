//! All tests of the built program, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod bad_input;
#[path = "../../../harness/model/sim/tests/all/bits.rs"]
mod bits;
mod check;
mod dataset;
mod determinism;
mod fail_fast;
mod figures;
mod films;
mod full_disk;
mod golden;
mod granular;
mod hybrid;
mod imported;
mod installed;
mod languages;
mod pages;
mod perception;
mod planners;
mod policies;
mod processes;
mod proof;
mod replays;
mod ros;
mod scoring;
mod shards;
mod shell;
mod sites;
mod streams;
mod submission;
mod submission_ci;
mod sweeps;
mod teleop;
mod vehicle;
mod vehicles;
