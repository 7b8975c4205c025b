//! Behaviour on flat terrain.

use super::*;
use vb_sdk::{GridFrame, LocalMap, Map, Param, Point2, Pose, Vec3, Vehicle, math};

const DEFAULTS: [(&str, &str); 16] = [
    ("speed", "5"),
    ("lookahead", "10"),
    ("samples", "1000"),
    ("horizon", "20"),
    ("dt", "0.15"),
    ("spacing", "5"),
    ("steer_spread", "0.4"),
    ("speed_spread", "0.5"),
    ("effective", "0.1"),
    ("goal", "1"),
    ("obstacle", "10"),
    ("margin", "1"),
    ("pace", "3"),
    ("effort", "0.2"),
    ("speed_kp", "1"),
    ("explain", "0"),
];

/// A vehicle of 4 × 2 m on 80 × 80 m, with a global path east along the x axis, and obstacles where `blocked` is true.
fn task(blocked: impl Fn(f64, f64) -> bool, params: &[(&str, &str)]) -> Task {
    let frame = GridFrame { rows: 160, cols: 160, resolution: 0.5, origin_x: -39.75, origin_y: -39.75 };
    let at = |i: usize| -39.75 + 0.5 * i as f64;
    let data = (0..160 * 160).map(|i| u8::from(blocked(at(i % 160), at(i / 160)))).collect();
    let ground = GridFrame { rows: 81, cols: 81, resolution: 1.0, origin_x: -40.0, origin_y: -40.0 };
    let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
    Task {
        occupancy: Some(Map { frame, data }),
        elevation: Some(Map { frame: ground, data: vec![0.0; 81 * 81] }),
        path: (0..=60).map(|i| Point2 { x: f64::from(i) - 25.0, y: 0.0 }).collect(),
        vehicle: Vehicle {
            scale: 1.0,
            wheelbase: 3.0,
            width: 2.0,
            min_turn_radius: 8.0,
            max_steer_rate: 2.0,
            max_speed: 30.0,
            ..Vehicle::default()
        },
        control_period: 0.1,
        seed: 11,
        params: DEFAULTS.iter().map(|(k, d)| Param { key: (*k).into(), value: value(k, d) }).collect(),
        ..Task::default()
    }
}

/// Moves the planner's bicycle model for some steps, and returns its states.
fn drive(task: &Task, steps: usize) -> Vec<Pose> {
    let mut planner = MppiPlanner::init(task).unwrap();
    let start = task.path[0];
    let mut last_steering = 0.0;
    let mut o = Pose { position: Vec3 { x: start.x, y: start.y, z: 0.0 }, ..Pose::default() };
    let mut seen = Vec::new();
    for _ in 0..steps {
        let c = planner.step(&Observation { last_steering, ..Observation::of(o) }).unwrap();
        seen.push(o);
        let speed = (o.linear_velocity.x + 0.3 * (c.throttle - c.brake)).max(0.0);
        let rate = speed / task.vehicle.min_turn_radius * c.steering;
        o.yaw += 0.1 * rate;
        o.position.x += 0.1 * speed * math::cos(o.yaw);
        o.position.y += 0.1 * speed * math::sin(o.yaw);
        o.linear_velocity.x = speed;
        last_steering = c.steering;
    }
    seen
}

#[test]
fn on_free_ground_it_drives_straight_along_the_path_at_its_pace() {
    // 9 s, before the end of the path.
    let seen = drive(&task(|_, _| false, &[]), 90);
    assert!(seen.iter().all(|o| o.position.y.abs() < 0.3 && o.yaw.abs() < 0.1));
    let speed = seen.iter().skip(50).map(|o| o.linear_velocity.x).sum::<f64>() / 40.0;
    // The local goal also attracts it.
    assert!((4.5..5.8).contains(&speed), "{speed}");
}

#[test]
fn an_obstacle_on_the_path_is_passed_on_its_nearer_side_without_a_touch() {
    // A block 3 m wide across the path, with its centre 1 m to one side: the other side is nearer.
    for side in [1.0, -1.0] {
        let block = move |x: f64, y: f64| x.abs() < 1.5 && (y - side).abs() < 1.5;
        let seen = drive(&task(block, &[]), 190);
        let past = seen.iter().min_by(|a, b| a.position.x.abs().total_cmp(&b.position.x.abs())).unwrap();
        assert!(seen.last().unwrap().position.x > 6.0, "it makes progress");
        assert!(past.position.y * side < 0.0, "side {side}: passes at {}", past.position.y);
        for o in &seen {
            for axle in [-1.5, 1.5] {
                let (x, y) = (o.position.x + axle * math::cos(o.yaw), o.position.y + axle * math::sin(o.yaw));
                let gap = math::hypot((x.abs() - 1.5).max(0.0), ((y - side).abs() - 1.5).max(0.0));
                assert!(gap > 0.9, "a wheel's circle of 1 m is {gap} m from the block at ({x}, {y})");
            }
        }
    }
}

#[test]
fn off_the_path_it_turns_towards_the_local_goal() {
    for y in [-4.0, 4.0] {
        let mut planner = MppiPlanner::init(&task(|_, _| false, &[])).unwrap();
        let position = Vec3 { x: -25.0, y, z: 0.0 };
        let linear_velocity = Vec3 { x: 3.0, ..Vec3::default() };
        let o = Observation::of(Pose { position, linear_velocity, ..Pose::default() });
        let mut steering = 0.0;
        for _ in 0..5 {
            steering = planner.step(&o).unwrap().steering;
        }
        assert!(steering * y < -0.4, "{y}: {steering}");
    }
}

#[test]
fn without_a_map_of_obstacles_it_goes_around_those_that_it_sees() {
    for side in [-1.0, 1.0] {
        let mut unknown = task(|_, _| false, &[]);
        (unknown.occupancy, unknown.elevation) = (None, None);
        unknown.half_extent = Point2 { x: 40.0, y: 40.0 };
        // A block 6 m ahead, slightly to one side of the path; unknown cells behind it.
        let frame = GridFrame { rows: 81, cols: 81, resolution: 0.25, origin_x: -35.0, origin_y: -10.0 };
        let label = |x: f64, y: f64| match x + 25.0 {
            ahead if (6.0..8.0).contains(&ahead) && (y - side).abs() < 1.5 => 1,
            ahead if ahead > 8.0 => 255,
            _ => 0,
        };
        let at = |i: i32, origin: f64| origin + 0.25 * f64::from(i);
        let data = (0..81 * 81).map(|i| label(at(i % 81, -35.0), at(i / 81, -10.0))).collect();
        let local_map = LocalMap { occupancy: Map { frame, data }, ..LocalMap::default() };
        let position = Vec3 { x: -25.0, y: 0.0, z: 0.0 };
        let linear_velocity = Vec3 { x: 3.0, ..Vec3::default() };
        let o = Observation::of(Pose { position, linear_velocity, ..Pose::default() });
        let steering = |o: &Observation| {
            let mut planner = MppiPlanner::init(&unknown).unwrap();
            (0..5).map(|_| planner.step(o).unwrap().steering).last().unwrap()
        };
        assert!(steering(&o).abs() < 0.1, "nothing is known: straight on");
        let seen = steering(&Observation { local_map: Some(local_map), ..o.clone() });
        assert!(seen * side < -0.3, "side {side}: {seen}");
    }
}

#[test]
fn a_tenth_of_the_scale_is_driven_alike() {
    let full = task(|x, y| x.abs() < 1.5 && (y - 1.0).abs() < 1.5, &[]);
    let mut small = full.clone();
    let v = &mut small.vehicle;
    (v.scale, v.wheelbase, v.width, v.min_turn_radius) = (0.1, 0.3, 0.2, 0.8);
    v.max_steer_rate *= 10.0_f64.sqrt();
    let (occupancy, elevation) = (small.occupancy.as_mut().unwrap(), small.elevation.as_mut().unwrap());
    for map in [&mut occupancy.frame, &mut elevation.frame] {
        (map.resolution, map.origin_x, map.origin_y) =
            (0.1 * map.resolution, 0.1 * map.origin_x, 0.1 * map.origin_y);
    }
    small.path.iter_mut().for_each(|p| *p = Point2 { x: 0.1 * p.x, y: 0.1 * p.y });
    // Speeds scale with the root of the lengths.
    let at = |task: &Task, s: f64| {
        let mut planner = MppiPlanner::init(task).unwrap();
        let position = Vec3 { x: -8.0 * s, y: 0.0, z: 0.0 };
        let linear_velocity = Vec3 { x: 3.0 * s.sqrt(), ..Vec3::default() };
        let pose = Pose { position, linear_velocity, ..Pose::default() };
        planner.step(&Observation::of(pose)).unwrap().steering
    };
    let (a, b) = (at(&full, 1.0), at(&small, 0.1));
    assert!((a - b).abs() < 0.02, "{a} {b}");
}

#[test]
fn what_it_considers_is_told_on_request() {
    let mut planner = MppiPlanner::init(&task(|_, _| false, &[("explain", "12")])).unwrap();
    let c = planner.step(&Observation::of(Pose::default())).unwrap();
    let series = |name: &str| c.debug.iter().find(|s| s.name == name).unwrap().values.len();
    // 16 courses of 21 points.
    assert_eq!(
        (series("trajectories"), series("trajectory_costs"), series("local_goal")),
        (16 * 21 * 2, 16, 2)
    );
}

#[test]
fn a_bad_parameter_is_refused_by_name() {
    for (key, value) in [("speed", "0"), ("samples", "0"), ("effective", "1"), ("goal", "-1"), ("dt", "NaN")]
    {
        let Err(error) = MppiPlanner::init(&task(|_, _| false, &[(key, value)])) else { panic!("{key}") };
        assert!(error.to_string().contains(key), "{error}");
    }
}
