//! The equations of motion with every kind of suspension.

use super::*;
use crate::collision::Obstacles;
use crate::granular::Beds;
use crate::soil::SoilGround;
use crate::tyre::{Contact, WheelMotion};
use vb_vehicle::suspension::{Damper, Linkage, Spring, SteeringGear, Strut};
use vb_vehicle::{
    GRAVITY,
    suspension::{AntiRoll, Beam as BeamSpec, LeafAxle, Part, Rod, SolidAxle, Stops, Torsion, TorsionArm},
};
use vb_world::{Heightfield, Semantics, TerrainClass};

fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv").unwrap()
}

pub(super) fn build(spec: &VehicleSpec) -> Vehicle {
    let axles: Vec<_> = spec.axles.iter().map(|a| AxleKinematics::solve(a).unwrap()).collect();
    Vehicle::new(spec, &axles, 0.1)
}

fn spring(stiffness: f64, free_length: f64) -> Option<Spring> {
    Some(Spring::Linear { stiffness, free_length, preload: 0.0 })
}

/// The HMMWV on two solid axles on rods, each end on an upright spring.
pub(super) fn on_beams(damping: f64) -> VehicleSpec {
    let mut spec = hmmwv();
    for axle in &mut spec.axles {
        axle.steering = None;
        axle.suspension.linkage = Linkage::SolidAxle(SolidAxle {
            spindle: [0.0, 0.909_701, 0.0],
            beam: BeamSpec { mass: 120.0, inertia: 40.0 },
            links: vec![
                Rod { chassis: [-0.8, 0.4, -0.05], carrier: [0.0, 0.45, -0.1] },
                Rod { chassis: [-0.8, 0.4, 0.2], carrier: [0.0, 0.0, 0.2] },
            ],
            single_links: vec![],
            knuckles: None,
        });
        axle.suspension.struts = vec![Strut {
            chassis: [0.0, 0.6, 0.5],
            end: [0.0, 0.7, 0.0],
            part: Part::Beam,
            spring: spring(90000.0, 0.58),
            damper: Some(Damper::Linear { coefficient: damping }),
            stops: None,
        }];
    }
    spec
}

fn on_leaves() -> VehicleSpec {
    let mut spec = on_beams(0.0);
    for axle in &mut spec.axles {
        axle.suspension.linkage = Linkage::LeafAxle(LeafAxle {
            spindle: [0.0, 0.909_701, 0.0],
            beam: BeamSpec { mass: 120.0, inertia: 40.0 },
            seat: [0.0, 0.5, 0.08],
            eye: [0.6, 0.5, 0.15],
            knuckles: None,
        });
    }
    spec
}

fn on_arms() -> VehicleSpec {
    let mut spec = hmmwv();
    for axle in &mut spec.axles {
        axle.steering = None;
        axle.suspension.linkage = Linkage::TorsionArm(TorsionArm {
            spindle: [0.0, 0.909_701, 0.0],
            pivot: [0.35, 0.7, 0.12],
            axis: [0.1, 1.0, 0.0],
            torsion: Some(Torsion { stiffness: 12000.0, damping: 0.0, preload: 1500.0 }),
        });
        axle.suspension.struts.clear();
    }
    spec
}

fn without_damping(mut spec: VehicleSpec) -> VehicleSpec {
    for axle in &mut spec.axles {
        // Out of reach: the stops' energy isn't in the sum.
        axle.suspension.stops = None;
        axle.suspension.struts.iter_mut().for_each(|s| s.damper = None);
    }
    spec
}

impl Vehicle {
    /// Its wheels and beams where they are, with the steering at rest.
    pub(super) fn placed(&mut self) -> Kinematics<'_> {
        let Self { design, state, last, .. } = self;
        let steering = Steering { command: state.steering.command, rate: 0.0, stalled: false };
        let (placements, beams) = (&mut last.placements, &mut last.beams);
        Kinematics::place(design, &state.body, &state.wheels, steering, placements, beams)
    }

    /// Kinetic energy seen from a frame that moves with `frame`, and energy of springs, J. The energy of a spring is
    /// its force's integral from a length of 0.3, by Simpson's rule, which is exact for straight lines.
    fn energy(&self, frame: V3) -> f64 {
        let mut copy = self.clone();
        let Kinematics { body, wheels, placements, beams, .. } = copy.placed();
        let design = &self.design;
        let local = body.q.inverse() * body.w_world;
        let mut e = 0.5 * design.mass * (body.v_world - frame).norm_squared()
            + 0.5 * local.dot(&design.inertia.component_mul(&local));
        for (c, p) in design.corners.iter().zip(placements) {
            let extra = match c.guide {
                Guide::Beam(b) => design.beams[b].at_hub,
                _ => 0.0,
            };
            e += 0.5 * (c.mass + extra) * (p.motion.velocity - frame).norm_squared();
            for (k, s) in c.struts.iter().enumerate() {
                let (a, b) = (0.3, p.struts[k]);
                e -= (b - a) / 6.0 * (s.force(a) + 4.0 * s.force(0.5 * (a + b)) + s.force(b));
            }
        }
        for (b, p) in design.beams.iter().zip(beams) {
            let rates = [0, 1].map(|i| wheels[b.left + i].travel_rate);
            let v = body.v_world - frame
                + body.w_world.cross(&p.arm)
                + p.tangents[0] * rates[0]
                + p.tangents[1] * rates[1];
            e += 0.5 * b.at_middle * v.norm_squared();
        }
        e
    }

    /// Makes the chassis as good as fixed.
    fn hold_chassis(&mut self) {
        let design = Arc::make_mut(&mut self.design);
        (design.mass, design.inertia) = (1e9, V3::repeat(1e9));
    }
}

fn flat() -> (Heightfield, Semantics, Obstacles) {
    let semantics = Semantics {
        rows: 1,
        cols: 1,
        patch: 2.0,
        classes: vec![TerrainClass::Clay],
        friction: vec![0.6],
        soil: vb_world::SoilLevels::default(),
    };
    (Heightfield::flat(3, 3, 1.0, 0.0), semantics, Obstacles::none())
}

/// Lets the vehicle tumble far above the ground; calls `see` after every step with the time.
fn fall(vehicle: &mut Vehicle, dt: f64, steps: u32, mut see: impl FnMut(&Vehicle, f64)) {
    let (heightfield, semantics, obstacles) = flat();
    let mut soil = SoilGround::none();
    let mut ground = Ground {
        soil: &mut soil,
        heightfield: &heightfield,
        semantics: &semantics,
        obstacles: &obstacles,
        beds: &mut Beds::none(),
    };
    vehicle.state.body.x_world.z = 100.0;
    for k in 1..=steps {
        vehicle.accelerate(Controls::default(), &mut ground, dt);
        vehicle.body_mut().move_on(dt);
        see(vehicle, dt * f64::from(k));
    }
}

/// Greatest change of energy in a tumbling fall, over the energy that moves to and fro.
fn drift(spec: &VehicleSpec, dt: f64) -> f64 {
    let mut vehicle = build(spec);
    vehicle.state.body.w_world = V3::new(0.9, -0.5, 0.7);
    for (w, travel) in vehicle.state.wheels.iter_mut().zip([0.03, 0.02, 0.0, -0.01]) {
        w.travel = travel;
    }
    let before = vehicle.energy(V3::zeros());
    let (mut worst, mut least, mut most) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
    fall(&mut vehicle, dt, (1.5 / dt) as u32, |v, t| {
        // In a frame that falls along, gravity does no work.
        worst = worst.max((v.energy(V3::new(0.0, 0.0, -GRAVITY * t)) - before).abs());
        let travel = v.state.wheels[0].travel;
        (least, most) = (least.min(travel), most.max(travel));
    });
    assert!(vehicle.state.body.x_world.z < 90.0, "it falls");
    assert!(most - least > 0.02, "the suspension works: {least} to {most}");
    worst / before.abs()
}

#[test]
fn in_free_fall_without_dampers_energy_stays_with_every_linkage() {
    for (name, spec) in [
        ("double wishbones", hmmwv()),
        ("beams on rods", on_beams(0.0)),
        ("beams on leaves", on_leaves()),
        ("arms", on_arms()),
    ] {
        let spec = without_damping(spec);
        // Symplectic Euler: an error of the order of the step, no drift.
        let (coarse, fine) = (drift(&spec, 1e-3), drift(&spec, 1.25e-4));
        assert!(coarse < 0.02, "{name}: {coarse}");
        assert!(fine < 0.25 * coarse, "{name}: {fine} at an eighth of the step, {coarse} at the whole");
    }
}

#[test]
fn a_beam_on_its_springs_oscillates_at_its_natural_frequencies() {
    // The chassis is as good as fixed, gravity is balanced by preload: unsprung mass on upright springs at the hubs.
    let mut spec = without_damping(on_beams(0.0));
    spec.chassis.mass = 1e9;
    spec.chassis.inertia = [1e9; 3];
    for axle in &mut spec.axles {
        // Level rods and long upright springs: the motion ratio is 1, and constant.
        if let Linkage::SolidAxle(l) = &mut axle.suspension.linkage {
            l.links[0].chassis = [-8.0, 0.45, -0.1];
            l.links[1].chassis = [-8.0, 3.0, 0.2];
        }
        let strut = &mut axle.suspension.struts[0];
        (strut.chassis, strut.end) = ([0.0, 0.6, 20.0], [0.0, 0.6, 0.0]);
        strut.spring = spring(90000.0, 20.0);
    }
    let (m, beam, half): (f64, f64, f64) = (spec.axles[0].unsprung_mass, 120.0, 0.909_701);
    let k = 90000.0;
    let heave = (2.0 * k / (2.0 * m + beam)).sqrt();
    // About the middle: two hubs and the beam; the triangle's tip 0.2 m above is the roll centre, about which the
    // masses turn.
    let inertia = 2.0 * m * half * half + 40.0 + (2.0 * m + beam) * 0.2 * 0.2;
    let roll = (2.0 * k * 0.6 * 0.6 / inertia).sqrt();
    for (start, expected) in [([0.01, 0.01], heave), ([0.01, -0.01], roll)] {
        let mut vehicle = build(&spec);
        vehicle.state.wheels[0].travel = start[0];
        vehicle.state.wheels[1].travel = start[1];
        let mut crossings = Vec::new();
        let mut before = 1.0;
        fall(&mut vehicle, 1e-4, 10000, |v, t| {
            // In free fall the springs rest at their free length.
            let q = v.state.wheels[0].travel;
            if before < 0.0 && q >= 0.0 {
                crossings.push(t);
            }
            before = q;
        });
        let periods = (crossings.len() - 1) as f64;
        let period = (crossings[crossings.len() - 1] - crossings[0]) / periods;
        let frequency = 2.0 * std::f64::consts::PI / period;
        assert!((frequency / expected - 1.0).abs() < 0.01, "{start:?}: {frequency} rad/s, {expected}");
    }
}

#[test]
fn an_anti_roll_bar_resists_roll_alone() {
    for mut spec in [without_damping(hmmwv()), without_damping(on_beams(0.0))] {
        let springs = build(&spec);
        for axle in &mut spec.axles {
            axle.suspension.anti_roll = Some(AntiRoll::Travel { stiffness: 40000.0 });
        }
        let bars = build(&spec);
        // The travels' accelerations in the first step, with a bar less without.
        let first = |vehicle: &Vehicle, travels: [f64; 2]| {
            let mut v = vehicle.clone();
            v.hold_chassis();
            (v.state.wheels[0].travel, v.state.wheels[1].travel) = (travels[0], travels[1]);
            let mut rates = [0.0; 2];
            fall(&mut v, 1e-3, 1, |v, _| rates = [0, 1].map(|i| v.state.wheels[i].travel_rate / 1e-3));
            rates
        };
        let change = |travels: [f64; 2]| {
            let (a, b) = (first(&springs, travels), first(&bars, travels));
            [b[0] - a[0], b[1] - a[1]]
        };
        assert!(change([0.03, 0.03]).iter().all(|x| x.abs() < 1e-6));
        let [l, r] = change([0.03, -0.03]);
        // 40 kN/m over 0.06 m against the unsprung mass of one end.
        let mass = |v: &Vehicle| {
            let mass = v.design.corners[0].mass;
            v.design.beams.first().map_or(mass, |b| mass + b.at_hub)
        };
        let expected = -40000.0 * 0.06 / mass(&bars);
        assert!((l / expected - 1.0).abs() < 0.1, "{l} {expected}");
        assert!((l + r).abs() < 0.1 * l.abs(), "{l} {r}");
    }
}

#[test]
fn a_bar_with_drop_links_resists_roll_by_the_twist_of_its_arms() {
    let mut spec = without_damping(hmmwv());
    let springs = build(&spec);
    let (stiffness, arm) = (8000.0, 0.25);
    for axle in &mut spec.axles {
        // Long upright drop links from the lower arms, on which they sit at the ball joints' height.
        axle.suspension.anti_roll = Some(AntiRoll::Bar {
            stiffness,
            damping: 0.0,
            pivot: [0.25, 0.78, 5.0],
            arm_end: [0.0, 0.78, 5.0],
            link_end: [0.0, 0.78, -0.118],
            part: Part::Arm,
        });
    }
    let bars = build(&spec);
    let force = |vehicle: &Vehicle, travels: [f64; 2]| {
        let mut v = vehicle.clone();
        v.hold_chassis();
        (v.state.wheels[0].travel, v.state.wheels[1].travel) = (travels[0], travels[1]);
        let mut rate = 0.0;
        fall(&mut v, 1e-3, 1, |v, _| rate = v.state.wheels[0].travel_rate);
        rate / 1e-3 * v.design.corners[0].mass
    };
    let change = |travels: [f64; 2]| force(&bars, travels) - force(&springs, travels);
    assert!(change([0.02, 0.02]).abs() < 1e-6);
    // The links follow the wheels nearly one to one: a twist of 0.04 m over the arm, back through the same ratio.
    let expected = -stiffness * (0.04 / arm) / arm;
    let got = change([0.02, -0.02]);
    assert!((got / expected - 1.0).abs() < 0.15, "{got} N, {expected} N");
}

/// Sets the vehicle down on flat ground, brakes on, and lets it come to rest.
fn at_rest(spec: &VehicleSpec) -> Vehicle {
    let mut vehicle = build(spec);
    let (heightfield, semantics, obstacles) = flat();
    let mut soil = SoilGround::none();
    let mut ground = Ground {
        soil: &mut soil,
        heightfield: &heightfield,
        semantics: &semantics,
        obstacles: &obstacles,
        beds: &mut Beds::none(),
    };
    vehicle.state.body.x_world.z = spec.tyre.radius() + spec.chassis.com[2];
    let controls = Controls { brake: 1.0, ..Controls::default() };
    for _ in 0..6000 {
        vehicle.accelerate(controls, &mut ground, 1e-3);
        vehicle.body_mut().move_on(1e-3);
    }
    vehicle
}

#[test]
fn every_suspension_carries_the_vehicles_weight_at_rest() {
    let mut rigid = hmmwv();
    rigid.axles[1].suspension = vb_vehicle::suspension::Suspension {
        linkage: Linkage::Rigid(vb_vehicle::suspension::RigidMount { spindle: [0.0, 0.909_701, -0.026] }),
        range: [0.0; 2],
        struts: vec![],
        stops: None,
        anti_roll: None,
    };
    let mut arms = on_arms();
    for axle in &mut arms.axles {
        if let Linkage::TorsionArm(l) = &mut axle.suspension.linkage
            && let Some(t) = &mut l.torsion
        {
            t.damping = 600.0;
        }
    }
    let mut pivot = hmmwv();
    pivot.axles[1].suspension.linkage = Linkage::PivotAxle(vb_vehicle::suspension::PivotAxle {
        spindle: [0.0, 0.909_701, -0.026],
        beam: BeamSpec { mass: 120.0, inertia: 40.0 },
        pin_height: 0.1,
        knuckles: None,
    });
    pivot.axles[1].suspension.struts.clear();
    let stops = Some(Stops { jounce: 0.12, rebound: -0.12, stiffness: 8e5, table: vec![] });
    for (name, mut spec) in [("beams on rods", on_beams(8000.0)), ("arms", arms), ("rigid rear", rigid)] {
        for axle in &mut spec.axles {
            if !matches!(axle.suspension.linkage, Linkage::Rigid(_)) {
                axle.suspension.stops.clone_from(&stops);
            }
        }
        let v = at_rest(&spec);
        assert!(
            v.body().v_world.norm() < 1e-3 && v.body().w_world.norm() < 1e-3,
            "{name}: {} {}",
            v.body().v_world,
            v.body().w_world
        );
        let carried: f64 = v.last.forces.iter().map(|f| f.load).sum();
        let weight = GRAVITY * spec.total_mass();
        assert!((carried / weight - 1.0).abs() < 1e-3, "{name}: {carried} {weight}");
        let (mass, _, _) = v.composite();
        assert!((mass / spec.total_mass() - 1.0).abs() < 1e-12, "{name}");
        let (left, right) = (v.last.forces[0].load, v.last.forces[1].load);
        assert!((left / right - 1.0).abs() < 0.01, "{name}: {left} {right}");
        for (i, c) in v.state.wheels.iter().enumerate() {
            assert!(c.travel.abs() < 0.13, "{name}: travel {i} {}", c.travel);
        }
    }
}

#[test]
fn every_steered_axle_turns_by_its_own_gear() {
    let mut spec = hmmwv();
    let gear = SteeringGear::RackAndPinion { travel: -0.02 };
    spec.axles[1].steering = Some(gear);
    let v = build(&spec);
    let angle = |i: usize| {
        let (_, axis) = v.design.guided(&v.design.corners[i], [0.0; 2], 1.0);
        vb_math::atan2(-axis.x, axis.y)
    };
    assert!(angle(0) > 0.3, "front to the left: {}", angle(0));
    // The rear's tie rods lie ahead of the axle.
    assert!(angle(2).abs() > 0.05 && angle(2).abs() < 0.2, "rear by less: {}", angle(2));
}

#[test]
fn a_contact_deepens_as_the_wheel_approaches_and_not_from_nowhere() {
    let moving = |velocity: V3| WheelMotion {
        hub: V3::new(0.0, 0.0, 0.4),
        velocity,
        rotation: V3::new(0.0, 10.0, 0.0),
        axis: V3::y(),
        spin: 10.0,
    };
    let at = |depth| Contact { point: V3::zeros(), normal: V3::z(), depth };
    // Falling at 3 m/s, and rolling at 5 m/s over an edge that raises the ground by a fifth of the way.
    let (mut depth, dt) = (0.0, 1e-3);
    for k in 1..=50 {
        let deep = 3e-3 * f64::from(k);
        assert_eq!(moving(V3::new(0.0, 0.0, -3.0)).held(&at(deep), &mut depth, 0.4, dt).0.depth, deep);
    }
    let mut depth = 0.01;
    assert_eq!(moving(V3::new(5.0, 0.0, 0.0)).held(&at(0.011), &mut depth, 0.4, dt).0.depth, 0.011);
    // Its lowest point changes sides: half a metre at once. As it leaves the ground, or at rest, that is let out slowly.
    let mut depth = 0.01;
    let (held, limited) = moving(V3::new(0.0, 0.0, 0.5)).held(&at(0.5), &mut depth, 0.4, dt);
    assert!(limited && held.depth < 0.0101 && held.depth == depth, "{}", held.depth);
    assert!(moving(V3::zeros()).held(&at(0.5), &mut depth, 0.4, dt).0.depth < 0.0102);
    // What shrinks isn't held.
    assert_eq!(moving(V3::zeros()).held(&at(0.003), &mut depth, 0.4, dt).0.depth, 0.003);
    // On its flank it isn't thrown any faster by being found as deep in another place, and never pulled.
    let flank = WheelMotion { axis: V3::z(), rotation: V3::zeros(), ..moving(V3::new(0.0, 0.0, 4.0)) };
    let mut depth = 0.01;
    let held = flank.held(&at(0.01), &mut depth, 0.4, dt).0.depth;
    assert!((0.006..0.00605).contains(&held), "{held}");
    for _ in 0..10 {
        flank.held(&at(0.01), &mut depth, 0.4, dt);
    }
    assert_eq!(depth, 0.0);
}

#[test]
fn a_wheel_that_comes_from_facets_to_soil_forgets_them() {
    let released = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");
    let mut vehicle = at_rest(&VehicleSpec::parse(released, "hmmwv-released").unwrap());
    let soils = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/soils/default.yaml");
    let soils = crate::SoilSet::load(soils.as_ref()).unwrap();
    let mut facets_on = |class| {
        let world = vb_world::World::uniform("w", Heightfield::flat(33, 33, 1.0, 0.0), class, 0.6);
        let mut soil = SoilGround::new(&world, &soils, 0.1).unwrap();
        let mut ground = Ground {
            soil: &mut soil,
            heightfield: &world.heightfield,
            semantics: &world.semantics,
            obstacles: &Obstacles::none(),
            beds: &mut Beds::none(),
        };
        vehicle.accelerate(Controls::default(), &mut ground, 1e-3);
        vehicle.state.contacts.iter().map(|c| c.facets.digest().count()).sum::<usize>()
    };
    assert!(facets_on(TerrainClass::Concrete) > 0, "it stands on facets");
    assert_eq!(facets_on(TerrainClass::Mud), 0);
}

/// A vehicle at rest on flat ground with trunks, and what is around it.
fn among(trunks: &[[f64; 2]]) -> (vb_world::World, Obstacles) {
    let obstacle = |p: &[f64; 2]| vb_world::Obstacle {
        x: p[0],
        y: p[1],
        yaw: 0.0,
        buried: 0.5,
        kind: vb_world::ObstacleKind::Trunk { radius: 0.3, height: 3.0 },
    };
    let mut world =
        vb_world::World::uniform("w", Heightfield::flat(33, 33, 1.0, 0.0), TerrainClass::Concrete, 0.8);
    world.obstacles = trunks.iter().map(obstacle).collect();
    let mut obstacles = Obstacles::new(&Arc::new(world.clone()).into());
    obstacles.look_around(&V3::zeros(), 20.0);
    (world, obstacles)
}

#[test]
fn a_wheel_that_is_wedged_between_two_trunks_is_pushed_by_both() {
    let vehicle = at_rest(&hmmwv());
    let hub = vehicle.hubs().next().unwrap().0;
    let radius = 0.467 + 0.3 - 0.01;
    let forces = |trunks: &[[f64; 2]]| {
        let (world, obstacles) = among(trunks);
        let mut soil = SoilGround::none();
        let (heightfield, semantics) = (&world.heightfield, &world.semantics);
        let mut v = vehicle.clone();
        // However deep it is there.
        v.state.contacts[0].obstacles = super::obstacles::ObstaclePatches::at_any_depth();
        let mut ground = Ground {
            soil: &mut soil,
            heightfield,
            semantics,
            obstacles: &obstacles,
            beds: &mut Beds::none(),
        };
        v.accelerate(Controls::default(), &mut ground, 1e-3);
        (v.last.forces[0].force.x, v.last.forces[0].load)
    };
    let (ahead, behind) = ([hub.x + radius, hub.y], [hub.x - radius, hub.y]);
    let (alone, free, both) = (forces(&[ahead]), forces(&[]), forces(&[ahead, behind]));
    let push = alone.0 - free.0;
    // About a centimetre of the tyre.
    assert!(push < -1000.0, "{push} N");
    assert!((both.0 - free.0).abs() < 0.1 * push.abs(), "{} N along of {push}", both.0 - free.0);
    let (one, two) = (alone.1 - free.1, both.1 - free.1);
    assert!((two / one - 2.0).abs() < 0.1, "{one} and {two} N");
}

/// The command, the load on it (N m) and the work of the steering (J) after a second in which a vehicle at rest, with brakes
/// on, is asked to turn its wheels fully to the left.
fn steered(spec: &VehicleSpec, trunks: impl Fn(V3) -> Vec<[f64; 2]>) -> (f64, f64, f64) {
    let mut vehicle = at_rest(spec);
    let (world, obstacles) = among(&trunks(vehicle.hubs().next().unwrap().0));
    let mut soil = SoilGround::none();
    let mut most = 0.0_f64;
    for _ in 0..1000 {
        let (heightfield, semantics) = (&world.heightfield, &world.semantics);
        let mut ground = Ground {
            soil: &mut soil,
            heightfield,
            semantics,
            obstacles: &obstacles,
            beds: &mut Beds::none(),
        };
        let controls = Controls { steering: 1.0, brake: 1.0, ..Controls::default() };
        vehicle.accelerate(controls, &mut ground, 1e-3);
        vehicle.body_mut().move_on(1e-3);
        most = most.max(vehicle.state.steering.load.abs());
    }
    (vehicle.steering(), most, vehicle.state.steering.work)
}

#[test]
fn a_rack_turns_the_wheels_at_rest_but_does_not_push_through_trunks() {
    let hmmwv =
        || VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap();
    let limited = |force| {
        let mut spec = hmmwv();
        spec.steering.force = force;
        spec
    };
    // Turning left, the left wheel's front goes to the left and its rear to the right, where trunks are.
    let aside = 0.5 * hmmwv().tyre.width() + 0.3 + 0.03;
    let blocked = |hub: V3| vec![[hub.x + 0.35, hub.y + aside], [hub.x - 0.35, hub.y - aside]];
    let force = 15_000.0;
    let Some(SteeringGear::RackAndPinion { travel }) = hmmwv().axles[0].steering else { panic!("a rack") };
    let effort = force * travel.abs();
    // Free: both wheels turn, for less than the limit.
    let (command, most, work) = steered(&limited(Some(force)), |_| vec![]);
    assert!(command > 0.99 && most < effort, "{command}, {most} N m");
    assert!(work > 0.0, "{work} J rub the tyres");
    // Against the trunks an unlimited rack does what it wants, one with a limit stalls.
    let (command, most, _) = steered(&limited(None), blocked);
    assert!(command > 0.99 && most > 2.0 * effort, "{command}, {most} N m");
    let (command, most, work) = steered(&limited(Some(force)), blocked);
    assert!(command < 0.7, "{command}");
    // Beyond its limit only by the inertia of the wheels that hit.
    assert!(most < 1.5 * effort, "{most} N m of {effort}");
    assert!(work < effort, "{work} J over less than the whole way");
}
