//! The inertial measurement unit: what it measures, and its errors by the Allan deviation of a vehicle at rest.

use crate::common::{Quat, V3, altered, at, flat, perceive, scene, seed, standing, watch};
use vb_sdk::{ImuSample, Vec3};
use vb_sense::Profile;
use vb_sim::VehicleState;

fn array(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}

#[track_caller]
fn assert_near(v: Vec3, expected: [f64; 3], within: f64) {
    let v = array(v);
    assert!((0..3).all(|k| (v[k] - expected[k]).abs() < within), "{v:?}, expected {expected:?}");
}

fn ideal(last: u64, state: impl Fn(f64) -> VehicleState) -> Vec<ImuSample> {
    let oracle = Profile::built_in("oracle").unwrap();
    watch(&mut perceive(&oracle, &["imu"], &scene(flat(), vec![]), &seed(1, "t")), last, state).imu
}

#[test]
fn at_rest_the_specific_force_points_up_whatever_the_attitude() {
    let samples = ideal(5, |_| standing(0.0, 0.0, 1.0, 2.0));
    assert_eq!(samples.len(), 5);
    for (k, s) in samples.iter().enumerate() {
        assert!((s.time - 0.01 * (k + 1) as f64).abs() < 1e-12);
        assert_near(s.specific_force, [0.0, 0.0, 9.81], 1e-9);
        assert_near(s.angular_velocity, [0.0; 3], 1e-12);
    }
    // Nose down by 0.3 rad: the force that holds the vehicle up points backward in its own axes, by -g sin 0.3.
    let nose_down = |_: f64| at(V3::zeros(), Quat::from_axis_angle(&V3::y_axis(), 0.3));
    let (s, c) = vb_math::sin_cos(0.3);
    assert_near(ideal(1, nose_down)[0].specific_force, [-9.81 * s, 0.0, 9.81 * c], 1e-9);
}

#[test]
fn on_a_circle_it_measures_the_turn_and_the_force_towards_the_middle() {
    // 5 m/s at 0.5 rad/s to the left: 2.5 m/s² to the left.
    let circle = |t: f64| VehicleState {
        velocity_body: V3::new(5.0, 0.0, 0.0),
        angular_velocity_body: V3::new(0.0, 0.0, 0.5),
        ..at(V3::zeros(), Quat::from_axis_angle(&V3::z_axis(), 0.5 * t))
    };
    for s in ideal(50, circle) {
        assert_near(s.specific_force, [0.0, 2.5, 9.81], 1e-4);
        assert_near(s.angular_velocity, [0.0, 0.0, 0.5], 1e-12);
    }
    // 3 m/s² forward, and free fall.
    let forward =
        |t: f64| VehicleState { velocity_body: V3::new(3.0 * t, 0.0, 0.0), ..standing(0.0, 0.0, 0.0, 1.0) };
    assert_near(ideal(3, forward)[2].specific_force, [3.0, 0.0, 9.81], 1e-9);
    let falling =
        |t: f64| VehicleState { velocity_body: V3::new(0.0, 0.0, -9.81 * t), ..standing(0.0, 0.0, 0.0, 1.0) };
    assert_near(ideal(3, falling)[2].specific_force, [0.0; 3], 1e-9);
}

/// The six series of a unit at rest, without gravity: force x y z, rate x y z.
fn at_rest(lines: &[(&str, &str)], samples: u64) -> [Vec<f64>; 6] {
    let profile = altered("oracle", lines);
    let mut p = perceive(&profile, &["imu"], &scene(flat(), vec![]), &seed(3, "t"));
    let imu = watch(&mut p, samples, |_| standing(0.0, 0.0, 0.0, 0.0)).imu;
    assert_eq!(imu.len() as u64, samples);
    std::array::from_fn(|k| {
        let value = |s: &ImuSample| {
            let (f, r) = (array(s.specific_force), array(s.angular_velocity));
            if k < 3 { f[k] - [0.0, 0.0, 9.81][k] } else { r[k - 3] }
        };
        imu.iter().map(value).collect()
    })
}

/// The Allan deviation over clusters of m samples (IEEE Std 952-1997, annex C), and its relative standard error 1/√(2(n/m − 1)).
fn allan(x: &[f64], m: usize) -> (f64, f64) {
    let means: Vec<f64> = x.chunks_exact(m).map(|c| c.iter().sum::<f64>() / m as f64).collect();
    let sum: f64 = means.windows(2).map(|w| (w[1] - w[0]) * (w[1] - w[0])).sum();
    let pairs = (means.len() - 1) as f64;
    ((sum / (2.0 * pairs)).sqrt(), 1.0 / (2.0 * pairs).sqrt())
}

/// Five standard errors about the expected deviation, on all axes.
#[track_caller]
fn assert_allan(series: &[Vec<f64>; 6], m: usize, expected: f64) {
    for (axis, x) in series.iter().enumerate() {
        let (got, error) = allan(x, m);
        // Neighbouring differences share a mean, which makes the error of the estimate greater by up to 1.5.
        let bound = 7.5 * error;
        assert!(
            (got / expected - 1.0).abs() < bound,
            "axis {axis}, {m} samples: {got}, expected {expected} within {bound}"
        );
    }
}

#[test]
fn white_noise_falls_with_the_root_of_the_time_from_its_random_walk() {
    let all = at_rest(&[("random_walk: 0\n    bias_i", "random_walk: 0.02\n    bias_i")], 100_000);
    // σ(τ) = N/√τ.
    for m in [1, 10, 100, 500] {
        assert_allan(&all, m, 0.02 / (0.01 * m as f64).sqrt());
    }
}

#[test]
fn the_rate_random_walk_rises_with_the_root_of_the_time() {
    let all = at_rest(&[("rate_random_walk: 0", "rate_random_walk: 0.003")], 100_000);
    // σ(τ) = K √(τ/3).
    for m in [20, 100, 500] {
        assert_allan(&all, m, 0.003 * (0.01 * m as f64 / 3.0).sqrt());
    }
}

#[test]
fn the_bias_has_its_highest_deviation_at_the_bias_instability() {
    let changes = [
        ("bias_instability: 0", "bias_instability: 0.005"),
        ("bias_correlation_s: 1", "bias_correlation_s: 0.5"),
    ];
    let all = at_rest(&changes, 200_000);
    // A first-order Gauss–Markov process has it at 1.89 correlation times, 0.945 s.
    assert_allan(&all, 94, 0.005);
    // σ²(τ) = 2σ²T/τ·(1 − T/(2τ)·(3 − 4 exp(−τ/T) + exp(−2τ/T))) (IEEE Std 952-1997, annex C, exponentially correlated noise), which is lower before and after.
    for m in [20, 300, 1000] {
        let (std, r) = (0.005 / 0.617, 0.01 * m as f64 / 0.5);
        let bracket = 3.0 - 4.0 * vb_math::exp(-r) + vb_math::exp(-2.0 * r);
        assert_allan(&all, m, std * (2.0 / r * (1.0 - bracket / (2.0 * r))).sqrt());
    }
}

#[test]
fn the_bias_at_the_start_is_drawn_once_with_its_deviation() {
    let profile = altered("oracle", &[("turn_on_bias: 0", "turn_on_bias: 0.1")]);
    let (s, mut sum, runs) = (scene(flat(), vec![]), 0.0, 600);
    for run in 0..runs {
        let imu = watch(&mut perceive(&profile, &["imu"], &s, &seed(run, "t")), 2, |_| {
            standing(0.0, 0.0, 0.0, 0.0)
        })
        .imu;
        assert_eq!(imu[0].angular_velocity, imu[1].angular_velocity);
        sum += array(imu[0].angular_velocity).map(|v| v * v).iter().sum::<f64>();
    }
    let n = 3.0 * runs as f64;
    assert!((sum / n / 0.01 - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{}", sum / n);
}

#[test]
fn a_slower_reading_is_the_mean_of_the_measurements_in_between() {
    let (onboard, s) = (Profile::built_in("onboard").unwrap(), scene(flat(), vec![]));
    let read = |need: &str| {
        watch(&mut perceive(&onboard, &[need], &s, &seed(1, "t")), 40, |_| standing(0.0, 0.0, 0.0, 0.0)).imu
    };
    let (fast, slow) = (read("imu"), read("imu 25"));
    assert_eq!((fast.len(), slow.len()), (40, 10));
    for (four, one) in fast.chunks_exact(4).zip(&slow) {
        assert_eq!(four[3].time, one.time);
        let mean = four.iter().map(|s| s.specific_force.x).sum::<f64>() / 4.0;
        assert!((mean - one.specific_force.x).abs() < 1e-12);
    }
}
