//! Bags of ROS 2 as recordings: odometry, wheel speeds or velocity commands, and an inertial sensor, as the table of wheel speeds and poses
//! that `vehicle compare` replays.
//!
//! [`read`] reads a bag into a [`Bag`], topic by topic; [`Bag::drive`] selects the topics and cuts the drive into windows of equal duration
//! without gaps; [`Drive::csv`] is the table. Bags are untrusted: record sizes and numbers of messages are bounded, and messages with
//! numbers that are not finite are skipped and counted.

#![deny(missing_docs)]

mod drive;
mod error;
mod file;
mod topic;

pub use drive::{Drive, Selection, Wheels};
pub use error::BagError;
pub use file::read;
pub use topic::Bag;
