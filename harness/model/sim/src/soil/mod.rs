//! Deformable terrain: pressure over sinkage, Janosi and Hanamoto's shear, slip sinkage, and a memory of ruts.
//!
//! A wheel meets soil along stations that are fixed to the wheel: a few strips across its width, with positions along
//! its heading that lie close together under the axle (`Footprint`). At each station the soil has a state, which is
//! how deep it was pressed, how much it is heaped up and how far it has been sheared. As the wheel moves over the
//! ground, the states move through the footprint; they enter at its edge from the memory of the ground (`Grid`) and
//! leave to it at the opposite edge. So the forces are smooth whatever the grid's resolution, which only says how finely
//! ruts are remembered for other wheels and later passes. Chrono's soil contact model instead keeps states and takes
//! forces at the nodes of the grid, whose coming and going shakes the vehicle.

mod footprint;
mod grid;
mod ground;
mod law;
mod rig;
mod set;
mod shear;
mod sinkage;
mod slip;
mod table;

pub(crate) use footprint::{Footprint, TRACK, WHEEL};
pub(crate) use ground::{SoilGround, Under};
pub use law::{Bulldozing, PressureDirection, SoilLaw};
pub use rig::{WheelBehaviour, WheelRig};
pub use set::{Classes, Levels, SoilSet, Soils};
pub use shear::Shear;
pub use sinkage::*;
pub use slip::SlipSinkage;
