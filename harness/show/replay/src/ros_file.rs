//! A replay as an MCAP file with messages of ROS 2 (profile `ros2`), for rosbag2, rviz and other readers of bags.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use foxglove::{ChannelBuilder, Context, McapWriteOptions, McapWriter, PartialMetadata, RawChannel, Schema};
use vb_record::Sample;
use vb_rosmsg::convert::{
    Datum, camera_info, depth_image, elevation_map, frame, header, imu, nav_sat_fix, occupancy_grid,
    odometry, optical_rotation, path, point_cloud, pose_stamped, quaternion, seconds, transform,
};
use vb_rosmsg::messages::sensor_msgs::JointState;
use vb_rosmsg::messages::std_msgs::String as Text;
use vb_rosmsg::messages::tf2_msgs::TFMessage;
use vb_rosmsg::urdf::wheel_joint;
use vb_rosmsg::{Message, to_cdr};
use vb_sdk::{GridFrame, HeightMap, Mount, Point2, Pose, Vec3};

use crate::motion::WheelFrame;
use crate::scene::ground;
use crate::sensed::Sensed;
use crate::{Replay, ReplayError, ReplayRun};

/// Writes the replay. Time is that of the simulation, as if it had begun at the epoch. Topics: `/elevation_map`, `/plan` and `/goal_pose` of the
/// task, `/tf` and `/tf_static`, and of each run `ground_truth` (the true odometry), `controls` (steering, throttle and brake as the
/// positions of a joint state), `joint_states` (angles of the wheels, rad, and their mean speeds since the frame before, rad/s), `outcome`, and what its sensors measured under the names of `vb-harness ros`: `odom` (the estimate),
/// `imu/data`, `gps/fix` (with the world's origin at latitude and longitude 0), `points`, `camera/depth`, `camera/camera_info`, `map` and
/// `local_elevation_map`. Topics and frames of one run have no prefix, those of several begin with `runN/`. Channels have the type hashes as
/// rosbag2 writes them (`topic_type_hash`). `file_path` is what the file is called in errors.
///
/// # Errors
/// Returns an error if the file can't be written.
pub fn write_ros2_mcap(replay: &Replay, file: File, file_path: &Path) -> Result<(), ReplayError> {
    let fail = |detail: String| ReplayError::Mcap { path: file_path.to_owned(), detail };
    let context = Context::new();
    let options = McapWriteOptions::new().compression(None).profile("ros2").library("vb-harness");
    let handle = McapWriter::with_options(options)
        .context(&context)
        .create(BufWriter::new(file))
        .map_err(|e| fail(e.to_string()))?;
    let mut bag = Bag { context, channels: BTreeMap::new() };
    bag.world(replay).map_err(&fail)?;
    let one = replay.runs.len() == 1;
    for (k, run) in replay.runs.iter().enumerate() {
        let prefix = if one { String::new() } else { format!("run{k}/") };
        bag.run(run, &prefix).map_err(&fail)?;
    }
    let mut file = handle.close().map_err(|e| fail(e.to_string()))?;
    std::io::Write::flush(&mut file).map_err(|e| fail(e.to_string()))
}

struct Bag {
    context: Arc<Context>,
    channels: BTreeMap<String, Arc<RawChannel>>,
}

/// The true pose of a frame of the motion.
fn pose_of(f: &Sample) -> Pose {
    Pose {
        position: Vec3 { x: f.x, y: f.y, z: f.z },
        roll: f.roll,
        pitch: f.pitch,
        yaw: f.yaw,
        linear_velocity: Vec3 { x: f.vx, y: f.vy, z: f.vz },
        angular_velocity: Vec3 { x: f.wx, y: f.wy, z: f.wz },
    }
}

impl Bag {
    /// Writes a message at a time, ns.
    fn log<M: Message>(&mut self, topic: &str, nanoseconds: i64, message: &M) -> Result<(), String> {
        let channel = match self.channels.get(topic) {
            Some(channel) => Arc::clone(channel),
            None => {
                let channel = ChannelBuilder::new(topic)
                    .message_encoding("cdr")
                    .schema(Schema::new(M::NAME, "ros2msg", M::DEFINITION.as_bytes()))
                    .add_metadata("topic_type_hash", M::HASH)
                    .context(&self.context)
                    .build_raw()
                    .map_err(|e| e.to_string())?;
                self.channels.insert(topic.to_owned(), Arc::clone(&channel));
                channel
            }
        };
        let bytes = to_cdr(message).map_err(|e| format!("{topic}: {e}"))?;
        let time = u64::try_from(nanoseconds).unwrap_or(0);
        channel.log_with_meta(&bytes, PartialMetadata::with_log_time(time));
        Ok(())
    }

    fn world(&mut self, replay: &Replay) -> Result<(), String> {
        let world = &replay.world;
        let (rows, cols, pitch, heights) = ground(world);
        // Grid maps have square cells.
        if (pitch[0] - pitch[1]).abs() < 1e-9 * pitch[0] {
            let heights = HeightMap {
                frame: GridFrame {
                    rows: rows as u32,
                    cols: cols as u32,
                    resolution: pitch[0],
                    origin_x: -world.heightfield.half_x(),
                    origin_y: -world.heightfield.half_y(),
                },
                data: heights.into_iter().map(|z| z as f32).collect(),
            };
            self.log("/elevation_map", 0, &elevation_map(0, &heights, None))?;
        }
        if replay.has_goal {
            let points: Vec<Point2> = replay.task.path.iter().map(|p| Point2 { x: p[0], y: p[1] }).collect();
            let [x, y] = replay.task.goal;
            let plan = path(0, &points);
            let yaw = plan
                .poses
                .last()
                .map_or(0.0, |p| 2.0 * vb_math::atan2(p.pose.orientation.z, p.pose.orientation.w));
            self.log("/plan", 0, &plan)?;
            self.log("/goal_pose", 0, &pose_stamped(0, &Point2 { x, y }, yaw))?;
        }
        Ok(())
    }

    fn run(&mut self, run: &ReplayRun, prefix: &str) -> Result<(), String> {
        let named = |frame: &str| format!("{prefix}{frame}");
        let topic = |name: &str| format!("/{prefix}{name}");
        let wheels = run.motion.wheels;
        let joints: Vec<String> = (0..wheels).map(wheel_joint).collect();
        let mut before: Option<(f64, &[WheelFrame])> = None;
        for (k, f) in run.motion.frames.iter().enumerate() {
            let (now, pose) = (seconds(f.time), pose_of(f));
            let mut truth = odometry(now, &pose);
            truth.header.frame_id = frame::MAP.to_owned();
            truth.child_frame_id = named(frame::BASE);
            let rotation = quaternion(pose.roll, pose.pitch, pose.yaw);
            let place = transform(now, frame::MAP, &named(frame::BASE), &pose.position, rotation);
            self.log("/tf", now, &TFMessage { transforms: vec![place] })?;
            self.log(&topic("ground_truth"), now, &truth)?;
            let controls = JointState {
                header: header(now, ""),
                name: ["steering", "throttle", "brake"].map(str::to_owned).into(),
                position: vec![f.steering, f.throttle, f.brake],
                ..JointState::default()
            };
            self.log(&topic("controls"), now, &controls)?;
            let Some(turned) = run.motion.wheel_frames.get(k * wheels..(k + 1) * wheels) else { continue };
            let states = JointState {
                header: header(now, ""),
                name: joints.clone(),
                position: turned.iter().map(|wheel| wheel.angle).collect(),
                velocity: before.map_or_else(
                    || vec![0.0; wheels],
                    |(time, old)| {
                        turned.iter().zip(old).map(|(a, b)| (a.angle - b.angle) / (f.time - time)).collect()
                    },
                ),
                ..JointState::default()
            };
            self.log(&topic("joint_states"), now, &states)?;
            before = Some((f.time, turned));
        }
        self.sensors(&run.sensed, prefix)?;
        let data = format!("{}: {}", run.record.outcome, run.record.explanation());
        self.log(&topic("outcome"), seconds(run.motion.end()), &Text { data })
    }

    fn sensors(&mut self, sensed: &Sensed, prefix: &str) -> Result<(), String> {
        let named = |frame: &str| format!("{prefix}{frame}");
        let topic = |name: &str| format!("/{prefix}{name}");
        let at = |parent: &str, child: &str, mount: &Mount| {
            let rotation = quaternion(mount.roll, mount.pitch, mount.yaw);
            transform(0, &named(parent), &named(child), &mount.position, rotation)
        };
        let mut fixed = Vec::new();
        if !sensed.poses.is_empty() {
            fixed.push(transform(
                0,
                frame::MAP,
                &named(frame::ODOM),
                &Vec3::default(),
                quaternion(0.0, 0.0, 0.0),
            ));
        }
        if let Some(lidar) = &sensed.lidar {
            fixed.push(at(frame::BASE, frame::LIDAR, &lidar.mount));
        }
        if let Some(depth) = &sensed.depth {
            fixed.push(at(frame::BASE, frame::CAMERA, &depth.mount));
            let (camera, optical) = (named(frame::CAMERA), named(frame::OPTICAL));
            fixed.push(transform(0, &camera, &optical, &Vec3::default(), optical_rotation()));
        }
        if !sensed.imu.is_empty() {
            fixed.push(at(frame::BASE, frame::IMU, &Mount::default()));
        }
        if !sensed.fixes.is_empty() {
            fixed.push(at(frame::BASE, frame::GNSS, &Mount::default()));
        }
        if !fixed.is_empty() {
            self.log("/tf_static", 0, &TFMessage { transforms: fixed })?;
        }
        for (time, pose) in &sensed.poses {
            let now = seconds(*time);
            let mut estimate = odometry(now, pose);
            estimate.header.frame_id = named(frame::ODOM);
            estimate.child_frame_id = named(frame::BASE);
            self.log(&topic("odom"), now, &estimate)?;
        }
        for sample in &sensed.imu {
            let now = seconds(sample.time);
            let mut message = imu(now, sample);
            message.header.frame_id = named(frame::IMU);
            self.log(&topic("imu/data"), now, &message)?;
        }
        for fix in &sensed.fixes {
            let now = seconds(fix.time);
            let mut message = nav_sat_fix(now, &fix.position, &Datum::default());
            message.header.frame_id = named(frame::GNSS);
            self.log(&topic("gps/fix"), now, &message)?;
        }
        if let Some(info) = &sensed.lidar {
            for scan in &sensed.scans {
                let now = seconds(scan.time);
                let mut message = point_cloud(now, info, scan);
                message.header.frame_id = named(frame::LIDAR);
                self.log(&topic("points"), now, &message)?;
            }
        }
        if let Some(info) = &sensed.depth {
            for image in &sensed.images {
                let now = seconds(image.time);
                let mut message = depth_image(now, info, image);
                message.header.frame_id = named(frame::OPTICAL);
                let mut calibration = camera_info(now, info);
                calibration.header.frame_id = named(frame::OPTICAL);
                self.log(&topic("camera/depth"), now, &message)?;
                self.log(&topic("camera/camera_info"), now, &calibration)?;
            }
        }
        for map in &sensed.maps {
            let now = seconds(map.time);
            self.log(&topic("map"), now, &occupancy_grid(now, &map.occupancy))?;
            let heights = elevation_map(now, &map.elevation, Some(&map.semantics));
            self.log(&topic("local_elevation_map"), now, &heights)?;
        }
        Ok(())
    }
}
