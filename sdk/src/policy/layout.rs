//! The parts of observations, with shapes, units and bounds: the single list of them.

use crate::crop::Window;
use crate::metadata::{Need, Sensor};
use crate::{PlannerError, Task};
use std::f64::consts::{FRAC_PI_2, PI};

/// The data type of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dtype {
    /// 32-bit floats.
    F32,
    /// Labels from 0 to 255.
    U8,
}

/// The range of a number of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The name; empty for the numbers of a grid.
    pub name: &'static str,
    /// The unit; empty for dimensionless numbers.
    pub unit: &'static str,
    /// The minimum; −∞ if unbounded.
    pub low: f64,
    /// The maximum; ∞ if unbounded.
    pub high: f64,
    /// The normalisation scale, by which the number is divided in the flat observation.
    pub usual: f64,
}

/// The observation window: the sizes of crops and of the path ahead. Lengths are at full scale and are multiplied by a
/// world's scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The number of rows, and of columns, of map crops.
    pub cells: usize,
    /// The distance between neighbouring samples of a crop, m.
    pub resolution: f64,
    /// The distance from the vehicle to the centre of a crop, m, positive ahead.
    pub ahead: f64,
    /// The number of path points ahead.
    pub points: usize,
    /// The distance between path points along the path, m.
    pub spacing: f64,
}

impl Default for Sight {
    /// Crops of 16 × 16 samples at 1 m around the vehicle, and ten points of the path at 2 m.
    fn default() -> Self {
        Self { cells: 16, resolution: 1.0, ahead: 0.0, points: 10, spacing: 2.0 }
    }
}

impl Sight {
    /// The window of a crop at a scale.
    #[must_use]
    pub fn window(&self, scale: f64) -> Window {
        let resolution = self.resolution * scale;
        Window { rows: self.cells, cols: self.cells, resolution, ahead: self.ahead * scale }
    }

    fn check(&self) -> Result<(), PlannerError> {
        let within = |name: &str, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                return Ok(());
            }
            Err(PlannerError::from(format!("sight: {name}: {value} must lie in {low} to {high}")))
        };
        within("cells", self.cells as f64, 2.0, 256.0)?;
        within("resolution", self.resolution, 0.05, 10.0)?;
        within("ahead", self.ahead, -50.0, 50.0)?;
        within("points", self.points as f64, 1.0, 256.0)?;
        within("spacing", self.spacing, 0.1, 50.0)
    }
}

/// The source of a part's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    State,
    Pose,
    Goal,
    Path,
    Wheels,
    LastCommand,
    Height,
    Class,
    Friction,
    LocalHeight,
    LocalClass,
    Imu,
    Gnss,
    Lidar,
    Depth,
    DepthLabels,
}

/// A kind of part, identified by its name in [`Layout::new`].
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The name in [`Layout::new`].
    pub name: &'static str,
    /// Its meaning, in words.
    pub about: &'static str,
    /// The sensor that it needs in addition to the pose, which all parts may use.
    pub sensor: Option<Sensor>,
    pub(super) fill: Fill,
}

const fn kind(name: &'static str, sensor: Option<Sensor>, fill: Fill, about: &'static str) -> Kind {
    Kind { name, about, sensor, fill }
}

/// All kinds of parts.
pub const PARTS: [Kind; 16] = [
    kind(
        "state",
        None,
        Fill::State,
        "Attitude, velocity and angular velocity in body axes (x forward, y left, z up), wheel steering, engine speed, and engaged gear (-1 reverse, 0 neutral, 1 forward)",
    ),
    kind(
        "pose",
        None,
        Fill::Pose,
        "Position of the reference point in the world frame (x east, y north, z up) and heading",
    ),
    kind("goal", None, Fill::Goal, "Goal in the vehicle's heading frame (x forward, y left)"),
    kind(
        "path",
        None,
        Fill::Path,
        "Points ahead on the global path at equal distances, in the vehicle's heading frame (x forward, y left); the goal after the end of the path",
    ),
    kind(
        "wheels",
        Some(Sensor::WheelOdometry),
        Fill::Wheels,
        "Angular velocity, and suspension travel, positive in compression, of each wheel, front to back, left before right",
    ),
    kind("command", None, Fill::LastCommand, "Current command: steering, throttle and brake"),
    kind(
        "height",
        None,
        Fill::Height,
        "Terrain heights on a square aligned with the vehicle's heading, relative to the terrain height under its reference point; row 0 is the rearmost, column 0 the rightmost; from the task's elevation map",
    ),
    kind(
        "class",
        None,
        Fill::Class,
        "Terrain classes on that square: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow, 10 obstacle, 255 outside the world",
    ),
    kind(
        "friction",
        None,
        Fill::Friction,
        "Mean friction coefficient of those terrain classes; 0 on deformable terrain, at obstacles and outside the world",
    ),
    kind(
        "local_height",
        Some(Sensor::LocalMap),
        Fill::LocalHeight,
        "As height, from the local map of lidar and camera; 0 for unknown cells",
    ),
    kind(
        "local_class",
        Some(Sensor::LocalMap),
        Fill::LocalClass,
        "As class, from the local map; 255 for unknown cells",
    ),
    kind(
        "imu",
        Some(Sensor::Imu),
        Fill::Imu,
        "Means of specific force and angular velocity in body axes since the last observation",
    ),
    kind("gnss", Some(Sensor::Gnss), Fill::Gnss, "Last GNSS position, in the world frame"),
    kind(
        "lidar",
        Some(Sensor::Lidar),
        Fill::Lidar,
        "Distances of the last lidar scan, lowest beam first, counter-clockwise from straight behind; 0 without an echo",
    ),
    kind(
        "depth",
        Some(Sensor::Depth),
        Fill::Depth,
        "Last image of the depth camera, topmost row and leftmost column first; 0 without a measurement",
    ),
    kind(
        "depth_labels",
        Some(Sensor::Depth),
        Fill::DepthLabels,
        "Terrain classes of that image's pixels, as in class; 255 without a measurement",
    ),
];

/// A part of an observation, with its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of its [`Kind`].
    pub name: &'static str,
    /// Its meaning, in words.
    pub about: &'static str,
    /// The data type of its numbers.
    pub dtype: Dtype,
    /// The shape: `[n]` for a vector, `[n, 2]` for points or wheels, `[rows, cols]` for a grid.
    pub shape: Vec<usize>,
    /// The ranges of its numbers: one for each entry of the innermost axis, or a single one for all.
    pub entries: Vec<Entry>,
    pub(super) fill: Fill,
}

impl Part {
    /// The number of values: the product of the shape.
    #[must_use]
    pub fn width(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether it is a crop of a map: a square of [`Sight::cells`] rows and columns.
    #[must_use]
    pub fn is_crop(&self) -> bool {
        matches!(
            self.fill,
            Fill::Height | Fill::Class | Fill::Friction | Fill::LocalHeight | Fill::LocalClass
        )
    }

    /// The range of the number at an index.
    #[must_use]
    pub fn entry(&self, index: usize) -> &Entry {
        &self.entries[index % self.entries.len()]
    }
}

/// The parts of an observation, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    parts: Vec<Part>,
    sight: Sight,
}

const fn entry(name: &'static str, unit: &'static str, bound: f64, usual: f64) -> Entry {
    Entry { name, unit, low: -bound, high: bound, usual }
}

const ANY: f64 = f64::INFINITY;

const STATE: [Entry; 11] = [
    entry("roll", "rad", PI, 0.5),
    entry("pitch", "rad", FRAC_PI_2, 0.5),
    entry("vx", "m/s", ANY, 5.0),
    entry("vy", "m/s", ANY, 1.0),
    entry("vz", "m/s", ANY, 1.0),
    entry("wx", "rad/s", ANY, 1.0),
    entry("wy", "rad/s", ANY, 1.0),
    entry("wz", "rad/s", ANY, 1.0),
    entry("steering", "", 1.0, 1.0),
    Entry { name: "engine_speed", unit: "rad/s", low: 0.0, high: ANY, usual: 200.0 },
    entry("gear", "", 1.0, 1.0),
];
const POSE: [Entry; 4] = [
    entry("x", "m", ANY, 60.0),
    entry("y", "m", ANY, 60.0),
    entry("z", "m", ANY, 5.0),
    entry("yaw", "rad", PI, PI),
];
const GOAL: [Entry; 2] = [entry("forward", "m", ANY, 50.0), entry("left", "m", ANY, 50.0)];
const POINT: [Entry; 2] = [entry("forward", "m", ANY, 10.0), entry("left", "m", ANY, 10.0)];
const WHEEL: [Entry; 2] = [entry("spin", "rad/s", ANY, 10.0), entry("travel", "m", ANY, 0.1)];
const COMMAND: [Entry; 3] = [
    entry("steering", "", 1.0, 1.0),
    Entry { name: "throttle", unit: "", low: 0.0, high: 1.0, usual: 1.0 },
    Entry { name: "brake", unit: "", low: 0.0, high: 1.0, usual: 1.0 },
];
const IMU: [Entry; 6] = [
    entry("fx", "m/s^2", ANY, 5.0),
    entry("fy", "m/s^2", ANY, 5.0),
    entry("fz", "m/s^2", ANY, 10.0),
    entry("wx", "rad/s", ANY, 1.0),
    entry("wy", "rad/s", ANY, 1.0),
    entry("wz", "rad/s", ANY, 1.0),
];
const GNSS: [Entry; 3] = [entry("x", "m", ANY, 60.0), entry("y", "m", ANY, 60.0), entry("z", "m", ANY, 5.0)];
const HEIGHT: [Entry; 1] = [entry("", "m", ANY, 2.0)];
const CLASS: [Entry; 1] = [Entry { name: "", unit: "", low: 0.0, high: 255.0, usual: 1.0 }];
const FRICTION: [Entry; 1] = [Entry { name: "", unit: "", low: 0.0, high: 1.0, usual: 1.0 }];
const RANGE: [Entry; 1] = [Entry { name: "", unit: "m", low: 0.0, high: ANY, usual: 20.0 }];

impl Layout {
    /// The bound of the numbers in a flat observation.
    pub const FLAT_BOUND: f32 = 5.0;

    /// Creates a layout of the named parts, for tasks with the same vehicle and perception profile.
    ///
    /// # Errors
    /// Returns an error for an unknown or duplicate name, an invalid size, and a part that needs data omitted by the
    /// task's perception profile.
    pub fn new(names: &[impl AsRef<str>], sight: Sight, task: &Task) -> Result<Self, PlannerError> {
        sight.check()?;
        if names.is_empty() {
            return Err("an observation needs at least one part".into());
        }
        let mut parts: Vec<Part> = Vec::new();
        for name in names {
            let name = name.as_ref();
            let Some(kind) = PARTS.iter().find(|k| k.name == name) else {
                let known = PARTS.map(|k| k.name).join(", ");
                return Err(format!("no part {name} of an observation (parts: {known})").into());
            };
            if parts.iter().any(|p| p.name == name) {
                return Err(format!("the part {name} of the observation is named twice").into());
            }
            parts.push(part(kind, &sight, task)?);
        }
        Ok(Self { parts, sight })
    }

    /// The sensors of the named parts. The pose is always included; unknown names are ignored.
    #[must_use]
    pub fn needs(names: &[impl AsRef<str>]) -> Vec<Need> {
        let mut needs = vec![Need { sensor: Sensor::Pose, rate: None }];
        for kind in PARTS.iter().filter(|k| names.iter().any(|n| n.as_ref() == k.name)) {
            if let Some(sensor) = kind.sensor.filter(|s| needs.iter().all(|n| n.sensor != *s)) {
                needs.push(Need { sensor, rate: None });
            }
        }
        needs
    }

    /// The parts, in the given order.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The observation window.
    #[must_use]
    pub fn sight(&self) -> &Sight {
        &self.sight
    }

    /// The parts of a flat observation: those of 32-bit floats, in order.
    pub fn flat_parts(&self) -> impl Iterator<Item = (usize, &Part)> {
        self.parts.iter().enumerate().filter(|(_, p)| p.dtype == Dtype::F32)
    }

    /// The size of a flat observation.
    #[must_use]
    pub fn flat_width(&self) -> usize {
        self.flat_parts().map(|(_, p)| p.width()).sum()
    }
}

fn part(kind: &Kind, sight: &Sight, task: &Task) -> Result<Part, PlannerError> {
    let missing = |what: &str| {
        let (name, profile) = (kind.name, &task.perception);
        Err(format!("the part {name} needs {what}, which the perception profile {profile} omits").into())
    };
    let f32s = |shape: Vec<usize>, entries: &[Entry]| (Dtype::F32, shape, entries.to_vec());
    let crop = vec![sight.cells, sight.cells];
    let wheels = task.vehicle.wheels as usize;
    let (dtype, shape, entries) = match kind.fill {
        Fill::State => f32s(vec![STATE.len()], &STATE),
        Fill::Pose => f32s(vec![POSE.len()], &POSE),
        Fill::Goal => f32s(vec![GOAL.len()], &GOAL),
        Fill::Path => f32s(vec![sight.points, 2], &POINT),
        Fill::Wheels => f32s(vec![wheels, 2], &WHEEL),
        Fill::LastCommand => f32s(vec![COMMAND.len()], &COMMAND),
        Fill::Height if task.elevation.is_none() => return missing("an elevation map"),
        Fill::Class | Fill::Friction if task.semantics.is_none() => {
            return missing("a map of terrain classes");
        }
        Fill::Height | Fill::LocalHeight => f32s(crop, &HEIGHT),
        Fill::Class | Fill::LocalClass => (Dtype::U8, crop, CLASS.to_vec()),
        Fill::Friction => f32s(crop, &FRICTION),
        Fill::Imu => f32s(vec![IMU.len()], &IMU),
        Fill::Gnss => f32s(vec![GNSS.len()], &GNSS),
        Fill::Lidar => match &task.lidar {
            Some(l) => f32s(vec![l.rows as usize, l.cols as usize], &RANGE),
            None => return missing("a lidar"),
        },
        Fill::Depth => match &task.depth {
            Some(d) => f32s(vec![d.rows as usize, d.cols as usize], &RANGE),
            None => return missing("a depth camera"),
        },
        Fill::DepthLabels => match &task.depth {
            Some(d) if d.labels => (Dtype::U8, vec![d.rows as usize, d.cols as usize], CLASS.to_vec()),
            _ => return missing("a depth camera with labels"),
        },
    };
    let Kind { name, about, fill, .. } = *kind;
    Ok(Part { name, about, dtype, shape, entries, fill })
}
