//! The map of the surroundings.

use crate::common::{V3, altered, at, flat, perceive, scene, seed, standing, tilted, upright, watch};
use vb_sdk::LocalMap;
use vb_sense::Profile;
use vb_sim::VehicleState;

fn map(
    profile: &Profile,
    scene: &std::sync::Arc<vb_sense::rays::Scene>,
    last: u64,
    state: impl Fn(f64) -> VehicleState,
) -> LocalMap {
    watch(&mut perceive(profile, &["local-map"], scene, &seed(1, "t")), last, state).local_map.unwrap()
}

fn oracle() -> Profile {
    Profile::built_in("oracle").unwrap()
}

/// A drive of 12 m along a slant, in 3 s.
fn drive(t: f64) -> VehicleState {
    let yaw = 0.4;
    let (s, c) = vb_math::sin_cos(yaw);
    VehicleState {
        velocity_body: V3::new(4.0, 0.0, 0.0),
        ..standing(-5.0 + 4.0 * t * c, 4.0 * t * s, 0.7, yaw)
    }
}

#[test]
fn without_noise_the_map_is_the_truth_where_it_was_seen_and_unknown_elsewhere() {
    let (a, b, c) = (0.0, 0.05, -0.03);
    let on_slope = |t: f64| {
        let s = drive(t);
        VehicleState {
            position: s.position + V3::new(0.0, 0.0, a + b * s.position.x + c * s.position.y),
            ..s
        }
    };
    let s = scene(tilted(a, b, c), vec![]);
    let m = map(&oracle(), &s, 300, on_slope);
    assert_eq!(m.time, 3.0);
    let frame = m.elevation.frame;
    assert_eq!((frame.rows, frame.cols, frame.resolution), (80, 80, 0.25));
    assert_eq!((m.semantics.frame, m.occupancy.frame), (frame, frame));
    // The vehicle is in the middle.
    let here = on_slope(3.0).position;
    let (x, y) = frame.position(40, 40);
    assert!((here.x - x).abs() <= 0.25 && (here.y - y).abs() <= 0.25);
    let mut seen = 0;
    for row in 0..80 {
        for col in 0..80 {
            let (x, y) = frame.position(row, col);
            let z = f64::from(m.elevation.at(row, col));
            if z.is_nan() {
                assert_eq!((m.occupancy.at(row, col), m.semantics.at(row, col)), (255, 255));
                continue;
            }
            seen += 1;
            // Hits lie anywhere in their cell: a mean is off by at most the rise over half of it.
            let off = z - (a + b * x + c * y);
            assert!(off.abs() < 0.125 * (b.abs() + c.abs()) + 1e-4, "{row} {col}: {off}");
            assert_eq!(m.occupancy.at(row, col), 0);
            assert!([2, 255].contains(&m.semantics.at(row, col)));
        }
    }
    assert!(seen > 3500, "{seen} of 6400 cells");
}

#[test]
fn behind_a_wall_all_is_unknown_and_the_wall_is_occupied() {
    // Its face is at x = 3.1 m, within the cells about 3.125 m, from y = -20 to 20 m.
    let s = scene(flat(), vec![upright(3.35, 0.0, 0.0, [0.5, 40.0, 20.0])]);
    let m = map(&oracle(), &s, 30, |_| standing(0.0, 0.0, 0.7, 0.0));
    let (mut wall, mut before) = (0, 0);
    for row in 0..80 {
        for col in 0..80 {
            let (x, y) = m.occupancy.frame.position(row, col);
            let (occupancy, z) = (m.occupancy.at(row, col), m.elevation.at(row, col));
            if x > 3.2 {
                assert!(occupancy == 255 && z.is_nan(), "behind it, at {x} {y}: {occupancy} {z}");
            } else if x > 3.0 {
                wall += u32::from(occupancy == 1);
            } else {
                assert_ne!(occupancy, 1, "before it, at {x} {y}");
                before += u32::from(occupancy == 0);
            }
        }
    }
    // It goes across all of the map's 80 rows; at its ends columns of the scan are farther apart than cells. Near the
    // vehicle the ground is below the lowest beam.
    assert!(wall >= 76, "{wall} cells of the wall");
    assert!(before > 500, "{before} cells before it");
}

#[test]
fn what_was_seen_stays_while_it_is_within_the_map() {
    // A block in the way, which is within the bodywork's shadow when the vehicle stands beside it; the camera looks ahead.
    let s = scene(flat(), vec![upright(3.1, 4.1, 0.0, [0.5, 0.5, 0.5])]);
    let m = map(&oracle(), &s, 200, |t| standing(-6.0 + 5.0 * t, 0.0, 0.7, 0.0));
    assert_eq!(m.occupancy.nearest(3.0, 4.1), 1);
    // 10 m on, x = -6 is beyond the map's edge.
    assert!(!m.occupancy.frame.covers(-6.2, 0.0) && m.occupancy.frame.covers(-5.8, 0.0));
    assert!(!m.elevation.nearest(-3.0, 3.0).is_nan());
}

#[test]
fn the_drift_of_the_estimate_smears_the_map() {
    let post = || vec![upright(8.1, 3.1, 0.0, [0.2, 0.2, 6.0])];
    let occupied = |heading: &str| {
        let profile = altered(
            "onboard",
            &[
                ("heading_walk_rad_per_sqrt_m: 0.001", heading),
                ("position_walk_m_per_sqrt_m: 0.05", "position_walk_m_per_sqrt_m: 0"),
            ],
        );
        let m = map(&profile, &scene(flat(), post()), 400, |t| standing(2.0 * t, 0.0, 0.7, 0.0));
        m.occupancy.data.iter().filter(|o| **o == 1).count()
    };
    let (sharp, smeared) =
        (occupied("heading_walk_rad_per_sqrt_m: 0"), occupied("heading_walk_rad_per_sqrt_m: 0.08"));
    assert!(smeared > 2 * sharp, "{smeared} cells for {sharp}");
}

#[test]
fn the_map_stands_where_the_estimate_says_and_not_where_the_vehicle_is() {
    let profile =
        altered("onboard", &[("position_walk_m_per_sqrt_m: 0.05", "position_walk_m_per_sqrt_m: 1")]);
    let s = scene(flat(), vec![]);
    let r = watch(&mut perceive(&profile, &["pose", "local-map"], &s, &seed(1, "t")), 400, |t| {
        standing(2.0 * t, 0.0, 0.7, 0.0)
    });
    let (pose, m) = (r.pose.unwrap(), r.local_map.unwrap());
    let off = pose.position.x - 8.0;
    assert!(off.abs() > 0.5, "{off} m of drift");
    let (x, y) = m.elevation.frame.position(40, 40);
    assert!((pose.position.x - x).abs() <= 0.25 && (pose.position.y - y).abs() <= 0.25);
}

#[test]
fn the_map_of_a_vehicle_that_leans_is_level() {
    let lean = crate::common::Quat::from_euler_angles(0.15, -0.1, 0.5);
    let m = map(&oracle(), &scene(flat(), vec![]), 20, |_| at(V3::new(0.0, 0.0, 0.8), lean));
    let seen: Vec<f32> = m.elevation.data.iter().copied().filter(|z| !z.is_nan()).collect();
    assert!(seen.len() > 1000 && seen.iter().all(|z| z.abs() < 1e-4));
}

#[test]
fn what_the_camera_sees_is_put_where_the_estimate_says_too() {
    let text = crate::common::altered_text(
        "onboard",
        &[
            ("heading_walk_rad_per_sqrt_m: 0.001", "heading_walk_rad_per_sqrt_m: 0"),
            ("position_walk_m_per_sqrt_m: 0.05", "position_walk_m_per_sqrt_m: 1"),
            ("std_deg: 0.5", "std_deg: 0"),
            ("error_per_m: 0.0033", "error_per_m: 0"),
        ],
    );
    let (start, end) = (text.find("\nlidar:").unwrap(), text.find("\ndepth:").unwrap());
    let profile = Profile::parse(&format!("{}{}", &text[..start], &text[end..]), "no lidar").unwrap();
    // A post whose face is at x = 8 m, straight ahead.
    let s = scene(flat(), vec![upright(8.1, 0.0, 0.0, [0.2, 0.6, 6.0])]);
    let mut p = perceive(&profile, &["pose", "local-map"], &s, &seed(1, "t"));
    let r = watch(&mut p, 200, |t| standing(2.0 * t, 0.0, 0.7, 0.0));
    let (pose, m) = (r.pose.unwrap(), r.local_map.unwrap());
    let off = [pose.position.x - 4.0, pose.position.y];
    assert!(off[0].abs() > 0.5, "{off:?} m of drift");
    assert_eq!(m.occupancy.nearest(8.0 + off[0] + 1e-6, off[1]), 1);
}
