//! How far the hull is from the ground, at least: what spares rapier the triangles, and whole steps, that are out of reach.

use rapier3d_f64::geometry::{ContactData, ContactManifoldData};
use rapier3d_f64::parry::math::{Pose, Real, Vector};
use rapier3d_f64::parry::query::details::{NormalConstraints, contact_manifolds_heightfield_shape_shapes};
use rapier3d_f64::parry::query::{
    ClosestPoints, Contact, ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher,
    NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeCastOptions,
    ShapeDistance, ShapeIntersection, Unsupported,
};
use rapier3d_f64::parry::shape::{ConvexPolyhedron, Shape};

/// A lower bound on the distance (m) between a convex solid and a triangle in the solid's frame; negative, if they may
/// overlap. The axes tried are the triangle's normal and the normals of the solid's faces, and no more once one of them parts
/// the two by `enough`.
pub(super) fn separation(solid: &ConvexPolyhedron, triangle: [Vector; 3], enough: f64) -> f64 {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a);
    let (low, high) = solid.points().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let d = normal.dot(*p);
        (low.min(d), high.max(d))
    });
    let at = normal.dot(a);
    let mut most = (low - at).max(at - high) / normal.length().max(f64::MIN_POSITIVE);
    for face in solid.faces() {
        if most >= enough {
            break;
        }
        let vertex = solid.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
        let on_face = face.normal.dot(solid.points()[vertex as usize]);
        let nearest = face.normal.dot(a).min(face.normal.dot(b)).min(face.normal.dot(c));
        most = most.max(nearest - on_face);
    }
    most
}

/// parry's dispatcher, which asks for a contact of a convex solid with one of the ground's triangles only if they may be
/// within reach of each other.
pub(super) struct InReach;

impl InReach {
    fn is_out_of_reach(pos12: &Pose, g1: &dyn Shape, g2: &dyn Shape, prediction: Real) -> bool {
        let parted = |solid: &ConvexPolyhedron, t: [Vector; 3]| {
            separation(solid, t, prediction * (1.0 + 1e-9)) > prediction
        };
        match (g1.as_triangle(), g2.as_convex_polyhedron()) {
            (Some(t), Some(solid)) => {
                parted(solid, [t.a, t.b, t.c].map(|p| pos12.inverse_transform_point(p)))
            }
            _ => match (g1.as_convex_polyhedron(), g2.as_triangle()) {
                (Some(solid), Some(t)) => parted(solid, [t.a, t.b, t.c].map(|p| pos12.transform_point(p))),
                _ => false,
            },
        }
    }
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for InReach {
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<ContactManifoldData, ContactData>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        let convex = g1.as_convex_polyhedron().or(g2.as_convex_polyhedron()).is_some();
        if convex && g1.as_heightfield().or(g2.as_heightfield()).is_some() {
            contact_manifolds_heightfield_shape_shapes(self, pos12, g1, g2, prediction, manifolds, workspace);
            return Ok(());
        }
        DefaultQueryDispatcher.contact_manifolds(pos12, g1, g2, prediction, manifolds, workspace)
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold<ContactManifoldData, ContactData>,
    ) -> Result<(), Unsupported> {
        if Self::is_out_of_reach(pos12, g1, g2, prediction) {
            manifold.clear();
            // Where the search for the nearest points starts next time.
            manifold.local_n1 = Vector::ZERO;
            return Ok(());
        }
        DefaultQueryDispatcher.contact_manifold_convex_convex(
            pos12,
            g1,
            g2,
            normal_constraints1,
            normal_constraints2,
            prediction,
            manifold,
        )
    }
}

/// As parry's own.
impl QueryDispatcher for InReach {
    fn intersection_test(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        DefaultQueryDispatcher.intersection_test(pos12, g1, g2)
    }

    fn distance(&self, pos12: &Pose, g1: &dyn Shape, g2: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        DefaultQueryDispatcher.distance(pos12, g1, g2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        DefaultQueryDispatcher.contact(pos12, g1, g2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        DefaultQueryDispatcher.closest_points(pos12, g1, g2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        g1: &dyn Shape,
        g2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes(pos12, local_vel12, g1, g2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        g1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        g2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes_nonlinear(
            motion1,
            g1,
            motion2,
            g2,
            start_time,
            end_time,
            stop_at_penetration,
        )
    }
}
