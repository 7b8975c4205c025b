//! Compares the internal forward model with theory.

use super::*;
use vb_sdk::{GridFrame, Map, Pose, Vec3, Wheel as Told, math};

pub(super) const GRAVEL: u8 = 4;
const MUD: u8 = 7;
/// The assumed friction of gravel.
const FRICTION: f64 = 0.55;
/// Height of the reference point on flat terrain, m: tyres deflect by 8 % of the radius.
const REST: f64 = 0.428;

fn hmmwv() -> Vehicle {
    Vehicle {
        name: "hmmwv".into(),
        scale: 1.0,
        mass: 2494.0,
        wheelbase: 3.302,
        track: 1.819,
        length: 4.67,
        width: 2.2,
        wheel_radius: 0.467,
        ground_clearance: 0.41,
        max_steer_angle: 0.6,
        max_steer_rate: 1.25,
        max_speed: 31.0,
        max_reverse_speed: 5.0,
        direction_change_speed: 0.5,
        direction_change_time: 0.6,
        ..Vehicle::default()
    }
}

/// 80 x 80 m of these heights, with a node every 0.5 m.
pub(super) fn twin(kind: u8, height: impl Fn(f64, f64) -> f64) -> Twin {
    let frame = GridFrame { rows: 161, cols: 161, resolution: 0.5, origin_x: -40.0, origin_y: -40.0 };
    let heights = (0..161 * 161).map(|k| {
        let (x, y) = frame.position(k / 161, k % 161);
        height(x, y) as f32
    });
    let kinds = Map { frame, data: vec![kind; 161 * 161] };
    Twin::new(&Map { frame, data: heights.collect() }, Some(&kinds), &hmmwv(), 0.0)
}

/// At rest in the middle, at this height above the terrain and this pitch (positive nose up).
fn standing(height: f64, rise: f64, speed: f64) -> Observation {
    let pose = Pose {
        position: Vec3 { x: 0.0, y: 0.0, z: height },
        pitch: -rise,
        linear_velocity: Vec3 { x: speed, ..Vec3::default() },
        ..Pose::default()
    };
    let wheels = vec![Told { spin: speed / 0.467, travel: 0.0 }; 4];
    Observation { wheels, ..Observation::of(pose) }
}

fn drive(twin: &Twin, s: &mut State, steering: f32, speed: f32, seconds: f64) {
    for _ in 0..(seconds / 0.1).round() as usize {
        twin.step(s, &[[steering; LANES], [speed; LANES]], 0.1);
    }
}

fn height(s: &State, twin: &Twin) -> f64 {
    let reference = s.place + s.axes().out(V3::all(twin.shape.centre)) * all(-1.0);
    f64::from(reference.z.to_array()[0])
}

#[test]
fn on_flat_ground_it_stands_on_its_wheels() {
    let twin = twin(GRAVEL, |_, _| 0.0);
    // Dropped from 10 cm.
    let mut s = twin.state(&standing(REST + 0.1, 0.0, 0.0), 0.0).unwrap();
    drive(&twin, &mut s, 0.0, 0.0, 3.0);
    assert!((height(&s, &twin) - REST).abs() < 0.02, "{}", height(&s, &twin));
    assert!(s.speed[0].abs() < 0.05 && s.borne[0] == 0.0 && s.upright[0] > 0.999, "{s:?}");
    let loads: f32 = (0..WHEELS)
        .map(|i| {
            let (w, rear) = (&s.wheels[i], usize::from(i >= 2));
            let travel = w.travel.to_array()[0] - twin.shape.rest[rear];
            twin.shape.share[rear] + twin.shape.spring[rear] * travel
        })
        .sum();
    let weight = twin.shape.mass * GRAVITY;
    assert!((loads / weight - 1.0).abs() < 0.02, "{loads} for {weight}");
}

#[test]
fn it_keeps_speeds_both_ways_and_turns_as_a_bicycle_does() {
    let twin = twin(GRAVEL, |_, _| 0.0);
    for speed in [3.0, -2.0] {
        let mut s = twin.state(&standing(REST, 0.0, 0.0), 0.0).unwrap();
        drive(&twin, &mut s, 0.0, speed, 5.0);
        assert!((s.speed[0] - speed).abs() < 0.15, "{} for {speed}", s.speed[0]);
    }
    let mut s = twin.state(&standing(REST, 0.0, 2.0), 0.0).unwrap();
    drive(&twin, &mut s, 1.0, 2.0, 3.0);
    let rate = f64::from(s.rotation.z.to_array()[0]);
    // The yaw rate of a bicycle is v tan δ / L; tyres slip by a few per cent.
    let bicycle = f64::from(s.speed[0]) * math::tan(f64::from(twin.shape.steer)) / 3.302;
    assert!((rate / bicycle - 1.0).abs() < 0.15, "{rate} for {bicycle}");
}

/// No vehicle with four driven wheels climbs more than the friction angle, and brakes hold on lower slopes.
#[test]
fn it_climbs_a_slope_below_the_angle_of_friction_and_none_above() {
    for (part, climbs) in [(0.6, true), (1.25, false)] {
        let angle = part * math::atan(FRICTION);
        let (sin, cos) = math::sin_cos(angle);
        let twin = twin(GRAVEL, |x, _| x * sin / cos);
        let mut s = twin.state(&standing(REST / cos, angle, 0.0), 0.0).unwrap();
        drive(&twin, &mut s, 0.0, 3.0, 5.0);
        assert_eq!(s.x[0] > 5.0, climbs, "{part}: {}", s.x[0]);
    }
}

#[test]
fn a_ridge_below_its_belly_holds_a_slow_vehicle() {
    let ridge = |top: f64| twin(GRAVEL, move |x, _| if x.abs() < 0.6 { top } else { 0.0 });
    let over = |twin: &Twin| {
        let mut s = twin.state(&standing(0.75, 0.0, 0.0), 0.0).unwrap();
        drive(twin, &mut s, 0.0, 3.0, 4.0);
        s
    };
    let (hung, free) = (over(&ridge(0.75)), over(&ridge(0.2)));
    assert!(hung.x[0] < 1.0 && hung.borne[0] > 0.5, "{} {}", hung.x[0], hung.borne[0]);
    assert!(free.x[0] > 5.0 && free.borne[0] == 0.0, "{} {}", free.x[0], free.borne[0]);
}

/// Bekker's law: wheels observed at twice the sinkage are in softer soil, sink as deep again, and meet more resistance.
#[test]
fn what_soil_is_like_is_learned_from_how_deep_wheels_are() {
    let mut twin = twin(MUD, |_, _| 0.0);
    let known = twin.ground.kind(0.0, 0.0).sinkage;
    let deep = REST - 2.0 * f64::from(known) * 0.467;
    let coast = |twin: &Twin, height: f64| {
        let mut s = twin.state(&standing(height, 0.0, 4.0), 0.0).unwrap();
        drive(twin, &mut s, 0.0, 0.0, 0.1);
        for _ in 0..10 {
            let command = [[0.0; LANES], s.speed];
            twin.step(&mut s, &command, 0.1);
        }
        s.speed[0]
    };
    let before = coast(&twin, REST - f64::from(known) * 0.467);
    for k in 0..200 {
        let s = twin.state(&standing(deep, 0.0, 0.0), 0.0).unwrap();
        twin.learn(&s, 0.1 * f64::from(k));
    }
    let ratio = twin.ground.kind(0.0, 0.0).sinkage / known;
    assert!((ratio - 2.0).abs() < 0.2, "{ratio}");
    let after = coast(&twin, deep);
    assert!(after < before, "{after} for {before}");
}

#[test]
fn vehicles_side_by_side_know_nothing_of_each_other() {
    let bumpy = |x: f64, y: f64| 0.4 * math::sin(1.3 * x) * math::cos(0.9 * y);
    let twin = twin(MUD, bumpy);
    let start = twin.state(&standing(REST + 0.1, 0.0, 0.0), 0.0).unwrap();
    let commands: [Lanes; 2] =
        [std::array::from_fn(|l| 0.2 * l as f32 - 0.7), std::array::from_fn(|l| 1.0 + l as f32)];
    let mut together = start.clone();
    (0..30).for_each(|_| twin.step(&mut together, &commands, 0.1));
    for l in 0..LANES {
        let mut alone = start.clone();
        let own = commands.map(|c| [c[l]; LANES]);
        (0..30).for_each(|_| twin.step(&mut alone, &own, 0.1));
        let ends = |s: &State| [s.x[l], s.y[l], s.speed[l], s.upright[l]].map(f32::to_bits);
        assert_eq!(ends(&alone), ends(&together), "{l}");
    }
}

/// The state remains finite at any position and attitude, including outside the map, on the roof and inside the
/// terrain.
#[test]
fn nothing_makes_it_diverge() {
    let twin = twin(GRAVEL, |x, y| 1.5 * math::sin(0.7 * x) * math::sin(0.8 * y));
    for (x, roll, z) in
        [(0.0, 3.1, 2.0), (39.9, 0.0, 1.0), (60.0, 1.5, 0.0), (5.0, 0.0, -3.0), (-7.0, 0.5, 20.0)]
    {
        let mut o = standing(z, 0.0, 8.0);
        o.pose = o.pose.map(|p| Pose { position: Vec3 { x, ..p.position }, roll, ..p });
        let mut s = twin.state(&o, 0.0).unwrap();
        for k in 0..100 {
            let command: [Lanes; 2] = [[if k % 20 < 10 { 1.0 } else { -1.0 }; LANES], [8.0; LANES]];
            twin.step(&mut s, &command, 0.1);
            let fast = s.velocity.dot(s.velocity).to_array()[0];
            assert!(fast < 40.0 * 40.0, "{x} {roll} {z}: {fast} at {k}");
        }
    }
}

#[test]
fn small_maps_and_maps_of_other_scales_are_driven_on() {
    for (nodes, resolution, scale) in [(2, 1.0, 1.0), (3, 4.0, 1.0), (40, 0.1, 0.1), (200, 0.05, 1.0)] {
        let frame = GridFrame { rows: nodes, cols: nodes, resolution, origin_x: 0.0, origin_y: 0.0 };
        let full = hmmwv();
        let vehicle = Vehicle {
            scale,
            mass: full.mass * scale * scale * scale,
            wheelbase: full.wheelbase * scale,
            track: full.track * scale,
            length: full.length * scale,
            wheel_radius: full.wheel_radius * scale,
            ground_clearance: full.ground_clearance * scale,
            max_steer_rate: full.max_steer_rate / scale.sqrt(),
            direction_change_speed: full.direction_change_speed * scale.sqrt(),
            direction_change_time: full.direction_change_time * scale.sqrt(),
            ..full
        };
        let map = Map { frame, data: vec![0.0; (nodes * nodes) as usize] };
        let twin = Twin::new(&map, None, &vehicle, 0.05);
        let mut o = standing(REST * scale, 0.0, 0.0);
        o.wheels.iter_mut().for_each(|w| w.travel *= scale);
        let mut s = twin.state(&o, 0.0).unwrap();
        let root = scale.sqrt();
        for _ in 0..40 {
            twin.step(&mut s, &[[0.0; LANES], [(3.0 * root) as f32; LANES]], (0.1 * root) as f32);
        }
        // In accordance with Froude scaling.
        let way = f64::from(s.x[0]) / scale;
        assert!((way - 10.0).abs() < 1.5, "{nodes} {resolution} {scale}: {way}");
    }
}
