//! A navigation task: from a start to a goal along a global path.

/// A pose in the horizontal plane of the world frame.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose2 {
    /// The position along x (east), m.
    pub x: f64,
    /// The position along y (north), m.
    pub y: f64,
    /// The heading, rad, counter-clockwise from x.
    pub yaw: f64,
}

/// One task of a world.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// The name of the task within the world, e.g. `t03`.
    pub id: String,
    /// The pose at which the vehicle starts, at rest.
    pub start: Pose2,
    /// The point (x, y) to which the vehicle must go, m.
    pub goal: [f64; 2],
    /// The global path from the start to the goal, as waypoints (x, y), m.
    pub path: Vec<[f64; 2]>,
}
