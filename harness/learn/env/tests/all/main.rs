//! What environments promise.

mod common;
mod curricula;
mod curriculum;
mod episodes;
mod options;
mod vector;
