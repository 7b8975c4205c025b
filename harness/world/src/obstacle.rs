//! Convex obstacles that stand in the ground.

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum ObstacleKind {
    /// An irregular convex boulder inscribed in an ellipsoid-like hull; `seed` fixes its vertices.
    Boulder {
        /// Full extents along the obstacle's own x, y and z, m.
        size: [f64; 3],
        /// Chooses the vertices (see [`Obstacle::hull`]).
        seed: u64,
    },
    /// An upright box.
    Box {
        /// Full extents, m.
        size: [f64; 3],
    },
    /// A tree trunk: an upright cylinder, represented by a regular prism.
    Trunk {
        /// Trunk radius, m.
        radius: f64,
        /// Trunk length, m.
        height: f64,
    },
}

/// One obstacle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Obstacle {
    /// Position of the centre, m.
    pub x: f64,
    /// Position of the centre, m.
    pub y: f64,
    /// Heading of the obstacle's own x axis, rad.
    pub yaw: f64,
    /// How much of its height is below the ground at its centre, m (≥ 0).
    pub buried: f64,
    /// Its shape.
    #[serde(flatten)]
    pub kind: ObstacleKind,
}
