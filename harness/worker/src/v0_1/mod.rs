//! Version 0.1 of the interface: what the harness knows is told to its planners in that version's terms.
//!
//! What is new is left out. A planner of 0.1 gets the default: maps, pose and wheels; it drives forward.

#[cfg(unix)]
pub(crate) mod c_abi;
pub mod wire;

use vb_abi_v0_1 as old;

fn vec3(v: vb_sdk::Vec3) -> old::Vec3 {
    old::Vec3 { x: v.x, y: v.y, z: v.z }
}

fn map<T: Clone>(map: Option<&vb_sdk::Map<T>>) -> old::Map<T> {
    let empty = || old::Map { frame: old::GridFrame::default(), data: Vec::new() };
    map.map_or_else(empty, |m| {
        let vb_sdk::GridFrame { rows, cols, resolution, origin_x, origin_y } = m.frame;
        let frame = old::GridFrame { rows, cols, resolution, origin_x, origin_y };
        old::Map { frame, data: m.data.clone() }
    })
}

/// A task. Maps that the perception profile doesn't give are empty; a run with such a profile and a planner of this version
/// is refused.
#[must_use]
pub fn task(t: &vb_sdk::Task) -> old::Task {
    let v = &t.vehicle;
    old::Task {
        id: t.id.clone(),
        vehicle: old::Vehicle {
            name: v.name.clone(),
            scale: v.scale,
            mass: v.mass,
            length: v.length,
            width: v.width,
            height: v.height,
            wheelbase: v.wheelbase,
            track: v.track,
            wheel_radius: v.wheel_radius,
            wheels: v.wheels,
            ground_clearance: v.ground_clearance,
            max_steer_angle: v.max_steer_angle,
            max_steer_rate: v.max_steer_rate,
            min_turn_radius: v.min_turn_radius,
            max_speed: v.max_speed,
        },
        elevation: map(t.elevation.as_ref()),
        semantics: map(t.semantics.as_ref()),
        occupancy: map(t.occupancy.as_ref()),
        path: t.path.iter().map(|p| old::Point2 { x: p.x, y: p.y }).collect(),
        start: old::Pose2 { x: t.start.x, y: t.start.y, yaw: t.start.yaw },
        goal: old::Point2 { x: t.goal.x, y: t.goal.y },
        goal_radius: t.goal_radius,
        time_limit: t.time_limit,
        control_period: t.control_period,
        seed: t.seed,
        params: t.params.iter().map(|p| old::Param { key: p.key.clone(), value: p.value.clone() }).collect(),
    }
}

/// An observation. Its pose is there in every step, since that is the default.
#[must_use]
pub fn observation(o: &vb_sdk::Observation) -> old::Observation {
    let pose = o.pose.unwrap_or_default();
    old::Observation {
        time: o.time,
        position: vec3(pose.position),
        roll: pose.roll,
        pitch: pose.pitch,
        yaw: pose.yaw,
        linear_velocity: vec3(pose.linear_velocity),
        angular_velocity: vec3(pose.angular_velocity),
        wheels: o.wheels.iter().map(|w| old::Wheel { speed: w.spin, deflection: w.travel }).collect(),
        last_steering: o.last_steering,
        last_throttle: o.last_throttle,
        last_brake: o.last_brake,
    }
}

/// A command, which drives forward.
#[must_use]
pub fn command(c: old::Command) -> vb_sdk::Command {
    let series = |s: old::Series| vb_sdk::Series { name: s.name, values: s.values };
    vb_sdk::Command {
        steering: c.steering,
        throttle: c.throttle,
        brake: c.brake,
        gear: vb_sdk::Gear::Forward,
        debug: c.debug.into_iter().map(series).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of version 0.1's protocol, as the harness sent it when that version was the newest: all fields, their
    /// names, and the bytes of a map.
    #[test]
    fn a_command_of_version_0_1_reads_what_it_always_read() {
        let frame = vb_sdk::GridFrame { rows: 1, cols: 2, resolution: 0.5, origin_x: -1.0, origin_y: 2.0 };
        let o = vb_sdk::Observation {
            time: 0.25,
            pose: Some(vb_sdk::Pose { yaw: 1.5, ..vb_sdk::Pose::default() }),
            wheels: vec![vb_sdk::Wheel { spin: 2.0, travel: -0.5 }],
            ..vb_sdk::Observation::default()
        };
        let found = serde_json::to_string(&wire::Request::Step((&observation(&o)).into())).unwrap();
        let expected = "{\"step\":{\"time\":0.25,\"position\":[0.0,0.0,0.0],\"roll\":0.0,\"pitch\":0.0,\"yaw\":1.5,\
            \"linear_velocity\":[0.0,0.0,0.0],\"angular_velocity\":[0.0,0.0,0.0],\"wheels\":[{\"speed\":2.0,\
            \"deflection\":-0.5}],\"last_steering\":0.0,\"last_throttle\":0.0,\"last_brake\":0.0}}";
        assert_eq!(found, expected);
        let t = vb_sdk::Task {
            elevation: Some(vb_sdk::Map { frame, data: vec![1.0, 2.0] }),
            params: vec![vb_sdk::Param { key: "a".into(), value: "1".into() }],
            ..vb_sdk::Task::default()
        };
        let found = serde_json::to_string(&wire::Request::Init(Box::new((&task(&t)).into()))).unwrap();
        assert!(
            found.contains(
                "\"elevation\":{\"rows\":1,\"cols\":2,\"resolution\":0.5,\"origin_x\":-1.0,\"origin_y\":2.0,\
                 \"data\":[0,0,128,63,0,0,0,64]}"
            ),
            "{found}"
        );
        assert!(found.contains("\"params\":[[\"a\",\"1\"]]"), "{found}");
    }
}
