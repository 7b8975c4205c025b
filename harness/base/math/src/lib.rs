//! Deterministic mathematics: libm functions, angles, seeded random streams, best-first search.
//!
//! Everything that can reach a score computes its elementary functions here, so that the same inputs give the
//! same bits on every machine. `+ - * /` and `sqrt` are exact by IEEE 754 and need no wrapper.

pub mod angle;
mod elementary;
pub mod fft;
pub mod rng;
pub mod search;

pub use elementary::*;
