//! Pose, wheels and satellites.

use crate::common::{V3, altered, flat, perceive, scene, seed, standing, watch};
use std::f64::consts::TAU;
use vb_sdk::GnssFix;
use vb_sense::{Profile, Truth};
use vb_sim::{VehicleState, WheelState};

fn rolling(spin: f64) -> impl Fn(f64) -> VehicleState {
    move |_| {
        let wheels = vec![WheelState { speed: spin, deflection: 0.03, ..WheelState::default() }; 4];
        VehicleState { wheels, ..standing(0.0, 0.0, 0.0, 0.0) }
    }
}

/// Drives along x at a speed.
fn driving(speed: f64) -> impl Fn(f64) -> VehicleState {
    move |t| VehicleState { velocity_body: V3::new(speed, 0.0, 0.0), ..standing(speed * t, 0.0, 0.0, 0.0) }
}

#[test]
fn a_spin_is_a_multiple_of_a_mark_in_the_window_and_loses_nothing_in_the_long_run() {
    let onboard = altered("onboard", &[("counts_per_turn: 2000", "counts_per_turn: 96")]);
    let mut p = perceive(&onboard, &["wheel-odometry"], &scene(flat(), vec![]), &seed(1, "t"));
    let quantum = TAU / 96.0 / 0.05;
    let spin = 3.7;
    let (mut sum, mut seen, state) = (0.0, std::collections::BTreeSet::new(), rolling(spin));
    // 20 s, after the window has been filled.
    for k in 0..=2005_u32 {
        let now = VehicleState { time: f64::from(k) * 0.01, ..state(0.0) };
        p.sample(Truth { state: &now, ruts: None });
        let wheels = p.read(&now).wheels;
        assert_eq!(wheels.len(), 4);
        let marks = wheels[0].spin / quantum;
        assert!((marks - marks.round()).abs() < 1e-9, "{}", wheels[0].spin);
        if k > 5 {
            sum += wheels[0].spin / 2000.0;
            seen.insert(marks.round() as i64);
        }
    }
    // 3.7 rad/s are 2.83 marks in a window.
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [2, 3]);
    assert!((sum - spin).abs() < 0.02, "{sum}");
}

#[test]
fn the_travel_is_wrong_by_its_deviation() {
    let onboard = Profile::built_in("onboard").unwrap();
    let mut p = perceive(&onboard, &["wheel-odometry"], &scene(flat(), vec![]), &seed(1, "t"));
    let n = 5000;
    let squares: f64 = (0..n)
        .map(|_| {
            let now = rolling(0.0)(0.0);
            p.sample(Truth { state: &now, ruts: None });
            let off = p.read(&now).wheels[2].travel - 0.03;
            off * off
        })
        .sum();
    let spread = squares / f64::from(n) / (0.002 * 0.002);
    assert!((spread - 1.0).abs() < 5.0 * (2.0 / f64::from(n)).sqrt(), "{spread}");
}

#[test]
fn an_estimate_begins_at_the_truth_and_drifts_with_the_way_alone() {
    let onboard = Profile::built_in("onboard").unwrap();
    let s = scene(flat(), vec![]);
    let off = |run: u64, speed: f64| {
        let mut p = perceive(&onboard, &["pose"], &s, &seed(run, "t"));
        let pose = watch(&mut p, 500, driving(speed)).pose.unwrap();
        [pose.position.x - speed * 5.0, pose.position.y, pose.position.z, pose.yaw]
    };
    assert_eq!(off(1, 0.0), [0.0; 4], "at rest nothing drifts");
    let runs = 400;
    let (mut squares, mut together) = ([0.0; 4], 0.0);
    for run in 0..runs {
        let o = off(run, 20.0);
        together += o[1] * o[3] / runs as f64;
        (0..4).for_each(|k| squares[k] += o[k] * o[k] / runs as f64);
    }
    // 100 m: the heading walks by 0.001·√100, the position by 0.05·√100 and along y by the heading's error as well, whose
    // integral over the way has the variance 0.001²·100³/3; the height by 0.03·√100.
    let expected = [0.25, 0.25 + 1e-6 * 1e6 / 3.0, 0.09, 1e-4];
    let bound = 5.0 * (2.0 / runs as f64).sqrt();
    for k in 0..4 {
        assert!(
            (squares[k] / expected[k] - 1.0).abs() < bound,
            "{k}: {}, expected {}",
            squares[k],
            expected[k]
        );
    }
    // A heading that is wrong to the left carries it off to the left: a covariance of 0.001²·100²/2, with a standard error of
    // √((0.583·1e-4 + 0.005²)/400).
    assert!((together - 0.005).abs() < 5.0 * 4.6e-4, "{together}");
}

#[test]
fn tilt_and_velocities_are_wrong_by_their_deviations() {
    let onboard = altered("onboard", &[("correlation_s: 10}", "correlation_s: 0.05}")]);
    let mut p = perceive(&onboard, &["pose"], &scene(flat(), vec![]), &seed(1, "t"));
    let (n, mut squares) = (20_000, [0.0; 4]);
    for _ in 0..n {
        let now = driving(3.0)(0.0);
        p.sample(Truth { state: &now, ruts: None });
        let pose = p.read(&now).pose.unwrap();
        let off = [pose.roll, pose.pitch, pose.linear_velocity.x - 3.0, pose.angular_velocity.z];
        (0..4).for_each(|k| squares[k] += off[k] * off[k] / f64::from(n));
    }
    let half_degree = 0.5_f64.to_radians();
    for (k, std) in [half_degree, half_degree, 0.05, 0.002].into_iter().enumerate() {
        // 200 s of a process with 0.05 s: a standard error of √(2·0.05/200) = 2.2 %; the white ones have less.
        assert!((squares[k] / (std * std) - 1.0).abs() < 0.11, "{k}: {}", squares[k].sqrt());
    }
}

fn fixes(profile: &Profile, need: &str, samples: u64) -> Vec<GnssFix> {
    let mut p = perceive(profile, &[need], &scene(flat(), vec![]), &seed(2, "t"));
    let mut all = Vec::new();
    for k in 0..=samples {
        let now = VehicleState { time: k as f64 * 0.01, ..standing(3.0, -2.0, 1.0, 0.0) };
        p.sample(Truth { state: &now, ruts: None });
        all.extend(p.read(&now).gnss);
    }
    all
}

#[test]
fn positions_come_at_their_rate_and_are_wrong_by_both_errors() {
    let oracle = Profile::built_in("oracle").unwrap();
    let exact = fixes(&oracle, "gnss", 100);
    assert_eq!(exact.len(), 11);
    assert!(exact.iter().all(|f| [f.position.x, f.position.y, f.position.z] == [3.0, -2.0, 1.0]));
    assert_eq!(
        fixes(&oracle, "gnss 4", 100).iter().map(|f| f.time).collect::<Vec<_>>(),
        [0.0, 0.25, 0.5, 0.75, 1.0]
    );
    let model = "horizontal: {std_m: 0, correlation_s: 1, white_std_m: 0}";
    let wrong = altered("oracle", &[(model, "horizontal: {std_m: 2, correlation_s: 0.5, white_std_m: 1}")]);
    let all = fixes(&wrong, "gnss", 400_000);
    let n = all.len();
    let off: Vec<f64> = all.iter().map(|f| f.position.x - 3.0).collect();
    let product =
        |lag: usize| off[lag..].iter().zip(&off).map(|(a, b)| a * b).sum::<f64>() / (n - lag) as f64;
    // 4 + 1 m² altogether, and 4·exp(−0.5/0.5) m² after half a second; 4000 s hold 4000/0.5/2 values: errors of 2 %.
    assert!((product(0) - 5.0).abs() < 0.5, "{}", product(0));
    assert!((product(5) - 4.0 * vb_math::exp(-1.0)).abs() < 0.5, "{}", product(5));
    assert!(all.iter().all(|f| f.position.z == 1.0));
}

#[test]
fn during_an_outage_there_is_no_position() {
    let profile = altered("degraded", &[]);
    let all = fixes(&profile, "gnss", 400_000);
    // 15 s up and 8 s out, 4000 s with about 174 spells: a standard error of the share of some 3 %.
    let share = all.len() as f64 / (4000.0 * 5.0);
    assert!((share - 15.0 / 23.0).abs() < 0.1, "{share}");
    let longest = all.windows(2).map(|w| w[1].time - w[0].time).fold(0.0, f64::max);
    assert!(longest > 8.0, "{longest} s");
}

#[test]
fn lengths_are_those_of_the_full_size_world_times_the_scale() {
    let onboard = Profile::built_in("onboard").unwrap();
    let small = std::sync::Arc::new(vb_sense::rays::Scene::new(std::sync::Arc::new(
        crate::common::world(flat(), vec![]).scaled(0.1),
    )));
    let full = scene(flat(), vec![]);
    let x = |s, f: &dyn Fn(vb_sense::Readings) -> f64, need: &str| {
        f(watch(&mut perceive(&onboard, &[need], s, &seed(1, "t")), 20, driving(0.0)))
    };
    let gnss = |r: vb_sense::Readings| r.gnss.unwrap().position.y;
    assert!((x(&small, &gnss, "gnss") / x(&full, &gnss, "gnss") - 0.1).abs() < 1e-12);
    let p = perceive(&onboard, &["lidar", "depth"], &small, &seed(1, "t"));
    let (lidar, depth) = (p.lidar_info().unwrap(), p.depth_info().unwrap());
    assert!((lidar.max_range - 9.0).abs() < 1e-12 && (depth.max_depth - 2.0).abs() < 1e-12);
    // 0.4 m over a hull that is as high as the vehicle's file says, 1.4 m.
    assert!((lidar.mount.position.z - (1.4 + 0.04)).abs() < 1e-12, "{lidar:?}");
}
