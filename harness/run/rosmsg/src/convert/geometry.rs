//! Times, poses, transforms, and places on the Earth.

use vb_sdk::math::{atan2, cos, sin};
use vb_sdk::{Point2, Pose, Vec3};

use super::frame;
use crate::messages::builtin_interfaces::Time;
use crate::messages::geometry_msgs::{
    Point, Pose as RosPose, PoseStamped, PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist,
    TwistWithCovariance, Vector3,
};
use crate::messages::nav_msgs::{Odometry, Path};
use crate::messages::std_msgs::Header;

const NANOSECONDS: i64 = 1_000_000_000;

/// A time in nanoseconds as ROS has it. Times beyond 2038 (or before 1901) are cut to the nearest that there is.
#[must_use]
pub fn ros_time(nanoseconds: i64) -> Time {
    let seconds = nanoseconds.div_euclid(NANOSECONDS);
    let sec = seconds.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    Time { sec, nanosec: nanoseconds.rem_euclid(NANOSECONDS) as u32 }
}

/// A time of ROS in nanoseconds.
#[must_use]
pub fn time_nanoseconds(time: &Time) -> i64 {
    i64::from(time.sec) * NANOSECONDS + i64::from(time.nanosec)
}

/// A simulated time, s, in whole nanoseconds; 0 for what is not finite.
#[must_use]
pub fn seconds(time: f64) -> i64 {
    (time * NANOSECONDS as f64).round() as i64
}

/// The header of a message that was measured at a time in a frame.
#[must_use]
pub fn header(nanoseconds: i64, frame: &str) -> Header {
    Header { stamp: ros_time(nanoseconds), frame_id: frame.to_owned() }
}

/// The rotation of a body in its parent frame: yaw first, then pitch about the turned y axis, then roll about the turned x axis, rad. In
/// axes with x forward, y left and z up, positive pitch is nose down and positive roll right side down.
#[must_use]
pub fn quaternion(roll: f64, pitch: f64, yaw: f64) -> Quaternion {
    let [r, p, y] = [roll, pitch, yaw].map(|angle| [sin(0.5 * angle), cos(0.5 * angle)]);
    let ([sr, cr], [sp, cp], [sy, cy]) = (r, p, y);
    Quaternion {
        x: sr * cp * cy - cr * sp * sy,
        y: cr * sp * cy + sr * cp * sy,
        z: cr * cp * sy - sr * sp * cy,
        w: cr * cp * cy + sr * sp * sy,
    }
}

fn vector(v: &Vec3) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

fn point(v: &Vec3) -> Point {
    Point { x: v.x, y: v.y, z: v.z }
}

/// A pose estimate as odometry: pose of `base_link` in `odom`, velocities in `base_link`. The covariances are 0, which means unknown.
#[must_use]
pub fn odometry(nanoseconds: i64, pose: &Pose) -> Odometry {
    Odometry {
        header: header(nanoseconds, frame::ODOM),
        child_frame_id: frame::BASE.to_owned(),
        pose: PoseWithCovariance {
            pose: RosPose {
                position: point(&pose.position),
                orientation: quaternion(pose.roll, pose.pitch, pose.yaw),
            },
            ..PoseWithCovariance::default()
        },
        twist: TwistWithCovariance {
            twist: Twist { linear: vector(&pose.linear_velocity), angular: vector(&pose.angular_velocity) },
            ..TwistWithCovariance::default()
        },
    }
}

/// The place and rotation of a frame in its parent.
#[must_use]
pub fn transform(
    nanoseconds: i64,
    parent: &str,
    child: &str,
    position: &Vec3,
    rotation: Quaternion,
) -> TransformStamped {
    TransformStamped {
        header: header(nanoseconds, parent),
        child_frame_id: child.to_owned(),
        transform: Transform { translation: vector(position), rotation },
    }
}

/// A pose on the ground plane (z = 0) of the frame `map`.
#[must_use]
pub fn pose_stamped(nanoseconds: i64, place: &Point2, yaw: f64) -> PoseStamped {
    PoseStamped {
        header: header(nanoseconds, frame::MAP),
        pose: RosPose {
            position: Point { x: place.x, y: place.y, z: 0.0 },
            orientation: quaternion(0.0, 0.0, yaw),
        },
    }
}

/// A path on the ground plane of the frame `map`; each pose looks at the next one, and the last as the one before.
#[must_use]
pub fn path(nanoseconds: i64, points: &[Point2]) -> Path {
    let mut poses: Vec<PoseStamped> = Vec::with_capacity(points.len());
    let mut yaw = 0.0;
    for (k, place) in points.iter().enumerate() {
        if let Some(next) = points.get(k + 1)
            && (next.x != place.x || next.y != place.y)
        {
            yaw = atan2(next.y - place.y, next.x - place.x);
        }
        poses.push(pose_stamped(nanoseconds, place, yaw));
    }
    Path { header: header(nanoseconds, frame::MAP), poses }
}

/// The place of the world's origin on the Earth (WGS 84).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Datum {
    /// Geodetic latitude, degrees, positive north.
    pub latitude: f64,
    /// Longitude, degrees, positive east.
    pub longitude: f64,
    /// Height above the ellipsoid, m.
    pub altitude: f64,
}

impl Datum {
    /// Semi-major axis, m, and flattening of WGS 84 (NGA.STND.0036, 2014, table 3.1).
    const A: f64 = 6_378_137.0;
    const F: f64 = 1.0 / 298.257_223_563;
    /// The square of the first eccentricity.
    const E2: f64 = Self::F * (2.0 - Self::F);

    /// Whether the numbers are a place: latitude in [−90, 90], longitude in [−180, 180], altitude within 10 km.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.latitude.abs() <= 90.0 && self.longitude.abs() <= 180.0 && self.altitude.abs() <= 10_000.0
    }

    /// The place of a position of the world frame, which is the tangent plane at the datum (x east, y north, z up; m).
    ///
    /// East-north-up to earth-centred, then Bowring's formula (1985) for the latitude, whose error is below 1e-9 rad within 10 km of
    /// the ellipsoid.
    #[must_use]
    pub fn place(&self, position: &Vec3) -> Self {
        let (lat, lon) = (self.latitude.to_radians(), self.longitude.to_radians());
        let ([sl, cl], [so, co]) = ([sin(lat), cos(lat)], [sin(lon), cos(lon)]);
        let n = Self::A / (1.0 - Self::E2 * sl * sl).sqrt();
        let Vec3 { x: east, y: north, z: up } = *position;
        // Along the axis of the Earth, and in the plane of the equator.
        let outwards = (n + self.altitude + up) * cl - north * sl;
        let [x, y] = [outwards * co - east * so, outwards * so + east * co];
        let z = (n * (1.0 - Self::E2) + self.altitude + up) * sl + north * cl;
        let p = (x * x + y * y).sqrt();
        let b = Self::A * (1.0 - Self::F);
        let radius = (p * p + z * z).sqrt();
        // The reduced latitude, with Bowring's correction for the height.
        let tan_reduced = b * z / (Self::A * p) * (1.0 + Self::E2 / (1.0 - Self::E2) * b / radius);
        let c = 1.0 / (1.0 + tan_reduced * tan_reduced).sqrt();
        let s = tan_reduced * c;
        let (s, c) = if p > 0.0 { (s, c) } else { (z.signum(), 0.0) };
        let second = Self::E2 / (1.0 - Self::E2);
        let latitude = atan2(z + second * b * s * s * s, p - Self::E2 * Self::A * c * c * c);
        let ([sl, cl], longitude) = ([sin(latitude), cos(latitude)], atan2(y, x));
        let altitude = p * cl + z * sl - Self::A * (1.0 - Self::E2 * sl * sl).sqrt();
        Self { latitude: latitude.to_degrees(), longitude: longitude.to_degrees(), altitude }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_split_into_seconds_and_nanoseconds_before_and_after_the_epoch() {
        assert_eq!(ros_time(1_500_000_000), Time { sec: 1, nanosec: 500_000_000 });
        assert_eq!(ros_time(-1), Time { sec: -1, nanosec: 999_999_999 });
        assert_eq!(time_nanoseconds(&ros_time(-1)), -1);
        assert_eq!(seconds(0.1), 100_000_000);
    }

    #[test]
    fn a_quarter_turn_about_each_axis_has_its_quaternion() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let turn = std::f64::consts::FRAC_PI_2;
        for (angles, axis) in [([turn, 0.0, 0.0], 0), ([0.0, turn, 0.0], 1), ([0.0, 0.0, turn], 2)] {
            let q = quaternion(angles[0], angles[1], angles[2]);
            let found = [q.x, q.y, q.z];
            for (k, part) in found.into_iter().enumerate() {
                assert!((part - if k == axis { h } else { 0.0 }).abs() < 1e-15, "{q:?}");
            }
            assert!((q.w - h).abs() < 1e-15);
        }
    }

    #[test]
    fn yaw_comes_before_pitch_and_roll() {
        // Heading north, then nose down by a right angle: the vehicle's x axis points down, and its y axis west.
        let q = quaternion(0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2);
        let Quaternion { x, y, z, w } = q;
        let x_axis = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
        let y_axis = [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)];
        for (found, wanted) in [(x_axis, [0.0, 0.0, -1.0]), (y_axis, [-1.0, 0.0, 0.0])] {
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}, {wanted:?}");
        }
    }

    #[test]
    fn a_path_looks_along_itself() {
        let at = |x: f64, y: f64| Point2 { x, y };
        let path = path(0, &[at(0.0, 0.0), at(0.0, 2.0), at(0.0, 2.0), at(-1.0, 2.0)]);
        let yaw: Vec<f64> =
            path.poses.iter().map(|p| 2.0 * atan2(p.pose.orientation.z, p.pose.orientation.w)).collect();
        let (north, west) = (std::f64::consts::FRAC_PI_2, std::f64::consts::PI);
        for (found, wanted) in yaw.iter().zip([north, north, west, west]) {
            assert!((found - wanted).abs() < 1e-12, "{yaw:?}");
        }
    }

    #[test]
    fn places_on_the_earth_agree_with_the_radii_of_curvature_of_wgs_84() {
        for latitude in [0.0, 38.8, -52.0, 89.0] {
            let datum = Datum { latitude, longitude: 170.0, altitude: 250.0 };
            let at = |x: f64, y: f64, z: f64| datum.place(&Vec3 { x, y, z });
            let here = at(0.0, 0.0, 0.0);
            assert!((here.latitude - latitude).abs() < 1e-10 && (here.longitude - 170.0).abs() < 1e-10);
            assert!((here.altitude - 250.0).abs() < 1e-6, "{here:?}");
            assert!((at(0.0, 0.0, 30.0).altitude - 280.0).abs() < 1e-6);
            // Meridional and prime-vertical radius of curvature (Torge, Geodesy, 4.1.3).
            let s = sin(f64::to_radians(latitude));
            let w = (1.0 - Datum::E2 * s * s).sqrt();
            let (n, m) = (Datum::A / w, Datum::A * (1.0 - Datum::E2) / (w * w * w));
            let north = (at(0.0, 10.0, 0.0).latitude - latitude).to_radians() * (m + 250.0);
            let east = (at(10.0, 0.0, 0.0).longitude - 170.0).to_radians()
                * (n + 250.0)
                * cos(f64::to_radians(latitude));
            assert!((north - 10.0).abs() < 1e-4 && (east - 10.0).abs() < 1e-3, "{latitude}: {north}, {east}");
        }
    }
}
