//! Elementary functions with identical bits natively and as WASM, and angle helpers.
//!
//! `f64::sin` and similar functions call the platform's library, whose last bits differ; these functions come from the
//! `libm` crate, compiled into the planner.

pub use vb_math::angle::{turn, wrap};
pub use vb_math::{acos, asin, atan, atan2, cos, exp, hypot, ln, pow, sin, sin_cos, tan, tanh};
