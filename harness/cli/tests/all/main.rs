//! The tests of this crate, in one program.

mod commands;
mod common;
mod terrain;
