//! What a hull finds under each of its contacts, by the impulses of a single step.

use super::chassis::ChassisContacts;
use super::footing::Footing;
use crate::soil::{SoilGround, SoilSet};
use crate::{Quat, V3};
use std::sync::Arc;
use vb_vehicle::VehicleSpec;
use vb_world::{Heightfield, SoilLevels, TerrainClass, World};

const MASS: f64 = 2000.0;

/// A box of 4 m × 1 m × 0.6 m about the centre of mass, as the hull of the HMMWV.
fn a_box(friction: f64) -> VehicleSpec {
    let text = include_str!("../../../../../tasks/vehicles/hmmwv.yaml");
    let mut spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
    spec.chassis.com = [0.0; 3];
    spec.chassis.friction = friction;
    spec.chassis.wheel_faces = false;
    let corner = |k: usize| {
        let sign = |bit: usize| if k & bit == 0 { 1.0 } else { -1.0 };
        [2.0 * sign(1), 0.5 * sign(2), 0.3 * sign(4)]
    };
    spec.chassis.hull = vec![(0..8).map(corner).collect()];
    spec
}

/// Level ground that is of one kind in the west and of another in the east.
fn ground(west: (TerrainClass, f64), east: (TerrainClass, f64)) -> World {
    let mut world = World::uniform("test", Heightfield::flat(41, 41, 1.0, 0.0), west.0, west.1);
    (world.semantics.rows, world.semantics.cols, world.semantics.patch) = (2, 2, 20.0);
    world.semantics.classes = vec![west.0, east.0, west.0, east.0];
    world.semantics.friction = vec![west.1, east.1, west.1, east.1];
    world.semantics.soil = SoilLevels::default();
    world
}

fn soil_of(world: &World) -> SoilGround {
    let soils = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/soils/default.yaml");
    SoilGround::new(world, &SoilSet::load(soils.as_ref()).unwrap(), 0.1).unwrap()
}

/// Impulses on the hull, N s, upwards and against its sideways motion of 5 m/s, in a step in which it arrives at the ground
/// at 0.5 m/s.
fn impulses(world: &World, soil: &SoilGround, friction: f64, mut x: V3, mut q: Quat) -> (f64, f64) {
    let surroundings = Arc::new(world.clone()).into();
    let inertia = V3::repeat(3000.0);
    let spec = a_box(friction);
    let mut hull = ChassisContacts::new(&spec, &surroundings, MASS, inertia, V3::zeros(), 1e-3);
    hull.look_for_heaps(soil, &x, &q);
    let footing = Footing { semantics: &world.semantics, soil };
    let (mut v, mut w) = (V3::new(0.0, 5.0, -0.5), V3::zeros());
    hull.resolve(&footing, &mut x, &mut q, &mut v, &mut w);
    (MASS * (v.z + 0.5), MASS * (5.0 - v.y))
}

/// The box with its tail or its nose on the ground and its centre of mass at x = ±1 m beyond the border.
fn tilted(x: f64, nose_down: f64) -> (V3, Quat) {
    let q = Quat::from_axis_angle(&V3::y_axis(), nose_down);
    let corner = |k: usize| q * V3::new(if k & 1 == 0 { 2.0 } else { -2.0 }, 0.0, -0.3);
    let lowest = corner(0).z.min(corner(1).z);
    (V3::new(x, 0.0, -lowest), q)
}

#[test]
fn a_hull_on_rock_is_held_by_the_rock_though_its_centre_of_mass_is_over_ice() {
    let (rock, ice) = ((TerrainClass::Rock, 0.8), (TerrainClass::Concrete, 0.1));
    for (west, east, mu) in [(rock, ice, 0.8), (ice, rock, 0.1)] {
        let world = ground(west, east);
        // The tail is 2 m behind the centre of mass, in the west.
        let (x, q) = tilted(1.0, -0.2);
        let (normal, sideways) = impulses(&world, &soil_of(&world), 1.0, x, q);
        assert!(normal > 100.0, "{normal} N s");
        assert!((sideways / normal / mu - 1.0).abs() < 0.02, "{} for {mu}", sideways / normal);
    }
}

#[test]
fn on_rigid_ground_the_smaller_friction_of_hull_and_patch_counts() {
    for (hull, patch, mu) in [(0.4, 0.8, 0.4), (0.4, 0.2, 0.2)] {
        let kind = (TerrainClass::Rock, patch);
        let world = ground(kind, kind);
        let (x, q) = tilted(0.0, 0.2);
        let (normal, sideways) = impulses(&world, &soil_of(&world), hull, x, q);
        assert!((sideways / normal / mu - 1.0).abs() < 0.02, "{} for {mu}", sideways / normal);
    }
}

#[test]
fn a_flat_hull_on_two_patches_has_the_mean_of_their_frictions() {
    let world = ground((TerrainClass::Rock, 0.8), (TerrainClass::Concrete, 0.2));
    let (normal, sideways) =
        impulses(&world, &soil_of(&world), 1.0, V3::new(0.0, 0.0, 0.3), Quat::identity());
    let mu = sideways / normal;
    assert!((0.35..0.65).contains(&mu), "{mu}");
}

#[test]
fn on_sand_the_hull_slides_by_the_friction_of_steel_on_sand() {
    let kind = (TerrainClass::Sand, 0.0);
    let world = ground(kind, kind);
    let soil = soil_of(&world);
    let phi = vb_math::atan(soil.soils()[0].tan_phi);
    let (x, q) = tilted(0.0, 0.2);
    let (normal, sideways) = impulses(&world, &soil, 1.0, x, q);
    let mu = vb_math::tan(0.6 * phi);
    assert!((sideways / normal / mu - 1.0).abs() < 0.02, "{} for {mu}", sideways / normal);
}

/// Presses the cells of soil at which `pressed` is true by 0.2 m.
fn pressed(world: &World, pressed: impl Fn(f64, f64) -> bool) -> SoilGround {
    let mut soil = soil_of(world);
    for i in 0..120 {
        for j in 0..120 {
            let at = [-5.95 + 0.1 * f64::from(i), -5.95 + 0.1 * f64::from(j)];
            let cell = soil.grid.at_mut(at[0], at[1]).unwrap();
            if pressed(at[0], at[1]) {
                cell.plastic = 0.2;
            }
        }
    }
    soil
}

#[test]
fn the_hull_stands_on_what_wheels_have_left_of_the_soil() {
    let kind = (TerrainClass::Sand, 0.0);
    let world = ground(kind, kind);
    let at = |soil: &SoilGround, height: f64| {
        impulses(&world, soil, 1.0, V3::new(0.05, 0.05, 0.3 + height), Quat::identity()).0
    };
    let untouched = at(&soil_of(&world), 0.0);
    assert!(untouched > 0.9 * 0.5 * MASS, "{untouched} N s stop it");
    // Two ruts beside it, and the ridge between them carries it.
    let ruts = pressed(&world, |_, y| (0.7..1.0).contains(&(y - 0.05).abs()));
    assert!(at(&ruts, 0.0) > 0.9 * 0.5 * MASS);
    // Its edges are over ruts, but not its middle.
    let ridge = pressed(&world, |_, y| (y - 0.05).abs() > 0.36);
    assert!(at(&ridge, 0.0) > 0.9 * 0.5 * MASS);
    // All of it has been pressed.
    let all = pressed(&world, |_, _| true);
    assert_eq!(at(&all, 0.0), 0.0);
    assert!(at(&all, -0.2) > 0.9 * 0.5 * MASS);
    // A heap of 10 cm under it.
    let mut heap = soil_of(&world);
    for i in 0..40 {
        for j in 0..10 {
            let cell = heap.grid.at_mut(-1.95 + 0.1 * f64::from(i), -0.45 + 0.1 * f64::from(j));
            cell.unwrap().raised = 0.1;
        }
    }
    assert!(at(&heap, 0.1) > 0.9 * 0.5 * MASS);
    assert_eq!(at(&heap, 0.16), 0.0);
}

#[test]
fn contacts_that_rapier_keeps_are_those_that_were_corrected() {
    // A hull that lies still, then creeps: rapier keeps contacts or finds them again, and their friction stays the ground's.
    let world = ground((TerrainClass::Rock, 0.3), (TerrainClass::Rock, 0.3));
    let soil = soil_of(&world);
    let footing = Footing { semantics: &world.semantics, soil: &soil };
    let surroundings = Arc::new(world.clone()).into();
    let mut hull =
        ChassisContacts::new(&a_box(1.0), &surroundings, MASS, V3::repeat(3000.0), V3::zeros(), 1e-3);
    let (mut x, mut q) = (V3::new(0.0, 0.0, 0.3), Quat::identity());
    let (mut v, mut w) = (V3::zeros(), V3::zeros());
    for k in 0..1500 {
        v.z -= 9.81e-3;
        // 0.5 g forwards, which friction of 0.3 doesn't hold and friction of 1 would.
        v.x += if k > 200 { 0.5 * 9.81e-3 } else { 0.0 };
        hull.resolve(&footing, &mut x, &mut q, &mut v, &mut w);
    }
    let expected = (0.5 - 0.3) * 9.81 * 1.3;
    assert!((v.x / expected - 1.0).abs() < 0.05, "{} m/s, expected {expected}", v.x);
}
