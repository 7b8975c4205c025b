//! The tests of this crate, in one program.

#[path = "../common/mod.rs"]
mod common;
mod golden;
mod limits;
mod loading;
mod native;
mod real_planners;
mod sessions;
mod wasi;
