//! The lidar.

use crate::common::{Quat, V3, altered, at, flat, perceive, scene, seed, standing, tilted, upright, watch};
use std::f64::consts::{PI, TAU};
use vb_sdk::{LidarInfo, LidarScan};
use vb_sense::Profile;
use vb_sim::VehicleState;

fn oracle() -> Profile {
    Profile::built_in("oracle").unwrap()
}

/// The direction of a beam in the sensor's frame, as the interface states it.
fn beam(info: &LidarInfo, row: u32, col: u32) -> V3 {
    let elevation = info.lowest + f64::from(row) * (info.highest - info.lowest) / f64::from(info.rows - 1);
    let azimuth = -PI + (f64::from(col) + 0.5) * TAU / f64::from(info.cols);
    let ((up, flat), (s, c)) = (vb_math::sin_cos(elevation), vb_math::sin_cos(azimuth));
    V3::new(flat * c, flat * s, up)
}

/// The points of a scan that have been measured, with row and column, in the body frame.
fn points(info: &LidarInfo, scan: &LidarScan) -> Vec<(u32, u32, V3)> {
    let m = info.mount.position;
    let mut all = Vec::new();
    for row in 0..info.rows {
        for col in 0..info.cols {
            let range = f64::from(scan.ranges[(row * info.cols + col) as usize]);
            if range > 0.0 {
                all.push((row, col, V3::new(m.x, m.y, m.z) + beam(info, row, col) * range));
            }
        }
    }
    all
}

#[test]
fn the_points_of_a_plane_lie_on_the_plane_for_a_vehicle_that_leans() {
    let (a, b, c) = (0.5, 0.1, -0.05);
    let s = scene(tilted(a, b, c), vec![]);
    let mut p = perceive(&oracle(), &["lidar"], &s, &seed(1, "t"));
    let info = p.lidar_info().unwrap();
    let place = (V3::new(1.3, 2.1, 1.2), Quat::from_euler_angles(0.1, -0.15, 0.7));
    let scan = watch(&mut p, 10, |_| at(place.0, place.1)).lidar.unwrap();
    assert_eq!((scan.time, scan.ranges.len()), (0.1, 32 * 512));
    let all = points(&info, &scan);
    assert!(all.len() > 5000, "{}", all.len());
    for (row, col, p) in all {
        let q = place.0 + place.1 * p;
        assert!((q.z - (a + b * q.x + c * q.y)).abs() < 1e-4, "{row} {col}: {q:?}");
    }
}

#[test]
fn a_scan_comes_at_the_end_of_each_turn_and_once() {
    let s = scene(flat(), vec![]);
    let mut p = perceive(&oracle(), &["lidar 5"], &s, &seed(1, "t"));
    assert!((p.lidar_info().unwrap().period - 0.2).abs() < 1e-12);
    let state = standing(0.0, 0.0, 1.0, 0.0);
    let mut times = Vec::new();
    for k in 0..=60 {
        let now = VehicleState { time: f64::from(k) * 0.01, ..state.clone() };
        p.sample(vb_sense::Truth { state: &now, ruts: None });
        times.extend(p.read(&now).lidar.map(|s| (s.time * 100.0).round()));
    }
    assert_eq!(times, [20.0, 40.0, 60.0]);
}

#[test]
fn a_turn_of_a_moving_vehicle_is_measured_from_where_it_is_at_each_column() {
    // Along x at 10 m/s while it turns at 1 rad/s, between four walls.
    let wall = |x: f64, y: f64, sx: f64, sy: f64| upright(x, y, 0.0, [sx, sy, 8.0]);
    let walls = vec![
        wall(15.5, 0.0, 1.0, 40.0),
        wall(-15.5, 0.0, 1.0, 40.0),
        wall(0.0, 12.5, 40.0, 1.0),
        wall(0.0, -12.5, 40.0, 1.0),
    ];
    let s = scene(flat(), walls);
    let mut p = perceive(&oracle(), &["lidar"], &s, &seed(1, "t"));
    let info = p.lidar_info().unwrap();
    let place = |t: f64| (V3::new(10.0 * t, 0.0, 1.0), Quat::from_axis_angle(&V3::z_axis(), t));
    let scan = watch(&mut p, 10, |t| at(place(t).0, place(t).1)).lidar.unwrap();
    let (mut worst, mut as_if_still) = (0.0_f64, 0.0_f64);
    let mut on_walls = 0;
    for (_, col, p) in points(&info, &scan) {
        let off = |t: f64| {
            let q = place(t).0 + place(t).1 * p;
            let to_wall = (q.x.abs() - 15.0).abs().min((q.y.abs() - 12.0).abs());
            to_wall.min(q.z.abs())
        };
        let measured = scan.time - (1.0 - (f64::from(col) + 0.5) / f64::from(info.cols)) * info.period;
        worst = worst.max(off(measured));
        as_if_still = as_if_still.max(off(scan.time));
        on_walls += 1;
    }
    assert!(on_walls > 10_000, "{on_walls}");
    // Within a sample the vehicle is taken to move straight and to turn evenly: some 10⁻⁵ m for the arc of 10 ms.
    assert!(worst < 1e-3, "{worst} m");
    assert!(as_if_still > 0.5, "{as_if_still} m: the distortion would be seen");
}

#[test]
fn the_own_bodywork_hides_beams_and_nothing_else_does() {
    let info = "above_m: 0.4, pitch_deg: 0";
    let low = altered("oracle", &[(info, "above_m: 0.05, pitch_deg: 0")]);
    let high = altered("oracle", &[(info, "above_m: 3, pitch_deg: 0")]);
    let s = scene(vb_world::Heightfield::flat(201, 201, 1.0, 0.0), vec![]);
    let seen = |profile: &Profile| {
        let mut p = perceive(profile, &["lidar"], &s, &seed(1, "t"));
        let info = p.lidar_info().unwrap();
        let scan = watch(&mut p, 10, |_| standing(0.0, 0.0, 0.6, 0.0)).lidar.unwrap();
        (info, scan)
    };
    // From 3 m over the roof all beams below the horizon come down within 90 m but for those near it.
    let (info, scan) = seen(&high);
    let h = 0.6 + info.mount.position.z;
    for row in 0..info.rows {
        for col in 0..info.cols {
            let down = -beam(&info, row, col).z;
            let expected = if down > 0.0 { h / down } else { f64::INFINITY };
            let range = f64::from(scan.ranges[(row * info.cols + col) as usize]);
            let at = beam(&info, row, col) * expected;
            let inside = (at.x + info.mount.position.x).abs() < 100.0 && at.y.abs() < 100.0;
            if expected < 90.0 && inside {
                assert!((range - expected).abs() < 1e-4, "{row} {col}: {range}, expected {expected}");
            } else if expected > 90.0 {
                assert_eq!(range, 0.0, "{row} {col}");
            }
        }
    }
    // From 5 cm over it, the roof of 1.85 by 1.7 m is in the way of all beams that go down by more than 5 cm within it:
    // straight ahead those below atan(0.05/0.925) = 3.1°, and none above.
    let (info, scan) = seen(&low);
    let ahead = info.cols / 2;
    for row in 0..info.rows {
        let elevation = -22.5 + 45.0 * f64::from(row) / 31.0;
        let range = scan.ranges[(row * info.cols + ahead) as usize];
        if elevation < -3.1 {
            assert_eq!(range, 0.0, "{elevation}");
        } else if elevation < -1.5 {
            assert!(range > 0.0, "{elevation}");
        }
    }
}

#[test]
fn ranges_are_wrong_by_their_deviation_and_drop_out_as_stated() {
    let changes = [
        ("range_std_m: 0", "range_std_m: 0.05"),
        ("dropout_near: 0", "dropout_near: 0.1"),
        ("dropout_far: 0", "dropout_far: 0.7"),
    ];
    let s = scene(flat(), vec![upright(30.5, 0.0, 0.0, [1.0, 60.0, 30.0])]);
    let one = |profile: &Profile| {
        watch(&mut perceive(profile, &["lidar"], &s, &seed(1, "t")), 10, |_| standing(0.0, 0.0, 0.6, 0.0))
            .lidar
            .unwrap()
    };
    let (exact, noisy) = (one(&oracle()), one(&altered("oracle", &changes)));
    let (mut squares, mut back, mut lost) = (0.0, 0.0, 0.0);
    let (mut expected, mut variance, mut hits) = (0.0, 0.0, 0.0);
    for (e, n) in exact.ranges.iter().zip(&noisy.ranges).filter(|(e, _)| **e > 0.0) {
        let (e, n) = (f64::from(*e), f64::from(*n));
        let p = 0.1 + 0.6 * (e / 90.0) * (e / 90.0);
        (expected, variance, hits) = (expected + p, variance + p * (1.0 - p), hits + 1.0);
        if n > 0.0 {
            (squares, back) = (squares + (n - e) * (n - e), back + 1.0);
        } else {
            lost += 1.0;
        }
    }
    assert!(hits > 5000.0);
    assert!((lost - expected).abs() < 5.0 * f64::sqrt(variance), "{lost}, expected {expected}");
    let spread = squares / back / 0.0025;
    assert!((spread - 1.0).abs() < 5.0 * f64::sqrt(2.0 / back), "{spread}");
}

#[test]
fn in_dust_returns_from_afar_are_lost() {
    // Always in dust after the first samples, of which half the light is lost within 7 m.
    let dust = "dropout_far: 0\n  dust:\n    spells: {mean_interval_s: 0.01, mean_duration_s: 1000000}\n    extinction_per_m: 0.05\n";
    let dusty = altered("oracle", &[("dropout_far: 0\n", dust)]);
    let s = scene(flat(), vec![]);
    let mut p = perceive(&dusty, &["lidar"], &s, &seed(1, "t"));
    let clear =
        watch(&mut perceive(&oracle(), &["lidar"], &s, &seed(1, "t")), 10, |_| standing(0.0, 0.0, 0.6, 0.0))
            .lidar
            .unwrap();
    let scan = watch(&mut p, 50, |_| standing(0.0, 0.0, 0.6, 0.0)).lidar.unwrap();
    let (mut back, mut expected, mut variance) = (0.0, 0.0, 0.0);
    for (e, n) in clear.ranges.iter().zip(&scan.ranges).filter(|(e, _)| **e > 0.0) {
        let p = vb_math::exp(-0.1 * f64::from(*e));
        (back, expected, variance) =
            (back + f64::from(u8::from(*n > 0.0)), expected + p, variance + p * (1.0 - p));
    }
    assert!((back - expected).abs() < 5.0 * f64::sqrt(variance), "{back}, expected {expected}");
}
