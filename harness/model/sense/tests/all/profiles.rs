//! Profiles: those that are shipped, and what is refused.

use crate::common::{altered_text, flat, hmmwv, needs, scene, seed};
use vb_sense::{Perception, Profile};

#[test]
fn the_shipped_profiles_are_valid_and_named_as_their_files() {
    for name in Profile::names() {
        let built_in = Profile::built_in(name).unwrap();
        assert_eq!(built_in.name(), name);
        let path = format!("{}/../../../tasks/perception/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
        let loaded = Profile::load(path.as_ref()).unwrap();
        assert_eq!(loaded, built_in);
        assert_eq!(loaded.sha256(), vb_files::sha256(&std::fs::read(&path).unwrap()));
    }
    assert!(Profile::built_in("radar").is_none());
}

#[test]
fn a_profile_that_cannot_be_is_refused_with_its_field_and_value() {
    // A shipped profile, a text in it, another in its place, and what the message must say.
    let cases = [
        ("onboard", "schema: 1", "schema: 2", "version 2 is not supported"),
        ("onboard", "name: onboard", "name: On Board", "name: \"On Board\""),
        ("onboard", "rows: 32", "rows: 0", "lidar.rows: 0 must lie in 1"),
        ("onboard", "cols: 512", "cols: 65536", "lidar.cols: 32 x 65536 are 2097152 rays"),
        ("onboard", "cols: 512", "cols: -1", "lidar.cols: \"-1\""),
        ("onboard", "cols: 512", "columns: 512", "columns"),
        ("onboard", "rate_hz: 100", "rate_hz: 200", "imu.rate_hz: 200 must divide 100"),
        ("onboard", "rate_hz: 100", "rate_hz: 30", "imu.rate_hz: 30 must divide 100"),
        ("onboard", "max_range_m: 90", "max_range_m: .nan", "lidar.max_range_m: NaN must lie in"),
        (
            "onboard",
            "max_range_m: 90",
            "max_range_m: 0.4",
            "lidar.max_range_m: 0.4 must be more than min_range_m, 0.5",
        ),
        (
            "onboard",
            "highest_deg: 22.5",
            "highest_deg: -30",
            "lidar.highest_deg: -30 must be more than lowest_deg, -22.5",
        ),
        ("onboard", "range_std_m: 0.02", "range_std_m: -0.02", "lidar.range_std_m: -0.02 must lie in 0"),
        ("onboard", "dropout_near: 0.005", "dropout_near: 1.5", "lidar.dropout_near: 1.5 must lie in 0 to 1"),
        ("onboard", "above_m: 0.4", "above_m: .inf", "lidar.mount.roof.above_m: inf"),
        (
            "onboard",
            "field_of_view_deg: 90",
            "field_of_view_deg: 180",
            "depth.field_of_view_deg: 180 must lie in",
        ),
        (
            "onboard",
            "dirt: 0.12",
            "dirt: 0.99",
            "prior.semantics.coarse.confusions.mud: the probabilities add up to 1.04",
        ),
        (
            "onboard",
            "clay: {dirt: 0.08",
            "clay: {clay: 0.08",
            "prior.semantics.coarse.confusions.clay: a class cannot",
        ),
        ("onboard", "clay: {dirt", "clay: {lava", "lava"),
        (
            "onboard",
            "counts_per_turn: 2000",
            "counts_per_turn: 0",
            "wheel_odometry.measured.counts_per_turn: 0",
        ),
        (
            "onboard",
            "window_s: 0.05",
            "window_s: 0.015",
            "wheel_odometry.measured.window_s: 0.015 must be a multiple",
        ),
        (
            "onboard",
            "mean_duration_s: 2}",
            "mean_duration_s: 0}",
            "gnss.outages.mean_duration_s: 0 must lie in",
        ),
        (
            "onboard",
            "resolution_m: 0.25",
            "resolution_m: 0.3",
            "local_map.resolution_m: 0.3 must divide side_m, 20",
        ),
        ("onboard", "resolution_m: 4", "resolution_m: 0.001", "prior.elevation.coarse.resolution_m: 0.001"),
        ("onboard", "smoothing_m: 4", "smoothing_m: 121", "smoothing_m: 121 must lie in 0 to 120"),
        (
            "onboard",
            "bias_instability: 2.9e-4",
            "bias_instability: -1",
            "imu.accelerometer.bias_instability: -1",
        ),
        ("oracle", "pose: exact", "pose: guessed", "pose"),
        ("oracle", "pose: exact\n", "", "local_map: a local map needs an estimated pose"),
        ("degraded", "extinction_per_m: 0.05", "extinction_per_m: -1", "lidar.dust.extinction_per_m: -1"),
    ];
    for (name, old, new, expected) in cases {
        let text = altered_text(name, &[(old, new)]);
        let e = Profile::parse(&text, "p.yaml").expect_err(new).to_string();
        assert!(e.starts_with("p.yaml: ") && e.contains(expected) && !e.contains('\n'), "{new}: {e}");
    }
}

#[test]
fn a_file_that_is_none_is_refused_with_its_name() {
    let e = Profile::load("/nowhere/p.yaml".as_ref()).unwrap_err();
    assert!(e.field.is_empty() && e.file == "/nowhere/p.yaml", "{e}");
    let dir = tempfile::tempdir().unwrap();
    assert!(Profile::load(dir.path()).is_err());
}

#[test]
fn a_need_that_a_profile_cannot_meet_is_one_line_that_says_what_is_possible() {
    let text = altered_text("degraded", &[]);
    let (start, end) = (text.find("gnss:").unwrap(), text.find("lidar:").unwrap());
    let blind = Profile::parse(&format!("{}{}", &text[..start], &text[end..]), "p.yaml").unwrap();
    let s = scene(flat(), vec![]);
    let refuse = |profile: &Profile, names: &[&str]| {
        Perception::new(profile, &needs(names), &s, &hmmwv(), &seed(1, "t")).err().unwrap().to_string()
    };
    assert_eq!(
        refuse(&blind, &["pose", "gnss"]),
        "the planner needs gnss, which the perception profile degraded does not provide; it provides pose, imu, wheel-odometry, \
         lidar, depth, local-map"
    );
    assert_eq!(
        refuse(&blind, &["lidar 20"]),
        "the planner needs lidar at 20 Hz, but the perception profile degraded provides 10, 5, 4, 2, 1 Hz"
    );
}
