//! The tests of this crate, in one program.

mod common;
mod generate;
mod import;
mod path;
mod site;
mod testbed;
