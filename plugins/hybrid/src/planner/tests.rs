//! Behaviour on analytic terrain.

use super::*;
use vb_sdk::{GridFrame, Map, Param, Point2, Pose, Series, Vec3, Vehicle};

const PARAMS: [(&str, &str); 24] = [
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
    ("risk", "0"),
    ("guided", "0.3"),
    ("price_stuck", "50"),
    ("price_over", "200"),
    ("price_slow", "1"),
    ("price_obstacle", "30"),
];

/// A HMMWV on 80 x 80 m of gravel with these heights, with the goal to the east along the x axis.
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
            wheel_radius: 0.467,
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

fn hears(learned: Learned) -> Prediction {
    Prediction { learned, attention: false }
}

const ATTENDS: Prediction = Prediction { learned: Learned::All, attention: true };

/// The mean steering after some steps at a position.
fn steering(task: &Task, aim: Aim, by: Prediction, o: &Observation) -> f64 {
    let mut planner = Hybrid::new(task, aim, by).unwrap();
    (0..8).map(|_| planner.step(o).unwrap().steering).skip(3).sum::<f64>() / 5.0
}

#[test]
fn on_flat_ground_every_planner_drives_on_and_towards_its_way() {
    let flat = task(|_, _| 0.0, &[]);
    for (aim, by) in [
        (Aim::Path, hears(Learned::All)),
        (Aim::Path, hears(Learned::Attitude)),
        (Aim::Path, hears(Learned::Nothing)),
        (Aim::Path, ATTENDS),
        (Aim::Traversability, hears(Learned::All)),
    ] {
        let mut planner = Hybrid::new(&flat, aim, by).unwrap();
        let c = planner.step(&observed(-25.0, 0.0, 1.0)).unwrap();
        assert!(c.throttle > 0.5 && c.brake == 0.0, "{aim:?} {by:?}: {c:?}");
        assert!(steering(&flat, aim, by, &observed(-20.0, 0.0, 3.0)).abs() < 0.25, "{aim:?} {by:?}");
        for y in [-8.0, 8.0] {
            let s = steering(&flat, aim, by, &observed(10.0, y, 3.0));
            assert!(s * y < 0.0, "{aim:?} {by:?} at y = {y}: {s}");
        }
    }
}

/// Costs given at the start and costs added later result in the same commands.
#[test]
fn places_that_are_made_dearer_are_gone_around() {
    let flat = task(|_, _| 0.0, &[]);
    let (aim, by, here) = (Aim::Traversability, hears(Learned::All), observed(-20.0, 0.0, 3.0));
    for side in [1.0, -1.0] {
        let dear = move |Place { at, .. }: Place| {
            if (-6.0..-2.0).contains(&at.x) && at.y * side < 4.0 { 20.0 } else { 0.0 }
        };
        let mut told_later = Hybrid::new(&flat, aim, by).unwrap();
        told_later.avoid(dear);
        let mut told_at_once = Hybrid::over(&flat, aim, by, Some(dear)).unwrap();
        let mut sum = 0.0;
        for _ in 0..8 {
            let command = told_later.step(&here).unwrap();
            assert_eq!(command, told_at_once.step(&here).unwrap());
            sum += command.steering;
        }
        assert!(sum / 8.0 * side > 0.05, "side {side}: {}", sum / 8.0);
    }
}

#[test]
fn who_hurries_drives_faster() {
    let flat = task(|_, _| 0.0, &[("pace", "20")]);
    let throttle = |times: f64| {
        let mut planner = Hybrid::new(&flat, Aim::Path, hears(Learned::All)).unwrap();
        planner.hurry(times);
        (0..8)
            .map(|_| planner.step(&observed(-20.0, 0.0, 5.0)).unwrap())
            .map(|c| c.throttle - c.brake)
            .sum::<f64>()
    };
    assert!(throttle(1.5) > throttle(1.0) + 1.0, "{} {}", throttle(1.5), throttle(1.0));
}

#[test]
fn ground_that_it_foresees_to_be_impassable_is_gone_around() {
    // A ditch of 3 m across the path, from the south edge to 4 m beyond the path, or the same mirrored.
    for side in [1.0, -1.0] {
        let ditch =
            move |x: f64, y: f64| if (-6.0..-2.0).contains(&x) && y * side < 4.0 { -3.0 } else { 0.0 };
        let s =
            steering(&task(ditch, &[]), Aim::Traversability, hears(Learned::All), &observed(-20.0, 0.0, 3.0));
        assert!(s * side > 0.05, "side {side}: {s}");
    }
}

#[test]
fn a_descent_turns_towards_the_goal_and_goes_straight_once_it_looks_there() {
    let planner = Hybrid::new(&task(|_, _| 0.0, &[]), Aim::Traversability, hears(Learned::All)).unwrap();
    // The goal lies at (25, 0).
    let descent = |x: f64, y: f64| {
        let o = observed(x, y, 4.0);
        let start = State::of(&o, planner.model.terrain(), &planner.vehicle).unwrap();
        descend(&planner.model, &planner.objective, &start, (5, 5, 0.2))
    };
    assert!(descent(10.0, 15.0)[0][0] < -0.4 && descent(10.0, -15.0)[0][0] > 0.4);
    let straight = descent(-20.0, 0.0);
    assert_eq!(straight.len(), 5);
    assert!(straight.iter().all(|c| c[0].abs() < 0.5 && c[1] == 4.0), "{straight:?}");
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let new = |task: &Task| match Hybrid::new(task, Aim::Traversability, hears(Learned::All)) {
        Ok(_) => panic!("it was taken"),
        Err(e) => e.to_string(),
    };
    let flat = || task(|_, _| 0.0, &[]);
    assert!(new(&Task { elevation: None, ..flat() }).contains("omits the elevation map"));
    assert!(new(&Task { occupancy: None, ..flat() }).contains("omits the occupancy map"));
    for (key, value) in [
        ("speed", "0"),
        ("samples", "0"),
        ("effective", "1"),
        ("tilt", "-1"),
        ("risk", "1"),
        ("price_stuck", "x"),
    ] {
        let params = [(key, value)];
        let e = new(&task(|_, _| 0.0, &params));
        assert!(e.contains(key), "{key}: {e}");
    }
    // Without terrain classes it uses the heights only.
    let blind = Task { semantics: None, ..flat() };
    assert!(Hybrid::new(&blind, Aim::Path, hears(Learned::All)).is_ok());
}

#[test]
fn what_it_considers_is_told_on_request() {
    let explained = task(|x, _| 0.05 * x, &[("explain", "12")]);
    let told = |aim: Aim, by: Prediction| {
        let mut planner = Hybrid::new(&explained, aim, by).unwrap();
        let steps: Vec<Vec<Series>> =
            (0..12).map(|_| planner.step(&observed(-20.0, 0.0, 3.0)).unwrap().debug).collect();
        move |step: usize, name: &str| {
            steps[step].iter().find(|s| s.name == name).map(|s| s.values.clone()).unwrap_or_default()
        }
    };
    let series = told(Aim::Path, ATTENDS);
    // 16 courses of 21 points.
    assert_eq!((series(0, "trajectories").len(), series(0, "trajectory_costs").len()), (16 * 21 * 2, 16));
    // The plan lies on the terrain, starting at the vehicle.
    let plan = series(0, "plan.xyz");
    assert_eq!(plan.len(), 21 * 3);
    assert!(plan.chunks(3).all(|p| (p[2] - 0.05 * p[0]).abs() < 1e-3) && plan[0] == -20.0, "{plan:?}");
    // A vehicle that does not move deviates increasingly from its prediction.
    assert!(series(9, "prediction_error").is_empty() && series(10, "prediction_error")[0] > 0.5);
    // The attention weights sum to 1.
    let shares = series(0, "attention.cost");
    assert!(shares.len() == 5 && (shares.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{shares:?}");
    assert!(shares.iter().all(|s| *s > 0.0), "{shares:?}");
    // The map is recorded once.
    let series = told(Aim::Traversability, hears(Learned::All));
    assert_eq!(series(0, "traversability.cost").len(), 41 * 41);
    assert_eq!(series(0, "traversability.xyz").len(), 41 * 41 * 9);
    assert!(series(1, "traversability.cost").is_empty() && series(1, "attention.cost").is_empty());
    assert!(series(0, "way_left")[0] > 40.0);
}

#[test]
fn maps_of_any_resolution_and_worlds_of_any_scale_are_driven_in() {
    // The same slope with a resolution of 2 m and of 0.5 m, each also at a tenth of the scale.
    for (resolution, scale) in [(2.0, 1.0), (0.5, 1.0), (0.1, 0.1), (1.0, 1.0 / 6.0)] {
        let n = (80.0 * scale / resolution) as u32 + 1;
        let frame =
            GridFrame { rows: n, cols: n, resolution, origin_x: -40.0 * scale, origin_y: -40.0 * scale };
        let flat = task(|_, _| 0.0, &[]);
        let heights = (0..n * n).map(|k| 0.05 * (frame.position(k / n, k % n).0 as f32)).collect();
        let own = Task {
            elevation: Some(Map { frame, data: heights }),
            semantics: Some(Map { frame, data: vec![4; (n * n) as usize] }),
            occupancy: Some(Map { frame, data: vec![0; (n * n) as usize] }),
            path: flat.path.iter().map(|p| Point2 { x: p.x * scale, y: p.y * scale }).collect(),
            goal: Point2 { x: 25.0 * scale, y: 0.0 },
            vehicle: Vehicle {
                scale,
                wheelbase: 3.302 * scale,
                track: 1.819 * scale,
                width: 2.2 * scale,
                min_turn_radius: 5.2 * scale,
                wheel_radius: 0.467 * scale,
                max_steer_rate: 1.5 / scale.sqrt(),
                max_speed: 30.0 * scale.sqrt(),
                ..flat.vehicle.clone()
            },
            ..flat
        };
        for (aim, by) in [(Aim::Path, ATTENDS), (Aim::Traversability, hears(Learned::All))] {
            let s = steering(&own, aim, by, &observed(10.0 * scale, 8.0 * scale, 3.0 * scale.sqrt()));
            assert!(s < 0.0, "{resolution} m at scale {scale}, {aim:?}: {s}");
        }
    }
}

#[test]
fn an_observation_that_is_no_number_is_an_error() {
    let flat = task(|_, _| 0.0, &[]);
    let mut planner = Hybrid::new(&flat, Aim::Path, ATTENDS).unwrap();
    let mut o = observed(-20.0, 0.0, 3.0);
    o.wheels = vec![vb_sdk::Wheel { spin: f64::NAN, travel: 0.0 }];
    let e = planner.step(&o).unwrap_err().to_string();
    assert!(e.contains("NaN"), "{e}");
}
