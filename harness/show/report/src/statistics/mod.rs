//! What can be said about planners from a finite suite: intervals and paired tests.
//!
//! Ten tasks share a world, and a world that is hard for one task is hard for the others: tasks are not independent.
//! Intervals are therefore by a bootstrap that draws whole worlds (`vb_score`), and the test that decides flips the signs of whole
//! worlds ([`sign_flip`]).
//! Everything is a function of its arguments, with random streams named by seed and purpose.

mod holm;
mod mcnemar;
mod profile;
mod sign_flip;
mod wilcoxon;

pub use holm::holm;
pub use mcnemar::mcnemar;
pub use profile::{Profile, profiles};
pub use sign_flip::{SignFlip, least_p, sign_flip, worlds_needed};
pub use vb_score::{
    Interval, Ratio, bootstrap, bootstrap_ratio, normal_cdf, normal_quantile, success_interval, wilson,
};
pub use wilcoxon::{SignedRank, wilcoxon};
