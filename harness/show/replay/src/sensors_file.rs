//! What sensors measured, as topics of an MCAP file with Foxglove's schemas.

use std::sync::Arc;

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    CameraCalibration, FrameTransform, FrameTransforms, Grid, Odometry, PackedElementField, PointCloud, Pose,
    PoseInFrame, Quaternion, RawImage, Vector2,
};
use foxglove::{ChannelBuilder, Context};
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::json;
use vb_sdk::{DepthImage, DepthInfo, LidarInfo, LidarScan, LocalMap, Mount};

use crate::grains::Grains;
use crate::messages::{WORLD, at, json_channel, pose, quaternion, vector};
use crate::scene::label_colour;
use crate::sensed::Sensed;

/// JSON Schema of the topic `imu`.
const IMU_SCHEMA: &str = r#"{"title":"vb.Imu","type":"object","properties":{
"specific_force":{"type":"array","items":{"type":"number"},"description":"m/s2, body axes x forward, y left, z up"},
"angular_velocity":{"type":"array","items":{"type":"number"},"description":"rad/s, body axes"}}}"#;

/// The attitude of three angles: heading first, then pitch, then roll.
fn turned(roll: f64, pitch: f64, yaw: f64) -> UnitQuaternion<f64> {
    let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    about(Vector3::z_axis(), yaw) * about(Vector3::y_axis(), pitch) * about(Vector3::x_axis(), roll)
}

/// The frame of a camera: z along its axis, x to the right, y down.
fn optical(mount: &Mount) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let body = turned(mount.roll, mount.pitch, mount.yaw);
    // Its axes in those of the mount: to the right is -y, down is -z, ahead is x.
    let axes = nalgebra::Matrix3::from_columns(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    let turn = UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes));
    let p = mount.position;
    (Vector3::new(p.x, p.y, p.z), body * turn)
}

/// Writes the topics of a run's sensors: `lidar` (points in the vehicle's frame as it was when each was measured, with the
/// time before the end of the scan), `depth/image`, `depth/labels` and `depth/calibration`, `local_map` (in the frame of the
/// estimate, which is the world's but for its error), `estimate`, `gnss` and `imu`.
pub(crate) fn write_sensors(
    sensed: &Sensed,
    frame: &str,
    context: &Arc<Context>,
) -> Result<(), foxglove::FoxgloveError> {
    if let Some(info) = &sensed.lidar {
        let lidar = ChannelBuilder::new(format!("/{frame}/lidar")).context(context).build::<PointCloud>();
        for scan in &sensed.scans {
            lidar.log_with_meta(&cloud(info, scan, frame), at(scan.time).1);
        }
    }
    if let Some(info) = &sensed.depth {
        depth(sensed, info, frame, context);
    }
    if !sensed.maps.is_empty() {
        let grid = ChannelBuilder::new(format!("/{frame}/local_map")).context(context).build::<Grid>();
        for map in &sensed.maps {
            grid.log_with_meta(&local_map(map), at(map.time).1);
        }
    }
    if !sensed.poses.is_empty() {
        let estimate = ChannelBuilder::new(format!("/{frame}/estimate")).context(context).build::<Odometry>();
        for (time, p) in &sensed.poses {
            let (stamp, meta) = at(*time);
            let vector_of = |v: vb_sdk::Vec3| Some(vector([v.x, v.y, v.z]));
            let message = Odometry {
                timestamp: Some(stamp),
                frame_id: WORLD.into(),
                body_frame_id: format!("{frame}/estimate"),
                pose: Some(Pose {
                    position: vector_of(p.position),
                    orientation: Some(quaternion(turned(p.roll, p.pitch, p.yaw))),
                }),
                linear_velocity: vector_of(p.linear_velocity),
                angular_velocity: vector_of(p.angular_velocity),
                ..Odometry::default()
            };
            estimate.log_with_meta(&message, meta);
        }
    }
    if !sensed.fixes.is_empty() {
        let gnss = ChannelBuilder::new(format!("/{frame}/gnss")).context(context).build::<PoseInFrame>();
        for fix in &sensed.fixes {
            let (stamp, meta) = at(fix.time);
            let at = [fix.position.x, fix.position.y, fix.position.z];
            let message =
                PoseInFrame { timestamp: Some(stamp), frame_id: WORLD.into(), pose: Some(pose(at)) };
            gnss.log_with_meta(&message, meta);
        }
    }
    if !sensed.imu.is_empty() {
        let imu = json_channel(format!("/{frame}/imu"), ("vb.Imu", IMU_SCHEMA), context)?;
        for m in &sensed.imu {
            let of = |v: vb_sdk::Vec3| [v.x, v.y, v.z];
            let message =
                json!({"specific_force": of(m.specific_force), "angular_velocity": of(m.angular_velocity)});
            imu.log_with_meta(message.to_string().as_bytes(), at(m.time).1);
        }
    }
    Ok(())
}

fn fields<const N: usize>(all: [(&str, NumericType, u32); N]) -> Vec<PackedElementField> {
    let mut offset = 0;
    let mut field = |(name, kind, bytes): (&str, NumericType, u32)| {
        let field = PackedElementField { name: name.into(), offset, r#type: kind as i32 };
        offset += bytes;
        field
    };
    all.map(&mut field).into()
}

fn cloud(info: &LidarInfo, scan: &LidarScan, frame: &str) -> PointCloud {
    let mut data = Vec::new();
    for (row, col, p) in info.points(scan) {
        let before = (1.0 - (f64::from(col) + 0.5) / f64::from(info.cols)) * info.period;
        for v in [p.x, p.y, p.z, -before] {
            data.extend((v as f32).to_le_bytes());
        }
        data.extend((row as u16).to_le_bytes());
        data.extend((col as u16).to_le_bytes());
    }
    PointCloud {
        timestamp: Some(at(scan.time).0),
        frame_id: frame.into(),
        pose: Some(pose([0.0; 3])),
        point_stride: 20,
        fields: fields([
            ("x", NumericType::Float32, 4),
            ("y", NumericType::Float32, 4),
            ("z", NumericType::Float32, 4),
            ("time", NumericType::Float32, 4),
            ("row", NumericType::Uint16, 2),
            ("column", NumericType::Uint16, 2),
        ]),
        data: data.into(),
    }
}

/// Time between two clouds of grains, s: the whole cloud is in each.
const GRAINS_PERIOD: f64 = 0.5;

/// Writes the grains of granular beds until the end (s), as clouds of centres with radii in world axes; none where there are no grains.
pub(crate) fn write_grains(grains: &Grains, end: f64, frame: &str, context: &Arc<Context>) {
    if grains.radii.is_empty() {
        return;
    }
    let topic = ChannelBuilder::new(format!("/{frame}/grains")).context(context).build::<PointCloud>();
    let last = grains.moves.last().map_or(0.0, |m| m.time).min(end);
    for k in 0..=(last / GRAINS_PERIOD).ceil() as u32 {
        let time = (GRAINS_PERIOD * f64::from(k)).min(end);
        let (stamp, meta) = at(time);
        let mut data = Vec::with_capacity(16 * grains.radii.len());
        for (centre, radius) in grains.at(time) {
            for v in centre.into_iter().chain([radius]) {
                data.extend((v as f32).to_le_bytes());
            }
        }
        let message = PointCloud {
            timestamp: Some(stamp),
            frame_id: WORLD.into(),
            pose: Some(pose([0.0; 3])),
            point_stride: 16,
            fields: fields(["x", "y", "z", "radius"].map(|name| (name, NumericType::Float32, 4))),
            data: data.into(),
        };
        topic.log_with_meta(&message, meta);
    }
}

fn depth(sensed: &Sensed, info: &DepthInfo, frame: &str, context: &Arc<Context>) {
    let topic = |name: &str| ChannelBuilder::new(format!("/{frame}/depth/{name}")).context(context);
    let (images, labels) = (topic("image").build::<RawImage>(), topic("labels").build::<RawImage>());
    let calibration = topic("calibration").build::<CameraCalibration>();
    let tf = topic("tf").build::<FrameTransforms>();
    let camera = format!("{frame}/depth");
    let (stamp, start) = at(0.0);
    let (position, turn) = optical(&info.mount);
    let transform = FrameTransform {
        timestamp: Some(stamp),
        parent_frame_id: frame.into(),
        child_frame_id: camera.clone(),
        translation: Some(vector(position.into())),
        rotation: Some(quaternion(turn)),
    };
    tf.log_with_meta(&FrameTransforms { transforms: vec![transform] }, start);
    let focal = f64::from(info.cols) / 2.0 / vb_math::tan(info.field_of_view / 2.0);
    let (cx, cy) = (f64::from(info.cols) / 2.0, f64::from(info.rows) / 2.0);
    for image in &sensed.images {
        let (stamp, meta) = at(image.time);
        let raw = |encoding: &str, step: u32, data: Vec<u8>| RawImage {
            timestamp: Some(stamp),
            frame_id: camera.clone(),
            width: info.cols,
            height: info.rows,
            encoding: encoding.into(),
            step,
            data: data.into(),
        };
        let depths = image.depths.iter().flat_map(|d| d.to_le_bytes()).collect();
        images.log_with_meta(&raw("32FC1", 4 * info.cols, depths), meta);
        if !image.labels.is_empty() {
            labels.log_with_meta(&raw("rgb8", 3 * info.cols, coloured(image)), meta);
        }
        let message = CameraCalibration {
            timestamp: Some(stamp),
            frame_id: camera.clone(),
            width: info.cols,
            height: info.rows,
            k: vec![focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0],
            r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: vec![focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..CameraCalibration::default()
        };
        calibration.log_with_meta(&message, meta);
    }
}

/// The labels of an image as colours.
fn coloured(image: &DepthImage) -> Vec<u8> {
    image.labels.iter().flat_map(|l| label_colour(*l)).collect()
}

fn local_map(map: &LocalMap) -> Grid {
    let f = map.elevation.frame;
    let mut data = Vec::new();
    let cells = map.elevation.data.iter().zip(&map.semantics.data).zip(&map.occupancy.data);
    for ((height, class), occupied) in cells {
        data.extend(height.to_le_bytes());
        data.extend([*class, *occupied]);
    }
    // A grid begins at the corner of its first cell, a map has its samples in the middle of cells.
    let corner = [f.origin_x - 0.5 * f.resolution, f.origin_y - 0.5 * f.resolution, 0.0];
    let upright = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    Grid {
        timestamp: Some(at(map.time).0),
        frame_id: WORLD.into(),
        pose: Some(Pose { position: Some(vector(corner)), orientation: Some(upright) }),
        column_count: f.cols,
        cell_size: Some(Vector2 { x: f.resolution, y: f.resolution }),
        row_stride: 6 * f.cols,
        cell_stride: 6,
        fields: fields([
            ("elevation", NumericType::Float32, 4),
            ("class", NumericType::Uint8, 1),
            ("occupancy", NumericType::Uint8, 1),
        ]),
        data: data.into(),
    }
}
