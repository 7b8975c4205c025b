//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod bits;
mod canonical;
#[path = "../common/mod.rs"]
mod common;
mod granular;
mod linkages;
mod mutations;
mod reverse;
mod robust;
mod rugged;
mod soil;
mod test_stand;
mod tracks;
mod tyres;
mod vehicles;
