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
//!
//! # Choice of transport
//!
//! | property | `ros2-client` 0.12.1, RustDDS 0.15.1 | `hiroz` 0.2.1, Zenoh 1.10 |
//! |---|---|---|
//! | interoperates with | Fast DDS, Cyclone DDS and other DDS middlewares: those that ROS 2 installs by default | `rmw_zenoh` alone, which users must install and choose; needs a router |
//! | evidence | results of OMG's test suite against 9 other implementations in the package; tests of this repository against Cyclone DDS | tests of the project |
//! | asynchronous runtime | none (mio) | tokio, which this workspace bans |
//! | licence | Apache-2.0 | Apache-2.0 or MIT; Zenoh EPL-2.0 or Apache-2.0 |
//! | oldest compiler | 1.88 | not stated |
//! | crates; new crates in this workspace (Linux) | 101; 54 | 386; 274 |
//! | processor time of a release build with all dependencies | 170 s | not measured |
//! | services | yes, in both mappings of ROS 2 | yes |
//!
//! Users of Nav2 have Fast DDS or Cyclone DDS unless they changed the default, so DDS decides. `ros2-client` is preferred to RustDDS
//! alone since it makes the harness visible to `ros2 node list` and has the mappings of services. RustDDS has no setting for the user
//! data in which DDS middlewares announce type hashes, so `ros2 topic info --verbose` shows none.

mod actuator;
mod link;
mod options;
mod session;
mod tick;

pub use actuator::{Actuator, Setpoint};
pub use options::{LAST_DOMAIN, Options, OptionsError, Pace};
pub use session::plugin;
