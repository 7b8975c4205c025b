//! Driving backwards, in neutral, and to and fro.

use crate::common::{flat, model, reference_hmmwv, soils};
use std::path::Path;
use std::sync::Arc;
use vb_sim::{Controls, Gear, SimOptions, Simulation};
use vb_vehicle::{GRAVITY, VehicleSpec, powertrain::Governor};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

const NAMES: [&str; 10] = [
    "artcar",
    "feda",
    "gator",
    "hmmwv",
    "hmmwv-released",
    "m113",
    "man10t",
    "man5t",
    "man7t",
    "verti4wheeler",
];

/// Speed of the HMMWV's wheels over that of its engine in reverse, without the sign.
const REVERSE: f64 = 0.2 * 0.2;
/// What turns with the HMMWV's wheels in neutral, kg m²: wheels, axle shafts, axle boxes, output shaft and centre box.
const TURNING: f64 = 4.0 * 8.7143 + 2.0 * 0.5 / 0.04 + 2.0 * 0.6 + 1.1 / 0.04;

fn shipped(name: &str) -> VehicleSpec {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../../tasks/vehicles/{name}.yaml"));
    VehicleSpec::load(&file).expect("the shipped vehicle is valid")
}

fn start(world: &Arc<World>, spec: VehicleSpec, yaw: f64) -> Simulation {
    let at = Pose2 { x: 0.0, y: 0.0, yaw };
    Simulation::new(world.clone(), &model(spec), &soils(), at, SimOptions::default()).expect("it settles")
}

fn ask(gear: Gear, throttle: f64, brake: f64) -> Controls {
    Controls { throttle, brake, gear, ..Controls::default() }
}

/// Holds a speed backwards, m/s ≥ 0.
fn back_at(sim: &Simulation, speed: f64, steering: f64) -> Controls {
    let e = speed + sim.state().velocity_body.x;
    Controls { steering, ..ask(Gear::Reverse, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0)) }
}

fn back_for(sim: &mut Simulation, seconds: f64, speed: f64, steering: f64) {
    for _ in 0..(seconds / 0.01).round() as usize {
        let controls = back_at(sim, speed, steering);
        sim.advance(controls, 10).expect("it goes on");
    }
}

#[test]
fn every_shipped_vehicle_backs_off_from_rest() {
    for name in NAMES {
        let spec = shipped(name);
        let scale = spec.scale;
        let mut sim = start(&flat(0.9), spec, 0.0);
        // A change of direction first, then 1 m/s at full size.
        back_for(&mut sim, 2.0, scale.sqrt(), 0.0);
        let from = sim.state().position.x;
        back_for(&mut sim, 2.0, scale.sqrt(), 0.0);
        let s = sim.state();
        assert!(s.gear == Gear::Reverse && s.position.x - from < -0.5 * scale.sqrt(), "{name}: {s:?}");
        assert!(s.wheels.iter().all(|w| w.speed < 0.0), "{name}: {s:?}");
    }
}

#[test]
fn it_backs_up_a_slope_of_20_degrees_and_its_energy_comes_from_the_engine() {
    for name in ["hmmwv", "man5t", "m113"] {
        let spec = shipped(name);
        let weight = spec.total_mass() * GRAVITY;
        let mut sim = start(&crate::common::grade(20.0, 0.9), spec, std::f64::consts::PI);
        while sim.state().gear != Gear::Reverse {
            sim.advance(ask(Gear::Reverse, 0.0, 1.0), 10).expect("it goes on");
        }
        let from = sim.state().position;
        back_for(&mut sim, 10.0, 2.0, 0.0);
        let s = sim.state();
        assert!(s.position.x - from.x > 10.0 && s.velocity_body.x < -1.0, "{name}: {s:?}");
        let lift = weight * (s.position.z - from.z);
        assert!(
            sim.diagnostics().energy_surplus < 0.01 * lift,
            "{name}: {} J of {lift} J",
            sim.diagnostics().energy_surplus
        );
    }
}

#[test]
fn backwards_it_drives_at_the_speed_of_the_engine_through_the_reverse_ratio_on_the_radius_of_its_wheels() {
    let mut sim = start(&flat(0.9), reference_hmmwv(), 0.0);
    for speed in [1.0, 2.0, 4.0] {
        back_for(&mut sim, 10.0, speed, 0.0);
        let s = sim.state();
        assert!(s.velocity_body.x < -0.7 * speed, "{s:?}");
        // The rolling radius lies between the loaded one, 6116 N / 411 kN/m = 15 mm below, and the free one.
        let radius = -s.velocity_body.x / (s.engine_speed * REVERSE);
        assert!((0.452..0.4675).contains(&radius), "{radius} m at {} m/s", s.velocity_body.x);
    }
}

#[test]
fn a_command_for_reverse_at_5_m_per_s_waits_for_the_brake_and_then_takes_its_latency() {
    let mut sim = start(&flat(0.9), reference_hmmwv(), 0.0);
    // At so little throttle no wheel spins.
    while sim.state().velocity_body.x < 5.0 {
        sim.advance(ask(Gear::Forward, 0.1, 0.0), 10).expect("it goes on");
    }
    // Throttle and no brake: it rolls on, slower and slower.
    let mut last = sim.state().velocity_body.x;
    for _ in 0..200 {
        sim.advance(ask(Gear::Reverse, 1.0, 0.0), 10).expect("it goes on");
        let s = sim.state();
        // The tyres' carcass gives back what the last push has strained.
        assert!(s.gear == Gear::Forward && s.velocity_body.x < last + 0.01, "{s:?}");
        last = s.velocity_body.x;
    }
    assert!(last > 1.0);
    while sim.state().gear == Gear::Forward {
        last = sim.state().velocity_body.x;
        sim.advance(ask(Gear::Reverse, 1.0, 0.5), 1).expect("it goes on");
    }
    // vehicles/hmmwv-released.yaml: below 0.5 m/s, 0.6 s.
    assert!(last < 0.5 && last > 0.48, "{last} m/s");
    let begin = sim.time();
    while sim.state().gear == Gear::Neutral {
        assert!(sim.drive().shaft_torque == 0.0);
        sim.advance(ask(Gear::Reverse, 1.0, 0.0), 1).expect("it goes on");
    }
    assert!((sim.time() - begin - 0.6).abs() < 1.5e-3, "{} s", sim.time() - begin);
    assert!(sim.state().gear == Gear::Reverse && sim.drive().shaft_torque < 0.0);
    sim.advance(ask(Gear::Reverse, 1.0, 0.0), 1000).expect("it goes on");
    assert!(sim.state().velocity_body.x < -1.0);
}

#[test]
fn in_neutral_it_coasts_against_rolling_resistance_alone() {
    for back in [false, true] {
        let spec = reference_hmmwv();
        let mass = spec.total_mass();
        let mut sim = start(&flat(0.9), spec, 0.0);
        let gear = if back { Gear::Reverse } else { Gear::Forward };
        // In reverse its engine ends at 4.6 m/s.
        while sim.state().velocity_body.x.abs() < 4.0 {
            sim.advance(ask(gear, 0.3, 0.0), 10).expect("it goes on");
        }
        sim.advance(ask(Gear::Neutral, 1.0, 0.0), 500).expect("it goes on");
        let from = sim.state().velocity_body.x.abs();
        sim.advance(ask(Gear::Neutral, 1.0, 0.0), 5000).expect("it goes on");
        // 0.015 of the weight on the mass and on what turns, on a radius a third of the deflection below the free one.
        let radius = 0.467 - 0.015 / 3.0;
        let slower = 0.015 * mass * GRAVITY / (mass + TURNING / (radius * radius)) * 5.0;
        let lost = from - sim.state().velocity_body.x.abs();
        assert!((lost / slower - 1.0).abs() < 0.02, "{lost} m/s, theory {slower}, back {back}");
        assert_eq!(sim.state().gear, Gear::Neutral);
    }
}

#[test]
fn with_its_wheels_turned_it_backs_around_the_centre_around_which_it_drives() {
    // At walking pace no tyre slips to speak of.
    for steering in [0.6, -0.6] {
        let mut sim = start(&flat(0.9), reference_hmmwv(), 0.0);
        let mut curvature = [0.0; 2];
        for _ in 0..1000 {
            let c = Controls { steering, ..ask(Gear::Forward, 1.0 - sim.state().velocity_body.x, 0.0) };
            let c = Controls { throttle: c.throttle.clamp(0.0, 1.0), ..c };
            sim.advance(c, 10).expect("it goes on");
        }
        let s = sim.state();
        curvature[0] = s.angular_velocity_body.z / s.velocity_body.x;
        sim.advance(Controls { steering, ..ask(Gear::Reverse, 0.0, 1.0) }, 2000).expect("it goes on");
        back_for(&mut sim, 10.0, 1.0, steering);
        let s = sim.state();
        curvature[1] = s.angular_velocity_body.z / s.velocity_body.x;
        assert!(s.velocity_body.x < -0.5 && curvature[1] * steering > 0.0, "{s:?}");
        assert!((curvature[1] / curvature[0] - 1.0).abs() < 0.02, "{curvature:?}");
    }
}

#[test]
fn a_tracked_vehicle_backs_straight_and_turns_about_its_inner_track() {
    let mut sim = start(&flat(0.8), shipped("m113"), 0.0);
    back_for(&mut sim, 15.0, 3.0, 0.0);
    let s = sim.state();
    assert!(s.position.x < -15.0 && s.position.y.abs() < 0.01 && s.roll_pitch_yaw().2.abs() < 1e-3, "{s:?}");
    // To the left: the left belt is the inner one, and backwards that turns to the right.
    for steering in [0.5, -0.5] {
        let mut sim = start(&flat(0.8), shipped("m113"), 0.0);
        back_for(&mut sim, 10.0, 3.0, steering);
        let s = sim.state();
        let [inner, outer] = if steering > 0.0 { [2, 3] } else { [3, 2] };
        assert!(s.angular_velocity_body.z * steering < -0.05 && s.velocity_body.x < -0.5, "{s:?}");
        assert!(s.wheels[inner].speed.abs() < s.wheels[outer].speed.abs(), "{s:?}");
    }
}

/// Rocks to and fro with full throttle, each way up to 3 m/s or for two seconds, with the brakes on for a change of direction;
/// returns how often the direction has changed.
fn rock(sim: &mut Simulation, seconds: f64) -> usize {
    let (mut wanted, mut changes, mut since) = (Gear::Forward, 0, 0.0);
    while sim.time() < seconds {
        let s = sim.state();
        if s.gear != wanted {
            sim.advance(ask(wanted, 1.0, 0.3), 10).expect("it goes on");
            since = sim.time();
        } else if s.velocity_body.x.abs() < 3.0 && s.time - since < 2.0 {
            sim.advance(ask(wanted, 1.0, 0.0), 10).expect("it goes on");
        } else {
            wanted = if wanted == Gear::Forward { Gear::Reverse } else { Gear::Forward };
            changes += 1;
        }
    }
    changes
}

#[test]
fn rocking_to_and_fro_makes_no_energy_on_rigid_ground_and_on_soil() {
    for name in ["hmmwv", "man5t", "m113", "gator"] {
        for class in [None, Some(TerrainClass::Mud), Some(TerrainClass::Snow)] {
            let world = class.map_or_else(
                || flat(0.9),
                |class| crate::common::soil_world(Heightfield::flat(301, 301, 1.0, 0.0), class),
            );
            let spec = shipped(name);
            let weight = spec.total_mass() * GRAVITY;
            let mut sim = start(&world, spec, 0.0);
            let changes = rock(&mut sim, 20.0);
            assert!(changes >= 5, "{name} on {class:?}: {changes} changes of direction");
            // Five centimetres of height: what springs and tyres hold. Its energy of motion at 3 m/s is nine times that.
            let surplus = sim.diagnostics().energy_surplus;
            assert!(surplus < 0.05 * weight, "{name} on {class:?}: {surplus} J from nowhere");
        }
    }
}

#[test]
fn to_and_fro_without_brakes_the_engines_work_is_energy_of_motion_and_rolling_resistance() {
    let spec = reference_hmmwv();
    let mass = spec.total_mass();
    let mut sim = start(&flat(0.9), spec, 0.0);
    let (mut work, mut way) = (0.0, 0.0);
    let mut go = |sim: &mut Simulation, gear: Gear, throttle: f64, until: &dyn Fn(&Simulation) -> bool| {
        while !until(sim) {
            let before = sim.drive().shaft_speed;
            sim.advance(ask(gear, throttle, 0.0), 1).expect("it goes on");
            let drive = sim.drive();
            work += drive.shaft_torque * 0.5 * (before + drive.shaft_speed) * 1e-3;
            way += sim.state().velocity_body.x.abs() * 1e-3;
        }
    };
    go(&mut sim, Gear::Forward, 0.1, &|sim| sim.state().velocity_body.x > 3.0);
    // The engine's drag slows it down until the gearbox changes the direction.
    go(&mut sim, Gear::Reverse, 0.1, &|sim| sim.state().velocity_body.x < -3.0);
    // A radius a third of the deflection below the free one.
    let radius = 0.467 - 0.015 / 3.0;
    let moving = 0.5 * (mass + TURNING / (radius * radius)) * 9.0;
    let rolling = 0.015 * mass * GRAVITY * way;
    assert!(moving > 1e4 && rolling > 2e3, "{moving} J, {rolling} J");
    assert!((work / (moving + rolling) - 1.0).abs() < 0.02, "{work} J, {moving} J and {rolling} J");
}

#[test]
fn a_governor_limits_the_speed_backwards_as_it_does_forwards() {
    let mut spec = reference_hmmwv();
    spec.powertrain.governor = Some(Governor { speed: 2.0, band: 0.5 });
    let mut sim = start(&flat(0.9), spec, 0.0);
    sim.advance(ask(Gear::Reverse, 1.0, 0.0), 10_000).expect("it goes on");
    let v = sim.state().velocity_body.x;
    assert!(v < -1.5 && v > -2.0, "{v} m/s");
}

#[test]
fn a_vehicle_that_was_put_into_reverse_is_in_it() {
    let mut sim = start(&flat(0.9), shipped("man5t"), 0.0);
    let state = vb_sim::VehicleState { gear: Gear::Reverse, engine_speed: 150.0, ..sim.state() };
    sim.rig().put(&state, 1);
    assert_eq!(sim.state().gear, Gear::Reverse);
    sim.advance(ask(Gear::Reverse, 1.0, 0.0), 1).expect("it goes on");
    // Within a step the engine changes by some radians per second at most.
    assert!((sim.state().engine_speed - 150.0).abs() < 5.0 && sim.drive().shaft_torque < 0.0);
}
