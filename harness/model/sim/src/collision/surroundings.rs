//! What surrounds vehicles: a world, made ready for collisions.

use std::sync::Arc;

use rapier3d_f64::parry::shape::ConvexPolyhedron;
use rapier3d_f64::prelude::*;
use vb_world::{Obstacle, World};

use super::{Cuboid, extents, from_vector, points, rotation, vector};
use crate::granular::{self, Packings};
use crate::{Quat, V3};

/// A world with the convex bodies of its obstacles and the grains of its beds. To make them takes as long as some hundred steps of a
/// vehicle, and seconds where there are beds, so whoever drives in the same world again keeps them; a clone shares them.
#[derive(Clone)]
pub struct Surroundings {
    world: Arc<World>,
    solids: Arc<[Solid]>,
    packings: Packings,
}

/// One convex obstacle in place.
pub(super) struct Solid {
    pub(super) shape: Arc<ConvexPolyhedron>,
    pub(super) pose: Pose,
    pub(super) centre: V3,
    pub(super) bound: f64,
    /// The box around it along its own axes.
    pub(super) cuboid: Cuboid,
}

impl From<Arc<World>> for Surroundings {
    fn from(world: Arc<World>) -> Self {
        let solids = world.obstacles.iter().filter_map(|o| Solid::new(o, &world)).collect();
        let packings = granular::fill(&world);
        Self { world, solids, packings }
    }
}

impl Surroundings {
    #[must_use]
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The beds of the world as they were filled.
    pub(crate) fn packings(&self) -> &Packings {
        &self.packings
    }

    pub(super) fn solids(&self) -> &Arc<[Solid]> {
        &self.solids
    }
}

impl Solid {
    /// An obstacle of a world; none for one that has no volume.
    fn new(obstacle: &Obstacle, world: &World) -> Option<Self> {
        let turn = Quat::from_axis_angle(&V3::z_axis(), obstacle.yaw);
        let at = Vector::new(obstacle.x, obstacle.y, obstacle.base_z(&world.heightfield));
        let pose = Pose::from_parts(at, rotation(&turn));
        let hull = points(&obstacle.hull());
        let shape = Arc::new(ConvexPolyhedron::from_convex_hull(&hull)?);
        let middle = hull.iter().copied().sum::<Vector>() / hull.len() as f64;
        let bound = hull.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max);
        let (low, high) = extents(hull.iter().map(|p| from_vector(*p)));
        let cuboid = Cuboid {
            centre: from_vector(pose * vector(&(0.5 * (low + high)))),
            half: 0.5 * (high - low),
            axes: *turn.to_rotation_matrix().matrix(),
        };
        Some(Self { shape, pose, centre: from_vector(pose * middle), bound, cuboid })
    }
}
