//! The data that pass between the harness and a planner, as `wit/v0_2/planner.wit` declares them. Units are SI, angles
//! radians, body axes x forward, y left, z up.
//!
//! Made by `cargo xtask abi`; edit the WIT instead.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub use crate::map::Map;

/// A vector in three dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[f64; 3]", into = "[f64; 3]"))]
pub struct Vec3 {
    /// The component along x.
    pub x: f64,
    /// The component along y.
    pub y: f64,
    /// The component along z.
    pub z: f64,
}

impl From<[f64; 3]> for Vec3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<Vec3> for [f64; 3] {
    fn from(v: Vec3) -> Self {
        [v.x, v.y, v.z]
    }
}

/// A point of the horizontal plane of the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[f64; 2]", into = "[f64; 2]"))]
pub struct Point2 {
    /// The coordinate towards the east, m.
    pub x: f64,
    /// The coordinate towards the north, m.
    pub y: f64,
}

impl From<[f64; 2]> for Point2 {
    fn from([x, y]: [f64; 2]) -> Self {
        Self { x, y }
    }
}

impl From<Point2> for [f64; 2] {
    fn from(v: Point2) -> Self {
        [v.x, v.y]
    }
}

/// A pose in the horizontal plane of the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[f64; 3]", into = "[f64; 3]"))]
pub struct Pose2 {
    /// The coordinate towards the east, m.
    pub x: f64,
    /// The coordinate towards the north, m.
    pub y: f64,
    /// The heading, rad, counter-clockwise from east.
    pub yaw: f64,
}

impl From<[f64; 3]> for Pose2 {
    fn from([x, y, yaw]: [f64; 3]) -> Self {
        Self { x, y, yaw }
    }
}

impl From<Pose2> for [f64; 3] {
    fn from(v: Pose2) -> Self {
        [v.x, v.y, v.yaw]
    }
}

/// The vehicle to be driven.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Vehicle {
    /// The name of the vehicle, e.g. `hmmwv`.
    pub name: String,
    /// The size of the world over that of the full-size original: 1, 1/6 or 1/10.
    pub scale: f64,
    /// The mass of the whole vehicle, kg.
    pub mass: f64,
    /// The length of what collides, hull and tyres, m.
    pub length: f64,
    /// The width of what collides, hull and tyres with the wheels straight ahead but without mirrors, m. Half of it lies
    /// to each side of the centre line.
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
    /// The top speed in reverse on flat ground, m/s; 0 for a vehicle without a reverse gear.
    pub max_reverse_speed: f64,
    /// The speed below which the gearbox changes between forward and reverse, m/s.
    pub direction_change_speed: f64,
    /// The time that such a change takes, during which no torque reaches the wheels, s.
    pub direction_change_time: f64,
}

/// The places at which the samples of a map lie: sample (row, col) is at x = `origin_x` + col·`resolution`, y =
/// `origin_y` + row·`resolution`; row 0 is the southernmost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
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

/// Heights on a square grid.
pub type HeightMap = Map<f32>;

/// Labels on a square grid.
pub type LabelMap = Map<u8>;

/// A parameter of a planner.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Param {
    /// The name of the parameter.
    pub key: String,
    /// The value of the parameter, as the user wrote it.
    pub value: String,
}

/// The place and the attitude of a sensor on the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Mount {
    /// The position of the sensor in the body frame, m.
    pub position: Vec3,
    /// The roll of the sensor against the body, rad.
    pub roll: f64,
    /// The pitch of the sensor against the body, rad, positive when it looks down.
    pub pitch: f64,
    /// The yaw of the sensor against the body, rad, positive when it looks to the left.
    pub yaw: f64,
}

/// The spinning lidar of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LidarInfo {
    /// The time of one turn, which is that between two scans, s.
    pub period: f64,
    /// The number of beams, which are the rows of a scan, lowest first.
    pub rows: u32,
    /// The number of directions of a turn, which are the columns of a scan: column c looks at the azimuth
    /// −π + (c + 1/2) · 2π / `cols` in the sensor's frame, counter-clockwise from straight ahead.
    pub cols: u32,
    /// The elevation angle of the lowest beam over the sensor's horizon, rad.
    pub lowest: f64,
    /// The elevation angle of the highest beam, rad. The others lie at equal angles between the two.
    pub highest: f64,
    /// The least distance that it measures, m.
    pub min_range: f64,
    /// The greatest distance that it measures, m.
    pub max_range: f64,
    /// The place of the sensor on the vehicle.
    pub mount: Mount,
}

/// The depth camera of the vehicle, a pinhole camera with square pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct DepthInfo {
    /// The time between two images, s.
    pub period: f64,
    /// The number of rows of an image, topmost first.
    pub rows: u32,
    /// The number of columns of an image, leftmost first.
    pub cols: u32,
    /// The angle between the left and the right edge of an image, rad.
    pub field_of_view: f64,
    /// The least depth that it measures, m.
    pub min_depth: f64,
    /// The greatest depth that it measures, m.
    pub max_depth: f64,
    /// Whether the images have a label for each pixel.
    pub labels: bool,
    /// The place of the sensor on the vehicle.
    pub mount: Mount,
}

/// What a planner is told at the start of a task.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Task {
    /// The name of the task within the suite, e.g. `w003/t07`.
    pub id: String,
    /// The vehicle to be driven.
    pub vehicle: Vehicle,
    /// The heights of the ground, m, as far as the perception profile gives them; absent if it gives none.
    pub elevation: Option<HeightMap>,
    /// The kinds of ground, as far as the perception profile gives them: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel,
    /// 5 rock, 6 wood, 7 mud, 8 sand, 9 snow; absent if it gives none.
    pub semantics: Option<LabelMap>,
    /// The obstacles, as far as the perception profile gives them: 1 where any part of the sample's square is covered by
    /// an obstacle, else 0; absent if it gives none.
    pub occupancy: Option<LabelMap>,
    /// Half of the world's extent along x and y, m: the vehicle must stay between −x and x, −y and y.
    pub half_extent: Point2,
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
    /// The time between two calls of `step`, s.
    pub control_period: f64,
    /// The seed for the planner's own randomness: the same in every run of this task with the same run seed.
    pub seed: u64,
    /// All parameters that the planner declares, with the user's values or the defaults.
    pub params: Vec<Param>,
    /// The name of the perception profile, e.g. `oracle`.
    pub perception: String,
    /// The lidar; absent if the planner doesn't ask for it.
    pub lidar: Option<LidarInfo>,
    /// The depth camera; absent if the planner doesn't ask for it.
    pub depth: Option<DepthInfo>,
}

/// An estimate of the vehicle's state, as the perception profile lets it be: the truth under `oracle`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Pose {
    /// The position of the vehicle's reference point in the world frame, m.
    pub position: Vec3,
    /// The roll, rad, positive with the right side down.
    pub roll: f64,
    /// The pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// The heading, rad, counter-clockwise from east.
    pub yaw: f64,
    /// The velocity of the reference point in body axes, m/s.
    pub linear_velocity: Vec3,
    /// The angular velocity in body axes, rad/s.
    pub angular_velocity: Vec3,
}

/// The state of one wheel, as its sensors measure it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Wheel {
    /// The angular velocity of the wheel about its axle, rad/s, positive when rolling forward.
    pub spin: f64,
    /// The suspension travel from the design position, m, positive in compression.
    pub travel: f64,
}

/// One measurement of the inertial measurement unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ImuSample {
    /// The simulated time of the measurement, s.
    pub time: f64,
    /// The specific force at the vehicle's reference point in body axes, m/s²: the acceleration less that of gravity, so
    /// +9.81 along z at rest.
    pub specific_force: Vec3,
    /// The angular velocity in body axes, rad/s.
    pub angular_velocity: Vec3,
}

/// A position from satellites.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct GnssFix {
    /// The simulated time of the measurement, s.
    pub time: f64,
    /// The measured position of the vehicle's reference point in the world frame, m.
    pub position: Vec3,
}

/// One turn of the lidar.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LidarScan {
    /// The simulated time at which the turn ended, s. Column c was measured (1 − (c + 1/2) / `cols`) · `period` before,
    /// while the vehicle moved.
    pub time: f64,
    /// The `rows` · `cols` measured distances, m, row-major; 0 where nothing came back.
    #[cfg_attr(feature = "serde", serde(with = "crate::bytes"))]
    pub ranges: Vec<f32>,
}

/// One image of the depth camera.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct DepthImage {
    /// The simulated time of the image, s.
    pub time: f64,
    /// The `rows` · `cols` depths along the camera's axis, m, row-major; 0 where nothing was measured.
    #[cfg_attr(feature = "serde", serde(with = "crate::bytes"))]
    pub depths: Vec<f32>,
    /// The kinds of ground that the pixels are recognised as, with the numbers of the task's `semantics`, 10 for an
    /// obstacle, and 255 where nothing was measured; empty if the camera has no labels.
    #[cfg_attr(feature = "serde", serde(with = "crate::bytes"))]
    pub labels: Vec<u8>,
}

/// The map of the vehicle's surroundings that is built from lidar and depth camera at the estimated pose. Its axes are
/// those of the world frame as far as the estimate is right, and the vehicle is in its middle.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LocalMap {
    /// The simulated time at which the map was last brought up to date, s.
    pub time: f64,
    /// The heights of the ground, m; NaN where it has not been seen.
    pub elevation: HeightMap,
    /// The kinds of ground, with the numbers of the task's `semantics`; 255 where it has not been seen, or isn't known.
    pub semantics: LabelMap,
    /// 1 where an obstacle was seen, 0 where ground was seen, and 255 where nothing was.
    pub occupancy: LabelMap,
}

/// The direction of travel that the gearbox is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(rename_all = "kebab-case"))]
pub enum Gear {
    /// One of the forward gears; the gearbox chooses which.
    #[default]
    Forward,
    /// The engine is uncoupled.
    Neutral,
    /// The reverse gear.
    Reverse,
}

/// What a planner sees every control period: what its sensors have measured since the last one. A sensor that the
/// planner doesn't ask for, or that has measured nothing since, is absent.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Observation {
    /// The simulated time since the start, s.
    pub time: f64,
    /// The estimate of the vehicle's state (`pose`).
    pub pose: Option<Pose>,
    /// The wheels (`wheel-odometry`), from front to back, left before right.
    pub wheels: Vec<Wheel>,
    /// The measurements of the inertial measurement unit (`imu`), oldest first.
    pub imu: Vec<ImuSample>,
    /// The last position from satellites (`gnss`).
    pub gnss: Option<GnssFix>,
    /// The last turn of the lidar (`lidar`).
    pub lidar: Option<LidarScan>,
    /// The last image of the depth camera (`depth`).
    pub depth: Option<DepthImage>,
    /// The map of the surroundings (`local-map`).
    pub local_map: Option<LocalMap>,
    /// The gear that is in: neutral while a change of direction takes its time.
    pub gear: Gear,
    /// The speed of the engine, rad/s.
    pub engine_speed: f64,
    /// The steering that the wheels have now, which follows the command at `max_steer_rate`, in [-1, 1], positive to the
    /// left.
    pub steering: f64,
    /// The steering command applied until now, after clamping; 0 at first.
    pub last_steering: f64,
    /// The throttle command applied until now, after clamping; 0 at first.
    pub last_throttle: f64,
    /// The brake command applied until now, after clamping; 0 at first.
    pub last_brake: f64,
}

/// Numbers that the harness records beside the trajectory, e.g. a sampled trajectory or a cost.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Series {
    /// The name of the series, which stays the same over a task.
    pub name: String,
    /// The values of the series.
    #[cfg_attr(feature = "serde", serde(with = "crate::bytes"))]
    pub values: Vec<f32>,
}

/// The command that holds until the next step.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Command {
    /// The steering, in [-1, 1], positive to the left.
    pub steering: f64,
    /// The throttle, in [0, 1].
    pub throttle: f64,
    /// The brake, in [0, 1].
    pub brake: f64,
    /// The direction of travel. A change between forward and reverse waits until the vehicle is slower than
    /// `direction_change_speed`, with the throttle closed; brake to bring that about.
    #[cfg_attr(feature = "serde", serde(default))]
    pub gear: Gear,
    /// Series that are recorded beside the trajectory and drawn by `vb-harness replay`. Leave this empty in normal runs.
    #[cfg_attr(feature = "serde", serde(default))]
    pub debug: Vec<Series>,
}
