//! What every vehicle that comes with the harness promises.

use std::sync::Arc;
use vb_math::rng::Stream;
use vb_sim::{Controls, SimOptions, Simulation, SoilSet};
use vb_vehicle::suspension::SteeringGear;
use vb_vehicle::{GRAVITY, VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

const START: Pose2 = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };

/// All files of tasks/vehicles.
fn vehicles() -> Vec<VehicleModel> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/vehicles");
    let mut files: Vec<_> =
        std::fs::read_dir(&folder).expect("the shipped vehicles").flatten().map(|e| e.path()).collect();
    files.sort();
    assert!(files.len() >= 8, "{files:?}");
    let load = |f: &std::path::PathBuf| {
        crate::common::model(VehicleSpec::load(f).expect("a shipped vehicle is valid"))
    };
    files.iter().map(load).collect()
}

/// A world of the vehicle's scale from one of full size.
fn scaled(world: World, model: &VehicleModel) -> Arc<World> {
    Arc::new(world.at_scale(model.spec().scale))
}

fn flat(model: &VehicleModel, friction: f64) -> Arc<World> {
    scaled(
        World::uniform("flat", Heightfield::flat(5, 5, 100.0, 0.0), TerrainClass::Concrete, friction),
        model,
    )
}

/// Ground of nodes a metre apart whose heights have this standard deviation, m, at full size.
fn rough(model: &VehicleModel, seed: u64, deviation: f64) -> Arc<World> {
    let n = 129;
    let mut s = Stream::new(seed, &["vehicles"]);
    let heights = (0..n * n).map(|_| s.normal(0.0, deviation)).collect();
    scaled(World::uniform("rough", Heightfield::new(n, n, 1.0, heights), TerrainClass::Concrete, 0.8), model)
}

fn start(world: &Arc<World>, model: &VehicleModel, step: f64) -> Simulation {
    let options = SimOptions { step, ..SimOptions::default() };
    Simulation::new(world.clone(), model, &crate::common::soils(), START, options).expect("it settles")
}

fn advance(sim: &mut Simulation, name: &str, controls: Controls, seconds: f64, step: f64) {
    let steps = (seconds / step).round() as u64;
    sim.advance(controls, steps).unwrap_or_else(|e| panic!("{name}: {e}"));
}

/// Σ loads = m g; nothing moves; hull and reference point are above the ground and it stands level.
#[test]
fn every_vehicle_stands_on_its_wheels_and_their_loads_make_its_weight() {
    for model in vehicles() {
        let (spec, name) = (model.spec(), model.spec().name.clone());
        let mut sim = start(&flat(&model, 0.9), &model, 1e-3);
        let brakes = crate::common::controls(0.0, 0.0, 1.0);
        advance(&mut sim, &name, brakes, 2.0, 1e-3);
        let before = sim.state();
        advance(&mut sim, &name, brakes, 2.0, 1e-3);
        let s = sim.state();
        let loads: f64 = s.wheels.iter().map(|w| w.load).sum();
        let weight = spec.total_mass() * GRAVITY;
        assert!((loads / weight - 1.0).abs() < 1e-3, "{name}: {loads} N, weight {weight} N");
        assert!((s.position - before.position).norm() < 1e-5 * spec.length, "{name} moves at rest");
        let (roll, pitch, _) = s.roll_pitch_yaw();
        assert!(roll.abs() < 0.004 && pitch.abs() < 0.04, "{name}: {roll} {pitch}");
        let lowest = spec.chassis.hull.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        assert!(
            s.position.z + lowest > 0.05 * spec.height,
            "{name}: the hull is {} up",
            s.position.z + lowest
        );
        // Within the springs' range and off its ends.
        for (i, w) in s.wheels.iter().enumerate() {
            let [low, high] = spec.axles[i / 2].suspension.range;
            assert!(low == high || (w.deflection > low && w.deflection < high), "{name}: {}", w.deflection);
        }
    }
}

#[test]
fn every_vehicle_reaches_the_top_speed_that_its_file_says_and_no_more() {
    for model in vehicles() {
        let (spec, name) = (model.spec(), model.spec().name.clone());
        let mut sim = start(&flat(&model, 0.9), &model, 1e-3);
        let mut fastest = 0.0_f64;
        for _ in 0..900 {
            let yaw = sim.state().roll_pitch_yaw().2;
            advance(&mut sim, &name, crate::common::controls((-yaw).clamp(-1.0, 1.0), 1.0, 0.0), 0.1, 1e-3);
            fastest = fastest.max(sim.state().velocity_body.x);
        }
        let fraction = fastest / spec.max_speed;
        assert!((0.95..=1.01).contains(&fraction), "{name}: {fastest} m/s, {} in its file", spec.max_speed);
    }
}

/// Left and right are mirror images, but for drag links, which lie on one side.
#[test]
fn every_vehicle_turns_to_the_side_that_it_is_told_to_and_both_ways_alike() {
    for model in vehicles() {
        let (spec, name) = (model.spec(), model.spec().name.clone());
        let turned = |steering: f64| {
            let mut sim = start(&flat(&model, 0.9), &model, 1e-3);
            let (speed, mut throttle) = (3.0 * spec.scale.sqrt(), 0.0_f64);
            for _ in 0..200 {
                // Slowly: what the throttle does to pitch and wheel loads steers, too.
                let e = (speed - sim.state().velocity_body.x) / speed;
                throttle = (throttle + 0.02 * e).clamp(0.0, 1.0);
                let controls = crate::common::controls(steering, throttle, 0.0);
                advance(&mut sim, &name, controls, 0.1 * spec.scale.sqrt(), 1e-3 * spec.scale.sqrt());
            }
            sim.state().angular_velocity_body.z
        };
        // A servo may turn less far to one side by the same command, so both turn by the same position of the gears.
        let gear = spec.axles.iter().find_map(|a| a.steering.as_ref());
        let opposite = gear.map_or(-0.4, |gear| command_at(gear, -gear.position(0.4)));
        let (left, right) = (turned(0.4), turned(opposite));
        assert!(left > 0.0 && right < 0.0, "{name}: {left} {right}");
        assert!((left / -right - 1.0).abs() < 0.12, "{name}: {left} rad/s to the left, {right} to the right");
    }
}

/// The command of a gear's position, by bisection.
fn command_at(gear: &SteeringGear, position: f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gear.position(middle) < position { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Steering, throttle and brake at random, every tenth of a second, on rough ground.
#[test]
fn no_commands_on_rough_ground_make_a_vehicle_diverge_or_gain_energy() {
    for model in vehicles() {
        let name = model.spec().name.clone();
        for seed in [1, 2] {
            let mut sim = start(&rough(&model, seed, 0.12), &model, 1e-3);
            let mut s = Stream::new(seed, &["commands", &name]);
            for _ in 0..150 {
                let controls = crate::common::controls(
                    s.uniform(-1.0, 1.0),
                    s.uniform(-0.5, 1.0).max(0.0),
                    s.uniform(-2.0, 1.0).max(0.0),
                );
                advance(&mut sim, &name, controls, 0.1, 1e-3);
                // Beyond the edge the ground is made up.
                let p = sim.state().position;
                if p.x.abs().max(p.y.abs()) > 60.0 * model.spec().scale {
                    break;
                }
            }
            // Half of what ends a simulation: the energy that lifts it by the radius of a wheel.
            let spec = model.spec();
            let allowed = 0.5 * spec.total_mass() * GRAVITY * spec.tyre.radius();
            assert!(
                sim.diagnostics().energy_surplus < allowed,
                "{name}, {seed}: {} J of {allowed}",
                sim.diagnostics().energy_surplus
            );
        }
    }
}

/// On its roof it comes to rest; on its side it stays where it was dropped, whatever it does there.
#[test]
fn an_overturned_vehicle_comes_to_rest_on_its_roof_and_is_not_thrown_off_its_side() {
    for model in vehicles() {
        let (spec, name) = (model.spec(), model.spec().name.clone());
        for roll in [1.5, 3.0] {
            let mut sim = start(&flat(&model, 0.6), &model, 1e-3);
            sim.rig().overturn(roll, spec.width);
            let mut highest = 0.0_f64;
            for _ in 0..150 {
                advance(&mut sim, &name, crate::common::controls(0.0, 0.0, 1.0), 0.1, 1e-3);
                highest = highest.max(sim.state().position.z);
            }
            let s = sim.state();
            if roll > 2.0 {
                assert!(
                    s.velocity_body.norm() < 0.03 * spec.scale.sqrt(),
                    "{name}: {}",
                    s.velocity_body.norm()
                );
            }
            assert!(
                s.position.z > 0.0 && highest < spec.height + 0.5 * spec.width,
                "{name}, {roll}: {highest}"
            );
        }
    }
}

#[test]
fn a_rugged_drive_of_every_vehicle_ends_at_the_same_place_at_a_quarter_of_the_step() {
    for model in vehicles() {
        let (spec, name) = (model.spec(), model.spec().name.clone());
        let pace = spec.scale.sqrt();
        let drive = |step: f64| {
            let mut sim = start(&rough(&model, 3, 0.05), &model, step);
            for _ in 0..50 {
                let e = 3.0 - sim.state().velocity_body.x / pace;
                let controls = crate::common::controls(0.2, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0));
                advance(&mut sim, &name, controls, 0.1 * pace, step);
            }
            sim.state()
        };
        let (coarse, fine) = (drive(1e-3), drive(0.25e-3));
        let apart = (coarse.position - fine.position).norm();
        let far = fine.position.xy().norm();
        // 10 m at full size; as the HMMWV alone promises for ten seconds.
        assert!(far > 3.0 * spec.scale, "{name}: it drives, {far}");
        assert!(apart < 0.3 * spec.scale, "{name}: {apart} m apart after {far} m");
    }
}

/// A tyre of another size on one axle: each wheel stands and rolls on its own.
#[test]
fn an_axle_may_have_tyres_of_its_own() {
    let model = vehicles().into_iter().find(|m| m.spec().name == "gator").expect("the Gator is shipped");
    let spec = model.spec();
    let own = |i: usize| spec.tyre_of(&spec.axles[i]).radius();
    assert!(own(0) < own(1));
    let mut sim = start(&flat(&model, 0.9), &model, 1e-3);
    for _ in 0..60 {
        let e = 3.0 - sim.state().velocity_body.x;
        advance(
            &mut sim,
            "gator",
            crate::common::controls(0.0, e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0)),
            0.1,
            1e-3,
        );
    }
    let s = sim.state();
    for (i, w) in s.wheels.iter().enumerate().take(2) {
        // Rolls on a radius between the loaded and the free one: some per cent below the latter.
        let radius = s.velocity_body.x / w.speed;
        assert!(radius < own(i / 2) && radius > 0.93 * own(i / 2), "wheel {i}: {radius}");
    }
    // Another tyre by name is put on both axles, each in its size.
    let rigid = spec.clone().with_tyre("rigid").expect("both axles have one");
    let radii =
        [0, 1].map(|i| (rigid.tyre_of(&rigid.axles[i]).model(), rigid.tyre_of(&rigid.axles[i]).radius()));
    assert_eq!(radii, [("rigid", own(0)), ("rigid", own(1))]);
    let e = spec.clone().with_tyre("slick").unwrap_err().to_string();
    assert!(e.contains("tyres") && e.contains("tmeasy"), "{e}");
}

/// A start on a slope, far above sea level: it is set down on the slope, not in the air beside it.
#[test]
fn a_vehicle_whose_wheels_lie_unevenly_about_its_middle_is_set_down_along_the_slope() {
    let model = vehicles().into_iter().find(|m| m.spec().name == "man7t").expect("the 7 t is shipped");
    let slope = vb_math::tan(0.35);
    let heights = (0..25).map(|i| 400.0 + slope * 10.0 * f64::from(i % 5)).collect();
    let world = crate::common::world(Heightfield::new(5, 5, 10.0, heights), 0.9, vec![]);
    let options = SimOptions { settle_time: 0.0, ..SimOptions::default() };
    let sim =
        Simulation::new(world.clone(), &model, &SoilSet::default(), START, options).expect("it is set down");
    let s = sim.state();
    assert!((s.roll_pitch_yaw().1 + 0.35).abs() < 1e-6, "{}", s.roll_pitch_yaw().1);
    assert!(s.position.z - world.heightfield.height(0.0, 0.0) < 0.8, "{}", s.position.z);
}

/// A simulation that diverges is an error of the simulation; a panic would count as one of the machine, and the task would not be
/// scored. The state here is what a diverging step leaves.
#[test]
fn a_velocity_that_is_no_number_ends_the_simulation_with_an_error() {
    for model in vehicles() {
        for class in [TerrainClass::Concrete, TerrainClass::Mud] {
            let ground = World::uniform("w", Heightfield::flat(5, 5, 100.0, 0.0), class, 0.6);
            let soils = crate::common::soils();
            let mut sim =
                Simulation::new(scaled(ground, &model), &model, &soils, START, SimOptions::default())
                    .unwrap();
            sim.rig().throw([f64::NAN; 3]);
            let end = sim.advance(Controls { throttle: 0.5, steering: 0.3, ..Controls::default() }, 10);
            assert!(
                matches!(end, Err(vb_sim::SimError::Diverged { .. })),
                "{} on {class:?}: {end:?}",
                model.spec().name
            );
        }
    }
}
