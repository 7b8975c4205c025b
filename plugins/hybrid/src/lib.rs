//! Components shared by the planners with learned models.
//!
//! - [`Terrain`] samples the terrain under a vehicle: the plane through its wheels, and the patch around it.
//! - [`Table`] contains the network's features of the patch at every position and heading, computed once in `init`: the
//!   terrain is static, so rollouts only look up.
//! - [`Attention`] looks up the features of positions ahead in the same table.
//! - [`Kinodynamics`] predicts motion in six degrees of freedom: a bicycle on the plane through its wheels, plus
//!   learned corrections.
//! - [`costs`] and [`Values`] are the traversability map and the cost-to-go over it; [`descend`] follows its descent.
//! - [`Objective`] is the cost of a rollout.
//!
//! Lengths are normalised by the wheelbase and times by Froude scaling, so that one model serves all scales of a
//! vehicle class. `tools/model-train` trains with the functions that the planners roll out.

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
