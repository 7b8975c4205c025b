//! The chassis among ground and obstacles, as rapier sees it, and when rapier has to be asked at all (`near`).

mod near;

use super::footing::{Correction, Footing};
use super::separation::InReach;
use super::{OBSTACLE_FRICTION, Surroundings, extents, from_vector, points, rotation, vector};
use crate::{Quat, V3};
use near::Looks;
use rapier3d_f64::parry::shape::{ConvexPolyhedron, HeightFieldFlags};
use rapier3d_f64::parry::utils::Array2;
use rapier3d_f64::prelude::*;
use vb_vehicle::{MAX_WHEELS, VehicleSpec};
use vb_world::Heightfield;

/// The chassis as rapier sees it: one body with the hull, among the ground and the obstacles.
pub(crate) struct ChassisContacts {
    physics: PhysicsWorld,
    body: RigidBodyHandle,
    ground: ColliderHandle,
    /// The convex parts of hull and wheels' faces, relative to the chassis' centre of mass.
    parts: Vec<ConvexPolyhedron>,
    /// How many of them are of the hull, the first ones.
    hull: usize,
    /// Whether soil doesn't stop the hull.
    passes_soil: bool,
    /// Whether hull and faces don't meet the ground now.
    passing: Passing,
    /// Lowest and highest coordinates of the hull, relative to the centre of mass.
    low: V3,
    high: V3,
    bound: f64,
    /// The friction coefficient of the hull.
    friction: f64,
    /// Lowest and highest coordinates of the lowest part of the hull, its sole, relative to the centre of mass.
    sole: (V3, V3),
    /// How high heaps of soil under the sole stand above the ground, m.
    heaps: f64,
    /// The pose of the hull when the contacts with the ground were found and corrected last.
    corrected: Option<(V3, Quat)>,
    /// The distance from its origin within which the ground lies, m: rapier takes it for how far a turn moves a contact.
    extent: f64,
    looks: Looks,
}

/// Which parts pass through the ground: the hull, and the faces of each wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Passing {
    hull: bool,
    faces: [bool; MAX_WHEELS],
}

impl Passing {
    /// Whether a part does, of which the first `hull` are the hull's.
    fn is(self, part: usize, hull: usize) -> bool {
        if part < hull { self.hull } else { self.faces[part - hull] }
    }
}

/// The distance within which rapier finds contacts at full scale, m: its default.
const CONTACTS_WITHIN: f64 = 0.02;
/// The ground's group of colliders.
const GROUND: Group = Group::GROUP_1;
/// Fraction of the hull's height that counts as its sole.
const SOLE: f64 = 0.1;
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
        Self { physics, parts: self.parts.clone(), looks: self.looks.clone(), ..*self }
    }
}

impl ChassisContacts {
    /// `mass` and `inertia` are of the whole vehicle, about `com` relative to the chassis' centre of mass.
    pub(crate) fn new(
        v: &VehicleSpec,
        surroundings: &Surroundings,
        mass: f64,
        inertia: V3,
        com: V3,
        dt: f64,
    ) -> Self {
        let world = surroundings.world();
        let mut physics = PhysicsWorld::new();
        physics.narrow_phase.set_query_dispatcher(InReach);
        physics.gravity = Vector::ZERO;
        physics.integration_parameters.dt = dt;
        // Of which the solver's tolerances are fractions.
        physics.integration_parameters.length_unit = world.scale;
        // Four by default, for steps of 1/60 s: ours are finer as they are.
        physics.integration_parameters.num_solver_iterations = 1;
        // A hull that touches the ground at one place must not sink in at another before rapier looks there.
        physics.integration_parameters.normalized_prediction_distance = CONTACTS_WITHIN;
        physics.integration_parameters.normalized_contact_recycle_distance = CONTACTS_WITHIN;
        let ground = physics.insert_collider(
            ground_collider(&world.heightfield)
                .collision_groups(InteractionGroups::new(GROUND, Group::ALL, InteractionTestMode::And))
                .friction(v.chassis.friction)
                .friction_combine_rule(CoefficientCombineRule::Min)
                .restitution(0.0),
            None,
        );
        let extent = physics.colliders[ground].shape().compute_local_aabb();
        let extent = extent.mins.length().max(extent.maxs.length());
        for solid in surroundings.solids().iter() {
            physics.insert_collider(
                ColliderBuilder::new(SharedShape(solid.shape.clone()))
                    .position(solid.pose)
                    .friction(OBSTACLE_FRICTION)
                    .friction_combine_rule(CoefficientCombineRule::Min)
                    .restitution(0.0),
                None,
            );
        }
        let chassis_com = V3::from(v.chassis.com);
        let properties = MassProperties::new(vector(&com), mass, vector(&inertia));
        let body = physics.insert_body(
            RigidBodyBuilder::dynamic()
                .additional_mass_properties(properties)
                .gyroscopic_forces_enabled(false)
                .can_sleep(false),
        );
        let mut parts = Vec::new();
        let mut hull = 0;
        for (number, part) in v.chassis.hull.iter().cloned().chain(wheel_faces(v)).enumerate() {
            let relative: Vec<[f64; 3]> = part.iter().map(|p| (V3::from(*p) - chassis_com).into()).collect();
            if let Some(solid) = ConvexPolyhedron::from_convex_hull(&points(&relative)) {
                physics.insert_collider(
                    ColliderBuilder::new(SharedShape::new(solid.clone()))
                        .density(0.0)
                        .friction(v.chassis.friction)
                        .friction_combine_rule(CoefficientCombineRule::Min)
                        .restitution(0.0),
                    Some(body),
                );
                parts.push(solid);
                if number < v.chassis.hull.len() {
                    hull = parts.len();
                }
            }
        }
        let vertices = || parts.iter().flat_map(|part| part.points()).map(|p| from_vector(*p));
        let (low, high) = extents(vertices());
        let bound = vertices().map(|p| p.norm()).fold(0.0, f64::max);
        let of_hull = || parts[..hull].iter().flat_map(|part| part.points()).map(|p| from_vector(*p));
        let (bottom, top) = extents(of_hull());
        let sole = extents(of_hull().filter(|p| p.z <= bottom.z + SOLE * (top.z - bottom.z)));
        let looks = Looks::default();
        let (passes_soil, passing) = (v.chassis.hull_passes_soil, Passing::default());
        Self {
            physics,
            body,
            ground,
            parts,
            hull,
            passes_soil,
            passing,
            low,
            high,
            bound,
            friction: v.chassis.friction,
            sole,
            heaps: 0.0,
            corrected: None,
            extent: extent.max(bound),
            looks,
        }
    }

    /// Whether soil doesn't stop the hull, so that [`Self::pass_over`] has to be told of it.
    pub(crate) fn passes_soil(&self) -> bool {
        self.passes_soil
    }

    /// Whether the faces of the wheels are among its parts.
    pub(crate) fn has_faces(&self) -> bool {
        self.parts.len() > self.hull
    }

    /// Takes note of whether there is soil below the hull, which doesn't stop it, and of which wheels `stand` on the ground
    /// under them. Their faces don't meet the ground, since a wheel that stands in soil has forces of its own wherever the
    /// middle of the hull is; those of one that leans against a bank do, as nothing else holds it there.
    pub(crate) fn pass_over(&mut self, soil: bool, stand: [bool; MAX_WHEELS]) {
        let passing = Passing { hull: soil, faces: stand };
        if passing == self.passing {
            return;
        }
        self.passing = passing;
        self.looks = Looks::default();
        self.corrected = None;
        let parts = self.physics.bodies[self.body].colliders().to_vec();
        for (number, part) in parts.into_iter().enumerate() {
            let meets = if passing.is(number, self.hull) { Group::ALL & !GROUND } else { Group::ALL };
            let groups = InteractionGroups::new(Group::ALL, meets, InteractionTestMode::And);
            self.physics.colliders[part].set_collision_groups(groups);
        }
    }

    /// Distance from the centre of mass within which the hull lies, m.
    pub(crate) fn bound(&self) -> f64 {
        self.bound
    }

    /// How high heaps of soil under the sole stand above the ground, m.
    pub(crate) fn heaps(&self) -> f64 {
        self.heaps
    }

    /// Whether rapier may keep the contacts with the ground that were found and corrected last. It does so by itself where
    /// pairs moved less than a distance, unless their contacts are to be corrected; asked with the same measure, somewhat
    /// earlier, it keeps those that were.
    fn keeps_contacts(&self, x: &V3, q: &Quat) -> bool {
        let Some((x0, q0)) = &self.corrected else { return false };
        let turn = q * q0.inverse();
        // The pose of the hull in the frame of the ground and that of the ground in the frame of the hull.
        let moved = (x - x0).norm().max((q.inverse() * x - q0.inverse() * x0).norm());
        let drift = moved + 2.0 * turn.imag().norm() * self.extent;
        drift < 0.99 * self.physics.integration_parameters.contact_recycle_distance()
    }

    /// Lets rapier resolve the contacts of one step: takes the velocities that the forces gave, returns pose and
    /// velocities at the end of the step.
    pub(crate) fn resolve(
        &mut self,
        footing: &Footing<'_>,
        x: &mut V3,
        q: &mut Quat,
        v: &mut V3,
        w: &mut V3,
    ) {
        let keeps = self.keeps_contacts(x, q);
        if !keeps {
            self.corrected = Some((*x, *q));
        }
        let hooks = if keeps { ActiveHooks::empty() } else { ActiveHooks::MODIFY_SOLVER_CONTACTS };
        if self.physics.colliders[self.ground].active_hooks() != hooks {
            self.physics.colliders[self.ground].set_active_hooks(hooks);
        }
        if !keeps {
            // Contacts are found by the ground without its heaps.
            let scale = self.physics.integration_parameters.length_unit;
            let reach = CONTACTS_WITHIN + self.heaps / scale;
            self.physics.integration_parameters.normalized_prediction_distance = reach;
        }
        let body = &mut self.physics.bodies[self.body];
        body.set_position(Pose::from_parts(vector(x), rotation(q)), true);
        // rapier's linear velocity is that of the body's centre of mass, which isn't the chassis' own.
        let offset = *q * from_vector(body.mass_properties().local_mprops.local_com);
        body.set_linvel(vector(&(*v + w.cross(&offset))), true);
        body.set_angvel(vector(w), true);
        let correction = Correction { footing, ground: self.ground, hull: self.friction };
        self.physics.step_with_events(&correction, &());
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
    use super::super::Obstacles;
    use super::near::Clear;
    use super::*;
    use crate::soil::SoilGround;
    use rapier3d_f64::parry::query::{Ray, distance};
    use std::sync::Arc;
    use vb_world::World;

    fn rough(n: usize, std: f64) -> Heightfield {
        let mut stream = vb_math::rng::Stream::new(6, &["hull"]);
        Heightfield::new(n, n, 1.0, (0..n * n).map(|_| stream.normal(0.0, std)).collect())
    }

    fn hmmwv_over(ground: &Heightfield) -> ChassisContacts {
        let spec = include_str!("../../../../../../tasks/vehicles/hmmwv.yaml");
        let mut spec = VehicleSpec::parse(spec, "hmmwv.yaml").unwrap();
        // The hull alone: faces of wheels are looked at in an order of their own.
        spec.chassis.wheel_faces = false;
        let world = World::uniform("test", ground.clone(), vb_world::TerrainClass::Concrete, 0.6);
        ChassisContacts::new(&spec, &Arc::new(world).into(), 2000.0, V3::repeat(1000.0), V3::zeros(), 1e-3)
    }

    /// A flight over the ground, now near and now far.
    fn flight(k: u32) -> (V3, Quat) {
        let t = 4e-3 * f64::from(k);
        let x = V3::new(
            19.0 * vb_math::sin(0.1 * t),
            15.0 * vb_math::sin(0.13 * t),
            0.7 + 0.4 * vb_math::sin(0.7 * t),
        );
        (x, Quat::from_euler_angles(0.2 * vb_math::sin(t), 0.15 * vb_math::sin(1.7 * t), 0.2 * t))
    }

    #[test]
    fn what_is_remembered_of_the_hulls_clearance_hardly_changes_an_answer() {
        let ground = rough(41, 0.12);
        let mut hull = hmmwv_over(&ground);
        let obstacles = Obstacles::none();
        // Both are bounds from below, of which either may be the tighter one for a hull of several parts.
        let (mut near, mut saved, mut other) = (0, 0, 0);
        for k in 0..9000 {
            let (mut x, mut q) = flight(k);
            if k >= 8000 {
                // Straight down, where it nears the ground by all of its way.
                (x, q) = flight(8000);
                x.z += 0.5 - 1e-3 * f64::from(k - 8000);
            }
            let margin = 0.05 + 0.03 * vb_math::sin(0.02 * f64::from(k)).abs();
            let remembered = hull.looks.clone();
            let touches = hull.may_touch(&ground, &obstacles, &x, &q, margin);
            let clear = |c: &Clear| hull.is_still_clear(c, &x, q.to_rotation_matrix().matrix(), margin);
            saved += u32::from(remembered.clear.as_ref().is_some_and(clear));
            let after = std::mem::take(&mut hull.looks);
            other += u32::from(touches != hull.may_touch(&ground, &obstacles, &x, &q, margin));
            hull.looks = after;
            near += u32::from(touches);
        }
        assert!((1000..7000).contains(&near), "{near}");
        assert!(saved > 1000, "{saved} looks were saved");
        assert!(other < 90, "{other} of 9000 answers differ");
    }

    #[test]
    fn no_contact_of_the_hull_is_overlooked_and_few_are_supposed() {
        // Against parry's distance between each part and each triangle around.
        let ground = rough(41, 0.12);
        let mut hull = hmmwv_over(&ground);
        let field = hull.physics.colliders[hull.ground].clone();
        let triangles: Vec<_> = field.shape().as_heightfield().unwrap().triangles().collect();
        let (mut within, mut supposed) = (0, 0);
        for k in (0..8000).step_by(8) {
            let (x, q) = flight(k);
            let pose = Pose::from_parts(vector(&x), rotation(&q));
            let mut nearest = f64::INFINITY;
            for t in triangles.iter().filter(|t| (*field.position() * t.a - vector(&x)).length() < 5.0) {
                for part in &hull.parts {
                    let away = distance(&pose, part, field.position(), t).unwrap().distance;
                    nearest = nearest.min(away);
                }
            }
            let touches = hull.may_touch(&ground, &Obstacles::none(), &x, &q, 0.05);
            if nearest <= 0.05 {
                within += 1;
                assert!(touches, "{nearest} m at {k}");
            } else {
                supposed += u32::from(touches);
            }
        }
        assert!(within > 200, "{within}");
        assert!(supposed < within / 5, "{supposed} of {within}");
    }

    #[test]
    fn triangles_out_of_reach_make_no_difference_to_a_contact() {
        let ground = rough(41, 0.12);
        let world = World::uniform("test", ground.clone(), vb_world::TerrainClass::Concrete, 0.6);
        let manifolds = |filter: bool, x: V3, q: Quat| {
            let mut hull = hmmwv_over(&ground);
            if !filter {
                hull.physics
                    .narrow_phase
                    .set_query_dispatcher(rapier3d_f64::parry::query::DefaultQueryDispatcher);
            }
            let (mut x, mut q, mut v, mut w) = (x, q, V3::new(3.0, 0.0, -1.0), V3::zeros());
            let footing = Footing { semantics: &world.semantics, soil: &SoilGround::none() };
            hull.resolve(&footing, &mut x, &mut q, &mut v, &mut w);
            (v, w)
        };
        let mut touched = 0;
        for k in (0..8000).step_by(40) {
            let (x, q) = flight(k);
            let (plain, filtered) = (manifolds(false, x, q), manifolds(true, x, q));
            assert_eq!(plain, filtered, "{k}");
            touched += u32::from(plain.0.z > -0.999);
        }
        assert!(touched > 50, "{touched}");
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
