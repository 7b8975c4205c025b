//! Suspension and steering as data.

use super::Point;
use serde::{Deserialize, Serialize};

/// How a wheel is guided and sprung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Suspension {
    /// Two wishbones and a tie rod of fixed length, ideal joints, massless links; the strut acts on the upright.
    DoubleWishbone {
        /// Where the joints are.
        hardpoints: Hardpoints,
        /// Along the strut.
        spring: Spring,
        /// Along the strut.
        damper: Damper,
        /// At the ends of the travel.
        stops: Stops,
    },
}

/// Joints of a double wishbone: left side, at design height, relative to the axle's reference point, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct Hardpoints {
    pub spindle: Point,
    pub upper_arm_front: Point,
    pub upper_arm_rear: Point,
    pub upper_ball_joint: Point,
    pub lower_arm_front: Point,
    pub lower_arm_rear: Point,
    pub lower_ball_joint: Point,
    pub strut_chassis: Point,
    pub strut_upright: Point,
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// A linear spring: force = stiffness · (free length − length), in tension too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// N/m.
    pub stiffness: f64,
    /// m.
    pub free_length: f64,
}

/// A linear damper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Damper {
    /// N s/m.
    pub coefficient: f64,
}

/// Linear stops that act on the wheel beyond these travels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stops {
    /// Compression at which the upper stop is met, m, > 0.
    pub jounce: f64,
    /// Travel at which the lower stop is met, m, < 0.
    pub rebound: f64,
    /// N/m at the wheel.
    pub stiffness: f64,
}

/// A rack that moves the inner tie-rod joints of steered axles sideways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steering {
    /// Travel to the right at command +1, m.
    pub rack_travel: f64,
    /// Greatest rate of the command, 1/s.
    pub rate: f64,
}
