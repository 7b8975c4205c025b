//! What the vehicle's sensors measured, from a simulation repeated with them: the same numbers as the planner had.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Value, json};
use vb_record::Sample;
use vb_sdk::{DepthImage, DepthInfo, GnssFix, ImuSample, LidarInfo, LidarScan, LocalMap, Pose};
use vb_sense::Perception;
use vb_sense::rays::Scene;
use vb_sim::VehicleState;
use vb_world::World;

use crate::attitude::attitude;

/// The least time between two scans, images or maps that a page shows, s.
const SHOWN: f64 = 0.5;
/// The points of a scan that a page shows, at most.
const POINTS: usize = 8_000;
/// Bytes for the scans of a page, at most; of more, every second scan is left out until they fit.
const BYTES: usize = 8_000_000;

/// What to repeat with the simulation.
pub struct Sensors {
    /// The sensors, fresh.
    pub perception: Perception,
}

impl Sensors {
    /// What sensors see of a world, to make a [`Perception`] in it.
    #[must_use]
    pub fn scene(world: &Arc<World>) -> Arc<Scene> {
        Arc::new(Scene::new(world.clone()))
    }
}

/// What the sensors measured in one trial, each in the order of time.
#[derive(Clone, Debug, Default)]
pub struct Sensed {
    pub lidar: Option<LidarInfo>,
    pub depth: Option<DepthInfo>,
    pub scans: Vec<LidarScan>,
    pub images: Vec<DepthImage>,
    /// The local map each time that it was brought up to date.
    pub maps: Vec<LocalMap>,
    /// The estimates of the pose with their times, s; ten a second.
    pub poses: Vec<(f64, Pose)>,
    pub fixes: Vec<GnssFix>,
    pub imu: Vec<ImuSample>,
    /// Whether the estimate of the pose is the truth.
    pub exact: bool,
}

impl Sensed {
    #[must_use]
    pub(crate) fn new(perception: &Perception) -> Self {
        let (lidar, depth) = (perception.lidar_info(), perception.depth_info());
        Self { lidar, depth, exact: true, ..Self::default() }
    }

    /// Takes what was measured until a sample of the simulation.
    pub(crate) fn take(&mut self, perception: &mut Perception, state: &VehicleState) {
        let read = perception.read(state);
        self.scans.extend(read.lidar);
        self.images.extend(read.depth);
        self.maps.extend(read.local_map);
        self.fixes.extend(read.gnss);
        self.imu.extend(read.imu);
        if let Some(pose) = read.pose {
            let p = state.position;
            self.exact &= [pose.position.x, pose.position.y, pose.position.z] == [p.x, p.y, p.z];
            if self.poses.last().is_none_or(|(time, _)| state.time > time + 0.099) {
                self.poses.push((state.time, pose));
            }
        }
    }

    #[must_use]
    pub fn is_empty(&self) -> bool {
        let nothing = self.scans.is_empty() && self.images.is_empty() && self.maps.is_empty();
        nothing && self.fixes.is_empty() && self.imu.is_empty() && (self.exact || self.poses.is_empty())
    }

    /// For the page; `frames` are the true states. Scans, images and maps are thinned.
    pub(crate) fn json(&self, frames: &[Sample]) -> Value {
        let scans = thinned(&self.scans, |s| s.time);
        let each = scans.first().and(self.lidar.as_ref()).map_or(0, |info| 6 * shown_columns(info).1);
        let every = (scans.len() * each).div_ceil(BYTES).max(1);
        let scans: Vec<Value> = scans.iter().step_by(every).filter_map(|s| self.scan(s, frames)).collect();
        let images: Vec<Value> = thinned(&self.images, |i| i.time).iter().map(|i| self.image(i)).collect();
        let maps: Vec<Value> = thinned(&self.maps, |m| m.time).iter().map(|m| map(m)).collect();
        let poses = self
            .poses
            .iter()
            .filter(|_| !self.exact)
            .flat_map(|(t, p)| [*t, p.position.x, p.position.y, p.position.z, p.yaw]);
        let fixes = self.fixes.iter().flat_map(|f| [f.time, f.position.x, f.position.y, f.position.z]);
        json!({
            "scans": scans,
            "scans_of": self.scans.len(),
            "images": images,
            "images_of": self.images.len(),
            "image": self.depth.map(|d| json!([d.rows, d.cols, d.max_depth])),
            "maps": maps,
            "maps_of": self.maps.len(),
            "poses": floats(poses),
            "fixes": floats(fixes),
        })
    }

    /// A scan: time, the point about which it is, and its points around that in centimetres, each placed by where the vehicle
    /// truly was when it was measured.
    fn scan(&self, scan: &LidarScan, frames: &[Sample]) -> Option<Value> {
        let info = self.lidar.as_ref()?;
        let (every, _) = shown_columns(info);
        let (centre, _) = pose_at(frames, scan.time)?;
        let mut bytes = Vec::new();
        for (_, col, p) in info.points(scan).filter(|(_, col, _)| col.is_multiple_of(every)) {
            // As the interface has it: the column was measured so much before the end of the turn.
            let age = (1.0 - (f64::from(col) + 0.5) / f64::from(info.cols)) * info.period;
            let (place, turn) = pose_at(frames, scan.time - age)?;
            let world = turn * Vector3::new(p.x, p.y, p.z) + place;
            for v in (world - centre).iter() {
                let cm = (v * 100.0).round().clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16;
                bytes.extend(cm.to_le_bytes());
            }
        }
        Some(json!([scan.time, [centre.x, centre.y, centre.z], STANDARD.encode(bytes)]))
    }

    /// An image: time, depths in 255 steps up to the greatest, labels.
    fn image(&self, image: &DepthImage) -> Value {
        let most = self.depth.map_or(1.0, |d| d.max_depth);
        let depth = |d: &f32| (f64::from(*d) / most * 255.0).round().clamp(0.0, 255.0) as u8;
        let depths: Vec<u8> = image.depths.iter().map(depth).collect();
        json!([image.time, STANDARD.encode(depths), STANDARD.encode(&image.labels)])
    }
}

/// Each how many columns of a scan a page shows, and how many points these have at most.
fn shown_columns(info: &LidarInfo) -> (u32, usize) {
    let all = (info.rows * info.cols) as usize;
    let every = u32::try_from(all.div_ceil(POINTS)).unwrap_or(1).max(1);
    (every, all / every as usize)
}

/// Those with at least [`SHOWN`] between them.
fn thinned<T>(all: &[T], time: impl Fn(&T) -> f64) -> Vec<&T> {
    let mut kept: Vec<&T> = Vec::new();
    for one in all {
        if kept.last().is_none_or(|last| time(one) >= time(last) + SHOWN - 1e-9) {
            kept.push(one);
        }
    }
    kept
}

/// The vehicle's pose at a time, between the frames before and after it: a milliradian puts what is far away off by
/// centimetres.
fn pose_at(frames: &[Sample], time: f64) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let after = frames.partition_point(|f| f.time < time).min(frames.len().checked_sub(1)?);
    let (a, b) = (&frames[after.saturating_sub(1)], &frames[after]);
    let part = if b.time > a.time { ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0) } else { 1.0 };
    let place = |f: &Sample| Vector3::new(f.x, f.y, f.z);
    Some((place(a).lerp(&place(b), part), attitude(a).nlerp(&attitude(b), part)))
}

/// A map: time, rows, columns, resolution, x and y of its first sample, heights in centimetres (none: -32768), kinds of ground,
/// obstacles.
fn map(map: &LocalMap) -> Value {
    let f = map.elevation.frame;
    let cm = |z: &f32| {
        if z.is_finite() { (f64::from(*z) * 100.0).round().clamp(-32767.0, 32767.0) as i16 } else { i16::MIN }
    };
    let heights: Vec<u8> = map.elevation.data.iter().flat_map(|z| cm(z).to_le_bytes()).collect();
    json!([
        map.time,
        [f64::from(f.rows), f64::from(f.cols), f.resolution, f.origin_x, f.origin_y],
        STANDARD.encode(heights),
        STANDARD.encode(&map.semantics.data),
        STANDARD.encode(&map.occupancy.data),
    ])
}

fn floats(values: impl Iterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.flat_map(|v| (v as f32).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}
