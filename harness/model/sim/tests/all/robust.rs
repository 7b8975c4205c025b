//! Whatever the world and the commands, the simulation goes on: no NaN, no tunnelling, no explosion, no energy from
//! nowhere.

use crate::common::{hmmwv, model, soils};
use std::sync::Arc;
use vb_math::rng::Stream;
use vb_sim::{Controls, SimError, SimOptions, Simulation, SoilSet};
use vb_world::{
    Density, Elevation, Heightfield, Obstacle, ObstacleKind, Pose2, Semantics, SoilLevel, SoilLevels,
    Terrain, TerrainClass, World,
};

/// Rough ground with all classes in patches of 4 m, and boulders and trunks anywhere.
fn wild_world(rng: &mut Stream) -> Arc<World> {
    let n = 49;
    let rough = rng.uniform(0.02, 0.5);
    let heights = (0..n * n).map(|_| rng.normal(0.0, rough)).collect();
    let patches = 12;
    let classes: Vec<_> = (0..patches * patches).map(|_| TerrainClass::ALL[rng.below(10) as usize]).collect();
    let friction =
        classes.iter().map(|c| if c.is_deformable() { 0.0 } else { rng.uniform(0.1, 1.0) }).collect();
    let mut level = || SoilLevel::ALL[rng.below(3) as usize];
    let soil = SoilLevels { mud: level(), sand: level(), snow: level() };
    let obstacles = (0..12)
        .map(|k| Obstacle {
            x: rng.uniform(-20.0, 20.0),
            y: rng.uniform(-20.0, 20.0),
            yaw: rng.uniform(-3.0, 3.0),
            buried: 0.5,
            kind: if k % 3 == 0 {
                ObstacleKind::Trunk { radius: 0.4, height: 4.0 }
            } else {
                ObstacleKind::Boulder { size: [2.0, 2.5, 1.8], seed: k }
            },
        })
        .collect();
    Arc::new(World {
        id: "wild".to_owned(),
        elevation: Elevation::High,
        terrain: Terrain::Mixed,
        density: Density::Dense,
        scale: 1.0,
        heightfield: Heightfield::new(n, n, 1.0, heights),
        semantics: Semantics { rows: patches, cols: patches, patch: 4.0, classes, friction, soil },
        obstacles,
        tasks: vec![],
        beds: Vec::new(),
    })
}

/// Drives with commands that no planner would give; until the vehicle leaves the world; returns the
/// way of its centre, m, and the time, s.
fn drive_wildly(rng: &mut Stream, seconds: f64, step: f64) -> (f64, f64) {
    let world = wild_world(rng);
    let start =
        Pose2 { x: rng.uniform(-22.0, 22.0), y: rng.uniform(-22.0, 22.0), yaw: rng.uniform(-3.1, 3.1) };
    let options = SimOptions { step, ..SimOptions::default() };
    let mut sim =
        Simulation::new(world.clone(), &model(hmmwv()), &soils(), start, options).expect("it starts");
    let from = sim.state().position;
    let mode = rng.below(4);
    let every = if mode == 0 { 1 } else { 20 };
    let inside = |s: &vb_sim::VehicleState| world.heightfield.contains(s.position.x, s.position.y);
    while sim.time() < seconds && inside(&sim.state()) {
        let controls = match mode {
            // Full lock the other way at every step, throttle and brake together.
            0 => Controls {
                steering: if sim.steps().is_multiple_of(2) { 1.0 } else { -1.0 },
                throttle: 1.0,
                brake: 1.0,
                ..Controls::default()
            },
            1 => Controls { steering: rng.uniform(-1.0, 1.0), throttle: 1.0, ..Controls::default() },
            2 => Controls {
                steering: rng.uniform(-1.0, 1.0),
                throttle: rng.uniform(0.0, 1.0),
                brake: rng.uniform(0.0, 1.0),
                ..Controls::default()
            },
            _ => Controls { steering: 1.0, throttle: rng.uniform(0.0, 1.0), ..Controls::default() },
        };
        // A state that no vehicle can have, below the ground or beyond all speed, is an error.
        sim.advance(controls, every).expect("it goes on");
    }
    let s = sim.state();
    // Half of what counts as diverged: 24.5 kN times the radius of a wheel.
    assert!(
        sim.diagnostics().energy_surplus < 0.5 * 24_462.0 * 0.467,
        "{} J from nowhere",
        sim.diagnostics().energy_surplus
    );
    if !inside(&s) {
        return ((s.position - from).norm(), sim.time());
    }
    assert!(
        s.velocity_body.norm() < 60.0 && s.angular_velocity_body.norm() < 60.0,
        "{:?} {:?}",
        s.velocity_body,
        s.angular_velocity_body
    );
    let ground = world.heightfield.height(s.position.x, s.position.y);
    assert!(s.position.z > ground - 1.5, "its middle is {} m below the ground", ground - s.position.z);
    ((s.position - from).norm(), sim.time())
}

#[test]
fn wild_commands_in_wild_worlds_never_make_it_diverge() {
    let mut rng = Stream::new(11, &["wild"]);
    let moved = (0..32).filter(|_| drive_wildly(&mut rng, 4.0, 1e-3).0 > 1.0).count();
    assert!(moved >= 8, "only {moved} of 32 went anywhere: the test tests nothing");
}

#[test]
fn steps_of_a_quarter_and_of_three_milliseconds_do_not_diverge_either() {
    let mut rng = Stream::new(12, &["wild"]);
    for step in [2.5e-4, 3e-3] {
        for _ in 0..4 {
            drive_wildly(&mut rng, 2.0, step);
        }
    }
}

#[test]
fn energy_that_nothing_supplied_is_an_error_with_the_state_to_look_at() {
    // Air that pushes with 20 kN, from 5 m/s on.
    let mut vehicle = hmmwv();
    vehicle.chassis.resistance = vec![[4.0, 0.0], [5.0, -20_000.0]];
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let drive = |vehicle| -> Result<(), SimError> {
        let mut sim = Simulation::new(
            crate::common::flat(0.8),
            &model(vehicle),
            &SoilSet::default(),
            start,
            SimOptions::default(),
        )?;
        sim.advance(crate::common::controls(0.0, 1.0, 0.0), 5000)
    };
    drive(hmmwv()).expect("as it is, it drives");
    let message = drive(vehicle).expect_err("it is pushed").to_string();
    assert!(message.contains("mechanical energy that nothing supplied"), "{message}");
    assert!(
        message.contains("diverged at t = ") && message.contains("wheels (spin, travel, load"),
        "{message}"
    );
}

#[test]
fn energy_that_comes_slowly_from_nowhere_is_found_too() {
    // A vehicle that coasts at 5 m/s against some 370 N of rolling resistance, in air that pushes with 700 N: 1.7 kW and more,
    // which lifts it by a tenth of its wheel's radius in a second.
    let after = |push: f64| {
        let mut vehicle = hmmwv();
        vehicle.chassis.resistance = vec![[0.5, -push], [10.0, -push]];
        let world = crate::common::flat(0.8);
        let start = Pose2 { x: -140.0, y: 0.0, yaw: 0.0 };
        let mut sim = Simulation::new(world, &model(vehicle), &soils(), start, SimOptions::default())
            .expect("it settles");
        sim.rig().throw([5.0, 0.0, 0.0]);
        let neutral = Controls { gear: vb_sim::Gear::Neutral, ..Controls::default() };
        sim.advance(neutral, 25_000).map(|()| sim.diagnostics().energy_surplus)
    };
    let surplus = after(0.0).expect("without the push it coasts");
    assert!(surplus < 500.0, "{surplus} J");
    let message = after(700.0).expect_err("it is pushed").to_string();
    assert!(message.contains("mechanical energy that nothing supplied"), "{message}");
}

#[test]
fn a_world_with_a_class_that_the_set_has_no_soil_for_is_refused_by_name() {
    let world = crate::common::soil_world(Heightfield::flat(9, 9, 1.0, 0.0), TerrainClass::Snow);
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let new = |soils: &SoilSet| {
        Simulation::new(world.clone(), &model(hmmwv()), soils, start, SimOptions::default()).map(|_| ())
    };
    let refused = new(&SoilSet::default()).expect_err("an empty set");
    assert!(matches!(&refused, SimError::NoSoil { class: "snow", .. }), "{refused}");
    let message = refused.to_string();
    assert!(message.contains("world test has snow") && !message.contains('\n'), "{message}");
    new(&soils()).expect("with its soil it starts");
}

/// Ten hours, in a new world whenever the vehicle has left the old one or ten minutes are over. Some minutes:
/// `cargo test --release -p vb-sim -- --ignored soak`.
#[test]
#[ignore = "ten hours of simulated time"]
fn soak() {
    let mut rng = Stream::new(13, &["soak"]);
    let mut driven = 0.0;
    while driven < 36_000.0 {
        driven += drive_wildly(&mut rng, 600.0, 1e-3).1;
    }
}
