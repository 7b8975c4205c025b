//! Bags of ROS 2, and messages of ROS 2 nodes.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use mcap::WriteOptions;
use vb_bag::{Selection, Wheels, read};
use vb_rosmsg::convert::{header, odometry};
use vb_rosmsg::messages::ackermann_msgs::AckermannDriveStamped;
use vb_rosmsg::messages::geometry_msgs::TwistStamped;
use vb_rosmsg::messages::grid_map_msgs::GridMap;
use vb_rosmsg::messages::nav_msgs::Odometry;
use vb_rosmsg::messages::sensor_msgs::{JointState, PointCloud2};
use vb_rosmsg::{Message, from_cdr, to_cdr};
use vb_sdk::Pose;

use crate::site::{Site, select};

const NAME: &str = "drive.mcap";

/// The first byte chooses between a bag and the types of messages.
pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = Site::new());
    let Some((&kind, content)) = data.split_first() else { return };
    match kind % 6 {
        0 => SITE.with(|site| {
            site.write(Path::new(NAME), content);
            let Ok(bag) = read(&site.path().join(NAME)) else { return };
            let selection = Selection { window: 0.2, ..Selection::default() };
            if let Ok(drive) = bag.drive(&selection, Wheels { radius: 0.2, track: 0.5 }) {
                assert!(drive.csv().lines().count() > drive.windows());
            }
        }),
        1 => drop(from_cdr::<TwistStamped>(content)),
        2 => drop(from_cdr::<AckermannDriveStamped>(content)),
        3 => drop(from_cdr::<JointState>(content)),
        4 => drop(from_cdr::<PointCloud2>(content)),
        _ => drop(from_cdr::<GridMap>(content)),
    }
}

fn cdr(message: &impl Message) -> Vec<u8> {
    to_cdr(message).unwrap_or_default()
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let joints = JointState {
        header: header(1, ""),
        name: vec!["left_wheel".into(), "right_wheel".into()],
        velocity: vec![1.0, 2.0],
        ..JointState::default()
    };
    let mut all = vec![
        select(1, &cdr(&TwistStamped::default())),
        select(2, &cdr(&AckermannDriveStamped::default())),
        select(3, &cdr(&joints)),
        select(4, &cdr(&PointCloud2 { data: vec![1; 40], ..PointCloud2::default() })),
        select(5, &cdr(&GridMap { layers: vec!["elevation".into()], ..GridMap::default() })),
    ];
    all.extend(bag(&joints).map(|bytes| select(0, &bytes)));
    all
}

/// A bag of half a second.
fn bag(joints: &JointState) -> mcap::McapResult<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut writer = WriteOptions::new().compression(None).profile("ros2").create(Cursor::new(&mut bytes))?;
    let mut channel = |name: &str, kind: &str, definition: &str| {
        let schema = writer.add_schema(kind, "ros2msg", definition.as_bytes())?;
        writer.add_channel(schema, name, "cdr", &BTreeMap::new())
    };
    let poses = channel("/odom", Odometry::NAME, Odometry::DEFINITION)?;
    let speeds = channel("/joint_states", JointState::NAME, JointState::DEFINITION)?;
    for k in 0..6 {
        let time = 1_000_000_000 + 100_000_000 * k;
        let pose = cdr(&odometry(time as i64, &Pose { yaw: 0.1 * k as f64, ..Pose::default() }));
        for (channel_id, data) in [(poses, pose), (speeds, cdr(joints))] {
            let about =
                mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
            writer.write_to_known_channel(&about, &data)?;
        }
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes)
}
