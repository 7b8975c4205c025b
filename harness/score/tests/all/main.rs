//! The tests of this crate, in one program.

mod runs;
mod trials;
