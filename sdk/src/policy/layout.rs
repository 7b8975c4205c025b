//! The parts of which an observation can be made, with shapes, units and bounds: the one list of them.

use crate::crop::Window;
use crate::metadata::{Need, Sensor};
use crate::{PlannerError, Task};
use std::f64::consts::{FRAC_PI_2, PI};

/// The kind of number that a part has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dtype {
    /// Numbers of 32 bits.
    F32,
    /// Labels from 0 to 255.
    U8,
}

/// What a number of a part may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The name; empty for the numbers of a grid.
    pub name: &'static str,
    /// The unit; empty where there is none.
    pub unit: &'static str,
    /// The least value; −∞ where there is none.
    pub low: f64,
    /// The greatest value; ∞ where there is none.
    pub high: f64,
    /// The size that it usually has, by which it is divided for the flat observation.
    pub usual: f64,
}

/// The sizes of what is seen of the surroundings. Lengths are those of the full-size world and are multiplied by a world's
/// scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The number of rows, and of columns, of crops of maps.
    pub cells: usize,
    /// The distance between neighbouring samples of a crop, m.
    pub resolution: f64,
    /// The distance by which the middle of a crop lies ahead of the vehicle, m.
    pub ahead: f64,
    /// The number of points of the path ahead.
    pub points: usize,
    /// The distance between two of them along the path, m.
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

/// How a part's numbers follow from what was seen.
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

/// A kind of part: what [`Layout::new`] takes by its name.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The name by which [`Layout::new`] takes it.
    pub name: &'static str,
    /// What it is, in words.
    pub about: &'static str,
    /// The sensor that it takes, beside the pose, which every part may use.
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
        "Attitude, velocity and angular velocity in body axes (x forward, y left, z up), steering that the wheels have, speed of the engine, and the gear that is in (-1 reverse, 0 neutral, 1 forward)",
    ),
    kind(
        "pose",
        None,
        Fill::Pose,
        "Position of the reference point in the world (x east, y north, z up) and heading",
    ),
    kind("goal", None, Fill::Goal, "The goal, as seen from the vehicle along its heading"),
    kind(
        "path",
        None,
        Fill::Path,
        "Points of the global path ahead at equal distances along it, as seen from the vehicle along its heading; the goal where the path has ended",
    ),
    kind(
        "wheels",
        Some(Sensor::WheelOdometry),
        Fill::Wheels,
        "Of each wheel, front to back, left before right: angular velocity, and suspension travel, positive in compression",
    ),
    kind(
        "command",
        None,
        Fill::LastCommand,
        "The command that holds until now: steering, throttle and brake",
    ),
    kind(
        "height",
        None,
        Fill::Height,
        "Heights of the ground on a square that turns with the vehicle's heading, less the height of the ground under its reference point; row 0 is the rearmost, column 0 the rightmost; from the map that the task comes with",
    ),
    kind(
        "class",
        None,
        Fill::Class,
        "Kinds of ground on that square: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow, 10 obstacle, 255 beyond the world",
    ),
    kind(
        "friction",
        None,
        Fill::Friction,
        "The usual friction coefficient of those kinds of ground; 0 where the ground yields, at obstacles and beyond the world",
    ),
    kind(
        "local_height",
        Some(Sensor::LocalMap),
        Fill::LocalHeight,
        "As height, from the map of the surroundings that lidar and camera build; 0 where nothing was seen",
    ),
    kind(
        "local_class",
        Some(Sensor::LocalMap),
        Fill::LocalClass,
        "As class, from the map of the surroundings; 255 where nothing was seen",
    ),
    kind(
        "imu",
        Some(Sensor::Imu),
        Fill::Imu,
        "Means of specific force and angular velocity in body axes since the last observation",
    ),
    kind("gnss", Some(Sensor::Gnss), Fill::Gnss, "The last position from satellites, in the world"),
    kind(
        "lidar",
        Some(Sensor::Lidar),
        Fill::Lidar,
        "Distances of the last turn of the lidar, lowest beam first, counter-clockwise from straight behind; 0 where nothing came back",
    ),
    kind(
        "depth",
        Some(Sensor::Depth),
        Fill::Depth,
        "The last image of the depth camera, topmost row and leftmost column first; 0 where nothing was measured",
    ),
    kind(
        "depth_labels",
        Some(Sensor::Depth),
        Fill::DepthLabels,
        "Kinds of ground of that image's pixels, as class has them; 255 where nothing was measured",
    ),
];

/// A part of an observation, with its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of its [`Kind`].
    pub name: &'static str,
    /// What it is, in words.
    pub about: &'static str,
    /// The kind of its numbers.
    pub dtype: Dtype,
    /// The shape: `[n]` for a vector, `[n, 2]` for points or wheels, `[rows, cols]` for a grid.
    pub shape: Vec<usize>,
    /// What the numbers may be: one for each of the innermost axis, or a single one for all.
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

    /// What the number at an index may be.
    #[must_use]
    pub fn entry(&self, index: usize) -> &Entry {
        &self.entries[index % self.entries.len()]
    }
}

/// The parts that an observation has, in order.
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
    /// The bound of the numbers of a flat observation.
    pub const FLAT_BOUND: f32 = 5.0;

    /// A layout of the named parts, for tasks that are like this one in vehicle and perception.
    ///
    /// # Errors
    /// Returns an error for a name that there isn't, or is there twice, for a size that makes no sense, and for a part of what
    /// the task's perception doesn't give.
    pub fn new(names: &[impl AsRef<str>], sight: Sight, task: &Task) -> Result<Self, PlannerError> {
        sight.check()?;
        if names.is_empty() {
            return Err("an observation takes one part at least".into());
        }
        let mut parts: Vec<Part> = Vec::new();
        for name in names {
            let name = name.as_ref();
            let Some(kind) = PARTS.iter().find(|k| k.name == name) else {
                let known = PARTS.map(|k| k.name).join(", ");
                return Err(
                    format!("there is no part {name} of an observation (take some of {known})").into()
                );
            };
            if parts.iter().any(|p| p.name == name) {
                return Err(format!("the part {name} of the observation is named twice").into());
            }
            parts.push(part(kind, &sight, task)?);
        }
        Ok(Self { parts, sight })
    }

    /// The sensors that the named parts take. The pose is always among them; names that there aren't are passed over.
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

    /// The parts, in the order in which they were named.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The sizes of what is seen of the surroundings.
    #[must_use]
    pub fn sight(&self) -> &Sight {
        &self.sight
    }

    /// The parts of a flat observation: those of 32-bit numbers, in order.
    pub fn flat_parts(&self) -> impl Iterator<Item = (usize, &Part)> {
        self.parts.iter().enumerate().filter(|(_, p)| p.dtype == Dtype::F32)
    }

    /// The number of numbers of a flat observation.
    #[must_use]
    pub fn flat_width(&self) -> usize {
        self.flat_parts().map(|(_, p)| p.width()).sum()
    }
}

fn part(kind: &Kind, sight: &Sight, task: &Task) -> Result<Part, PlannerError> {
    let missing = |what: &str| {
        let (name, profile) = (kind.name, &task.perception);
        Err(format!("the part {name} takes {what}, which the perception profile {profile} doesn't give")
            .into())
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
        Fill::Height if task.elevation.is_none() => return missing("a map of heights"),
        Fill::Class | Fill::Friction if task.semantics.is_none() => {
            return missing("a map of kinds of ground");
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
