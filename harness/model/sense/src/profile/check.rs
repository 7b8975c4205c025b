//! Whether the figures of a profile make sense.

use super::{
    Confusions, DepthModel, GnssError, Inertial, LidarModel, MountModel, PoseModel, PriorElevation,
    PriorSemantics, ProfileData, Spells, WheelModel,
};
use vb_files::Flaw;
use vb_files::document::within;
use vb_sdk::metadata::is_rate;

/// The most rays of a sensor at a time, which bounds memory and time.
const MOST_RAYS: u64 = 1 << 20;
/// The most cells along the side of a local map.
const MOST_CELLS: f64 = 1024.0;
/// The least resolution of a prior map at full scale, m, which bounds its memory in the largest worlds.
const LEAST_RESOLUTION: f64 = 0.05;
/// How many times as wide as the resolution of a prior the squares may be, at most, over which it is smoothed: they overlap by then,
/// and the time to make it rises with the square.
const MOST_SMOOTHING: f64 = 30.0;

type Checked = Result<(), Flaw>;

fn flaw(field: impl Into<String>, problem: impl Into<String>) -> Checked {
    Err(Flaw::new(field, problem))
}

/// The same for several fields of one part.
fn all_within(part: &str, fields: &[(&str, f64, f64, f64)]) -> Checked {
    fields
        .iter()
        .try_for_each(|&(name, value, low, high)| within(&format!("{part}.{name}"), value, low, high))
}

fn rate(field: &str, value: f64) -> Checked {
    if is_rate(value) && value >= 0.1 {
        return Ok(());
    }
    flaw(field, format!("{value} must divide 100 and be at least 0.1"))
}

fn ordered(part: &str, low: (&str, f64), high: (&str, f64)) -> Checked {
    if low.1 < high.1 {
        return Ok(());
    }
    flaw(format!("{part}.{}", high.0), format!("{} must be more than {}, {}", high.1, low.0, low.1))
}

fn spells(part: &str, s: &Spells) -> Checked {
    all_within(
        part,
        &[
            ("mean_interval_s", s.mean_interval_s, 0.01, 1e6),
            ("mean_duration_s", s.mean_duration_s, 0.01, 1e6),
        ],
    )
}

fn confusions(part: &str, c: &Confusions) -> Checked {
    for (truth, others) in &c.0 {
        let field = format!("{part}.{}", format!("{truth:?}").to_lowercase());
        for (seen, p) in others {
            within(&format!("{field}.{}", format!("{seen:?}").to_lowercase()), *p, 0.0, 1.0)?;
            if seen == truth {
                return flaw(
                    field,
                    "a class cannot be confused with itself: the remaining probability is that of its recognition",
                );
            }
        }
        let sum: f64 = others.values().sum();
        if sum > 1.0 {
            return flaw(field, format!("the probabilities add up to {sum}, which must be at most 1"));
        }
    }
    Ok(())
}

fn inertial(part: &str, i: &Inertial) -> Checked {
    all_within(
        part,
        &[
            ("random_walk", i.random_walk, 0.0, 10.0),
            ("bias_instability", i.bias_instability, 0.0, 10.0),
            ("bias_correlation_s", i.bias_correlation_s, 0.1, 1e6),
            ("rate_random_walk", i.rate_random_walk, 0.0, 10.0),
            ("turn_on_bias", i.turn_on_bias, 0.0, 10.0),
        ],
    )
}

fn gnss_error(part: &str, e: &GnssError) -> Checked {
    all_within(
        part,
        &[
            ("std_m", e.std_m, 0.0, 1000.0),
            ("correlation_s", e.correlation_s, 0.1, 1e6),
            ("white_std_m", e.white_std_m, 0.0, 1000.0),
        ],
    )
}

fn mount(part: &str, m: &MountModel) -> Checked {
    match m {
        MountModel::Roof { above_m, pitch_deg } => all_within(
            &format!("{part}.roof"),
            &[("above_m", *above_m, 0.0, 10.0), ("pitch_deg", *pitch_deg, -90.0, 90.0)],
        ),
        MountModel::RoofFront { above_m, pitch_deg } => all_within(
            &format!("{part}.roof_front"),
            &[("above_m", *above_m, 0.0, 10.0), ("pitch_deg", *pitch_deg, -90.0, 90.0)],
        ),
        MountModel::At { position_m, roll_deg, pitch_deg, yaw_deg } => {
            let part = format!("{part}.at");
            for (k, &x) in position_m.iter().enumerate() {
                within(&format!("{part}.position_m[{k}]"), x, -20.0, 20.0)?;
            }
            all_within(
                &part,
                &[
                    ("roll_deg", *roll_deg, -180.0, 180.0),
                    ("pitch_deg", *pitch_deg, -90.0, 90.0),
                    ("yaw_deg", *yaw_deg, -180.0, 180.0),
                ],
            )
        }
    }
}

fn rays(part: &str, rows: u32, cols: u32) -> Checked {
    for (name, n) in [("rows", rows), ("cols", cols)] {
        within(&format!("{part}.{name}"), f64::from(n), 1.0, 65_536.0)?;
    }
    let all = u64::from(rows) * u64::from(cols);
    if all > MOST_RAYS {
        return flaw(
            format!("{part}.cols"),
            format!("{rows} x {cols} are {all} rays; at most {MOST_RAYS} are allowed"),
        );
    }
    Ok(())
}

fn lidar(l: &LidarModel) -> Checked {
    rate("lidar.rate_hz", l.rate_hz)?;
    rays("lidar", l.rows, l.cols)?;
    all_within(
        "lidar",
        &[
            ("lowest_deg", l.lowest_deg, -89.0, 89.0),
            ("highest_deg", l.highest_deg, -89.0, 89.0),
            ("min_range_m", l.min_range_m, 0.0, 1000.0),
            ("max_range_m", l.max_range_m, 0.1, 1000.0),
            ("range_std_m", l.range_std_m, 0.0, 10.0),
            ("dropout_near", l.dropout_near, 0.0, 1.0),
            ("dropout_far", l.dropout_far, 0.0, 1.0),
        ],
    )?;
    if l.rows > 1 {
        ordered("lidar", ("lowest_deg", l.lowest_deg), ("highest_deg", l.highest_deg))?;
    }
    ordered("lidar", ("min_range_m", l.min_range_m), ("max_range_m", l.max_range_m))?;
    if let Some(dust) = &l.dust {
        spells("lidar.dust.spells", &dust.spells)?;
        within("lidar.dust.extinction_per_m", dust.extinction_per_m, 0.0, 100.0)?;
    }
    mount("lidar.mount", &l.mount)
}

fn depth(d: &DepthModel) -> Checked {
    rate("depth.rate_hz", d.rate_hz)?;
    rays("depth", d.rows, d.cols)?;
    all_within(
        "depth",
        &[
            ("field_of_view_deg", d.field_of_view_deg, 1.0, 170.0),
            ("min_depth_m", d.min_depth_m, 0.0, 1000.0),
            ("max_depth_m", d.max_depth_m, 0.1, 1000.0),
            ("error_per_m", d.error_per_m, 0.0, 1.0),
            ("dropout", d.dropout, 0.0, 1.0),
        ],
    )?;
    ordered("depth", ("min_depth_m", d.min_depth_m), ("max_depth_m", d.max_depth_m))?;
    confusions("depth.confusions", &d.confusions)?;
    mount("depth.mount", &d.mount)
}

fn prior(p: &ProfileData) -> Checked {
    if let Some(PriorElevation::Coarse { resolution_m, smoothing_m, error_std_m, error_correlation_m }) =
        p.prior.elevation
    {
        all_within(
            "prior.elevation.coarse",
            &[
                ("resolution_m", resolution_m, LEAST_RESOLUTION, 1000.0),
                ("smoothing_m", smoothing_m, 0.0, 1000.0),
                ("error_std_m", error_std_m, 0.0, 100.0),
                ("error_correlation_m", error_correlation_m, LEAST_RESOLUTION, 1e6),
            ],
        )?;
        // Each node is the mean over such a square of the world's own heights.
        within("prior.elevation.coarse.smoothing_m", smoothing_m, 0.0, MOST_SMOOTHING * resolution_m)?;
    }
    if let Some(PriorSemantics::Coarse { resolution_m, confusions: c }) = &p.prior.semantics {
        within("prior.semantics.coarse.resolution_m", *resolution_m, LEAST_RESOLUTION, 1000.0)?;
        confusions("prior.semantics.coarse.confusions", c)?;
    }
    match &p.prior.occupancy {
        Some(o) => within("prior.occupancy.resolution_m", o.resolution_m, LEAST_RESOLUTION, 1000.0),
        None => Ok(()),
    }
}

/// The first flaw of a profile, if it has one.
pub(super) fn check(p: &ProfileData) -> Checked {
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if p.name.is_empty() || p.name.len() > 64 || !p.name.chars().all(is_word) {
        return flaw("name", format!("{:?} must consist of lower-case letters, digits and hyphens", p.name));
    }
    prior(p)?;
    if let Some(PoseModel::Estimated(e)) = &p.pose {
        all_within(
            "pose.estimated",
            &[
                ("heading_walk_rad_per_sqrt_m", e.heading_walk_rad_per_sqrt_m, 0.0, 1.0),
                ("position_walk_m_per_sqrt_m", e.position_walk_m_per_sqrt_m, 0.0, 10.0),
                ("height_walk_m_per_sqrt_m", e.height_walk_m_per_sqrt_m, 0.0, 10.0),
                ("tilt.std_deg", e.tilt.std_deg, 0.0, 45.0),
                ("tilt.correlation_s", e.tilt.correlation_s, 0.01, 1e6),
                ("velocity_std_m_per_s", e.velocity_std_m_per_s, 0.0, 10.0),
                ("angular_velocity_std_rad_per_s", e.angular_velocity_std_rad_per_s, 0.0, 10.0),
            ],
        )?;
    }
    if let Some(WheelModel::Measured(w)) = &p.wheel_odometry {
        let part = "wheel_odometry.measured";
        within(&format!("{part}.counts_per_turn"), f64::from(w.counts_per_turn), 1.0, 1e9)?;
        within(&format!("{part}.window_s"), w.window_s, 0.01, 10.0)?;
        let samples = w.window_s * 100.0;
        if (samples - samples.round()).abs() > 1e-6 {
            return flaw(format!("{part}.window_s"), format!("{} must be a multiple of 0.01", w.window_s));
        }
        within(&format!("{part}.travel_std_m"), w.travel_std_m, 0.0, 1.0)?;
    }
    if let Some(i) = &p.imu {
        rate("imu.rate_hz", i.rate_hz)?;
        inertial("imu.accelerometer", &i.accelerometer)?;
        inertial("imu.gyroscope", &i.gyroscope)?;
    }
    if let Some(g) = &p.gnss {
        rate("gnss.rate_hz", g.rate_hz)?;
        gnss_error("gnss.horizontal", &g.horizontal)?;
        gnss_error("gnss.vertical", &g.vertical)?;
        if let Some(s) = &g.outages {
            spells("gnss.outages", s)?;
        }
    }
    p.lidar.as_ref().map_or(Ok(()), lidar)?;
    p.depth.as_ref().map_or(Ok(()), depth)?;
    if let Some(m) = &p.local_map {
        rate("local_map.rate_hz", m.rate_hz)?;
        all_within(
            "local_map",
            &[
                ("side_m", m.side_m, 0.1, 1000.0),
                ("resolution_m", m.resolution_m, 0.01, 100.0),
                ("memory", f64::from(m.memory), 1.0, 1e6),
            ],
        )?;
        let cells = m.side_m / m.resolution_m;
        if !(2.0..=MOST_CELLS).contains(&cells) || (cells - cells.round()).abs() > 1e-6 {
            let problem =
                format!("{} must divide side_m, {}, into 2 to {MOST_CELLS} cells", m.resolution_m, m.side_m);
            return flaw("local_map.resolution_m", problem);
        }
        if p.pose.is_none() {
            return flaw("local_map", "a local map needs an estimated pose, and the profile has none");
        }
        if p.lidar.is_none() && p.depth.is_none() {
            return flaw(
                "local_map",
                "a local map needs a lidar or a depth camera, and the profile has neither",
            );
        }
    }
    Ok(())
}
