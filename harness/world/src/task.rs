//! A navigation task: from a start to a goal along a global path.

/// A planar pose.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose2 {
    /// m.
    pub x: f64,
    /// m.
    pub y: f64,
    /// Heading, rad, counter-clockwise from x.
    pub yaw: f64,
}

/// One task of a world.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Name within the world, e.g. `t03`.
    pub id: String,
    /// Where the vehicle stands, at rest.
    pub start: Pose2,
    /// Where it must go, (x, y), m.
    pub goal: [f64; 2],
    /// The global path from start to goal, (x, y) waypoints, m.
    pub path: Vec<[f64; 2]>,
}
