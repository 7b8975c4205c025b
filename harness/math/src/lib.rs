//! Deterministic mathematics: libm functions, angles, seeded random streams.
//!
//! Everything that can reach a score computes its elementary functions here, so that the same inputs give the
//! same bits on every machine. `+ - * /` and `sqrt` are exact by IEEE 754 and need no wrapper.

pub mod angle;
mod elementary;
mod fast;
pub mod rng;

pub use elementary::*;
pub use fast::{fast_exp, fast_pow};
