//! The data of version 0.1 of the planner interface, and the root module of native planners that were built for it.
//!
//! The harness hosts such planners as long as 0.1 is in its window (`docs/abi.md`). Nothing here changes any more.

pub mod native;
mod types;

pub use types::*;
