//! Elementary functions that give the same bits natively and as WASM, and angle helpers.
//!
//! `f64::sin` and its kin call the platform's own library, whose last bits differ; these come from the `libm`
//! crate, compiled into the planner.

pub use vb_math::angle::{turn, wrap};
pub use vb_math::{acos, asin, atan, atan2, cos, exp, hypot, ln, pow, sin, sin_cos, tan, tanh};
