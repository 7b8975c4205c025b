//! Behaviour beyond TNT, on known terrain and on local maps.

use super::*;
use vb_sdk::{Gear, GridFrame, LocalMap, Map, Param, Point2, Pose, Vec3, Wheel};

const PARAMS: &[(&str, &str)] = &[
    ("speed", "4"),
    ("lookahead", "12"),
    ("samples", "256"),
    ("horizon", "20"),
    ("spacing", "5"),
    ("steer_spread", "0.5"),
    ("speed_spread", "1"),
    ("effective", "0.03"),
    ("goal", "2"),
    ("obstacle", "10"),
    ("margin", "1"),
    ("pace", "0.5"),
    ("effort", "0.2"),
    ("tilt", "6"),
    ("roll", "12"),
    ("pitch", "15"),
    ("stuck", "8"),
    ("over", "30"),
    ("risk", "0"),
    ("guided", "0.3"),
    ("price_stuck", "25"),
    ("price_over", "200"),
    ("price_slow", "1"),
    ("price_obstacle", "30"),
    ("price_hull", "10"),
    ("price_tilt", "5"),
    ("price_again", "20"),
    ("foresight", "64"),
    ("clearance", "0.05"),
    ("hull", "4"),
    ("recover", "1"),
    ("learned", "1"),
    ("explain", "0"),
];

/// A HMMWV on 80 x 80 m of gravel with these heights, with the goal to the east along the x axis.
fn task(height: impl Fn(f64, f64) -> f64, params: &[(&str, &str)]) -> Task {
    let frame = GridFrame { rows: 161, cols: 161, resolution: 0.5, origin_x: -40.0, origin_y: -40.0 };
    let heights = (0..161 * 161).map(|k| {
        let (x, y) = frame.position(k / 161, k % 161);
        height(x, y) as f32
    });
    let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
    Task {
        elevation: Some(Map { frame, data: heights.collect() }),
        semantics: Some(Map { frame, data: vec![4; 161 * 161] }),
        occupancy: Some(Map { frame, data: vec![0; 161 * 161] }),
        half_extent: Point2 { x: 40.0, y: 40.0 },
        path: (0..=50).map(|i| Point2 { x: f64::from(i) - 25.0, y: 0.0 }).collect(),
        goal: Point2 { x: 25.0, y: 0.0 },
        vehicle: Vehicle {
            name: "hmmwv".into(),
            scale: 1.0,
            wheelbase: 3.302,
            track: 1.819,
            width: 2.2,
            length: 4.67,
            ground_clearance: 0.41,
            min_turn_radius: 7.6,
            max_steer_angle: 0.6,
            wheel_radius: 0.467,
            max_steer_rate: 1.5,
            max_speed: 30.0,
            max_reverse_speed: 5.0,
            direction_change_time: 0.6,
            direction_change_speed: 0.5,
            mass: 2494.0,
            ..Vehicle::default()
        },
        control_period: 0.1,
        seed: 5,
        params: PARAMS.iter().map(|(k, d)| Param { key: (*k).into(), value: value(k, d) }).collect(),
        ..Task::default()
    }
}

fn observed(time: f64, x: f64, speed: f64, gear: Gear) -> Observation {
    let position = Vec3 { x, y: 0.0, z: 0.42 };
    let linear_velocity = Vec3 { x: speed, ..Vec3::default() };
    let pose = Pose { position, linear_velocity, ..Pose::default() };
    let wheels = vec![Wheel { spin: 20.0, travel: 0.0 }; 4];
    Observation { time, gear, wheels, ..Observation::of(pose) }
}

/// The mean steering after some steps along the path.
fn steering(planner: &mut Searching) -> f64 {
    let o = observed(0.0, -15.0, 3.0, Gear::Forward);
    (0..20).map(|_| planner.step(&o).unwrap().steering).sum::<f64>() / 20.0
}

/// A bank across the path that is higher than the belly and narrower than the wheelbase, to 4 m beyond the path.
#[test]
fn a_bank_that_the_hull_would_sit_on_is_gone_around() {
    for side in [1.0, -1.0] {
        let bank = move |x: f64, y: f64| if (-5.6..-4.4).contains(&x) && y * side < 4.0 { 0.8 } else { 0.0 };
        let turn = |params: &[(&str, &str)]| steering(&mut Searching::new(&task(bank, params)).unwrap());
        let seen = turn(&[("learned", "0"), ("foresight", "0")]);
        let unseen = turn(&[("learned", "0"), ("foresight", "0"), ("price_hull", "0"), ("price_tilt", "0")]);
        assert!(seen * side > 0.05 && (seen - unseen) * side > 0.1, "side {side}: {seen} for {unseen}");
    }
}

#[test]
fn a_vehicle_that_does_not_get_on_backs_out_and_then_hurries_past_another_place() {
    let mut planner = Searching::new(&task(|_, _| 0.0, &[])).unwrap();
    let stuck: Vec<Gear> = (0..40)
        .map(|k| planner.step(&observed(0.1 * f64::from(k), 0.0, 0.0, Gear::Forward)).unwrap().gear)
        .collect();
    assert_eq!(stuck[0], Gear::Forward);
    assert!(stuck.contains(&Gear::Reverse), "{stuck:?}");
    assert!(planner.hurry > 1.0);
    // On a retry the vehicle steers to one side of the place, and straight on where the cost is unchanged. The learned
    // models may also steer aside.
    let again = |price: &str| {
        let params = [("learned", "0"), ("price_again", price)];
        let mut planner = Searching::new(&task(|_, _| 0.0, &params)).unwrap();
        planner.was_stuck(&observed(0.0, -8.0, 0.0, Gear::Forward)).unwrap();
        steering(&mut planner).abs()
    };
    let (aside, straight) = (again("20"), again("0"));
    assert!(aside > straight + 0.02, "{aside} for {straight}");
}

/// Without foresight, `vb_sdk::recovery` reverses.
#[test]
fn a_vehicle_without_foresight_backs_out_too() {
    let mut planner = Searching::new(&task(|_, _| 0.0, &[("foresight", "0")])).unwrap();
    let backs = (0..40).any(|k| {
        planner.step(&observed(0.1 * f64::from(k), 0.0, 0.0, Gear::Forward)).unwrap().gear == Gear::Reverse
    });
    assert!(backs && planner.hurry > 1.0);
}

/// A ridge across the path, with learned models disabled and without a cost on the map: the internal model predicts the
/// hull contact, and the planner avoids it.
#[test]
fn a_ridge_that_only_the_simulation_knows_of_is_gone_around() {
    let ridge = |x: f64, y: f64| if (-9.5..-8.5).contains(&x) && y < 2.0 { 1.6 } else { 0.0 };
    let turn = |foresight: &str| {
        let params = [("learned", "0"), ("price_hull", "0"), ("price_tilt", "0"), ("foresight", foresight)];
        steering(&mut Searching::new(&task(ridge, &params)).unwrap())
    };
    let (seen, unseen) = (turn("128"), turn("0"));
    assert!(seen > unseen + 0.1, "{seen} for {unseen}");
}

#[test]
fn without_recovery_it_only_drives_forward() {
    let mut planner = Searching::new(&task(|_, _| 0.0, &[("recover", "0")])).unwrap();
    for k in 0..40 {
        let command = planner.step(&observed(0.1 * f64::from(k), 0.0, 0.0, Gear::Forward)).unwrap();
        assert_eq!(command.gear, Gear::Forward);
    }
}

#[test]
fn a_price_below_0_is_an_error() {
    for key in ["price_hull", "price_tilt", "price_again", "clearance", "hull"] {
        let error = Searching::new(&task(|_, _| 0.0, &[(key, "-1")])).err().expect("an error").to_string();
        assert!(error.contains(key) && error.contains("below 0"), "{error}");
    }
}

#[test]
fn a_map_that_is_no_surface_is_an_error() {
    for rows in [0, 1] {
        let mut task = task(|_, _| 0.0, &[]);
        let frame = GridFrame { rows, cols: 1, resolution: 1.0, origin_x: 0.0, origin_y: 0.0 };
        task.elevation = Some(Map { frame, data: vec![0.0; rows as usize] });
        let error = Searching::new(&task).err().expect("an error").to_string();
        assert!(error.contains("fewer than 2 x 2"), "{error}");
    }
}

/// The same task without maps.
fn unknown(params: &[(&str, &str)]) -> Task {
    Task { elevation: None, semantics: None, occupancy: None, ..task(|_, _| 0.0, params) }
}

/// The local map of a vehicle 15 m before the middle with a radius of 10 m: heights and obstacles.
fn seen(height: impl Fn(f64, f64) -> f64, blocked: impl Fn(f64, f64) -> bool) -> LocalMap {
    let frame = GridFrame { rows: 81, cols: 81, resolution: 0.25, origin_x: -25.0, origin_y: -10.0 };
    let places: Vec<(f64, f64)> = (0..81 * 81).map(|k| frame.position(k / 81, k % 81)).collect();
    LocalMap {
        time: 0.0,
        elevation: Map { frame, data: places.iter().map(|(x, y)| height(*x, *y) as f32).collect() },
        semantics: Map { frame, data: vec![4; places.len()] },
        occupancy: Map { frame, data: places.iter().map(|(x, y)| u8::from(blocked(*x, *y))).collect() },
    }
}

/// The mean steering after some steps of a vehicle without maps and with this local map.
fn steering_by_sight(map: LocalMap) -> f64 {
    let mut planner = Ibex::init(&unknown(&[("foresight", "256")])).unwrap();
    let o = Observation { local_map: Some(map), ..observed(0.0, -15.0, 3.0, Gear::Forward) };
    (0..20).map(|_| planner.step(&o).unwrap().steering).sum::<f64>() / 20.0
}

#[test]
fn without_maps_a_ridge_and_an_obstacle_that_it_sees_are_gone_around() {
    let free = |_: f64, _: f64| false;
    for side in [1.0, -1.0] {
        let ridge = move |x: f64, y: f64| if (-8.0..-7.0).contains(&x) && y * side < 0.5 { 1.6 } else { 0.0 };
        let turn = steering_by_sight(seen(ridge, free));
        assert!(turn * side > 0.05, "a ridge, side {side}: {turn}");
        let rock = move |x: f64, y: f64| (-9.0..-7.0).contains(&x) && (-2.0..1.0).contains(&(y * side));
        let turn = steering_by_sight(seen(|_, _| 0.0, rock));
        assert!(turn * side > 0.05, "a rock, side {side}: {turn}");
    }
}

#[test]
fn without_maps_it_waits_for_its_first_look_and_then_goes_on_by_the_last() {
    let mut planner = Ibex::init(&unknown(&[])).unwrap();
    let blind = observed(0.0, -15.0, 0.0, Gear::Forward);
    assert_eq!(planner.step(&blind).unwrap(), Command::default());
    // Unknown terrain is not treated as a danger.
    let map = seen(|_, _| f64::NAN, |_, _| false);
    let looks = Observation { local_map: Some(map), ..blind.clone() };
    for o in [&looks, &blind] {
        let command = planner.step(o).unwrap();
        assert!(command.throttle > 0.0 && command.steering.is_finite(), "{command:?}");
    }
}

#[test]
fn without_maps_a_stuck_vehicle_backs_out() {
    let mut planner = Ibex::init(&unknown(&[])).unwrap();
    let map = seen(|_, _| 0.0, |_, _| false);
    let backs = (0..40).any(|k| {
        let o = observed(0.1 * f64::from(k), -15.0, 0.0, Gear::Forward);
        planner.step(&Observation { local_map: Some(map.clone()), ..o }).unwrap().gear == Gear::Reverse
    });
    assert!(backs);
    let error = Ibex::init(&unknown(&[("foresight", "0")])).err().expect("an error").to_string();
    assert!(error.contains("`foresight`"), "{error}");
}
