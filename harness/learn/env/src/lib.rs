//! Environments: tasks that are driven step by step from outside, as reinforcement learning does.
//!
//! An [`Arena`] holds what environments of one kind share: the tasks, the vehicle, what is observed, what an action means,
//! what a step is worth. An [`Env`] drives one episode after another in it, and a [`VectorEnv`] many at a time on several
//! threads. Observations and actions are those of [`vb_sdk::policy`], so that a policy drives as a plugin as it does here, and
//! episodes are those of [`vb_trial::Episode`], so that its records are those of the benchmark, bit for bit.
//!
//! Everything that is random follows from the seed of [`Env::reset`]: the tasks, and the noise of the sensors. Which thread
//! steps an environment changes nothing.

#![deny(missing_docs)]

mod arena;
pub mod curriculum;
mod drive_log;
mod env;
mod error;
mod output;
mod recall;
mod reward;
mod rows;
mod vector;

pub use arena::{Arena, Options};
pub use env::{Env, Reset, Snapshot, Step};
pub use error::{EnvError, guarded};
pub use output::{Output, Pointer};
pub use recall::{Column, Frame};
pub use reward::{Reward, TERMS, Term, Terms};
pub use vb_render::{Size, View};
pub use vector::{Arrival, Autoreset, VectorEnv};
