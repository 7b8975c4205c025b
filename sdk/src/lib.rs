//! What a planner author needs: the planner trait, its data, and helpers.

mod types;

pub use types::*;
