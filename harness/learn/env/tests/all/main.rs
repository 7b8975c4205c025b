//! What environments promise.

mod common;
mod curriculum;
mod episodes;
mod options;
mod vector;
