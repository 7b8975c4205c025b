//! Promises on planners that are nodes of ROS 2, over loopback.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod faults;
mod interop;
mod lockstep;
mod peer;
mod records;
