//! What can be said about planners from a finite suite: intervals and paired tests.
//!
//! Ten tasks share a world, and a world that is hard for one task is hard for the others: tasks are not independent.
//! Intervals are therefore by a bootstrap that draws whole worlds, and tests of figures take a world as one observation.
//! Everything is a function of its arguments, with random streams named by seed and purpose.

mod bootstrap;
mod holm;
mod mcnemar;
mod normal;
mod profile;
mod wilcoxon;

pub use bootstrap::{Interval, Ratio, bootstrap, bootstrap_ratio};
pub use holm::holm;
pub use mcnemar::mcnemar;
pub use normal::{normal_cdf, normal_quantile};
pub use profile::{Profile, profiles};
pub use vb_score::wilson;
pub use wilcoxon::{SignedRank, wilcoxon};
