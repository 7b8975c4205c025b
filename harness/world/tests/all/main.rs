//! The tests of this crate, in one program.

mod model;
mod selector;
mod suite_on_disk;
