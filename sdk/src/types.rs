//! The data that pass between the harness and a planner. They mirror `wit/v0_1/planner.wit`, which is the
//! normative text; units are SI, angles radians, body axes x forward, y left, z up.

/// A vector in three dimensions.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(target_family = "wasm"), derive(abi_stable::StableAbi))]
pub struct Vec3 {
    /// First component.
    pub x: f64,
    /// Second component.
    pub y: f64,
    /// Third component.
    pub z: f64,
}

/// A point of the plane, m.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(target_family = "wasm"), derive(abi_stable::StableAbi))]
pub struct Point2 {
    /// East, m.
    pub x: f64,
    /// North, m.
    pub y: f64,
}

/// A pose in the plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(target_family = "wasm"), derive(abi_stable::StableAbi))]
pub struct Pose2 {
    /// East, m.
    pub x: f64,
    /// North, m.
    pub y: f64,
    /// Heading, rad, counter-clockwise from east.
    pub yaw: f64,
}

/// The vehicle to be driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// Name, e.g. `hmmwv`.
    pub name: String,
    /// Factor of the world's size against the full-size original: 1, 1/6 or 1/10.
    pub scale: f64,
    /// Mass, kg, all included.
    pub mass: f64,
    /// Length of what collides, hull and tyres, m.
    pub length: f64,
    /// Width of what collides, hull and tyres with the wheels straight ahead, m: without mirrors. Half of it lies to each
    /// side of the centre line.
    pub width: f64,
    /// Height of what collides above flat ground, m.
    pub height: f64,
    /// Distance between the first and the last axle, m.
    pub wheelbase: f64,
    /// Distance between the wheels of an axle, m.
    pub track: f64,
    /// Wheel radius, m.
    pub wheel_radius: f64,
    /// Number of wheels; wheel data come front to back, left before right.
    pub wheels: u32,
    /// Height of the belly above flat ground, m.
    pub ground_clearance: f64,
    /// Road-wheel angle at steering command 1, rad (mean of both sides).
    pub max_steer_angle: f64,
    /// Greatest rate of the steering command, 1/s.
    pub max_steer_rate: f64,
    /// Turning radius of the reference point at full lock on flat ground, m.
    pub min_turn_radius: f64,
    /// Top speed on flat ground, m/s.
    pub max_speed: f64,
}

/// Where the samples of a [`Map`] lie: sample (row, col) is at x = `origin_x` + col·`resolution`,
/// y = `origin_y` + row·`resolution`; row 0 is the southernmost.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(target_family = "wasm"), derive(abi_stable::StableAbi))]
pub struct GridFrame {
    /// Number of rows (south to north).
    pub rows: u32,
    /// Number of columns (west to east).
    pub cols: u32,
    /// Distance between samples, m.
    pub resolution: f64,
    /// x of column 0, m.
    pub origin_x: f64,
    /// y of row 0, m.
    pub origin_y: f64,
}

/// Samples on a square grid, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map<T> {
    /// Where the samples lie.
    pub frame: GridFrame,
    /// `rows * cols` samples, row-major, row 0 in the south.
    pub data: Vec<T>,
}

/// What a planner is told at the start of a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Task {
    /// Name within the suite, e.g. `w003/t07`.
    pub id: String,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// Ground heights, m.
    pub elevation: Map<f32>,
    /// Semantic labels: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow.
    pub semantics: Map<u8>,
    /// 1 where any part of the sample's square is covered by an obstacle, else 0.
    pub occupancy: Map<u8>,
    /// The global path, start to goal.
    pub path: Vec<Point2>,
    /// Where the vehicle starts, at rest.
    pub start: Pose2,
    /// Where it must go.
    pub goal: Point2,
    /// The task is done within this distance of the goal, m.
    pub goal_radius: f64,
    /// Time limit, s.
    pub time_limit: f64,
    /// Time between two calls of `Planner::step`, s.
    pub control_period: f64,
    /// For the planner's own randomness: the same in every run of this task with the same run seed.
    pub seed: u64,
    /// Every parameter that the planner declares, with the user's value or the default.
    pub params: Vec<Param>,
}

/// A parameter of a planner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Param {
    /// Name.
    pub key: String,
    /// Value as the user wrote it.
    pub value: String,
}

/// The state of one wheel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(target_family = "wasm"), derive(abi_stable::StableAbi))]
pub struct Wheel {
    /// Spin, rad/s, positive when rolling forward.
    pub speed: f64,
    /// Suspension travel from the design position, m, positive in compression.
    pub deflection: f64,
}

/// What a planner sees every control period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// Simulated time since the start, s.
    pub time: f64,
    /// Position of the vehicle's reference point in the world frame, m.
    pub position: Vec3,
    /// Roll, rad, positive with the right side down. The attitude is yaw first, then pitch about the turned y axis, then
    /// roll about the turned x axis (ISO 8855).
    pub roll: f64,
    /// Pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// Heading, rad, counter-clockwise from east.
    pub yaw: f64,
    /// Velocity of the reference point in body axes, m/s.
    pub linear_velocity: Vec3,
    /// Angular velocity in body axes, rad/s.
    pub angular_velocity: Vec3,
    /// The wheels, front to back, left before right.
    pub wheels: Vec<Wheel>,
    /// The steering command applied until now, after clamping; 0 at first.
    pub last_steering: f64,
    /// The throttle command applied until now, after clamping; 0 at first.
    pub last_throttle: f64,
    /// The brake command applied until now, after clamping; 0 at first.
    pub last_brake: f64,
}

/// Numbers that the harness records beside the trajectory, e.g. a sampled trajectory or a cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name of the series, constant over a task.
    pub name: String,
    /// Values.
    pub values: Vec<f32>,
}

/// What a planner wants done until the next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Command {
    /// Steering in [-1, 1], positive to the left.
    pub steering: f64,
    /// Throttle in [0, 1].
    pub throttle: f64,
    /// Brake in [0, 1].
    pub brake: f64,
    /// Recorded beside the trajectory and drawn by `vb-harness replay`; leave it empty in normal runs.
    ///
    /// ```
    /// use vb_sdk::{Command, Series};
    ///
    /// let mut command = Command { throttle: 0.5, ..Command::default() };
    /// // A curve beside the view.
    /// command.debug.push(Series { name: "speed error".into(), values: vec![0.7] });
    /// // By the ending of its name a line on the ground, through (1, 2) and (3, 4).
    /// command.debug.push(Series { name: "plan.xy".into(), values: vec![1.0, 2.0, 3.0, 4.0] });
    /// ```
    pub debug: Vec<Series>,
}
