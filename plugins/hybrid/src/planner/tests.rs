//! What the planners do on ground that is known beforehand.

use super::*;
use vb_sdk::{GridFrame, Map, Param, Point2, Pose, Vec3, Vehicle};

const PARAMS: [(&str, &str); 22] = [
    ("speed", "4"),
    ("lookahead", "12"),
    ("samples", "400"),
    ("horizon", "20"),
    ("spacing", "5"),
    ("steer_spread", "0.5"),
    ("speed_spread", "1"),
    ("effective", "0.1"),
    ("goal", "1"),
    ("obstacle", "10"),
    ("margin", "1"),
    ("pace", "0.5"),
    ("effort", "0.2"),
    ("tilt", "2"),
    ("roll", "12"),
    ("pitch", "15"),
    ("stuck", "8"),
    ("over", "8"),
    ("price_stuck", "50"),
    ("price_over", "200"),
    ("price_slow", "1"),
    ("price_obstacle", "30"),
];

/// A HMMWV on 80 x 80 m of gravel with these heights, that is to go east along the x axis.
fn task(height: impl Fn(f64, f64) -> f64, params: &[(&str, &str)]) -> Task {
    let frame = GridFrame { rows: 81, cols: 81, resolution: 1.0, origin_x: -40.0, origin_y: -40.0 };
    let at = |k: usize| (f64::from((k % 81) as u32) - 40.0, f64::from((k / 81) as u32) - 40.0);
    let heights = (0..81 * 81).map(|k| height(at(k).0, at(k).1) as f32).collect();
    let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
    let more = [("learned", "1"), ("explain", "0")];
    Task {
        elevation: Some(Map { frame, data: heights }),
        semantics: Some(Map { frame, data: vec![4; 81 * 81] }),
        occupancy: Some(Map { frame, data: vec![0; 81 * 81] }),
        path: (0..=50).map(|i| Point2 { x: f64::from(i) - 25.0, y: 0.0 }).collect(),
        goal: Point2 { x: 25.0, y: 0.0 },
        vehicle: Vehicle {
            name: "hmmwv".into(),
            scale: 1.0,
            wheelbase: 3.302,
            track: 1.819,
            width: 2.2,
            min_turn_radius: 5.2,
            max_steer_rate: 1.5,
            max_speed: 30.0,
            ..Vehicle::default()
        },
        control_period: 0.1,
        seed: 5,
        params: PARAMS
            .iter()
            .chain(&more)
            .map(|(k, d)| Param { key: (*k).into(), value: value(k, d) })
            .collect(),
        ..Task::default()
    }
}

fn observed(x: f64, y: f64, speed: f64) -> Observation {
    let position = Vec3 { x, y, z: 0.0 };
    let linear_velocity = Vec3 { x: speed, ..Vec3::default() };
    Observation::of(Pose { position, linear_velocity, ..Pose::default() })
}

/// The mean steering after some steps at a place.
fn steering(task: &Task, aim: Aim, learned: Learned, o: &Observation) -> f64 {
    let mut planner = Hybrid::new(task, aim, learned).unwrap();
    (0..8).map(|_| planner.step(o).unwrap().steering).skip(3).sum::<f64>() / 5.0
}

#[test]
fn on_flat_ground_every_planner_drives_on_and_towards_its_way() {
    let flat = task(|_, _| 0.0, &[]);
    for (aim, learned) in [
        (Aim::Path, Learned::All),
        (Aim::Path, Learned::Attitude),
        (Aim::Path, Learned::Nothing),
        (Aim::Traversability, Learned::All),
    ] {
        let mut planner = Hybrid::new(&flat, aim, learned).unwrap();
        let c = planner.step(&observed(-25.0, 0.0, 1.0)).unwrap();
        assert!(c.throttle > 0.5 && c.brake == 0.0, "{aim:?} {learned:?}: {c:?}");
        assert!(
            steering(&flat, aim, learned, &observed(-20.0, 0.0, 3.0)).abs() < 0.25,
            "{aim:?} {learned:?}"
        );
        for y in [-8.0, 8.0] {
            let s = steering(&flat, aim, learned, &observed(10.0, y, 3.0));
            assert!(s * y < 0.0, "{aim:?} {learned:?} at y = {y}: {s}");
        }
    }
}

#[test]
fn ground_that_it_foresees_to_be_impassable_is_gone_around() {
    // A ditch of 3 m across the path, from the south edge to 4 m beyond the path, or the same mirrored.
    for side in [1.0, -1.0] {
        let ditch =
            move |x: f64, y: f64| if (-6.0..-2.0).contains(&x) && y * side < 4.0 { -3.0 } else { 0.0 };
        let s = steering(&task(ditch, &[]), Aim::Traversability, Learned::All, &observed(-20.0, 0.0, 3.0));
        assert!(s * side > 0.05, "side {side}: {s}");
    }
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let new = |task: &Task| match Hybrid::new(task, Aim::Traversability, Learned::All) {
        Ok(_) => panic!("it was taken"),
        Err(e) => e.to_string(),
    };
    let flat = || task(|_, _| 0.0, &[]);
    assert!(new(&Task { elevation: None, ..flat() }).contains("gives no map of heights"));
    assert!(new(&Task { occupancy: None, ..flat() }).contains("gives no map of obstacles"));
    for (key, value) in
        [("speed", "0"), ("samples", "0"), ("effective", "1"), ("tilt", "-1"), ("price_stuck", "x")]
    {
        let params = [(key, value)];
        let e = new(&task(|_, _| 0.0, &params));
        assert!(e.contains(key), "{key}: {e}");
    }
    // Without kinds of ground it goes by the heights alone.
    let blind = Task { semantics: None, ..flat() };
    assert!(Hybrid::new(&blind, Aim::Path, Learned::All).is_ok());
}

#[test]
fn what_it_considers_is_told_on_request() {
    let mut planner = Hybrid::new(&task(|_, _| 0.0, &[("explain", "12")]), Aim::Path, Learned::All).unwrap();
    let c = planner.step(&observed(-20.0, 0.0, 3.0)).unwrap();
    let series = |name: &str| c.debug.iter().find(|s| s.name == name).unwrap().values.len();
    // 16 courses of 21 points.
    assert_eq!((series("trajectories"), series("trajectory_costs")), (16 * 21 * 2, 16));
}
