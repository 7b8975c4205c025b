//! Results that others can verify: submissions, their verification, leaderboards.
//!
//! [`make`] turns a finished run into a *submission*, a small folder with a [`Manifest`]. [`verify`] holds it against
//! suite, plugin, vehicle and soils, computes everything again that can be computed, drives a sample of the tasks again, and
//! tells each difference as a [`Finding`]. [`leaderboard::build`] makes a site of verified submissions. [`Scores`] is all
//! that an evaluation on a hidden suite tells.
//!
//! A submission comes from strangers: sizes are bounded, links are refused, texts reach pages as text only, and nothing of it
//! is executed but the plugin, by the host.

mod check;
mod division;
mod error;
mod files;
pub mod leaderboard;
mod make;
mod manifest;
mod rerun;
mod sample;
mod scores;
mod verdict;

pub use check::{Expected, Submission};
pub use division::{Division, OpenReason, Shipped, ShippedSuite, ShippedVehicle};
pub use error::SubmissionError;
pub use files::sha256_file;
pub use make::{Request, check_replays, make};
pub use manifest::{Entrant, Manifest, SUBMISSION_SCHEMA, TaskEntry};
pub use rerun::{Sampling, verify};
pub use scores::{SCORES_SCHEMA, Scores};
pub use verdict::{Check, Finding, SampleTaken, VERIFICATION_SCHEMA, Verification};
