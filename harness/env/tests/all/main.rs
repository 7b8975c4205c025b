//! What environments promise.

mod common;
mod episodes;
mod options;
mod vector;
