//! Planners that are nodes of ROS 2.
//!
//! [`plugin`] makes a planner of [`Options`] that the runner treats like any other. For each task it publishes sensors, maps, path, goal
//! and `/clock` over DDS, and takes commands from `/cmd_vel`, `/ackermann_cmd` and `/gear`; neither side needs an installation of ROS.
//! `docs/ros2.md` describes topics, lockstep and faults.
//!
//! - [`Options`] are the user's choices;
//! - `link` is the node: its endpoints, and the nodes discovered in the network;
//! - `tick` makes the messages of a task and of an observation;
//! - `session` is the lockstep, or the real-time mode, with one fault for each thing that can go wrong;
//! - [`Actuator`] turns commanded velocities into steering, throttle, brake and gear.

mod actuator;
mod link;
mod options;
mod session;
mod tick;

pub use actuator::{Actuator, Setpoint};
pub use options::{LAST_DOMAIN, Options, OptionsError, Pace};
pub use session::plugin;
