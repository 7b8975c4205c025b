//! The topics of a bag that a recording may use.

use std::collections::BTreeMap;
use std::path::Path;

use vb_math::atan2;
use vb_rosmsg::convert::time_nanoseconds;
use vb_rosmsg::messages::geometry_msgs::{Quaternion, Twist, TwistStamped};
use vb_rosmsg::messages::nav_msgs::Odometry;
use vb_rosmsg::messages::sensor_msgs::{Imu, JointState};
use vb_rosmsg::messages::std_msgs::Header;
use vb_rosmsg::{Message, from_cdr};

use crate::BagError;

/// Maximum number of messages of all topics that are read: 30 h at 200 Hz.
const MOST: usize = 20_000_000;
/// Largest deviation of the norm of a quaternion from 1.
const NORM: f64 = 0.01;

/// A moment of a topic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry<const N: usize> {
    /// Time at which the message was recorded, ns.
    pub(crate) recorded: i64,
    /// Time of the message's header, ns; none without a header, or for 0.
    pub(crate) stamp: Option<i64>,
    pub(crate) values: [f64; N],
}

/// The messages of a topic.
#[derive(Clone, Debug)]
pub(crate) enum Series {
    /// x and y, m, and yaw, rad (`nav_msgs/msg/Odometry`).
    Pose(Vec<Entry<3>>),
    /// Speeds of the left and the right wheels, rad/s (`sensor_msgs/msg/JointState`).
    Joints(Vec<Entry<2>>),
    /// Forward speed, m/s, and yaw rate, rad/s (`geometry_msgs/msg/Twist` and `TwistStamped`).
    Commands(Vec<Entry<2>>),
    /// Yaw rate, rad/s (`sensor_msgs/msg/Imu`).
    Rate(Vec<Entry<1>>),
}

/// The odometry, wheel speeds, velocity commands and yaw rates of a bag.
#[derive(Clone, Debug, Default)]
pub struct Bag {
    pub(crate) topics: BTreeMap<String, Series>,
    messages: usize,
    /// Messages with numbers that are not finite or with no rotation, by topic.
    skipped: BTreeMap<String, usize>,
}

impl Bag {
    /// Number of messages that were read.
    #[must_use]
    pub fn messages(&self) -> usize {
        self.messages
    }

    /// Topics with messages that were skipped, and their number: a number is not finite, or the orientation is no rotation.
    pub fn skipped(&self) -> impl Iterator<Item = (&str, usize)> {
        self.skipped.iter().map(|(topic, count)| (topic.as_str(), *count))
    }

    /// Adds a message, if it is of a type that recordings use.
    pub(crate) fn add(
        &mut self,
        path: &Path,
        topic: &str,
        kind: &str,
        recorded: i64,
        data: &[u8],
    ) -> Result<(), BagError> {
        let decoding = Decoding { path, topic, data };
        match kind {
            Odometry::NAME => {
                let m = decoding.read::<Odometry>()?;
                let pose = &m.pose.pose;
                let values = yaw(&pose.orientation).map(|yaw| [pose.position.x, pose.position.y, yaw]);
                self.push(topic, recorded, stamp(&m.header), values, Series::Pose(Vec::new()), |s| match s {
                    Series::Pose(all) => Some(all),
                    _ => None,
                })
            }
            JointState::NAME => {
                let m = decoding.read::<JointState>()?;
                // Joints without wheels, or without velocities: not the speeds that are wanted.
                let Some(sides) = sides(&m) else { return Ok(()) };
                self.push(topic, recorded, stamp(&m.header), Some(sides), Series::Joints(Vec::new()), |s| {
                    match s {
                        Series::Joints(all) => Some(all),
                        _ => None,
                    }
                })
            }
            Twist::NAME | TwistStamped::NAME => {
                let (time, twist) = if kind == Twist::NAME {
                    (None, decoding.read::<Twist>()?)
                } else {
                    let m = decoding.read::<TwistStamped>()?;
                    (stamp(&m.header), m.twist)
                };
                let values = Some([twist.linear.x, twist.angular.z]);
                self.push(topic, recorded, time, values, Series::Commands(Vec::new()), |s| match s {
                    Series::Commands(all) => Some(all),
                    _ => None,
                })
            }
            Imu::NAME => {
                let m = decoding.read::<Imu>()?;
                let values = Some([m.angular_velocity.z]);
                self.push(topic, recorded, stamp(&m.header), values, Series::Rate(Vec::new()), |s| match s {
                    Series::Rate(all) => Some(all),
                    _ => None,
                })
            }
            _ => Ok(()),
        }
    }

    fn push<const N: usize>(
        &mut self,
        topic: &str,
        recorded: i64,
        stamp: Option<i64>,
        values: Option<[f64; N]>,
        empty: Series,
        of: fn(&mut Series) -> Option<&mut Vec<Entry<N>>>,
    ) -> Result<(), BagError> {
        self.messages += 1;
        if self.messages > MOST {
            return Err(BagError::Topic(format!("the bag has more than {MOST} messages; cut it into parts")));
        }
        let Some(values) = values.filter(|values| values.iter().all(|v| v.is_finite())) else {
            *self.skipped.entry(topic.to_owned()).or_default() += 1;
            return Ok(());
        };
        let series = match self.topics.get_mut(topic) {
            Some(series) => series,
            None => self.topics.entry(topic.to_owned()).or_insert(empty),
        };
        let Some(all) = of(series) else {
            return Err(BagError::Topic(format!("{topic} has messages of several types")));
        };
        all.push(Entry { recorded, stamp, values });
        Ok(())
    }
}

/// A message before it is decoded.
struct Decoding<'a> {
    path: &'a Path,
    topic: &'a str,
    data: &'a [u8],
}

impl Decoding<'_> {
    fn read<M: Message>(&self) -> Result<M, BagError> {
        from_cdr(self.data).map_err(|e| BagError::Message {
            path: self.path.to_owned(),
            topic: self.topic.to_owned(),
            kind: M::NAME,
            problem: e.to_string(),
        })
    }
}

/// The time of a header; none for 0, which nodes without a clock write.
fn stamp(header: &Header) -> Option<i64> {
    Some(time_nanoseconds(&header.stamp)).filter(|stamp| *stamp != 0)
}

/// The yaw of an orientation, rad: of the body's forward axis on the ground plane. None for what is no rotation.
fn yaw(q: &Quaternion) -> Option<f64> {
    let norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    let rotates = (norm - 1.0).abs() <= NORM;
    rotates.then(|| atan2(2.0 * (q.w * q.z + q.x * q.y), norm - 2.0 * (q.y * q.y + q.z * q.z)))
}

/// Mean speeds of the joints with `left` and with `right` in their names, rad/s. None without both.
fn sides(m: &JointState) -> Option<[f64; 2]> {
    if m.velocity.len() != m.name.len() {
        return None;
    }
    let mean = |side: &str| {
        let of =
            || m.name.iter().zip(&m.velocity).filter(|(name, _)| name.to_ascii_lowercase().contains(side));
        let count = of().count();
        (count > 0).then(|| of().map(|(_, speed)| *speed).sum::<f64>() / count as f64)
    };
    Some([mean("left")?, mean("right")?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_rosmsg::convert::quaternion;

    #[test]
    fn the_yaw_is_that_of_the_forward_axis() {
        assert!((yaw(&quaternion(0.0, 0.0, 2.5)).unwrap() - 2.5).abs() < 1e-12);
        // Heading comes first, so roll and pitch do not change it.
        assert!((yaw(&quaternion(0.4, -0.3, -2.0)).unwrap() + 2.0).abs() < 1e-12);
        assert_eq!(yaw(&Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }), None);
        assert_eq!(yaw(&Quaternion { x: f64::NAN, y: 0.0, z: 0.0, w: 1.0 }), None);
    }

    #[test]
    fn wheels_are_assigned_to_sides_by_the_names_of_their_joints() {
        let joints = |names: &[&str], velocity: &[f64]| {
            sides(&JointState {
                name: names.iter().map(|name| (*name).to_owned()).collect(),
                velocity: velocity.to_vec(),
                ..JointState::default()
            })
        };
        let husky = ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"];
        assert_eq!(joints(&husky, &[1.0, 2.0, 3.0, 5.0]), Some([2.0, 3.5]));
        assert_eq!(joints(&["Left_Wheel", "RIGHT_WHEEL", "arm"], &[1.0, 2.0, 9.0]), Some([1.0, 2.0]));
        assert_eq!(joints(&husky, &[]), None);
        assert_eq!(joints(&["arm", "left_wheel"], &[1.0, 2.0]), None);
    }
}
