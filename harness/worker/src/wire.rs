//! Task, observation and command as they cross between processes. Maps cross as the bytes of their samples, least
//! significant first, so that any language reads them at once; all else as named fields.

use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use vb_sdk::{
    Command, GridFrame, Map, Observation, Param, Point2, Pose2, Series, Task, Vec3, Vehicle, Wheel,
};

/// [`Vehicle`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of `Vehicle`")]
pub struct WireVehicle {
    pub name: String,
    pub scale: f64,
    pub mass: f64,
    pub length: f64,
    pub width: f64,
    pub height: f64,
    pub wheelbase: f64,
    pub track: f64,
    pub wheel_radius: f64,
    pub wheels: u32,
    pub ground_clearance: f64,
    pub max_steer_angle: f64,
    pub max_steer_rate: f64,
    pub min_turn_radius: f64,
    pub max_speed: f64,
}

/// [`Map`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireMap {
    /// Number of rows, south to north.
    pub rows: u32,
    /// Number of columns, west to east.
    pub cols: u32,
    /// Distance between samples, m.
    pub resolution: f64,
    /// x of column 0, m.
    pub origin_x: f64,
    /// y of row 0, m.
    pub origin_y: f64,
    /// The samples, row-major: `f32` for heights, bytes for labels.
    pub data: ByteBuf,
}

/// [`Task`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireTask {
    /// Name within the suite.
    pub id: String,
    /// The vehicle.
    pub vehicle: WireVehicle,
    /// Ground heights, m, as `f32`.
    pub elevation: WireMap,
    /// Semantic labels, one byte each.
    pub semantics: WireMap,
    /// Occupancy, one byte each.
    pub occupancy: WireMap,
    /// The global path: [x, y], m.
    pub path: Vec<[f64; 2]>,
    /// [x, y, yaw], m and rad.
    pub start: [f64; 3],
    /// [x, y], m.
    pub goal: [f64; 2],
    /// m.
    pub goal_radius: f64,
    /// s.
    pub time_limit: f64,
    /// s.
    pub control_period: f64,
    /// For the planner's own randomness.
    pub seed: u64,
    /// Key and value of every parameter, in the order of their declaration.
    pub params: Vec<[String; 2]>,
}

/// [`Wheel`] as it crosses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of `Wheel`")]
pub struct WireWheel {
    pub speed: f64,
    pub deflection: f64,
}

/// [`Observation`] as it crosses; vectors are arrays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of `Observation`")]
pub struct WireObservation {
    pub time: f64,
    pub position: [f64; 3],
    pub roll: f64,
    pub pitch: f64,
    pub yaw: f64,
    pub linear_velocity: [f64; 3],
    pub angular_velocity: [f64; 3],
    pub wheels: Vec<WireWheel>,
    pub last_steering: f64,
    pub last_throttle: f64,
    pub last_brake: f64,
}

/// [`Series`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of `Series`")]
pub struct WireSeries {
    pub name: String,
    pub values: Vec<f32>,
}

/// [`Command`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are those of `Command`")]
pub struct WireCommand {
    pub steering: f64,
    pub throttle: f64,
    pub brake: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub debug: Vec<WireSeries>,
}

fn map_out<T: Copy>(map: &Map<T>, bytes: impl Fn(&[T]) -> Vec<u8>) -> WireMap {
    let GridFrame { rows, cols, resolution, origin_x, origin_y } = map.frame;
    WireMap { rows, cols, resolution, origin_x, origin_y, data: ByteBuf::from(bytes(&map.data)) }
}

fn frame(m: &WireMap) -> GridFrame {
    GridFrame {
        rows: m.rows,
        cols: m.cols,
        resolution: m.resolution,
        origin_x: m.origin_x,
        origin_y: m.origin_y,
    }
}

fn vec3([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3 { x, y, z }
}

impl From<&Vehicle> for WireVehicle {
    fn from(v: &Vehicle) -> Self {
        Self {
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
}

impl From<WireVehicle> for Vehicle {
    fn from(v: WireVehicle) -> Self {
        Self {
            name: v.name,
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
}

impl From<&Task> for WireTask {
    fn from(t: &Task) -> Self {
        let heights = |data: &[f32]| data.iter().flat_map(|h| h.to_le_bytes()).collect();
        Self {
            id: t.id.clone(),
            vehicle: (&t.vehicle).into(),
            elevation: map_out(&t.elevation, heights),
            semantics: map_out(&t.semantics, <[u8]>::to_vec),
            occupancy: map_out(&t.occupancy, <[u8]>::to_vec),
            path: t.path.iter().map(|p| [p.x, p.y]).collect(),
            start: [t.start.x, t.start.y, t.start.yaw],
            goal: [t.goal.x, t.goal.y],
            goal_radius: t.goal_radius,
            time_limit: t.time_limit,
            control_period: t.control_period,
            seed: t.seed,
            params: t.params.iter().map(|p| [p.key.clone(), p.value.clone()]).collect(),
        }
    }
}

impl From<WireTask> for Task {
    fn from(t: WireTask) -> Self {
        let labels = |m: WireMap| Map { frame: frame(&m), data: m.data.into_vec() };
        let (heights, _) = t.elevation.data.as_chunks::<4>();
        let [key, value] = [0, 1];
        let param = |mut p: [String; 2]| Param {
            key: std::mem::take(&mut p[key]),
            value: std::mem::take(&mut p[value]),
        };
        let ([x, y, yaw], [goal_x, goal_y]) = (t.start, t.goal);
        Self {
            id: t.id,
            vehicle: t.vehicle.into(),
            elevation: Map {
                frame: frame(&t.elevation),
                data: heights.iter().map(|h| f32::from_le_bytes(*h)).collect(),
            },
            semantics: labels(t.semantics),
            occupancy: labels(t.occupancy),
            path: t.path.into_iter().map(|[x, y]| Point2 { x, y }).collect(),
            start: Pose2 { x, y, yaw },
            goal: Point2 { x: goal_x, y: goal_y },
            goal_radius: t.goal_radius,
            time_limit: t.time_limit,
            control_period: t.control_period,
            seed: t.seed,
            params: t.params.into_iter().map(param).collect(),
        }
    }
}

impl From<&Observation> for WireObservation {
    fn from(o: &Observation) -> Self {
        let array = |v: &Vec3| [v.x, v.y, v.z];
        Self {
            time: o.time,
            position: array(&o.position),
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: array(&o.linear_velocity),
            angular_velocity: array(&o.angular_velocity),
            wheels: o.wheels.iter().map(|w| WireWheel { speed: w.speed, deflection: w.deflection }).collect(),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        }
    }
}

impl From<WireObservation> for Observation {
    fn from(o: WireObservation) -> Self {
        Self {
            time: o.time,
            position: vec3(o.position),
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: vec3(o.linear_velocity),
            angular_velocity: vec3(o.angular_velocity),
            wheels: o
                .wheels
                .into_iter()
                .map(|w| Wheel { speed: w.speed, deflection: w.deflection })
                .collect(),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        }
    }
}

impl From<Command> for WireCommand {
    fn from(c: Command) -> Self {
        let series = |s: Series| WireSeries { name: s.name, values: s.values };
        Self {
            steering: c.steering,
            throttle: c.throttle,
            brake: c.brake,
            debug: c.debug.into_iter().map(series).collect(),
        }
    }
}

impl From<WireCommand> for Command {
    fn from(c: WireCommand) -> Self {
        let series = |s: WireSeries| Series { name: s.name, values: s.values };
        Self {
            steering: c.steering,
            throttle: c.throttle,
            brake: c.brake,
            debug: c.debug.into_iter().map(series).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_crosses_whole() {
        let frame = GridFrame { rows: 2, cols: 3, resolution: 0.5, origin_x: -1.0, origin_y: 2.0 };
        let task = Task {
            id: "w001/t02".into(),
            vehicle: Vehicle {
                name: "v".into(),
                scale: 0.1,
                wheels: 6,
                max_speed: 30.0,
                ..Vehicle::default()
            },
            elevation: Map { frame, data: vec![0.1, -0.0, 1e-40, f32::MAX, 2.5, 3.0] },
            semantics: Map { frame, data: vec![0, 1, 2, 3, 4, 255] },
            occupancy: Map { frame, data: vec![0, 1, 0, 1, 0, 1] },
            path: vec![Point2 { x: 0.1, y: -0.2 }, Point2 { x: 3.0, y: 4.0 }],
            start: Pose2 { x: 1.0, y: 2.0, yaw: 0.3 },
            goal: Point2 { x: 5.0, y: 6.0 },
            goal_radius: 8.0,
            time_limit: 60.0,
            control_period: 0.1,
            seed: u64::MAX,
            params: vec![Param { key: "a".into(), value: "1".into() }],
        };
        let mut frame = Vec::new();
        crate::protocol::encode(&WireTask::from(&task), &mut frame).unwrap();
        let back: WireTask = crate::protocol::decode(&frame[crate::protocol::HEADER..]).unwrap();
        assert_eq!(Task::from(back), task);
    }
}
