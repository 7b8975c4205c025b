//! The table of docs/perception.md against the profiles.

use serde_json::Value;

/// How a row begins, and the fields whose values its cells have, in their order, each with the number of its unit in the docs that
/// make up one in the profile.
const ROWS: &[(&str, &[(&str, f64)])] = &[
    (
        "prior heights",
        &[
            ("prior.elevation.coarse.resolution_m", 1.0),
            ("prior.elevation.coarse.smoothing_m", 1.0),
            ("prior.elevation.coarse.error_std_m", 1.0),
            ("prior.elevation.coarse.error_correlation_m", 1.0),
        ],
    ),
    ("prior terrain classes", &[("prior.semantics.coarse.resolution_m", 1.0)]),
    ("prior obstacles", &[("prior.occupancy.resolution_m", 1.0)]),
    (
        "pose: heading",
        &[
            ("pose.estimated.heading_walk_rad_per_sqrt_m", 1.0),
            ("pose.estimated.position_walk_m_per_sqrt_m", 1.0),
            ("pose.estimated.height_walk_m_per_sqrt_m", 1.0),
        ],
    ),
    ("pose: roll", &[("pose.estimated.tilt.std_deg", 1.0), ("pose.estimated.tilt.correlation_s", 1.0)]),
    (
        "pose: velocity",
        &[
            ("pose.estimated.velocity_std_m_per_s", 1.0),
            ("pose.estimated.angular_velocity_std_rad_per_s", 1.0),
        ],
    ),
    (
        "wheels",
        &[
            ("wheel_odometry.measured.counts_per_turn", 1.0),
            ("wheel_odometry.measured.window_s", 1.0),
            ("wheel_odometry.measured.travel_std_m", 1000.0),
        ],
    ),
    (
        "accelerometer",
        &[
            ("imu.accelerometer.random_walk", 1.0),
            ("imu.accelerometer.bias_instability", 1.0),
            ("imu.accelerometer.rate_random_walk", 1.0),
            ("imu.accelerometer.turn_on_bias", 1.0),
        ],
    ),
    (
        "gyroscope",
        &[
            ("imu.gyroscope.random_walk", 1.0),
            ("imu.gyroscope.bias_instability", 1.0),
            ("imu.gyroscope.rate_random_walk", 1.0),
            ("imu.gyroscope.turn_on_bias", 1.0),
        ],
    ),
    (
        "GNSS: rate",
        &[
            ("gnss.rate_hz", 1.0),
            ("gnss.horizontal.std_m", 1.0),
            ("gnss.horizontal.correlation_s", 1.0),
            ("gnss.horizontal.white_std_m", 1.0),
            ("gnss.vertical.std_m", 1.0),
            ("gnss.vertical.white_std_m", 1.0),
        ],
    ),
    ("GNSS: outages", &[("gnss.outages.mean_interval_s", 1.0), ("gnss.outages.mean_duration_s", 1.0)]),
    (
        "lidar: beams",
        &[
            ("lidar.rows", 1.0),
            ("lidar.cols", 1.0),
            ("lidar.rate_hz", 1.0),
            ("lidar.highest_deg", 1.0),
            ("lidar.min_range_m", 1.0),
            ("lidar.max_range_m", 1.0),
        ],
    ),
    (
        "lidar: range",
        &[("lidar.range_std_m", 100.0), ("lidar.dropout_near", 100.0), ("lidar.dropout_far", 100.0)],
    ),
    (
        "lidar: dust",
        &[
            ("lidar.dust.spells.mean_duration_s", 1.0),
            ("lidar.dust.spells.mean_interval_s", 1.0),
            ("lidar.dust.extinction_per_m", 1.0),
        ],
    ),
    (
        "depth camera: size",
        &[
            ("depth.cols", 1.0),
            ("depth.rows", 1.0),
            ("depth.rate_hz", 1.0),
            ("depth.field_of_view_deg", 1.0),
            ("depth.min_depth_m", 1.0),
            ("depth.max_depth_m", 1.0),
        ],
    ),
    ("depth camera: error", &[("depth.error_per_m", 1.0), ("depth.dropout", 100.0)]),
    ("local map", &[("local_map.side_m", 1.0), ("local_map.resolution_m", 1.0), ("local_map.rate_hz", 1.0)]),
];

/// The numbers of a cell, but for those of units.
fn numbers(cell: &str) -> Vec<f64> {
    let plain = cell.replace("1/m", "").replace("√(1 m)", "");
    let part = |c: char| !(c.is_ascii_digit() || matches!(c, '.' | 'e' | '-'));
    plain.split(part).filter_map(|word| word.parse().ok()).collect()
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs())
}

#[test]
fn the_table_has_the_figures_of_the_profiles() {
    let root = format!("{}/../../..", env!("CARGO_MANIFEST_DIR"));
    let read = |path: String| std::fs::read_to_string(format!("{root}/{path}")).unwrap();
    let docs = read("docs/perception.md".into());
    let profiles = ["oracle", "onboard", "degraded"].map(|name| -> Value {
        serde_yaml::from_str(&read(format!("tasks/perception/{name}.yaml"))).unwrap()
    });
    for (begin, fields) in ROWS {
        let row = docs.lines().find(|l| l.starts_with(&format!("| {begin}")));
        let row = row.unwrap_or_else(|| panic!("there is no row {begin}"));
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").skip(1).collect();
        let mut left: Vec<f64> = Vec::new();
        for (k, (cell, profile)) in cells.iter().zip(&profiles).enumerate() {
            let value = |(path, unit): &(&str, f64)| {
                let found = path.split('.').try_fold(profile, |at, key| at.get(key));
                found.and_then(Value::as_f64).map(|v| v * unit)
            };
            let own: Vec<f64> = fields.iter().filter_map(value).collect();
            // What is ideal is said in words, or once; what is the same as to the left isn't said again.
            let ideal = |v: f64| k == 0 && (v == 0.0 || v == 1.0);
            let said: Vec<f64> = own.iter().copied().filter(|v| !ideal(*v)).collect();
            let new: Vec<f64> = own
                .iter()
                .enumerate()
                .filter(|(i, v)| left.get(*i).is_none_or(|l| l != *v))
                .map(|(_, v)| *v)
                .collect();
            let told: Vec<f64> = numbers(cell).into_iter().filter(|v| !ideal(*v)).collect();
            assert!(
                same(&told, &said) || same(&told, &new),
                "{begin}: the docs have \"{cell}\", the profile {own:?}"
            );
            left = own;
        }
    }
}
