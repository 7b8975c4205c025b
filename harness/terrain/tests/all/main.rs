//! The tests of this crate, in one program.

mod data;
mod generate;
mod read;
