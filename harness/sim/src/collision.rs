//! Contacts of the chassis (rapier) and of the wheels with obstacles (parry), looked for only where something is near.

use crate::spec::{TyreSpec, VehicleSpec};
use crate::tyre::Contact;
use crate::{M3, Quat, V3};
use rapier3d_f64::parry::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use rapier3d_f64::parry::shape::{ConvexPolyhedron, Cylinder, HeightFieldFlags, SupportMap};
use rapier3d_f64::parry::utils::Array2;
use rapier3d_f64::prelude::*;
use vb_world::{Heightfield, World};

/// Friction of obstacles, combined with the tyre's or hull's by the minimum: Chrono's default material, which the
/// original gives its rocks and trees (facts §1.9).
pub(crate) const OBSTACLE_FRICTION: f64 = 0.6;

fn vector(v: &V3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_vector(v: Vector) -> V3 {
    V3::new(v.x, v.y, v.z)
}

fn rotation(q: &Quat) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w)
}

/// Points as rapier's vectors.
pub(crate) fn points(p: &[[f64; 3]]) -> Vec<Vector> {
    p.iter().map(|p| Vector::new(p[0], p[1], p[2])).collect()
}

/// One convex obstacle in place.
#[derive(Clone)]
struct Solid {
    shape: ConvexPolyhedron,
    pose: Pose,
    centre: V3,
    bound: f64,
    /// The box around it along its own axes.
    cuboid: Cuboid,
}

/// A box in place.
#[derive(Clone)]
struct Cuboid {
    centre: V3,
    half: V3,
    axes: M3,
}

impl Cuboid {
    /// Whether the boxes may come within `margin` of each other, judged along the axes of both.
    fn may_touch(&self, other: &Self, margin: f64) -> bool {
        let d = other.centre - self.centre;
        let between = self.axes.transpose() * other.axes;
        let spread = between.abs();
        let (a, b) = (self.axes.transpose() * d, other.axes.transpose() * d);
        let (reach_a, reach_b) =
            (self.half + spread * other.half, other.half + spread.transpose() * self.half);
        (0..3).all(|k| a[k].abs() < reach_a[k] + margin && b[k].abs() < reach_b[k] + margin)
    }
}

/// The obstacles of a world and the few that are near the vehicle.
#[derive(Clone)]
pub(crate) struct Obstacles {
    solids: Vec<Solid>,
    near: Vec<usize>,
}

impl Obstacles {
    pub(crate) fn new(world: &World) -> Self {
        let solids = world
            .obstacles
            .iter()
            .filter_map(|o| {
                let pose = Pose::from_parts(
                    Vector::new(o.x, o.y, o.base_z(&world.heightfield)),
                    rotation(&Quat::from_axis_angle(&V3::z_axis(), o.yaw)),
                );
                let hull = points(&o.hull());
                let shape = ConvexPolyhedron::from_convex_hull(&hull)?;
                let middle = hull.iter().copied().sum::<Vector>() / hull.len() as f64;
                let bound = hull.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max);
                let (low, high) = extents(hull.iter().map(|p| from_vector(*p)));
                let cuboid = Cuboid {
                    centre: from_vector(pose * vector(&(0.5 * (low + high)))),
                    half: 0.5 * (high - low),
                    axes: *Quat::from_axis_angle(&V3::z_axis(), o.yaw).to_rotation_matrix().matrix(),
                };
                Some(Solid { shape, pose, centre: from_vector(pose * middle), bound, cuboid })
            })
            .collect();
        Self { solids, near: Vec::new() }
    }

    /// No obstacles.
    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self { solids: Vec::new(), near: Vec::new() }
    }

    /// Notes which obstacles come within `reach` of `x`.
    pub(crate) fn look_around(&mut self, x: &V3, reach: f64) {
        self.near.clear();
        for (i, s) in self.solids.iter().enumerate() {
            let r = s.bound + reach;
            if (s.centre - x).norm_squared() < r * r {
                self.near.push(i);
            }
        }
    }

    pub(crate) fn any_near(&self) -> bool {
        !self.near.is_empty()
    }

    fn any_within(&self, hull: &Cuboid, margin: f64) -> bool {
        self.near.iter().any(|&i| self.solids[i].cuboid.may_touch(hull, margin))
    }

    /// The deepest contact of a plate with an obstacle. The plate lies along the columns of `axes`, with its size (m) along
    /// each; the edges along the last, its thickness, are round.
    pub(crate) fn plate_contact(&self, size: [f64; 3], middle: &V3, axes: &M3) -> Option<Contact> {
        let margin = 0.5 * size[2];
        let half = [0.5 * size[0], 0.5 * size[1] - margin, 1e-3 * margin];
        let core = rapier3d_f64::parry::shape::Cuboid::new(Vector::new(half[0], half[1], half[2]));
        let turn = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(*axes));
        let plate = Pose::from_parts(vector(middle), rotation(&turn));
        let bound = V3::new(half[0], half[1], half[2]).norm() + margin;
        let mut deepest: Option<Contact> = None;
        for &i in &self.near {
            let s = &self.solids[i];
            let reach = s.bound + bound;
            if (s.centre - middle).norm_squared() > reach * reach {
                continue;
            }
            if let Some(c) = s.contact(&core, margin, &plate)
                && deepest.is_none_or(|d| c.depth > d.depth)
            {
                deepest = Some(c);
            }
        }
        deepest
    }

    /// The deepest contact of a wheel with an obstacle.
    pub(crate) fn wheel_contact(&self, wheel: &WheelShape, hub: &V3, axis: &V3) -> Option<Contact> {
        let mut deepest: Option<Contact> = None;
        for &i in &self.near {
            let s = &self.solids[i];
            let reach = s.bound + wheel.bound;
            if (s.centre - hub).norm_squared() > reach * reach {
                continue;
            }
            if let Some(c) = wheel.contact(s, hub, axis)
                && deepest.is_none_or(|d| c.depth > d.depth)
            {
                deepest = Some(c);
            }
        }
        deepest
    }
}

/// A wheel against convex solids: a slim core inflated by a margin, so that its shoulders are round and the distance
/// between core and solid stays positive, where GJK gives exact and steady normals.
#[derive(Clone)]
pub(crate) struct WheelShape {
    core: Cylinder,
    margin: f64,
    bound: f64,
}

impl WheelShape {
    pub(crate) fn new(tyre: &TyreSpec) -> Self {
        let (radius, width) = (tyre.radius(), tyre.width());
        let margin = (0.4 * width).min(0.3 * radius);
        let core = Cylinder::new(0.5 * width - margin, radius - margin);
        Self { core, margin, bound: vb_math::hypot(radius, 0.5 * width) }
    }

    fn contact(&self, solid: &Solid, hub: &V3, axis: &V3) -> Option<Contact> {
        // parry's cylinders stand along y.
        let turn = Quat::rotation_between(&V3::y(), axis)
            .unwrap_or_else(|| Quat::from_axis_angle(&V3::x_axis(), std::f64::consts::PI));
        let wheel = Pose::from_parts(vector(hub), rotation(&turn));
        solid.contact(&self.core, self.margin, &wheel)
    }
}

impl Solid {
    /// Contact with a body that is a core inflated by a margin.
    fn contact(&self, core: &impl SupportMap, margin: f64, pose: &Pose) -> Option<Contact> {
        let relative = self.pose.inverse() * *pose;
        let start = relative.translation.try_normalize().unwrap_or(Vector::Z);
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(&relative, &self.shape, core, start));
        let found = gjk::closest_points(&relative, &self.shape, core, margin, true, &mut simplex);
        let (on_solid, out, depth) = match found {
            GJKResult::ClosestPoints(p1, p2, n) => (p1, n, margin - (p2 - p1).dot(n)),
            GJKResult::Intersection => {
                // The core itself is inside: deeper than any tyre deflects. Push it out the shortest way.
                let (p1, p2, n) = rapier3d_f64::parry::query::epa::EPA::new().closest_points(
                    &relative,
                    &self.shape,
                    core,
                    &simplex,
                )?;
                (p1, n, margin - (p2 - p1).dot(n))
            }
            _ => return None,
        };
        if depth <= 0.0 {
            return None;
        }
        let normal = from_vector(self.pose.rotation * out);
        Some(Contact { point: from_vector(self.pose * on_solid), normal, depth })
    }
}

/// The chassis as rapier sees it: one body with the hull, among the ground and the obstacles.
pub(crate) struct ChassisContacts {
    physics: PhysicsWorld,
    body: RigidBodyHandle,
    ground: ColliderHandle,
    /// Points on the hull, relative to the chassis' centre of mass, that are held against the ground.
    probes: Vec<V3>,
    /// Lowest and highest coordinates of the hull, relative to the centre of mass.
    low: V3,
    high: V3,
    bound: f64,
    looks: Looks,
}

/// What looks for ground under the hull leave to the next one, to save work: it changes no answer.
#[derive(Clone, Default)]
struct Looks {
    /// The probe that was near the ground last.
    near: usize,
    clear: Option<Clear>,
}

/// How far the hull was clear of the ground.
#[derive(Clone)]
struct Clear {
    x: V3,
    axes: M3,
    /// Steepest slopes around, and 1: what a height over ground loses by a way along each axis.
    slopes: V3,
    /// Height of the lowest probe over the ground, m.
    height: f64,
    /// By how much the hull's box can grow, at least, before a node of the ground is inside, m.
    gap: f64,
}

/// What is left of a clearance for rounding, m.
const ROUNDING: f64 = 1e-9;
/// How far the hull may go before slopes are looked at again, over its bound.
const ROOM: f64 = 0.25;

impl Clone for ChassisContacts {
    /// With all that the solver carries from step to step, so that original and clone go on alike. rapier's pipelines
    /// hold nothing between steps and are made anew.
    fn clone(&self) -> Self {
        let p = &self.physics;
        let physics = PhysicsWorld {
            gravity: p.gravity,
            integration_parameters: p.integration_parameters,
            islands: p.islands.clone(),
            broad_phase: p.broad_phase.clone(),
            narrow_phase: p.narrow_phase.clone(),
            bodies: p.bodies.clone(),
            colliders: p.colliders.clone(),
            impulse_joints: p.impulse_joints.clone(),
            multibody_joints: p.multibody_joints.clone(),
            soft_bodies: p.soft_bodies.clone(),
            ..PhysicsWorld::default()
        };
        Self { physics, probes: self.probes.clone(), looks: self.looks.clone(), ..*self }
    }
}

impl ChassisContacts {
    /// `mass` and `inertia` are of the whole vehicle, about `com` relative to the chassis' centre of mass.
    pub(crate) fn new(v: &VehicleSpec, world: &World, mass: f64, inertia: V3, com: V3, dt: f64) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::ZERO;
        physics.integration_parameters.dt = dt;
        // Of which the solver's tolerances are fractions.
        physics.integration_parameters.length_unit = world.scale;
        let ground = physics.insert_collider(
            ground_collider(&world.heightfield)
                .friction(1.0)
                .friction_combine_rule(CoefficientCombineRule::Min)
                .restitution(0.0),
            None,
        );
        for o in &world.obstacles {
            if let Some(c) = ColliderBuilder::convex_hull(&points(&o.hull())) {
                let q = Quat::from_axis_angle(&V3::z_axis(), o.yaw);
                let at = Vector::new(o.x, o.y, o.base_z(&world.heightfield));
                physics.insert_collider(
                    c.position(Pose::from_parts(at, rotation(&q)))
                        .friction(OBSTACLE_FRICTION)
                        .friction_combine_rule(CoefficientCombineRule::Min)
                        .restitution(0.0),
                    None,
                );
            }
        }
        let chassis_com = V3::from(v.chassis.com);
        let properties = MassProperties::new(vector(&com), mass, vector(&inertia));
        let body = physics.insert_body(
            RigidBodyBuilder::dynamic()
                .additional_mass_properties(properties)
                .gyroscopic_forces_enabled(false)
                .can_sleep(false),
        );
        let mut probes = Vec::new();
        let parts = v.chassis.hull.len();
        for (k, part) in v.chassis.hull.iter().cloned().chain(wheel_faces(v)).enumerate() {
            let relative: Vec<[f64; 3]> = part.iter().map(|p| (V3::from(*p) - chassis_com).into()).collect();
            if let Some(c) = ColliderBuilder::convex_hull(&points(&relative)) {
                physics.insert_collider(
                    c.density(0.0)
                        .friction(v.chassis.friction)
                        .friction_combine_rule(CoefficientCombineRule::Min)
                        .restitution(0.0),
                    Some(body),
                );
            }
            let vertices: Vec<V3> = relative.iter().map(|p| V3::from(*p)).collect();
            if k < parts {
                probes.extend(underside(&vertices, 0.5 * world.scale));
                probes.extend(vertices);
            } else {
                // A wheel's face meets the ground with its corners, which are farthest out.
                let outer = vertices.iter().map(|p| p.y.abs()).fold(0.0, f64::max);
                probes.extend(vertices.into_iter().filter(|p| p.y.abs() >= outer));
            }
        }
        let (low, high) = extents(probes.iter().copied());
        let bound = probes.iter().map(V3::norm).fold(0.0, f64::max);
        Self { physics, body, ground, probes, low, high, bound, looks: Looks::default() }
    }

    /// Distance from the centre of mass within which the hull lies, m.
    pub(crate) fn bound(&self) -> f64 {
        self.bound
    }

    /// Whether the hull may come within `margin` of ground or obstacles.
    pub(crate) fn may_touch(
        &mut self,
        ground: &Heightfield,
        obstacles: &Obstacles,
        x: &V3,
        q: &Quat,
        margin: f64,
    ) -> bool {
        let r = q.to_rotation_matrix();
        let hull = Cuboid {
            centre: x + r * (0.5 * (self.low + self.high)),
            half: 0.5 * (self.high - self.low),
            axes: *r.matrix(),
        };
        if obstacles.any_within(&hull, margin) {
            return true;
        }
        if self.looks.clear.as_ref().is_some_and(|c| self.is_still_clear(c, x, r.matrix(), margin)) {
            return false;
        }
        self.looks.clear = None;
        let over = |p: &V3| {
            let p = x + r * p;
            let ground = ground.height(p.x, p.y);
            (p.z < ground + margin, p.z - ground)
        };
        if self.probes.get(self.looks.near).is_some_and(|p| over(p).0) {
            return true;
        }
        let mut height = f64::INFINITY;
        for (i, p) in self.probes.iter().enumerate() {
            let (near, above) = over(p);
            if near {
                self.looks.near = i;
                return true;
            }
            height = height.min(above);
        }
        let Some(gap) = self.node_gap(ground, &hull, x, q, margin) else { return true };
        let slopes = ground.steepest(x.x, x.y, (1.0 + ROOM) * self.bound);
        self.looks.clear = slopes.map(|[sx, sy]| Clear {
            x: *x,
            axes: *r.matrix(),
            slopes: V3::new(sx, sy, 1.0),
            height,
            gap,
        });
        false
    }

    /// Distance from the centre of mass within which the hull's box lies if it grows by `margin`, m.
    fn box_bound(&self, margin: f64) -> f64 {
        self.low.abs().sup(&self.high.abs()).add_scalar(margin).norm()
    }

    /// Whether the hull can't have come within `margin` of the ground since it was clear.
    fn is_still_clear(&self, c: &Clear, x: &V3, axes: &M3, margin: f64) -> bool {
        let way = x - c.x;
        let turn = axes - c.axes;
        if way.x.abs().max(way.y.abs()) > ROOM * self.bound {
            return false;
        }
        // A probe goes along each axis as far as the centre and, at its distance, the rows of the rotation.
        let rows = V3::new(turn.row(0).norm(), turn.row(1).norm(), turn.row(2).norm());
        let lost = c.slopes.dot(&(way.abs() + rows * self.bound));
        let moved = way.norm() + turn.norm() * self.box_bound(margin);
        c.height - lost > margin + ROUNDING && c.gap - moved > margin + ROUNDING
    }

    /// By how much the hull's box can grow before a node of the ground stands inside, at least, m; none if one stands
    /// within `margin` of it: a summit between the probes.
    fn node_gap(&self, ground: &Heightfield, hull: &Cuboid, x: &V3, q: &Quat, margin: f64) -> Option<f64> {
        let pitch = ground.pitch();
        let range = |v: f64, reach: f64, half: f64, count: usize| {
            let index = |value: f64| (((value + half) / pitch).max(0.0) as usize).min(count - 1);
            (index(v - reach), index(v + reach))
        };
        let (cols, rows) = (
            range(x.x, self.bound, ground.half_x(), ground.cols()),
            range(x.y, self.bound, ground.half_y(), ground.rows()),
        );
        // Of those farther out the next looks need to know.
        let wide = self.box_bound(margin) + ROOM * self.bound;
        let (c0, c1) = range(x.x, wide, ground.half_x(), ground.cols());
        let (r0, r1) = range(x.y, wide, ground.half_y(), ground.rows());
        let bottom = hull.centre.z - hull.axes.row(2).abs().dot(&hull.half.transpose());
        let inverse = q.inverse();
        let mut gap = self.bound;
        for row in r0..=r1 {
            for col in c0..=c1 {
                let z = ground.node(row, col);
                // Along one of the box's axes it is at least 1/√3 of the way off.
                if 0.57 * (bottom - z) >= gap.max(margin + ROUNDING) {
                    continue;
                }
                let node =
                    V3::new(col as f64 * pitch - ground.half_x(), row as f64 * pitch - ground.half_y(), z);
                let p = inverse * (node - x);
                let inside = (0..3).all(|k| p[k] > self.low[k] - margin && p[k] < self.high[k] + margin);
                if inside && (cols.0..=cols.1).contains(&col) && (rows.0..=rows.1).contains(&row) {
                    return None;
                }
                gap = gap.min((self.low - p).sup(&(p - self.high)).max());
            }
        }
        Some(gap)
    }

    /// Lets rapier resolve the contacts of one step: takes the velocities that the forces gave, returns pose and
    /// velocities at the end of the step.
    pub(crate) fn resolve(&mut self, friction: f64, x: &mut V3, q: &mut Quat, v: &mut V3, w: &mut V3) {
        self.physics.colliders[self.ground].set_friction(friction);
        let body = &mut self.physics.bodies[self.body];
        body.set_position(Pose::from_parts(vector(x), rotation(q)), true);
        // rapier's linear velocity is that of the body's centre of mass, which isn't the chassis' own.
        let offset = *q * from_vector(body.mass_properties().local_mprops.local_com);
        body.set_linvel(vector(&(*v + w.cross(&offset))), true);
        body.set_angvel(vector(w), true);
        self.physics.step();
        let body = &self.physics.bodies[self.body];
        let r = body.rotation();
        *x = from_vector(body.translation());
        *q = Quat::from_quaternion(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z));
        *w = from_vector(body.angvel());
        let offset = *q * from_vector(body.mass_properties().local_mprops.local_com);
        *v = from_vector(body.linvel()) - w.cross(&offset);
    }
}

/// Blocks within the wheels, at design height, that reach from face to face, if the vehicle lies on those.
fn wheel_faces(v: &VehicleSpec) -> Vec<Vec<[f64; 3]>> {
    // Narrow enough to stay within the outline of a wheel that has moved in its springs.
    const SHARE: f64 = 0.3;
    let mut blocks = Vec::new();
    for axle in v.axles.iter().filter(|_| v.chassis.wheel_faces) {
        let (tyre, spindle) = (v.tyre_of(axle), axle.suspension.linkage.spindle());
        let reach = SHARE * tyre.radius();
        for side in [1.0, -1.0] {
            let [x, y, z] =
                [0, 1, 2].map(|k| axle.position[k] + if k == 1 { side } else { 1.0 } * spindle[k]);
            let corner = |k: usize| {
                let sign = |bit: usize| if k & bit == 0 { 1.0 } else { -1.0 };
                [x + sign(1) * reach, y + sign(2) * 0.5 * tyre.width(), z + sign(4) * reach]
            };
            blocks.push((0..8).map(corner).collect());
        }
    }
    blocks
}

/// Lowest and highest coordinates of some points.
fn extents(points: impl Iterator<Item = V3>) -> (V3, V3) {
    let start = (V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY));
    points.fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)))
}

/// A grid of points over the underside of a convex part, about `spacing` (m) apart.
fn underside(vertices: &[V3], spacing: f64) -> Vec<V3> {
    let bottom = vertices.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let flat: Vec<&V3> = vertices.iter().filter(|p| p.z < bottom + 1e-6).collect();
    let range = |k: usize| {
        flat.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| (lo.min(p[k]), hi.max(p[k])))
    };
    let ((x0, x1), (y0, y1)) = (range(0), range(1));
    let count = |length: f64| (length / spacing) as usize + 1;
    let (nx, ny) = (count(x1 - x0), count(y1 - y0));
    let mut grid = Vec::new();
    for i in 0..=nx {
        for j in 0..=ny {
            let at = |a: f64, b: f64, k: usize, n: usize| a + (b - a) * k as f64 / n as f64;
            grid.push(V3::new(at(x0, x1, i, nx), at(y0, y1, j, ny), bottom));
        }
    }
    grid
}

/// The ground as rapier's heightfield. Its own height axis is y: it is turned about x, which makes its row 0 the
/// north; its cells are cut from south-west to north-east like ours.
fn ground_collider(ground: &Heightfield) -> ColliderBuilder {
    let heights =
        Array2::from_fn(ground.rows(), ground.cols(), |row, col| ground.node(ground.rows() - 1 - row, col));
    let scale = Vector::new(2.0 * ground.half_x(), 1.0, 2.0 * ground.half_y());
    let upright = rotation(&Quat::from_axis_angle(&V3::x_axis(), std::f64::consts::FRAC_PI_2));
    ColliderBuilder::heightfield_with_flags(heights, scale, HeightFieldFlags::FIX_INTERNAL_EDGES)
        .position(Pose::from_parts(Vector::ZERO, upright))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d_f64::parry::query::Ray;

    #[test]
    fn what_is_remembered_of_the_hulls_clearance_changes_no_answer() {
        let spec = include_str!("../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(spec, "hmmwv.yaml").unwrap();
        let n = 41;
        let mut stream = vb_math::rng::Stream::new(6, &["hull"]);
        let heights = (0..n * n).map(|_| stream.normal(0.0, 0.12)).collect();
        let ground = Heightfield::new(n, n, 1.0, heights);
        let world = World::uniform("test", ground.clone(), vb_world::TerrainClass::Concrete, 0.6);
        let mut hull = ChassisContacts::new(&spec, &world, 2000.0, V3::repeat(1000.0), V3::zeros(), 1e-3);
        let obstacles = Obstacles::none();
        let (mut near, mut saved) = (0, 0);
        for k in 0..8000 {
            let t = 4e-3 * f64::from(k);
            let x = V3::new(
                19.0 * vb_math::sin(0.1 * t),
                15.0 * vb_math::sin(0.13 * t),
                0.9 + 0.4 * vb_math::sin(0.7 * t),
            );
            let q = Quat::from_euler_angles(0.2 * vb_math::sin(t), 0.15 * vb_math::sin(1.7 * t), 0.2 * t);
            let margin = 0.05 + 0.03 * vb_math::sin(5.0 * t).abs();
            let remembered = hull.looks.clone();
            let touches = hull.may_touch(&ground, &obstacles, &x, &q, margin);
            let clear = |c: &Clear| hull.is_still_clear(c, &x, q.to_rotation_matrix().matrix(), margin);
            saved += u32::from(remembered.clear.as_ref().is_some_and(clear));
            let after = std::mem::take(&mut hull.looks);
            assert_eq!(touches, hull.may_touch(&ground, &obstacles, &x, &q, margin), "look {k}");
            hull.looks = after;
            near += u32::from(touches);
        }
        assert!((1000..7000).contains(&near), "{near}");
        assert!(saved > 1000, "{saved} looks were saved");
    }

    #[test]
    fn the_chassis_and_the_tyres_see_one_ground() {
        // An asymmetric surface, so that a flipped axis or the other diagonal would show.
        let (rows, cols) = (7, 9);
        let h = (0..rows * cols).map(|i| 0.37 * f64::from((i * 7919 % 101) as u8) * 0.05).collect();
        let ground = Heightfield::new(rows, cols, 1.0, h);
        let mut world = PhysicsWorld::new();
        let handle = world.insert_collider(ground_collider(&ground), None);
        let collider = &world.colliders[handle];
        for k in 0..200 {
            let x = -3.9 + 7.8 * f64::from(k % 20) / 19.0;
            let y = -2.9 + 5.8 * f64::from(k / 20) / 9.0;
            let ray = Ray::new(Vector::new(x, y, 10.0), Vector::new(0.0, 0.0, -1.0));
            let t = collider.shape().cast_ray(collider.position(), &ray, 20.0, true).unwrap();
            assert!((10.0 - t - ground.height(x, y)).abs() < 1e-9, "({x}, {y})");
        }
    }
}
