//! How far the hull is from the ground, at least: what spares rapier the triangles, and whole steps, that are out of reach.

use rapier3d_f64::geometry::{ContactData, ContactManifoldData};
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d_f64::parry::math::{Pose, Real, Vector};
use rapier3d_f64::parry::query::details::NormalConstraints;
use rapier3d_f64::parry::query::{
    ClosestPoints, Contact, ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher,
    NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeCastOptions,
    ShapeDistance, ShapeIntersection, TypedWorkspaceData, Unsupported, WorkspaceData,
};
use rapier3d_f64::parry::shape::{ConvexPolyhedron, HeightField, Shape};

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

/// parry's dispatcher, which looks only at those of the ground's triangles that may be within reach of a convex solid. The
/// contacts are parry's own, bit for bit: of some thirty triangles under a hull that touches the ground, few are within reach,
/// and parry makes a manifold and the normals at the edges for each.
pub(super) struct InReach;

/// What rapier takes as the sign that manifolds come and go with the parts of a shape. parry remembers here which manifold is
/// which triangle's, which the manifolds tell as well.
#[derive(Clone)]
struct Composite;

impl WorkspaceData for Composite {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::Custom
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(Self)
    }
}

type Manifold = ContactManifold<ContactManifoldData, ContactData>;

/// Which of a pair of shapes is the ground.
#[derive(Clone, Copy, PartialEq)]
enum Order {
    GroundFirst,
    SolidFirst,
}

impl Order {
    /// The manifold of a triangle that has none yet.
    fn manifold(self, triangle: u32) -> Manifold {
        let (first, second) = if self == Self::GroundFirst { (triangle, 0) } else { (0, triangle) };
        Manifold::with_data(first, second, ContactManifoldData::default())
    }

    fn triangle_of(self, manifold: &Manifold) -> u32 {
        if self == Self::GroundFirst { manifold.subshape1 } else { manifold.subshape2 }
    }
}

/// A pose as a matrix, which places a point in half as many operations as parry's quaternion.
struct Placement {
    axes: [Vector; 3],
    origin: Vector,
}

impl Placement {
    fn new(pose: &Pose) -> Self {
        Self {
            axes: [Vector::X, Vector::Y, Vector::Z].map(|axis| pose.rotation * axis),
            origin: pose.translation,
        }
    }

    /// Where a point of the frame lies.
    fn of(&self, p: Vector) -> Vector {
        let [x, y, z] = self.axes;
        x * p.x + y * p.y + z * p.z + self.origin
    }

    /// The box about some points of the frame.
    fn bounds(&self, points: &[Vector]) -> Aabb {
        let start = (Vector::splat(Real::INFINITY), Vector::splat(Real::NEG_INFINITY));
        let (mins, maxs) =
            points.iter().map(|p| self.of(*p)).fold(start, |(low, high), p| (low.min(p), high.max(p)));
        Aabb::new(mins, maxs)
    }
}

/// The manifolds of a convex solid with the ground. `pose` is that of the second shape in the frame of the first.
fn ground_manifolds(
    ground: &HeightField,
    solid: &ConvexPolyhedron,
    order: Order,
    pose: &Pose,
    prediction: Real,
    manifolds: &mut Vec<Manifold>,
) {
    // parry turns the pose round once to find the triangles and once more for each, which rounds.
    let (of_solid, pose) = match order {
        Order::GroundFirst => (*pose, *pose),
        Order::SolidFirst => (pose.inverse(), pose.inverse().inverse()),
    };
    // The new ones are put behind those of the last step, which go then.
    let before = manifolds.len();
    let around = Placement::new(&of_solid).bounds(solid.points()).loosened(prediction);
    let block = solid.local_aabb().loosened(prediction * (1.0 + 1e-9));
    let to_solid = Placement::new(&if order == Order::GroundFirst { pose.inverse() } else { pose });
    let mut out_of_reach = [None; 2];
    let mut passed = 0;
    ground.map_elements_in_local_aabb(&around, &mut |number, triangle| {
        let corners = [triangle.a, triangle.b, triangle.c].map(|p| to_solid.of(p));
        let beside = |k: usize| {
            let [a, b, c] = corners.map(|p| p[k]);
            a.min(b).min(c) > block.maxs[k] || a.max(b).max(c) < block.mins[k]
        };
        let apart = beside(0) || beside(1) || beside(2);
        if apart || separation(solid, corners, prediction * (1.0 + 1e-9)) > prediction {
            if let Some(place) = out_of_reach.get_mut(passed) {
                *place = Some(number);
            }
            passed += 1;
            return;
        }
        let known = manifolds[..before].iter_mut().find(|m| order.triangle_of(m) == number);
        let fresh = order.manifold(number);
        let mut manifold = match known {
            Some(known) => std::mem::replace(known, fresh),
            None => fresh,
        };
        let normals = ground.triangle_normal_constraints(number);
        let normals = normals.as_ref().map(|n| n as &dyn NormalConstraints);
        let (shapes, constraints): ([&dyn Shape; 2], _) = match order {
            Order::GroundFirst => ([triangle, solid], [normals, None]),
            Order::SolidFirst => ([solid, triangle], [None, normals]),
        };
        let [first, second] = shapes;
        let [at_first, at_second] = constraints;
        // Triangles and convex solids are among the shapes that parry supports.
        let _ = DefaultQueryDispatcher.contact_manifold_convex_convex(
            &pose,
            first,
            second,
            at_first,
            at_second,
            prediction,
            &mut manifold,
        );
        manifolds.push(manifold);
    });
    manifolds.drain(..before);
    // rapier joins the manifolds of a pair that has more than one, and it makes a difference whether it does.
    let empty = out_of_reach.into_iter().flatten().take(2_usize.saturating_sub(manifolds.len()));
    manifolds.extend(empty.map(|number| order.manifold(number)));
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for InReach {
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<Manifold>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        let found = match (g1.as_heightfield(), g2.as_heightfield()) {
            (Some(ground), _) => g2.as_convex_polyhedron().map(|solid| (ground, solid, Order::GroundFirst)),
            (_, Some(ground)) => g1.as_convex_polyhedron().map(|solid| (ground, solid, Order::SolidFirst)),
            _ => None,
        };
        let Some((ground, solid, order)) = found else {
            return DefaultQueryDispatcher.contact_manifolds(pos12, g1, g2, prediction, manifolds, workspace);
        };
        workspace.get_or_insert_with(|| Composite.into());
        ground_manifolds(ground, solid, order, pos12, prediction, manifolds);
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut Manifold,
    ) -> Result<(), Unsupported> {
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
