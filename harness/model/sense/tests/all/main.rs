//! The tests of this crate, in one program.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;
mod docs;
mod facade;
mod images;
mod inertial;
mod local_map;
mod noise;
mod prior;
mod profiles;
mod rays;
mod ruts;
mod scans;
mod vehicle;
