//! Between the data of version 0.1 and those of its bindings.

use super::bindings::vertibench::planner::types;
use vb_abi_v0_1::{Command, GridFrame, Observation, Point2, Series, Task, Vec3, Vehicle};

pub(in crate::wasm) fn task(t: &Task) -> types::Task {
    types::Task {
        id: t.id.clone(),
        vehicle: vehicle(&t.vehicle),
        elevation: types::ElevationMap { frame: frame(t.elevation.frame), heights: t.elevation.data.clone() },
        semantics: types::SemanticMap { frame: frame(t.semantics.frame), labels: t.semantics.data.clone() },
        occupancy: types::OccupancyMap {
            frame: frame(t.occupancy.frame),
            occupied: t.occupancy.data.clone(),
        },
        path: t.path.iter().copied().map(point).collect(),
        start: types::Pose2 { x: t.start.x, y: t.start.y, yaw: t.start.yaw },
        goal: point(t.goal),
        goal_radius: t.goal_radius,
        time_limit: t.time_limit,
        control_period: t.control_period,
        seed: t.seed,
        params: t
            .params
            .iter()
            .map(|p| types::Param { key: p.key.clone(), value: p.value.clone() })
            .collect(),
    }
}

fn vehicle(v: &Vehicle) -> types::Vehicle {
    types::Vehicle {
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
    }
}

fn frame(f: GridFrame) -> types::GridFrame {
    types::GridFrame {
        rows: f.rows,
        cols: f.cols,
        resolution: f.resolution,
        origin_x: f.origin_x,
        origin_y: f.origin_y,
    }
}

fn point(p: Point2) -> types::Point2 {
    types::Point2 { x: p.x, y: p.y }
}

fn vec3(v: Vec3) -> types::Vec3 {
    types::Vec3 { x: v.x, y: v.y, z: v.z }
}

pub(in crate::wasm) fn observation(o: &Observation) -> types::Observation {
    types::Observation {
        time: o.time,
        position: vec3(o.position),
        roll: o.roll,
        pitch: o.pitch,
        yaw: o.yaw,
        linear_velocity: vec3(o.linear_velocity),
        angular_velocity: vec3(o.angular_velocity),
        wheels: o.wheels.iter().map(|w| types::Wheel { speed: w.speed, deflection: w.deflection }).collect(),
        last_steering: o.last_steering,
        last_throttle: o.last_throttle,
        last_brake: o.last_brake,
    }
}

pub(in crate::wasm) fn command(c: types::Command) -> Command {
    Command {
        steering: c.steering,
        throttle: c.throttle,
        brake: c.brake,
        debug: c.debug.into_iter().map(|s| Series { name: s.name, values: s.values }).collect(),
    }
}
