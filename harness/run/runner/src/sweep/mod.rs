//! Many runs as one plan: each planner with each of its parameters, on each vehicle, under each perception profile, with each seed.
//!
//! [`Spec`] is the plan as data; [`Spec::runs`] are its runs, with names that stay the same when values are added. [`Layout`] says
//! where they lie, and [`Layout::state`] how far each is.

mod layout;
mod name;
mod spec;

pub use layout::{Layout, RunState};
pub use spec::{PlannedRun, Spec};
