//! What a planner gets: rates, readings, streams.

use crate::common::{V3, at, flat, needs, perceive, scene, seed, standing, upright, watch};
use std::sync::Arc;
use vb_sense::rays::Scene;
use vb_sense::{Perception, Profile, Readings, Seed, Truth};
use vb_sim::{VehicleState, WheelState};

fn hilly() -> Arc<Scene> {
    scene(flat(), vec![upright(8.0, 2.0, 0.3, [2.0, 2.0, 2.0])])
}

fn moving(t: f64) -> VehicleState {
    VehicleState {
        velocity_body: V3::new(2.0, 0.1, 0.0),
        angular_velocity_body: V3::new(0.0, 0.0, 0.3),
        wheels: vec![WheelState { speed: 4.0, deflection: 0.01, ..WheelState::default() }; 4],
        ..at(V3::new(2.0 * t, 0.0, 0.7), crate::common::Quat::from_euler_angles(0.02, -0.03, 0.3 * t))
    }
}

/// All readings of a drive with a planner that looks every `every` samples.
fn readings(profile: &Profile, names: &[&str], seed: &Seed, every: u32) -> Vec<(u32, Readings)> {
    let mut p = perceive(profile, names, &hilly(), seed);
    let mut all = Vec::new();
    for k in 0..=60 {
        let now = VehicleState { time: f64::from(k) * 0.01, ..moving(f64::from(k) * 0.01) };
        p.sample(Truth { state: &now, ruts: None });
        if k % every == 0 {
            all.push((k, p.read(&now)));
        }
    }
    all
}

const ALL: [&str; 7] = ["pose", "imu", "wheel-odometry", "gnss", "lidar", "depth", "local-map"];

#[test]
fn the_oracle_tells_pose_and_wheels_to_the_last_bit_without_a_look_at_the_samples() {
    let oracle = Profile::built_in("oracle").unwrap();
    let mut p = Perception::new(&oracle, &[], &hilly(), &crate::common::hmmwv(), &seed(1, "t")).unwrap();
    assert!(p.is_idle());
    assert!(p.lidar_info().is_none() && p.depth_info().is_none());
    let state = moving(0.37);
    let r = p.read(&state);
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    let pose = r.pose.unwrap();
    assert_eq!(
        (pose.roll.to_bits(), pose.pitch.to_bits(), pose.yaw.to_bits()),
        (roll.to_bits(), pitch.to_bits(), yaw.to_bits())
    );
    assert_eq!([pose.position.x, pose.position.y, pose.position.z], *state.position.as_slice());
    assert_eq!([pose.linear_velocity.x, pose.linear_velocity.y], [2.0, 0.1]);
    assert_eq!(pose.angular_velocity.z, 0.3);
    assert_eq!((r.wheels.len(), r.wheels[3].spin, r.wheels[3].travel), (4, 4.0, 0.01));
    let nothing = Readings { pose: None, wheels: vec![], ..r.clone() };
    assert_eq!(nothing, Readings::default());
}

#[test]
fn what_is_not_asked_for_is_absent() {
    for name in ALL {
        let r = watch(
            &mut perceive(&Profile::built_in("onboard").unwrap(), &[name], &hilly(), &seed(1, "t")),
            20,
            moving,
        );
        let there = [
            r.pose.is_some(),
            !r.imu.is_empty(),
            !r.wheels.is_empty(),
            r.gnss.is_some(),
            r.lidar.is_some(),
            r.depth.is_some(),
            r.local_map.is_some(),
        ];
        assert_eq!(there, ALL.map(|n| n == name), "{name}");
    }
}

#[test]
fn each_sensor_comes_at_the_rate_that_is_asked_for() {
    let asked = ["pose 20", "imu 50", "wheel-odometry 10", "gnss 5", "lidar 5", "depth 2", "local-map 5"];
    let all = readings(&Profile::built_in("onboard").unwrap(), &asked, &seed(1, "t"), 1);
    let times = |there: &dyn Fn(&Readings) -> bool| {
        all.iter().filter(|(_, r)| there(r)).map(|(k, _)| *k).collect::<Vec<_>>()
    };
    assert_eq!(times(&|r| r.pose.is_some()), (0..=60).step_by(5).collect::<Vec<_>>());
    assert_eq!(times(&|r| !r.imu.is_empty()), (2..=60).step_by(2).collect::<Vec<_>>());
    assert_eq!(times(&|r| !r.wheels.is_empty()), (0..=60).step_by(10).collect::<Vec<_>>());
    assert_eq!(times(&|r| r.gnss.is_some()), [0, 20, 40, 60]);
    assert_eq!(times(&|r| r.lidar.is_some()), [20, 40, 60]);
    assert_eq!(times(&|r| r.depth.is_some()), [0, 50]);
    assert_eq!(times(&|r| r.local_map.is_some()), [0, 20, 40, 60]);
}

/// Text that tells apart what numbers tell apart, unknown heights included.
fn bits(r: &Readings) -> String {
    format!("{r:?}")
}

#[test]
fn the_same_seed_and_task_give_the_same_bits_and_others_give_others() {
    let degraded = Profile::built_in("degraded").unwrap();
    let all = |s: &Seed| {
        let r = readings(&degraded, &ALL, s, 60);
        bits(&r[1].1)
    };
    assert_eq!(all(&seed(1, "w001/t01")), all(&seed(1, "w001/t01")));
    let one = |s: &Seed, name: &str| bits(&readings(&degraded, &[name], s, 60)[1].1);
    for name in ["pose", "imu", "wheel-odometry", "lidar", "depth", "local-map"] {
        assert_ne!(one(&seed(1, "w001/t01"), name), one(&seed(1, "w001/t02"), name), "{name}, another task");
        assert_ne!(one(&seed(1, "w001/t01"), name), one(&seed(2, "w001/t01"), name), "{name}, another seed");
    }
}

#[test]
fn a_sensor_more_or_another_rate_changes_no_other_sensor() {
    let onboard = Profile::built_in("onboard").unwrap();
    let s = seed(1, "w001/t01");
    let together = readings(&onboard, &ALL, &s, 10);
    let slower = readings(&onboard, &["pose", "lidar 5", "depth 5", "local-map"], &s, 10);
    for name in ALL {
        for ((_, alone), (_, all)) in readings(&onboard, &[name], &s, 10).iter().zip(&together) {
            let same = match name {
                "pose" => alone.pose == all.pose,
                "imu" => alone.imu == all.imu,
                "wheel-odometry" => alone.wheels == all.wheels,
                "gnss" => alone.gnss == all.gnss,
                "lidar" => alone.lidar == all.lidar,
                "depth" => alone.depth == all.depth,
                _ => format!("{:?}", alone.local_map) == format!("{:?}", all.local_map),
            };
            assert!(same, "{name}");
        }
    }
    let maps =
        |all: &[(u32, Readings)]| all.iter().map(|(_, r)| format!("{:?}", r.local_map)).collect::<Vec<_>>();
    assert_eq!(maps(&together), maps(&slower), "a map isn't built from the planner's slower lidar");
    assert!(slower[1].1.lidar.is_none() && slower[2].1.lidar.is_some());
}

#[test]
fn numbers_do_not_depend_on_when_the_planner_looks() {
    let onboard = Profile::built_in("onboard").unwrap();
    let s = seed(1, "w001/t01");
    let (often, seldom) = (readings(&onboard, &ALL, &s, 1), readings(&onboard, &ALL, &s, 20));
    for (k, late) in seldom {
        let now = &often[k as usize].1;
        assert_eq!((late.pose, &late.wheels), (now.pose, &now.wheels));
        assert_eq!((&late.gnss, &late.lidar, &late.depth), (&now.gnss, &now.lidar, &now.depth));
        if k > 0 {
            assert_eq!((late.imu.len(), late.imu.last()), (20, now.imu.last()));
        }
    }
}

#[test]
fn a_pose_is_told_between_samples_too() {
    let onboard = Profile::built_in("onboard").unwrap();
    let mut p =
        Perception::new(&onboard, &needs(&["pose"]), &hilly(), &crate::common::hmmwv(), &seed(1, "t"))
            .unwrap();
    let state = standing(0.0, 0.0, 0.7, 0.0);
    p.sample(Truth { state: &state, ruts: None });
    let (first, again) = (p.read(&state).pose, p.read(&state).pose);
    assert!(first.is_some() && first == again, "the last estimate");
}
