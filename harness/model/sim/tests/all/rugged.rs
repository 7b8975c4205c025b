//! Rugged ground, obstacles, rollover: what the simulator must survive and conserve.

use crate::common::{controls, flat, hmmwv, hold_speed, soils, start, world};
use std::sync::Arc;
use vb_math::rng::Stream;
use vb_sim::{SimOptions, Simulation};
use vb_world::{Heightfield, Obstacle, ObstacleKind, Pose2, World};

/// White noise on 1 m nodes, smoothed once: rougher than any world of the suite for `amplitude` above 1.
fn rugged(amplitude: f64, seed: u64, obstacles: Vec<Obstacle>) -> Arc<World> {
    let n = 129;
    let mut s = Stream::new(seed, &["rugged"]);
    let noise: Vec<f64> = (0..n * n).map(|_| s.normal(0.0, amplitude)).collect();
    let at = |r: usize, c: usize| noise[r.min(n - 1) * n + c.min(n - 1)];
    let h = (0..n * n)
        .map(|i| {
            let (r, c) = (i / n, i % n);
            0.25 * (at(r, c) + at(r + 1, c) + at(r, c + 1) + at(r + 1, c + 1))
        })
        .collect();
    world(Heightfield::new(n, n, 1.0, h), 0.6, obstacles)
}

fn drive(world: &Arc<World>, step: f64, seconds: f64) -> Simulation {
    let options = SimOptions { step, ..SimOptions::default() };
    let mut sim = Simulation::new(
        world.clone(),
        &crate::common::model(hmmwv()),
        &soils(),
        Pose2 { x: -50.0, y: 0.0, yaw: 0.0 },
        options,
    )
    .expect("it settles");
    let ticks = (seconds / 0.01) as u64;
    for k in 0..ticks {
        let steer = 0.3 * vb_math::sin(0.01 * k as f64);
        let c = hold_speed(&sim, 4.0, steer);
        sim.advance(c, (0.01 / step).round() as u64).expect("finite");
    }
    sim
}

#[test]
fn the_same_drive_gives_the_same_bits() {
    let w = rugged(0.6, 1, vec![]);
    let bits = || {
        let mut v = Vec::new();
        drive(&w, 1e-3, 10.0).visit_state(|x| v.push(x.to_bits()));
        v
    };
    assert_eq!(bits(), bits());
}

#[test]
fn the_step_has_converged() {
    // A rugged drive ends within decimetres of the same place at half and at a quarter of the step.
    let w = rugged(0.3, 2, vec![]);
    let end = |step: f64| drive(&w, step, 10.0).state().position;
    let (a, b, c) = (end(1e-3), end(0.5e-3), end(0.25e-3));
    assert!((a - c).norm() < 0.3, "1 ms: {a}, 0.25 ms: {c}");
    assert!((b - c).norm() < 0.2, "0.5 ms: {b}, 0.25 ms: {c}");
}

#[test]
fn no_ground_however_rough_makes_it_diverge_or_sink() {
    for seed in 0..12 {
        let w = rugged(0.4 + 0.25 * seed as f64, seed, vec![]);
        let sim = drive(&w, 1e-3, 20.0);
        let s = sim.state();
        let above = s.position.z - w.heightfield.height(s.position.x, s.position.y);
        if w.heightfield.contains(s.position.x, s.position.y) {
            assert!(above > -0.5 && above < 6.0, "seed {seed}: {above} m above ground");
        }
        assert!(s.velocity_body.norm() < 15.0, "seed {seed}: {} m/s", s.velocity_body.norm());
    }
}

#[test]
fn a_wall_stops_it_without_penetration() {
    let wall = Obstacle {
        x: 8.0,
        y: 0.0,
        yaw: 0.0,
        buried: 1.0,
        kind: ObstacleKind::Box { size: [2.0, 20.0, 6.0] },
    };
    let w = world(Heightfield::flat(129, 129, 1.0, 0.0), 0.8, vec![wall]);
    for throttle in [0.3, 1.0] {
        let mut sim = start(&w, -8.0, 0.0, 0.0);
        for _ in 0..600 {
            sim.advance(controls(0.0, throttle, 0.0), 10).unwrap();
            let s = sim.state();
            // The nose is 2.21 m ahead of the reference point when level.
            let nose = (s.position + s.attitude * nalgebra::Vector3::new(2.21, 0.0, 0.5)).x;
            assert!(nose < 7.15, "nose at {nose} m, wall at 7 m, t = {}", sim.time());
        }
    }
}

#[test]
fn a_low_step_is_climbed_and_a_high_one_is_not() {
    // Four driven wheels of radius 0.467 m at μ 0.6: a step of a quarter of the radius is passed, one of a diameter
    // is a wall (Bekker 1969, ch. 2: the limit of an all-wheel drive lies between half a radius and a radius).
    for (height, passes) in [(0.12, true), (1.0, false)] {
        let step = Obstacle {
            x: 12.0,
            y: 0.0,
            yaw: 0.0,
            buried: 1.0,
            kind: ObstacleKind::Box { size: [12.0, 30.0, 1.0 + height] },
        };
        let w = world(Heightfield::flat(129, 129, 1.0, 0.0), 0.6, vec![step]);
        let mut sim = start(&w, 0.0, 0.0, 0.0);
        for _ in 0..1500 {
            let mut c = hold_speed(&sim, 3.0, 0.0);
            c.brake = 0.0;
            sim.advance(c, 10).unwrap();
            if sim.state().position.x > 12.0 {
                break;
            }
        }
        let s = sim.state();
        assert_eq!(s.position.x > 12.0, passes, "step {height} m: ended at x = {}", s.position.x);
        if passes {
            // It stands on the step, its wheels as deep in their tyres as on the ground (0.417 m at rest).
            let above = s.position.z - height;
            assert!((above - 0.417).abs() < 0.06, "step {height} m: {above} m above it");
        }
    }
}

#[test]
fn on_its_roof_it_comes_to_rest_and_stays_above_ground() {
    let w = flat(0.6);
    let mut sim = start(&w, 0.0, 0.0, 0.0);
    sim.rig().overturn(std::f64::consts::PI, 3.0);
    sim.advance(controls(0.0, 0.0, 0.0), 8000).unwrap();
    let s = sim.state();
    let (roll, _, _) = s.roll_pitch_yaw();
    assert!(roll.abs() > 1.2, "it does not right itself: roll {roll}");
    assert!(s.velocity_body.norm() < 0.05, "{}", s.velocity_body);
    assert!(s.position.z > 0.5 && s.position.z < 2.0, "{}", s.position.z);
}

#[test]
fn wheels_meet_obstacles_that_the_hull_is_far_from() {
    // Without a hull, and with a stump in the way of the left wheels, which is farther from the vehicle's middle than its own size.
    let mut vehicle = hmmwv();
    vehicle.chassis.hull.clear();
    let kind = ObstacleKind::Trunk { radius: 0.2, height: 1.0 };
    let stump = Obstacle { x: 8.0, y: 0.91, yaw: 0.0, buried: 0.1, kind };
    let w = world(Heightfield::flat(129, 129, 1.0, 0.0), 0.8, vec![stump]);
    let place = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let model = crate::common::model(vehicle);
    let mut sim = Simulation::new(w, &model, &soils(), place, SimOptions::default()).unwrap();
    let mut hit = false;
    for _ in 0..600 {
        let c = hold_speed(&sim, 3.0, 0.0);
        sim.advance(c, 10).unwrap();
        let s = sim.state();
        hit |= s.position.x > 2.0 && s.velocity_body.x < 1.0;
    }
    assert!(
        hit,
        "it passes through the stump: at {} m, {} m/s",
        sim.state().position.x,
        sim.state().velocity_body.x
    );
}
