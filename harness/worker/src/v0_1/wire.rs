//! Task and observation as commands that speak version 0.1 read them. What they answer is what newer ones do, with fewer
//! fields.

use serde::Serialize;
use serde_bytes::ByteBuf;
use vb_abi_v0_1::{GridFrame, Map, Observation, Task, Vec3, Vehicle};

/// The requests that differ from those of newer versions.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// Starts a planner on a task.
    Init(Box<WireTask>),
    /// Asks for a command.
    Step(WireObservation),
}

/// [`Vehicle`] as it crosses.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
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

/// `Wheel` as it crosses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the fields are those of `Wheel`")]
pub struct WireWheel {
    pub speed: f64,
    pub deflection: f64,
}

/// [`Observation`] as it crosses; vectors are arrays.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

fn map_out<T: Copy>(map: &Map<T>, bytes: impl Fn(&[T]) -> Vec<u8>) -> WireMap {
    let GridFrame { rows, cols, resolution, origin_x, origin_y } = map.frame;
    WireMap { rows, cols, resolution, origin_x, origin_y, data: ByteBuf::from(bytes(&map.data)) }
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
