//! What the planners with learned models share.
//!
//! - [`Terrain`] tells how the ground lies under a vehicle: the plane through its wheels, and the patch about it.
//! - [`Table`] holds what a network makes of the patch at every place and heading, made once in `init`: the ground doesn't change,
//!   so that roll-outs only look up.
//! - [`Kinodynamics`] moves the vehicle in six degrees of freedom: a bicycle on the plane through its wheels, and what a network
//!   has learned that these two get wrong.
//! - [`Objective`] is what a course costs.
//!
//! Lengths are measured in wheelbases and times by Froude's rule, so that a model serves a vehicle class at any scale.
//! `tools/model-train` trains with the very functions that the planners roll out.

mod kinodynamics;
mod objective;
mod planner;
mod table;
mod terrain;
mod traversability;

pub use kinodynamics::{
    DT, HAZARDS, INPUTS, Kinodynamics, Learned, OUTPUTS, SCALES, SOON, State, Units, probability,
};
pub use objective::{Objective, Weights};
pub use planner::{Aim, Hybrid};
pub use table::{CHANNELS, HEADINGS, Table, around, heading, heading_of};
pub use terrain::{CLASSES, PATCH, Terrain};
pub use traversability::{Prices, Values, costs};
