//! Messages of what planners receive, by the conventions of REP 103 (units and axes), REP 105 (frames), REP 118 (depth images) and REP
//! 145 (inertial sensors).
//!
//! The world frame of the benchmark (x east, y north, z up, origin at the world's centre) is the frame `map`; the body frame (x forward, y
//! left, z up, origin at the vehicle's reference point) is `base_link`. Positions are in m, angles in rad.

mod geometry;
mod map;
mod sensor;

pub use geometry::{
    Datum, header, odometry, path, pose_stamped, quaternion, ros_time, seconds, time_nanoseconds, transform,
};
pub use map::{elevation_map, occupancy_grid};
pub use sensor::{camera_info, depth_image, imu, joint_states, nav_sat_fix, optical_rotation, point_cloud};

/// The names of the frames (REP 105, and the usual suffixes of sensors).
pub mod frame {
    /// The world frame.
    pub const MAP: &str = "map";
    /// The frame in which the estimated pose moves.
    pub const ODOM: &str = "odom";
    /// The body frame at the reference point: half-way between the first and last axle, at the height of the wheel centres.
    pub const BASE: &str = "base_link";
    /// The inertial measurement unit, which is at the reference point.
    pub const IMU: &str = "imu_link";
    /// The GNSS antenna, which is at the reference point.
    pub const GNSS: &str = "gps_link";
    /// The lidar, x forward and z up.
    pub const LIDAR: &str = "lidar_link";
    /// The depth camera, x along its axis and z up.
    pub const CAMERA: &str = "camera_link";
    /// The depth camera, z along its axis, x right and y down.
    pub const OPTICAL: &str = "camera_optical_frame";
}
