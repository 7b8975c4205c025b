//! What the planners with learned models share.
//!
//! - [`Terrain`] tells how the ground lies under a vehicle: the plane through its wheels, and the patch about it.
//! - [`Table`] holds what a network makes of the patch at every place and heading, made once in `init`: the ground doesn't change,
//!   so that roll-outs only look up.
//! - [`Attention`] looks at places ahead in the same table.
//! - [`Kinodynamics`] moves the vehicle in six degrees of freedom: a bicycle on the plane through its wheels, and what a network
//!   has learned that these two get wrong.
//! - [`costs`] and [`Values`] are the map of traversability and the cost of the way to the goal over it; [`descend`] is where they
//!   lead.
//! - [`Objective`] is what a course costs.
//!
//! Lengths are measured in wheelbases and times by Froude's rule, so that a model serves a vehicle class at any scale.
//! `tools/model-train` trains with the very functions that the planners roll out.

mod attention;
mod explanation;
mod export;
mod guide;
mod kinodynamics;
mod models;
mod objective;
mod planner;
mod sight;
mod table;
mod terrain;
mod traversability;

pub use attention::{Attention, PLACES, place};
pub use guide::descend;
pub use kinodynamics::{
    ACCELERATION, DT, HAZARDS, Kinodynamics, LAG, Learned, OUTPUTS, SCALES, SLIP_KEPT, SLIP_LIMIT, SOON,
    State, TOLD, Units, probability, slip,
};
pub use models::{ATTENTION_MODELS, PATCH_MODELS};
pub use objective::{Objective, Weights, beyond};
pub use planner::{Aim, Hybrid, Place, Prediction};
pub use sight::{SEEN, Sight};
pub use table::{CHANNELS, HEADINGS, Table, heading, heading_of};
pub use terrain::{PATCH, Terrain};
pub use traversability::{Prices, Values, costs};
