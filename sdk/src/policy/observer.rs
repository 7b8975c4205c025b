//! Observations of a policy.

use super::layout::{Fill, Layout, Part};
use crate::crop::Window;
use crate::path::{Follower, Path};
use crate::{
    DepthImage, Gear, GnssFix, ImuSample, LidarScan, LocalMap, Observation, PlannerError, Point2, Pose, Task,
    Wheel, math,
};

/// Mean friction coefficient of each terrain class, by label, from the generator's rules
/// (`tasks/generator/default.yaml`); 0 for mud, sand and snow, which are deformable.
const USUAL_FRICTION: [f32; 10] = [0.60, 0.85, 0.60, 0.36, 0.55, 0.65, 0.45, 0.0, 0.0, 0.0];
/// The label of an obstacle.
const OBSTACLE: u8 = 10;
/// The label outside the world, and of unknown cells.
const UNKNOWN: u8 = 255;
/// Search window for the vehicle's progress along the path, m at scale 1.
const WINDOW: f64 = 8.0;

/// The destination of a part's numbers.
#[derive(Debug)]
pub enum Row<'a> {
    /// For a part of [`Dtype::F32`](super::Dtype::F32).
    F32(&'a mut [f32]),
    /// For a part of [`Dtype::U8`](super::Dtype::U8).
    U8(&'a mut [u8]),
}

/// Stores the last measurements, and converts them to arrays. It serves one task.
#[derive(Clone, Debug)]
pub struct Observer {
    follower: Follower,
    /// The position of the vehicle on the maps.
    window: Window,
    spacing: f64,
    pose: Pose,
    /// Commands and state of vehicle and engine.
    steering: f64,
    engine_speed: f64,
    gear: Gear,
    command: [f64; 3],
    wheels: Vec<Wheel>,
    imu: Vec<ImuSample>,
    gnss: GnssFix,
    lidar: Option<LidarScan>,
    depth: Option<DepthImage>,
    local_map: Option<LocalMap>,
}

impl Observer {
    /// Creates an observer of a task, for arrays of this layout.
    ///
    /// # Errors
    /// Returns an error for an invalid path of the task.
    pub fn new(task: &Task, layout: &Layout) -> Result<Self, PlannerError> {
        let (sight, scale) = (layout.sight(), task.vehicle.scale);
        let mut points = task.path.clone();
        // The path's last point may be slightly before the goal.
        points.push(task.goal);
        Ok(Self {
            follower: Follower::new(Path::new(&points)?, WINDOW * scale),
            window: sight.window(scale),
            spacing: sight.spacing * scale,
            pose: Pose::default(),
            steering: 0.0,
            engine_speed: 0.0,
            gear: Gear::Forward,
            command: [0.0; 3],
            wheels: Vec::new(),
            imu: Vec::new(),
            gnss: GnssFix::default(),
            lidar: None,
            depth: None,
            local_map: None,
        })
    }

    /// Updates the measurements. Values without a new measurement are unchanged; the IMU means are those of the latest
    /// observation with IMU measurements.
    pub fn look(&mut self, observation: &Observation) {
        let o = observation;
        if let Some(pose) = o.pose {
            self.pose = pose;
            self.follower.update(pose.position.x, pose.position.y);
        }
        (self.steering, self.engine_speed, self.gear) = (o.steering, o.engine_speed, o.gear);
        self.command = [o.last_steering, o.last_throttle, o.last_brake];
        if !o.wheels.is_empty() {
            self.wheels.clone_from(&o.wheels);
        }
        if !o.imu.is_empty() {
            self.imu.clone_from(&o.imu);
        }
        if let Some(gnss) = o.gnss {
            self.gnss = gnss;
        }
        if o.lidar.is_some() {
            self.lidar.clone_from(&o.lidar);
        }
        if o.depth.is_some() {
            self.depth.clone_from(&o.depth);
        }
        if o.local_map.is_some() {
            self.local_map.clone_from(&o.local_map);
        }
    }

    /// The remaining length of the path after the vehicle's progress, m.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        self.follower.remaining()
    }

    /// Writes the numbers of a part. Numbers without a measurement are 0 or unknown. A row that is too short takes the
    /// first numbers, and a row of another type none.
    pub fn fill(&self, task: &Task, part: &Part, row: Row<'_>) {
        match row {
            Row::F32(to) => self.numbers(task, part, to),
            Row::U8(to) => self.labels(task, part, to),
        }
    }

    /// Writes a flat observation: all parts of 32-bit floats in order, each number divided by its normalisation scale
    /// ([`Entry::usual`](super::Entry::usual)) and clamped to ±[`Layout::FLAT_BOUND`].
    pub fn flat(&self, task: &Task, layout: &Layout, to: &mut [f32]) {
        let mut at = 0;
        for (_, part) in layout.flat_parts() {
            let end = (at + part.width()).min(to.len());
            let row = &mut to[at..end];
            self.numbers(task, part, row);
            for (k, value) in row.iter_mut().enumerate() {
                let scaled = *value / part.entry(k).usual as f32;
                *value = scaled.clamp(-Layout::FLAT_BOUND, Layout::FLAT_BOUND);
            }
            at = end;
        }
    }

    fn numbers(&self, task: &Task, part: &Part, to: &mut [f32]) {
        let p = &self.pose;
        let mut write = |values: &mut dyn Iterator<Item = f64>| {
            for (to, value) in to.iter_mut().zip(values) {
                *to = value as f32;
            }
        };
        match part.fill {
            Fill::State => {
                let (v, w) = (p.linear_velocity, p.angular_velocity);
                let gear = self.gear.direction();
                let moving = [p.roll, p.pitch, v.x, v.y, v.z, w.x, w.y, w.z];
                write(&mut moving.into_iter().chain([self.steering, self.engine_speed, gear]));
            }
            Fill::Pose => write(&mut [p.position.x, p.position.y, p.position.z, p.yaw].into_iter()),
            Fill::Goal => write(&mut self.seen(task.goal).into_iter()),
            Fill::Path => {
                let point = |k: usize| self.follower.look_ahead((k + 1) as f64 * self.spacing);
                write(&mut (0..part.width() / 2).flat_map(|k| self.seen(point(k))));
            }
            Fill::Wheels => {
                let missing = std::iter::repeat(0.0);
                write(&mut self.wheels.iter().flat_map(|w| [w.spin, w.travel]).chain(missing));
            }
            Fill::LastCommand => write(&mut self.command.into_iter()),
            Fill::Imu => write(&mut self.mean_of_imu().into_iter()),
            Fill::Gnss => {
                let at = self.gnss.position;
                write(&mut [at.x, at.y, at.z].into_iter());
            }
            Fill::Height => match &task.elevation {
                Some(map) if map.frame.rows >= 2 && map.frame.cols >= 2 => {
                    let under = map.ground(p.position.x, p.position.y).z;
                    write(&mut self.places().map(|[x, y]| map.ground(x, y).z - under));
                }
                _ => to.fill(0.0),
            },
            Fill::Friction => write(&mut self.places().map(|at| f64::from(friction(task, at)))),
            Fill::LocalHeight => match &self.local_map {
                Some(map) if !map.elevation.data.is_empty() => {
                    let seen = |x: f64, y: f64| {
                        let z = if map.elevation.frame.covers(x, y) {
                            map.elevation.nearest(x, y)
                        } else {
                            f32::NAN
                        };
                        f64::from(z)
                    };
                    let own = seen(p.position.x, p.position.y);
                    let under = if own.is_nan() { p.position.z } else { own };
                    let height = |z: f64| if z.is_nan() { 0.0 } else { z - under };
                    write(&mut self.places().map(|[x, y]| height(seen(x, y))));
                }
                _ => to.fill(0.0),
            },
            Fill::Lidar => copy(self.lidar.as_ref().map(|l| l.ranges.as_slice()), to, 0.0),
            Fill::Depth => copy(self.depth.as_ref().map(|d| d.depths.as_slice()), to, 0.0),
            Fill::Class | Fill::LocalClass | Fill::DepthLabels => {}
        }
    }

    fn labels(&self, task: &Task, part: &Part, to: &mut [u8]) {
        match part.fill {
            Fill::Class => {
                for (to, at) in to.iter_mut().zip(self.places()) {
                    *to = class(task, at);
                }
            }
            Fill::LocalClass => {
                let Some(map) = self.local_map.as_ref().filter(|m| !m.semantics.data.is_empty()) else {
                    return to.fill(UNKNOWN);
                };
                for (to, [x, y]) in to.iter_mut().zip(self.places()) {
                    *to = if !map.semantics.frame.covers(x, y) {
                        UNKNOWN
                    } else if !map.occupancy.data.is_empty() && map.occupancy.nearest(x, y) == 1 {
                        OBSTACLE
                    } else {
                        map.semantics.nearest(x, y)
                    };
                }
            }
            Fill::DepthLabels => copy(self.depth.as_ref().map(|d| d.labels.as_slice()), to, UNKNOWN),
            _ => {}
        }
    }

    /// A point of the world in the vehicle's heading frame: metres forward and to the left.
    fn seen(&self, point: Point2) -> [f64; 2] {
        let (sin, cos) = math::sin_cos(self.pose.yaw);
        let (dx, dy) = (point.x - self.pose.position.x, point.y - self.pose.position.y);
        [cos * dx + sin * dy, cos * dy - sin * dx]
    }

    /// The positions of a crop's samples in the world, row by row.
    fn places(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let (window, at) = (self.window, self.pose.position);
        let (sin, cos) = math::sin_cos(self.pose.yaw);
        (0..window.rows * window.cols).map(move |k| {
            let (forward, left) = window.body_position(k / window.cols, k % window.cols);
            [at.x + cos * forward - sin * left, at.y + sin * forward + cos * left]
        })
    }

    fn mean_of_imu(&self) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for sample in &self.imu {
            let (f, w) = (sample.specific_force, sample.angular_velocity);
            for (sum, value) in sum.iter_mut().zip([f.x, f.y, f.z, w.x, w.y, w.z]) {
                *sum += value;
            }
        }
        sum.map(|s| s / self.imu.len().max(1) as f64)
    }
}

/// The terrain class at a position, from the task's maps.
fn class(task: &Task, [x, y]: [f64; 2]) -> u8 {
    let half = task.half_extent;
    let Some(map) = task.semantics.as_ref().filter(|m| !m.data.is_empty()) else { return UNKNOWN };
    if x.abs() > half.x || y.abs() > half.y {
        return UNKNOWN;
    }
    if task.occupancy.as_ref().is_some_and(|o| !o.data.is_empty() && o.nearest(x, y) == 1) {
        return OBSTACLE;
    }
    map.nearest(x, y)
}

fn friction(task: &Task, at: [f64; 2]) -> f32 {
    USUAL_FRICTION.get(usize::from(class(task, at))).copied().unwrap_or(0.0)
}

/// Copies the available numbers, and fills the rest.
fn copy<T: Copy>(from: Option<&[T]>, to: &mut [T], rest: T) {
    let from = from.unwrap_or_default();
    let n = from.len().min(to.len());
    to[..n].copy_from_slice(&from[..n]);
    to[n..].fill(rest);
}
