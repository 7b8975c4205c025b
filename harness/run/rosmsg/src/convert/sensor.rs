//! Measurements of sensors.

use vb_sdk::math::{cos, sin, tan};
use vb_sdk::{DepthImage, DepthInfo, ImuSample, LidarInfo, LidarScan, Vec3, Wheel};

use super::{Datum, frame, header};
use crate::Array;
use crate::messages::geometry_msgs::{Quaternion, Vector3};
use crate::messages::sensor_msgs::{
    CameraInfo, Image, Imu, JointState, NavSatFix, NavSatStatus, PointCloud2, PointField,
};

/// The values that REP 145 has for an orientation that is not measured.
const NO_ORIENTATION: f64 = -1.0;

/// A measurement of the inertial measurement unit: specific force (REP 145: +9.81 m/s² along z at rest) and angular velocity, rad/s. An
/// orientation is not measured.
#[must_use]
pub fn imu(nanoseconds: i64, sample: &ImuSample) -> Imu {
    let vector = |v: &Vec3| Vector3 { x: v.x, y: v.y, z: v.z };
    let mut orientation_covariance = Array::default();
    orientation_covariance.0[0] = NO_ORIENTATION;
    Imu {
        header: header(nanoseconds, frame::IMU),
        orientation: Quaternion { w: 1.0, ..Quaternion::default() },
        orientation_covariance,
        angular_velocity: vector(&sample.angular_velocity),
        linear_acceleration: vector(&sample.specific_force),
        ..Imu::default()
    }
}

/// A GNSS position of the world frame as a place on the Earth.
#[must_use]
pub fn nav_sat_fix(nanoseconds: i64, position: &Vec3, datum: &Datum) -> NavSatFix {
    let Datum { latitude, longitude, altitude } = datum.place(position);
    NavSatFix {
        header: header(nanoseconds, frame::GNSS),
        status: NavSatStatus { status: NavSatStatus::STATUS_FIX, service: NavSatStatus::SERVICE_GPS },
        latitude,
        longitude,
        altitude,
        position_covariance: Array::default(),
        position_covariance_type: NavSatFix::COVARIANCE_TYPE_UNKNOWN,
    }
}

/// Spins of the wheels, rad/s, positive when rolling forward, named as the joints of the robot description.
#[must_use]
pub fn joint_states(nanoseconds: i64, wheels: &[Wheel]) -> JointState {
    JointState {
        header: header(nanoseconds, ""),
        name: (0..wheels.len()).map(crate::urdf::wheel_joint).collect(),
        velocity: wheels.iter().map(|wheel| wheel.spin).collect(),
        ..JointState::default()
    }
}

/// Bytes of a point: x, y, z and time as `float32`, beam as `uint16`, and two bytes of padding.
const POINT: u32 = 20;

/// A turn of the lidar as an organised cloud in `lidar_link`: a row for each beam, the lowest first; NaN without an echo. The field
/// `time` is that of the point relative to the stamp, s (0 or less), the field `ring` the number of the beam.
#[must_use]
pub fn point_cloud(nanoseconds: i64, info: &LidarInfo, scan: &LidarScan) -> PointCloud2 {
    let (rows, cols) = (info.rows as usize, info.cols as usize);
    let column = |c: usize| (c as f64 + 0.5) / cols as f64;
    let azimuths: Vec<[f64; 2]> = (0..cols)
        .map(|c| {
            let azimuth = (2.0 * column(c) - 1.0) * std::f64::consts::PI;
            [cos(azimuth), sin(azimuth)]
        })
        .collect();
    let step = if rows > 1 { (info.highest - info.lowest) / (rows - 1) as f64 } else { 0.0 };
    let mut data = Vec::with_capacity(rows * cols * POINT as usize);
    let mut ranges = scan.ranges.iter().copied();
    for row in 0..rows {
        let elevation = info.lowest + step * row as f64;
        let (up, level) = (sin(elevation), cos(elevation));
        for (c, [along, left]) in azimuths.iter().enumerate() {
            let range = match ranges.next() {
                Some(range) if range > 0.0 => f64::from(range),
                _ => f64::NAN,
            };
            for value in
                [range * level * along, range * level * left, range * up, (column(c) - 1.0) * info.period]
            {
                data.extend((value as f32).to_le_bytes());
            }
            data.extend((row as u16).to_le_bytes());
            data.extend([0, 0]);
        }
    }
    let field = |name: &str, offset: u32, datatype: u8| PointField {
        name: name.to_owned(),
        offset,
        datatype,
        count: 1,
    };
    PointCloud2 {
        header: header(nanoseconds, frame::LIDAR),
        height: info.rows,
        width: info.cols,
        fields: vec![
            field("x", 0, PointField::FLOAT32),
            field("y", 4, PointField::FLOAT32),
            field("z", 8, PointField::FLOAT32),
            field("time", 12, PointField::FLOAT32),
            field("ring", 16, PointField::UINT16),
        ],
        is_bigendian: false,
        point_step: POINT,
        row_step: POINT * info.cols,
        data,
        is_dense: false,
    }
}

/// A depth image by REP 118: `32FC1`, m along the camera's axis, NaN without a measurement.
#[must_use]
pub fn depth_image(nanoseconds: i64, info: &DepthInfo, image: &DepthImage) -> Image {
    let data = image.depths.iter().flat_map(|d| if *d > 0.0 { *d } else { f32::NAN }.to_le_bytes()).collect();
    Image {
        header: header(nanoseconds, frame::OPTICAL),
        height: info.rows,
        width: info.cols,
        encoding: "32FC1".to_owned(),
        is_bigendian: 0,
        step: 4 * info.cols,
        data,
    }
}

/// The calibration of the depth camera: a pinhole with square pixels and no distortion; pixel centres have whole coordinates.
#[must_use]
pub fn camera_info(nanoseconds: i64, info: &DepthInfo) -> CameraInfo {
    let focal = 0.5 * f64::from(info.cols) / tan(0.5 * info.field_of_view);
    let [cx, cy] = [info.cols, info.rows].map(|n| 0.5 * (f64::from(n) - 1.0));
    CameraInfo {
        header: header(nanoseconds, frame::OPTICAL),
        height: info.rows,
        width: info.cols,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![0.0; 5],
        k: Array([focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]),
        r: Array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        p: Array([focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ..CameraInfo::default()
    }
}

/// The rotation of an optical frame (z forward, x right, y down) in its camera's frame (x forward, y left, z up), REP 103.
#[must_use]
pub fn optical_rotation() -> Quaternion {
    Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of a point.
    fn number(cloud: &PointCloud2, point: usize, field: usize) -> f32 {
        let at = point * POINT as usize + cloud.fields[field].offset as usize;
        f32::from_le_bytes(cloud.data[at..at + 4].try_into().unwrap())
    }

    #[test]
    fn points_lie_where_their_beam_and_column_look() {
        let info = LidarInfo {
            period: 0.1,
            rows: 2,
            cols: 4,
            lowest: -std::f64::consts::FRAC_PI_6,
            highest: std::f64::consts::FRAC_PI_6,
            ..LidarInfo::default()
        };
        let scan = LidarScan { time: 1.0, ranges: vec![2.0, 0.0, 2.0, 2.0, 2.0, 2.0, 2.0, 4.0] };
        let cloud = point_cloud(1, &info, &scan);
        assert_eq!((cloud.height, cloud.width, cloud.row_step, cloud.data.len()), (2, 4, 80, 160));
        // Columns look at −135°, −45°, 45° and 135°; 2 m at 30° below the horizon is √3 m away and 1 m down.
        let side = 1.5f32.sqrt();
        let near = |point: usize, wanted: [f32; 3]| {
            let found = [0, 1, 2].map(|k| number(&cloud, point, k));
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}, {wanted:?}");
        };
        near(0, [-side, -side, -1.0]);
        near(2, [side, side, -1.0]);
        near(7, [-2.0 * side, 2.0 * side, 2.0]);
        assert!(number(&cloud, 1, 0).is_nan());
        // Measured (1 − (c + 1/2)/4) · 0.1 s before the stamp.
        assert!((number(&cloud, 0, 3) + 0.0875).abs() < 1e-8 && (number(&cloud, 7, 3) + 0.0125).abs() < 1e-8);
        assert_eq!(cloud.data[7 * 20 + 16..7 * 20 + 18], [1, 0]);
    }

    #[test]
    fn a_scan_that_is_too_short_has_no_echo_at_its_end() {
        let info = LidarInfo { rows: 1, cols: 2, ..LidarInfo::default() };
        let cloud = point_cloud(0, &info, &LidarScan { time: 0.0, ranges: vec![] });
        assert_eq!(cloud.data.len(), 40);
        assert!(number(&cloud, 1, 2).is_nan());
    }

    #[test]
    fn a_pinhole_of_90_degrees_has_half_the_width_as_focal_length() {
        let info = DepthInfo {
            rows: 64,
            cols: 96,
            field_of_view: std::f64::consts::FRAC_PI_2,
            ..DepthInfo::default()
        };
        let camera = camera_info(0, &info);
        assert!((camera.k.0[0] - 48.0).abs() < 1e-12 && camera.k.0[0] == camera.k.0[4]);
        assert_eq!((camera.k.0[2], camera.k.0[5]), (47.5, 31.5));
        let image = DepthImage { time: 0.0, depths: vec![1.5, 0.0], labels: vec![] };
        let image = depth_image(0, &info, &image);
        assert_eq!(image.data[..4], 1.5f32.to_le_bytes());
        assert!(f32::from_le_bytes(image.data[4..8].try_into().unwrap()).is_nan());
    }

    #[test]
    fn at_rest_an_inertial_sensor_measures_gravity_upwards_and_no_orientation() {
        let sample =
            ImuSample { specific_force: Vec3 { z: 9.81, ..Vec3::default() }, ..ImuSample::default() };
        let imu = imu(5, &sample);
        assert_eq!(imu.linear_acceleration.z, 9.81);
        assert_eq!((imu.orientation_covariance.0[0], imu.header.frame_id.as_str()), (-1.0, "imu_link"));
    }
}
