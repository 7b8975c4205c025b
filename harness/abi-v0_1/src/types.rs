//! The data that pass between the harness and a planner, as `sdk/wit/v0_1/planner.wit` has them.

/// A vector in three dimensions.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, abi_stable::StableAbi)]
pub struct Vec3 {
    /// The component along x.
    pub x: f64,
    /// The component along y.
    pub y: f64,
    /// The component along z.
    pub z: f64,
}

/// A point of the horizontal plane of the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, abi_stable::StableAbi)]
pub struct Point2 {
    /// The coordinate towards the east, m.
    pub x: f64,
    /// The coordinate towards the north, m.
    pub y: f64,
}

/// A pose in the horizontal plane of the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, abi_stable::StableAbi)]
pub struct Pose2 {
    /// The coordinate towards the east, m.
    pub x: f64,
    /// The coordinate towards the north, m.
    pub y: f64,
    /// The heading, rad, counter-clockwise from east.
    pub yaw: f64,
}

/// The vehicle to be driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// The name of the vehicle, e.g. `hmmwv`.
    pub name: String,
    /// The size of the world over that of the full-size original: 1, 1/6 or 1/10.
    pub scale: f64,
    /// The mass of the whole vehicle, kg.
    pub mass: f64,
    /// The length of what collides, hull and tyres, m.
    pub length: f64,
    /// The width of what collides, hull and tyres with the wheels straight ahead but without mirrors, m. Half of it
    /// lies to each side of the centre line.
    pub width: f64,
    /// The height of what collides above flat ground, m.
    pub height: f64,
    /// The distance between the first and the last axle, m.
    pub wheelbase: f64,
    /// The distance between the two wheels of an axle, m.
    pub track: f64,
    /// The radius of the wheels, m.
    pub wheel_radius: f64,
    /// The number of wheels. Wheel data come from front to back, left before right.
    pub wheels: u32,
    /// The height of the belly above flat ground, m.
    pub ground_clearance: f64,
    /// The road-wheel angle at steering command 1, rad: the mean of both sides.
    pub max_steer_angle: f64,
    /// The greatest rate of the steering command, 1/s.
    pub max_steer_rate: f64,
    /// The turning radius of the reference point at full lock on flat ground, m.
    pub min_turn_radius: f64,
    /// The top speed on flat ground, m/s.
    pub max_speed: f64,
}

/// The places at which the samples of a [`Map`] lie: sample (row, col) is at x = `origin_x` + col·`resolution`, y =
/// `origin_y` + row·`resolution`; row 0 is the southernmost.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, abi_stable::StableAbi)]
pub struct GridFrame {
    /// The number of rows, which go from south to north.
    pub rows: u32,
    /// The number of columns, which go from west to east.
    pub cols: u32,
    /// The distance between neighbouring samples, m.
    pub resolution: f64,
    /// The x coordinate of column 0, m.
    pub origin_x: f64,
    /// The y coordinate of row 0, m.
    pub origin_y: f64,
}

/// Samples on a square grid, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map<T> {
    /// The places at which the samples lie.
    pub frame: GridFrame,
    /// The `rows * cols` samples, row-major, with row 0 in the south.
    pub data: Vec<T>,
}

/// What a planner is told at the start of a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Task {
    /// The name of the task within the suite, e.g. `w003/t07`.
    pub id: String,
    /// The vehicle to be driven.
    pub vehicle: Vehicle,
    /// The heights of the ground in the world frame, m.
    pub elevation: Map<f32>,
    /// The semantic labels: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow.
    pub semantics: Map<u8>,
    /// The occupancy: 1 where any part of the sample's square is covered by an obstacle, else 0.
    pub occupancy: Map<u8>,
    /// The global path, from the start to the goal.
    pub path: Vec<Point2>,
    /// The pose from which the vehicle starts, at rest.
    pub start: Pose2,
    /// The point to which the vehicle must go.
    pub goal: Point2,
    /// The distance from the goal within which the task is done, m.
    pub goal_radius: f64,
    /// The time limit, s.
    pub time_limit: f64,
    /// The time between two calls of `Planner::step`, s.
    pub control_period: f64,
    /// The seed for the planner's own randomness: the same in every run of this task with the same run seed.
    pub seed: u64,
    /// All parameters that the planner declares, with the user's values or the defaults.
    pub params: Vec<Param>,
}

/// A parameter of a planner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Param {
    /// The name of the parameter.
    pub key: String,
    /// The value of the parameter, as the user wrote it.
    pub value: String,
}

/// The state of one wheel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, abi_stable::StableAbi)]
pub struct Wheel {
    /// The spin, rad/s, positive when rolling forward.
    pub speed: f64,
    /// The suspension travel from the design position, m, positive in compression.
    pub deflection: f64,
}

/// The state that a planner sees every control period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// The simulated time since the start, s.
    pub time: f64,
    /// The position of the vehicle's reference point in the world frame, m.
    pub position: Vec3,
    /// The roll, rad, positive with the right side down. The attitude is the yaw first, then the pitch about the turned
    /// y axis, then the roll about the turned x axis (ISO 8855).
    pub roll: f64,
    /// The pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// The heading, rad, counter-clockwise from east.
    pub yaw: f64,
    /// The velocity of the reference point in body axes, m/s.
    pub linear_velocity: Vec3,
    /// The angular velocity in body axes, rad/s.
    pub angular_velocity: Vec3,
    /// The wheels, from front to back, left before right.
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
    /// The name of the series, which stays the same over a task.
    pub name: String,
    /// The values of the series.
    pub values: Vec<f32>,
}

/// The command that holds until the next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Command {
    /// The steering, in [-1, 1], positive to the left.
    pub steering: f64,
    /// The throttle, in [0, 1].
    pub throttle: f64,
    /// The brake, in [0, 1].
    pub brake: f64,
    /// Series that are recorded beside the trajectory.
    pub debug: Vec<Series>,
}
