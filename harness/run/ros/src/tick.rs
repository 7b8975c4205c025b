//! The messages of a task and of an observation.

use vb_host::FaultCause;
use vb_rosmsg::convert::{
    camera_info, depth_image, elevation_map, frame, imu, joint_states, nav_sat_fix, occupancy_grid, odometry,
    optical_rotation, path, point_cloud, pose_stamped, quaternion, ros_time, seconds, transform,
};
use vb_rosmsg::messages::geometry_msgs::TransformStamped;
use vb_rosmsg::messages::rosgraph_msgs::Clock;
use vb_rosmsg::messages::std_msgs::String as Text;
use vb_rosmsg::messages::tf2_msgs::TFMessage;
use vb_rosmsg::urdf;
use vb_sdk::metadata::Sensor;
use vb_sdk::{LocalMap, Mount, Observation, Task, Vec3};

use crate::link::{Outgoing, send};
use crate::{Options, Pace};

/// The clock of the first task of a suite, and the time between the clocks of two tasks, s. Both exceed every time limit.
const FIRST: i64 = 10_000;
const APART: i64 = 10_000;
/// Tasks whose clocks differ; the seconds of ROS end at 2³¹.
const CLOCKS: usize = 200_000;

/// The time on `/clock` at the start of a task, ns.
pub(crate) fn start_of(options: &Options, task: &str) -> i64 {
    let place = options.places.get(task).copied().unwrap_or(0) % CLOCKS;
    (FIRST + APART * place as i64) * 1_000_000_000
}

/// The transforms that hold for all of a task.
fn fixed(options: &Options, task: &Task, now: i64) -> Vec<TransformStamped> {
    let still = |parent: &str, child: &str, mount: &Mount| {
        let rotation = quaternion(mount.roll, mount.pitch, mount.yaw);
        transform(now, parent, child, &mount.position, rotation)
    };
    let mut all = Vec::new();
    if options.has(Sensor::Pose) {
        // The estimate is in the world frame, and nothing corrects it.
        all.push(still(frame::MAP, frame::ODOM, &Mount::default()));
    }
    if options.has(Sensor::Imu) {
        all.push(still(frame::BASE, frame::IMU, &Mount::default()));
    }
    if options.has(Sensor::Gnss) {
        all.push(still(frame::BASE, frame::GNSS, &Mount::default()));
    }
    if let Some(lidar) = &task.lidar {
        all.push(still(frame::BASE, frame::LIDAR, &lidar.mount));
    }
    if let Some(depth) = &task.depth {
        all.push(still(frame::BASE, frame::CAMERA, &depth.mount));
        all.push(transform(now, frame::CAMERA, frame::OPTICAL, &Vec3::default(), optical_rotation()));
    }
    all
}

/// Publishes what holds for all of a task.
pub(crate) fn publish_task(
    out: &Outgoing,
    options: &Options,
    task: &Task,
    start: i64,
) -> Result<(), FaultCause> {
    send(
        &out.description,
        Text { data: urdf::description(&task.vehicle, task.lidar.as_ref(), task.depth.as_ref()) },
    )?;
    send(&out.tf_static, TFMessage { transforms: fixed(options, task, start) })?;
    if let Some(occupancy) = &task.occupancy {
        send(&out.map, occupancy_grid(start, occupancy))?;
    }
    if let Some(elevation) = &task.elevation {
        send(&out.elevation_map, elevation_map(start, elevation, task.semantics.as_ref()))?;
    }
    send(&out.task, Text { data: described(options, task, start) })?;
    send(&out.plan, path(start, &task.path))?;
    // The vehicle is to come as the path does.
    let yaw = match &task.path[..] {
        [.., before, last] => vb_sdk::math::atan2(last.y - before.y, last.x - before.x),
        _ => task.start.yaw,
    };
    send(&out.goal, pose_stamped(start, &task.goal, yaw))
}

/// A task as JSON, for nodes that want more than a goal.
fn described(options: &Options, task: &Task, start: i64) -> String {
    serde_json::json!({
        "state": "running",
        "task": task.id,
        "clock_start": start / 1_000_000_000,
        "control_period": task.control_period,
        "time_limit": task.time_limit,
        "start": [task.start.x, task.start.y, task.start.yaw],
        "goal": [task.goal.x, task.goal.y],
        "goal_radius": task.goal_radius,
        "half_extent": [task.half_extent.x, task.half_extent.y],
        "perception": task.perception,
        "vehicle": task.vehicle.name,
        "seed": task.seed.to_string(),
        "lockstep": options.pace == Pace::Lockstep,
    })
    .to_string()
}

/// Tells that a task is over.
pub(crate) fn publish_end(out: &Outgoing, task: &str) -> Result<(), FaultCause> {
    let data = serde_json::json!({ "state": "ended", "task": task }).to_string();
    send(&out.task, Text { data })
}

/// Publishes an observation, with the clock last. `start` is the time at which the task began, ns.
pub(crate) fn publish_tick(
    out: &Outgoing,
    options: &Options,
    task: &Task,
    start: i64,
    observation: &Observation,
) -> Result<(), FaultCause> {
    let at = |time: f64| start + seconds(time);
    let now = at(observation.time);
    if let Some(publisher) = &out.imu {
        for sample in &observation.imu {
            send(publisher, imu(at(sample.time), sample))?;
        }
    }
    if let (Some(publisher), Some(fix)) = (&out.fix, &observation.gnss) {
        send(publisher, nav_sat_fix(at(fix.time), &fix.position, &options.datum))?;
    }
    if let (Some(publisher), Some(info), Some(scan)) = (&out.points, &task.lidar, &observation.lidar) {
        send(publisher, point_cloud(at(scan.time), info, scan))?;
    }
    if let (Some((images, calibration)), Some(info), Some(image)) =
        (&out.depth, &task.depth, &observation.depth)
    {
        send(calibration, camera_info(at(image.time), info))?;
        send(images, depth_image(at(image.time), info, image))?;
    }
    if let Some(map) = &observation.local_map {
        publish_local_map(out, task, at(map.time), map)?;
    }
    if let Some(publisher) = &out.joints
        && !observation.wheels.is_empty()
    {
        send(publisher, joint_states(now, &observation.wheels))?;
    }
    if let Some(pose) = &observation.pose {
        if let Some(publisher) = &out.tf {
            let rotation = quaternion(pose.roll, pose.pitch, pose.yaw);
            let place = transform(now, frame::ODOM, frame::BASE, &pose.position, rotation);
            send(publisher, TFMessage { transforms: vec![place] })?;
        }
        if let Some(publisher) = &out.odometry {
            send(publisher, odometry(now, pose))?;
        }
    }
    send(&out.clock, Clock { clock: ros_time(now) })
}

/// The map of the surroundings takes the place of maps that the profile does not give.
fn publish_local_map(out: &Outgoing, task: &Task, now: i64, map: &LocalMap) -> Result<(), FaultCause> {
    if task.occupancy.is_none() {
        send(&out.map, occupancy_grid(now, &map.occupancy))?;
    }
    if task.elevation.is_none() {
        send(&out.elevation_map, elevation_map(now, &map.elevation, Some(&map.semantics)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_of_a_task_depends_on_its_place_in_the_suite_alone() {
        let places = [("w001/t00".to_owned(), 0), ("w001/t01".to_owned(), 1)].into();
        let options = Options { places, ..Options::default() };
        assert_eq!(start_of(&options, "w001/t00"), 10_000_000_000_000);
        assert_eq!(start_of(&options, "w001/t01"), 20_000_000_000_000);
        let last = Options { places: [("t".to_owned(), CLOCKS - 1)].into(), ..Options::default() };
        assert!(i32::try_from(start_of(&last, "t") / 1_000_000_000 + APART).is_ok());
    }
}
