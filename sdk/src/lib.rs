//! SDK for planner authors: the planner trait, its data types, and helpers.
//!
//! A planner implements [`Planner`] and is exported with [`export_planner!`]. The same source builds both kinds of
//! plugin: a WebAssembly module (`cargo build --release --target wasm32-unknown-unknown`) and a native library
//! (`cargo build --release`). `docs/writing-a-planner.md` is a tutorial.
//!
//! Units are SI, and angles are in radians. The world frame has its origin at the world's centre, x east, y north and z
//! up. The body frame (ISO 8855) has x forward, y left and z up.
//!
//! A planner must return bit-identical commands as WASM and natively. `+ - * /` and `sqrt` are exact (IEEE 754); all
//! other functions (`sin`, `exp`, …) must come from [`math`], because the standard library calls the platform's
//! functions.

#![deny(missing_docs)]

#[cfg(feature = "serde")]
mod bytes;
#[cfg(not(target_family = "wasm"))]
pub mod c;
pub mod crop;
mod export;
pub mod fault;
pub mod log;
pub mod map;
pub mod math;
pub mod metadata;
pub mod mppi;
#[cfg(not(target_family = "wasm"))]
pub mod native;
pub mod nn;
pub mod path;
mod planner;
pub mod policy;
pub mod recovery;
pub mod rng;
pub mod search;
pub mod sensors;
pub mod speed;
#[rustfmt::skip]
mod types;
#[cfg(target_family = "wasm")]
#[doc(hidden)]
pub mod wasm;

pub use log::{LogLevel, log};
pub use planner::{Planner, PlannerError};
pub use types::*;

/// The version of the planner interface in this SDK: major.minor of the package `vertibench:planner`.
pub const ABI_VERSION: &str = "1.0";

// Items that `export_planner!` uses in the planner's crate.
#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub use abi_stable as __abi_stable;
