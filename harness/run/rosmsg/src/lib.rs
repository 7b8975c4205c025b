//! Messages of ROS 2, without a ROS installation.
//!
//! [`messages`] has a type for each definition in the folder `msg`, with its name, its text and its type hash; it is generated from them
//! (`cargo run --package vb-rosmsg --example generate`). [`to_cdr`] and [`from_cdr`] are the encoding of messages in bags and on DDS.
//! [`convert`] makes messages of what planners receive.

mod array;
mod cdr;
pub mod convert;
pub mod idl;
#[rustfmt::skip]
pub mod messages;
pub mod urdf;

pub use array::Array;
pub use cdr::{CdrError, from_cdr, to_cdr};

/// A type of the folder `msg`.
pub trait Message: serde::Serialize + serde::de::DeserializeOwned {
    /// The name of the package, e.g. `geometry_msgs`.
    const PACKAGE: &str;
    /// The name of the type within its package, e.g. `Twist`.
    const TYPE: &str;
    /// The full name, e.g. `geometry_msgs/msg/Twist`.
    const NAME: &str;
    /// The type hash of REP 2016, `RIHS01_` and 64 hexadecimal digits.
    const HASH: &str;
    /// The definition with those of all types that it names, as MCAP files have it (encoding `ros2msg`).
    const DEFINITION: &str;
}
