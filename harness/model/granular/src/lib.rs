//! Beds of grains: a bin with a floor and four walls that is filled with spheres, and bodies (*tools*: wheels, plates, hulls) that move
//! among them.
//!
//! Grains are a discrete element model (Cundall and Strack 1979): each contact is a spring and damper with friction and rolling
//! resistance (`contact`), and steps are short enough to resolve it. rapier's solver of contacts isn't used: it
//! lacks rolling resistance, and under bodies much heavier than a grain its results depend on the step (docs/granular.md).
//!
//! # Coupling
//!
//! A tool belongs to somebody else, who integrates its motion. In a step of the bed it moves with the velocities that its owner gives
//! ([`Motion`]), while the grains make several sub-steps; the impulses on it, equal and opposite to those on the grains, come back as
//! [`Reaction`], and its owner applies them over the same step.
//!
//! The scheme is explicit. It is stable while the springs of all grains at a tool, `n k`, don't turn a tool of mass `m` round within a
//! step `T`: `T² n k < m`. Twenty grains of 3e5 N/m under a wheel of 90 kg allow 3.9 ms. Sub-steps are a fifteenth of the duration of
//! contact of the smallest grains, π √(m/2k).
//!
//! Grains at rest that are far from all tools are left out of the computation until a tool comes near ([`Settings::reach`]).
//!
//! World axes: z up; the floor is z = 0. Units are SI. All results are functions of the arguments, bit for bit.

mod bed;
mod contact;
mod material;
mod neighbours;
mod packing;
pub mod rig;
mod tool;
mod walls;

pub use bed::{Bed, Settings};
pub use material::MaterialFile;
pub use packing::{Bin, Grain, Packing, PackingError};
pub use tool::{Motion, Reaction, Shape, Tool};

pub use vb_world::GRAVITY;

type V3 = nalgebra::Vector3<f64>;
type Quat = nalgebra::UnitQuaternion<f64>;
