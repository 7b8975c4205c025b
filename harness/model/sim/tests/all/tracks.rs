//! Tracks, by the M113: against theory of tracked vehicles and the published figures of the real one.

use crate::common::{controls, hold_speed};
use std::sync::Arc;
use vb_sim::{
    SimOptions, Simulation, SoilSet,
    soil::{Bekker, PressureDirection, Sinkage, Snow, SoilLaw},
};
use vb_vehicle::{GRAVITY, VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

/// Radius of a road wheel, and gauge, m.
const WHEEL: f64 = 0.305;
const GAUGE: f64 = 2.159;
/// Length of ground that five wheels stand for, 0.667 m apart, m.
const LENGTH: f64 = 5.0 * 0.667;

fn m113() -> VehicleModel {
    let text = include_str!("../../../../../tasks/vehicles/m113.yaml");
    crate::common::model(VehicleSpec::parse(text, "m113.yaml").expect("the shipped vehicle is valid"))
}

fn start(world: &Arc<World>, model: &VehicleModel, soils: &SoilSet, x: f64) -> Simulation {
    let at = Pose2 { x, y: 0.0, yaw: 0.0 };
    Simulation::new(world.clone(), model, soils, at, SimOptions::default()).expect("it settles")
}

/// Ground whose height depends on x alone, nodes 0.1 m apart.
fn across(height: impl Fn(f64) -> f64) -> Arc<World> {
    let (rows, cols) = (41, 401);
    let heights = (0..rows * cols).map(|i| height((i % cols) as f64 * 0.1 - 20.0)).collect();
    crate::common::world(Heightfield::new(rows, cols, 0.1, heights), 0.8, vec![])
}

/// Drives at a speed until x, or for half a minute; returns where it is then.
fn drive_to(sim: &mut Simulation, speed: f64, x: f64) -> f64 {
    while sim.time() < 30.0 && sim.state().position.x < x {
        let controls = hold_speed(sim, speed, 0.0);
        sim.advance(controls, 100).expect("it goes on");
    }
    sim.state().position.x
}

/// Speed of a side's belt, m/s.
fn belt(sim: &Simulation, side: usize) -> f64 {
    sim.state().wheels[2 + side].speed * WHEEL
}

#[test]
fn on_hard_ground_the_belts_move_as_fast_as_the_vehicle() {
    let mut sim = start(&crate::common::flat(0.8), &m113(), &crate::common::soils(), 0.0);
    for _ in 0..100 {
        let controls = hold_speed(&sim, 5.0, 0.0);
        sim.advance(controls, 100).expect("it goes on");
    }
    let v = sim.state().velocity_body.x;
    assert!(v > 4.0);
    for side in [0, 1] {
        assert!((belt(&sim, side) / v - 1.0).abs() < 0.01, "{} m/s, {v} m/s", belt(&sim, side));
    }
}

/// Nikitin's formula as quoted by Wong (Theory of Ground Vehicles, ch. 6): the moment of resistance to turning is
/// μ_t W L/4 with μ_t = μ/(0.925 + 0.15 R/B), from trials; it holds within some ten percent. In steady turning the belts' forces
/// differ by that of the brake that steers.
#[test]
fn the_resistance_to_turning_falls_with_the_radius_as_in_trials() {
    let (model, world) = (m113(), crate::common::flat(0.8));
    let weight = model.spec().total_mass() * GRAVITY;
    let torque = model.spec().tracks.as_ref().expect("a tracked vehicle").steering_torque;
    let mut last = f64::INFINITY;
    for steering in [0.1, 0.2, 0.3, 0.4, 0.5] {
        let mut sim = start(&world, &model, &crate::common::soils(), 0.0);
        for _ in 0..150 {
            let controls = hold_speed(&sim, 3.0, steering);
            sim.advance(controls, 100).expect("it goes on");
        }
        let s = sim.state();
        let radius = s.velocity_body.x / s.angular_velocity_body.z;
        let moment = 0.5 * GAUGE * steering * torque / (0.2792 - 0.03);
        let fraction = moment / (0.25 * weight * LENGTH) / 0.8;
        let trials = 1.0 / (0.925 + 0.15 * radius / GAUGE);
        assert!(
            (fraction / trials - 1.0).abs() < 0.3,
            "at {radius} m: {fraction} of all friction, trials {trials}"
        );
        assert!(radius < 0.8 * last, "{radius} m at {steering}, {last} m before");
        last = radius;
    }
}

/// With the inner belt locked the vehicle turns about a point below it, if not quite: the belt is dragged along.
#[test]
fn at_full_steering_it_turns_about_its_inner_track_and_stays_level() {
    for sign in [1.0, -1.0] {
        let mut sim = start(&crate::common::flat(0.8), &m113(), &crate::common::soils(), 0.0);
        for _ in 0..100 {
            let controls = hold_speed(&sim, 3.0, sign);
            sim.advance(controls, 100).expect("it goes on");
        }
        let s = sim.state();
        let inner = usize::from(sign < 0.0);
        assert!(belt(&sim, inner).abs() < 0.01 && belt(&sim, 1 - inner) > 1.0);
        let radius = s.velocity_body.x / s.angular_velocity_body.z.abs();
        assert!(s.angular_velocity_body.z * sign > 0.3, "{}", s.angular_velocity_body.z);
        assert!((0.5 * GAUGE..GAUGE).contains(&radius), "{radius} m from its middle");
        assert!(s.roll_pitch_yaw().0.abs() < 0.02);
    }
}

/// Published: 60 % grade, vertical obstacle 0.61 m, trench 1.68 m. Higher than its sprocket's axle, at 0.58 m and 0.28 m
/// of radius, is a wall.
#[test]
fn it_climbs_the_published_step_and_grade_crosses_the_published_trench_and_stops_at_a_wall() {
    let (model, soils) = (m113(), crate::common::soils());
    for (height, over) in [(0.3, true), (0.61, true), (0.9, false)] {
        let mut sim = start(&across(|x| if x > 0.0 { height } else { 0.0 }), &model, &soils, -8.0);
        let x = drive_to(&mut sim, 1.5, 8.0);
        assert_eq!(x >= 8.0, over, "a step of {height} m: at {x} m");
    }
    let mut sim = start(&across(|x| if x > 0.0 && x < 1.68 { -1.5 } else { 0.0 }), &model, &soils, -8.0);
    let mut lowest = f64::INFINITY;
    while sim.time() < 30.0 && sim.state().position.x < 8.0 {
        let controls = hold_speed(&sim, 2.0, 0.0);
        sim.advance(controls, 100).expect("it goes on");
        lowest = sim.state().position.z.min(lowest);
    }
    assert!(sim.state().position.x >= 8.0 && lowest > 0.1, "it bridges the trench: {lowest} m");
    let mut sim = start(&crate::common::grade(30.96, 0.8), &model, &soils, -100.0);
    assert!(drive_to(&mut sim, 3.0, -85.0) >= -85.0, "60 %");
}

/// Friction's bound, atan μ, less what it takes to move on.
#[test]
fn on_a_slope_it_climbs_up_to_the_angle_of_friction_and_slides_beyond() {
    let bound = vb_math::atan(0.5).to_degrees();
    for (degrees, climbs) in [(bound - 1.5, true), (bound + 0.5, false)] {
        let mut sim = start(&crate::common::grade(degrees, 0.5), &m113(), &crate::common::soils(), 0.0);
        drive_to(&mut sim, 2.0, 10.0);
        let x = sim.state().position.x;
        assert_eq!(x > 5.0, climbs, "{degrees} degrees: {x} m");
    }
}

#[test]
fn parked_on_a_slope_it_stays() {
    let mut sim = start(&crate::common::grade(20.0, 0.8), &m113(), &crate::common::soils(), 0.0);
    sim.advance(controls(0.0, 0.0, 1.0), 5_000).expect("it goes on");
    let before = sim.state().position;
    sim.advance(controls(0.0, 0.0, 1.0), 60_000).expect("it goes on");
    let moved = (sim.state().position - before).norm();
    assert!(moved < 1e-3, "{moved} m in a minute");
}

/// The set with one soil throughout.
fn of_one(law: SoilLaw) -> SoilSet {
    let mut set = crate::common::soils();
    set.soils.values_mut().for_each(|l| *l = law);
    set
}

/// Slip and sinkage at a pull of `fraction` of the weight, or none if it can't.
fn pulled(model: &VehicleModel, law: SoilLaw, fraction: f64) -> Option<(f64, f64)> {
    let world = crate::common::soil_world(Heightfield::flat(301, 301, 1.0, 0.0), TerrainClass::Sand);
    let mut sim = start(&world, model, &of_one(law), -50.0);
    let (mut slip, mut sinkage, mut count) = (0.0, 0.0_f64, 0.0);
    for i in 0..150 {
        let pull = fraction * (f64::from(i) / 50.0).min(1.0);
        // A load behind it that pulls as its own weight does on a slope.
        sim.rig().set_gravity([-pull * GRAVITY, 0.0, -GRAVITY]);
        let controls = hold_speed(&sim, 2.0, 0.0);
        sim.advance(controls, 100).expect("it goes on");
        if i >= 100 {
            let s = sim.state();
            slip += 1.0 - s.velocity_body.x / belt(&sim, 0);
            sinkage = s.wheels.iter().map(|w| w.sinkage).fold(sinkage, f64::max);
            count += 1.0;
        }
    }
    let slip = slip / count;
    (slip < 0.8 && sim.state().velocity_body.x > 0.05).then_some((slip, sinkage))
}

/// Published soils with pressure on the outline and little that springs back (Wong, table 2.3).
fn published() -> [(&'static str, SoilLaw); 3] {
    let wong = crate::common::wong_soils();
    ["dry-sand", "sandy-loam", "lete-sand"].map(|name| {
        let pressure = PressureDirection::Radial;
        let law =
            SoilLaw { pressure, damping: 1e3, bulldozing: None, elastic_stiffness: 4e8, ..wong.soils[name] };
        (name, law)
    })
}

/// Resistance to compaction in a rut of depth z over the weight (Bekker: 2 b ∫ p dz).
fn compaction(law: &SoilLaw, z: f64, weight: f64) -> f64 {
    let b = 0.38;
    let Sinkage::Bekker(Bekker { k_phi, k_c, exponent: n }) = law.sinkage else { panic!("{law:?}") };
    2.0 * b * (k_c / b + k_phi) * vb_math::pow(z, n + 1.0) / (n + 1.0) / weight
}

/// Wong, Theory of Ground Vehicles, ch. 2: thrust (A c + W tan φ)(1 − K/(iL)(1 − exp(−iL/K))) of a track under an even
/// pressure, less the resistance of the rut that it makes. Its pull can't exceed what full shear gives.
#[test]
fn on_published_soils_the_greatest_pull_is_that_of_coulomb_less_the_resistance_of_its_rut() {
    let model = m113();
    let weight = model.spec().total_mass() * GRAVITY;
    for (name, law) in published() {
        let area = 2.0 * 0.38 * LENGTH;
        let tan = vb_math::tan(law.friction_angle_deg.to_radians());
        let most = law.cohesion * area / weight + tan;
        let (mut low, mut high) = (0.2, 0.8);
        while high - low > 0.02 {
            let middle = 0.5 * (low + high);
            if pulled(&model, law, middle).is_some() { low = middle } else { high = middle }
        }
        let (_, sinkage) = pulled(&model, law, low).expect("just so");
        let theory = most - compaction(&law, sinkage, weight);
        assert!((low / theory - 1.0).abs() < 0.15, "{name}: {low} of the weight, theory {theory}");
    }
}

#[test]
fn slip_rises_with_the_pull_as_shear_that_builds_up_along_the_whole_track_does() {
    let model = m113();
    let weight = model.spec().total_mass() * GRAVITY;
    for (name, law) in published() {
        // A bent belt is longer than the ground under it: what it slips without a pull is none of the soil's.
        let (free, _) = pulled(&model, law, 0.0).expect("it drives");
        let (slip, sinkage) = pulled(&model, law, 0.4).expect("it pulls");
        let area = 2.0 * 0.38 * LENGTH;
        let tan = vb_math::tan(law.friction_angle_deg.to_radians());
        let most = law.cohesion * area / weight + tan;
        let fraction = (0.4 + compaction(&law, sinkage, weight)) / most;
        // The slip at which Janosi and Hanamoto's law gives that share.
        let (mut low, mut high) = (1e-6, 1.0);
        for _ in 0..60 {
            let i = 0.5 * (low + high);
            let way = i * LENGTH / law.shear_modulus;
            if 1.0 - (1.0 - vb_math::exp(-way)) / way < fraction { low = i } else { high = i }
        }
        let got = slip - free;
        // Loads gather under the wheels, most under the rear ones, where shear has built up: half the slip will do.
        assert!(got > 0.4 * low && got < 1.2 * low, "{name}: slip {got}, theory {low}");
    }
}

/// Rowland's mean maximum pressure (Wong, Theory of Ground Vehicles, ch. 4): 1.26 W/(2 n b √(t d)) for n wheels a side of
/// diameter d on belts of the width b and the pitch t, 120 kPa for this vehicle, made for soft ground; nominally, W/(2 b L),
/// it is 44 kPa. On sand, which is firmer than the clays from which the formula comes, pressures gather more closely under the
/// wheels. The law of the soil gives the pressure that has pressed a rut as deep as it is.
#[test]
fn on_soil_the_pressure_under_its_wheels_is_rowlands_up_to_twice_and_not_that_of_a_plate() {
    let model = m113();
    let weight = model.spec().total_mass() * GRAVITY;
    let rowland = 1.26 * weight / (2.0 * 5.0 * 0.38 * (0.154_f64 * 0.61).sqrt());
    for (name, law) in published().into_iter().take(2) {
        let (_, sinkage) = pulled(&model, law, 0.0).expect("it drives");
        let pressure = law.pressure(sinkage, 0.38);
        assert!(
            pressure > 0.8 * rowland && pressure < 2.2 * rowland,
            "{name}: {pressure} Pa at {sinkage} m, {rowland} Pa"
        );
    }
}

/// CRREL Report 95-1, table A5, example 1: the M113 on 15 cm of snow of 0.2 g/cm³ has a rut of 9.0 cm and a drawbar
/// coefficient of 0.370.
#[test]
fn on_shallow_snow_the_m113_has_crrels_rut_and_pull() {
    let model = m113();
    let snow = Sinkage::Snow(Snow { depth: 0.15, density: 200.0 });
    let law = SoilLaw { sinkage: snow, ..crate::common::soils().soils["medium-snow"] };
    let (_, sinkage) = pulled(&model, law, 0.0).expect("it drives");
    assert!((sinkage - 0.090).abs() < 0.015, "rut {sinkage} m");
    let (mut low, mut high) = (0.2, 0.6);
    while high - low > 0.02 {
        let middle = 0.5 * (low + high);
        if pulled(&model, law, middle).is_some() { low = middle } else { high = middle }
    }
    assert!((low / 0.370 - 1.0).abs() < 0.15, "pull {low} of the weight");
}
