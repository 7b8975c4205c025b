//! What a dataset has of each frame: the one list of its columns, with shape, names, units and how each is filled.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use vb_sdk::crop::Window;
use vb_sdk::{Command, Observation, Pose2};
use vb_sim::{Controls, Gear, VehicleState};
use vb_trial::{gear_number, simulated_gear};
use vb_world::World;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dtype {
    F32,
    I64,
    /// Labels from 0 to 255.
    U8,
    Bool,
}

impl Dtype {
    /// The name that LeRobot and numpy have for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "float32",
            Self::I64 => "int64",
            Self::U8 => "uint8",
            Self::Bool => "bool",
        }
    }
}

/// A column of a dataset.
#[derive(Clone, Debug)]
pub struct Feature {
    pub name: &'static str,
    pub dtype: Dtype,
    /// The shape of one frame's value: `[1]` for a number, `[n]` for a vector, `[rows, cols]` for a grid.
    pub shape: Vec<usize>,
    /// The names of a vector's entries, which end in their units; none for grids.
    pub names: Vec<String>,
    /// What it is, a sentence for the card.
    pub about: &'static str,
    fill: Fill,
}

impl Feature {
    /// The number of values of a frame.
    #[must_use]
    pub fn width(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether a frame's value is a grid.
    #[must_use]
    pub fn is_grid(&self) -> bool {
        self.shape.len() > 1
    }
}

/// The function that appends a frame's values to those of a column, and with it their type.
#[derive(Clone, Copy, Debug)]
enum Fill {
    F32(fn(&Frame<'_>, &Feature, &mut Vec<f32>)),
    I64(fn(&Frame<'_>) -> i64),
    U8(fn(&Frame<'_>, &Feature, &mut Vec<u8>)),
    Bool(fn(&Frame<'_>) -> bool),
}

impl Fill {
    fn dtype(self) -> Dtype {
        match self {
            Self::F32(_) => Dtype::F32,
            Self::I64(_) => Dtype::I64,
            Self::U8(_) => Dtype::U8,
            Self::Bool(_) => Dtype::Bool,
        }
    }
}

/// The shape of a frame's value, with the names of its entries.
#[derive(Clone, Copy, Debug)]
enum Shape {
    One,
    Vector(&'static [&'static str]),
    /// Entries of each wheel, front to back, left before right.
    PerWheel([&'static str; 2]),
    /// A crop of a map.
    Crop,
}

/// A column that datasets can have.
struct Column {
    name: &'static str,
    /// See [`Feature::about`].
    about: &'static str,
    shape: Shape,
    /// Whether datasets of a layout have it.
    is_there: fn(&Layout) -> bool,
    fill: Fill,
}

/// The settings that determine the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    /// The number of wheels of the vehicle.
    pub wheels: usize,
    /// Whether the driver reports its target speed.
    pub speed: bool,
    /// Whether the vehicle has a goal.
    pub goal: bool,
    /// Whether the driver's estimate of the state differs from the truth.
    pub truth: bool,
    /// The rows and columns of the crops of the maps; none for 0.
    pub crops: usize,
}

/// The side of a crop at scale 1, m.
pub const CROP_SIDE: f64 = 16.0;

/// The state's entries, as an observation has them.
const STATE: [&str; 15] = [
    "x_m",
    "y_m",
    "z_m",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
    "vx_m_per_s",
    "vy_m_per_s",
    "vz_m_per_s",
    "wx_rad_per_s",
    "wy_rad_per_s",
    "wz_rad_per_s",
    "steering",
    "engine_speed_rad_per_s",
    "gear",
];

/// The entries of a command.
const CONTROLS: [&str; 4] = ["steering", "throttle", "brake", "gear"];

/// All columns, in the order of the file.
const COLUMNS: [Column; 14] = [
    Column {
        name: "observation.state",
        about: "Observed vehicle state: position of the reference point in the world frame (x east, y north, z up), roll (positive right side down), pitch (positive nose down), yaw, velocity and angular velocity in body axes (x forward, y left, z up), wheel steering in [-1, 1], positive to the left, engine speed, and engaged gear (-1 reverse, 0 neutral, 1 forward)",
        shape: Shape::Vector(&STATE),
        is_there: |_| true,
        fill: Fill::F32(seen_state),
    },
    Column {
        name: "observation.wheels",
        about: "Angular velocity about the axle, and suspension travel, positive in compression, of each wheel, front to back, left before right",
        shape: Shape::PerWheel(["spin_rad_per_s", "travel_m"]),
        is_there: |_| true,
        fill: Fill::F32(seen_wheels),
    },
    Column {
        name: "observation.goal",
        about: "Goal in the vehicle's heading frame (x forward, y left)",
        shape: Shape::Vector(&["forward_m", "left_m"]),
        is_there: |of| of.goal,
        fill: Fill::F32(goal),
    },
    Column {
        name: "observation.height_crop",
        about: "Terrain heights on a square of 16 m (times the world's scale) aligned with the vehicle's heading, relative to the height under its reference point, m; row 0 is the rearmost, column 0 the rightmost",
        shape: Shape::Crop,
        is_there: |of| of.crops > 0,
        fill: Fill::F32(heights),
    },
    Column {
        name: "observation.class_crop",
        about: "Terrain classes on that square: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow, 10 obstacle, 255 outside the world",
        shape: Shape::Crop,
        is_there: |of| of.crops > 0,
        fill: Fill::U8(classes),
    },
    Column {
        name: "observation.friction_crop",
        about: "Friction coefficient on that square; 0 on deformable terrain and outside the world",
        shape: Shape::Crop,
        is_there: |of| of.crops > 0,
        fill: Fill::F32(frictions),
    },
    Column {
        name: "action",
        about: "Command of the driver, clamped: steering in [-1, 1], positive to the left, throttle and brake in [0, 1], gear (-1 reverse, 0 neutral, 1 forward); it holds until the next command",
        shape: Shape::Vector(&CONTROLS),
        is_there: |_| true,
        fill: Fill::F32(given),
    },
    Column {
        name: "action.speed",
        about: "Target forward speed of the driver, negative in reverse",
        shape: Shape::Vector(&["speed_m_per_s"]),
        is_there: |of| of.speed,
        fill: Fill::F32(|frame, _, to| put(to, [frame.speed])),
    },
    Column {
        name: "action.applied",
        about: "Actuator values until the next frame: mean wheel steering, clamped throttle and brake, and the gear engaged at the end",
        shape: Shape::Vector(&CONTROLS),
        is_there: |_| true,
        fill: Fill::F32(applied),
    },
    Column {
        name: "truth.state",
        about: "True values of the entries of observation.state",
        shape: Shape::Vector(&STATE),
        is_there: |of| of.truth,
        fill: Fill::F32(true_state),
    },
    Column {
        name: "truth.wheels",
        about: "Normal force from terrain and obstacles, and sinkage, of each wheel",
        shape: Shape::PerWheel(["load_N", "sinkage_m"]),
        is_there: |_| true,
        fill: Fill::F32(true_wheels),
    },
    Column {
        name: "truth.ground",
        about: "Terrain class under the reference point: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow",
        shape: Shape::One,
        is_there: |_| true,
        fill: Fill::I64(|frame| frame.ground.class(frame.state)),
    },
    Column {
        name: "next.done",
        about: "True for the last frame of an episode",
        shape: Shape::One,
        is_there: |_| true,
        fill: Fill::Bool(|frame| frame.is_last),
    },
    Column {
        name: "next.success",
        about: "True for the last frame of an episode that reached its goal",
        shape: Shape::One,
        is_there: |_| true,
        fill: Fill::Bool(|frame| frame.succeeds),
    },
];

impl Layout {
    /// The columns, in the order of the file. Those that every dataset of LeRobot has (`timestamp`, `frame_index`,
    /// `episode_index`, `index`, `task_index`) come besides.
    #[must_use]
    pub fn features(&self) -> Vec<Feature> {
        let feature = |column: &Column| {
            let named = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
            let (shape, names) = match column.shape {
                Shape::One => (vec![1], Vec::new()),
                Shape::Vector(names) => (vec![names.len()], named(names)),
                Shape::PerWheel(names) => {
                    let of = |w| names.map(|name| format!("wheel{w}_{name}"));
                    (vec![names.len() * self.wheels], (0..self.wheels).flat_map(of).collect())
                }
                Shape::Crop => (vec![self.crops, self.crops], Vec::new()),
            };
            let Column { name, about, fill, .. } = *column;
            Feature { name, dtype: fill.dtype(), shape, names, about, fill }
        };
        COLUMNS.iter().filter(|column| (column.is_there)(self)).map(feature).collect()
    }

    /// The bytes of a frame before compression.
    #[must_use]
    pub fn frame_bytes(&self) -> usize {
        let size = |f: &Feature| match f.dtype {
            Dtype::F32 => 4 * f.width(),
            Dtype::I64 => 8 * f.width(),
            Dtype::U8 | Dtype::Bool => f.width(),
        };
        36 + self.features().iter().map(size).sum::<usize>()
    }
}

/// A frame while it is recorded: what was seen, done and true at a step of the driver.
pub(crate) struct Frame<'a> {
    pub(crate) ground: &'a Ground,
    pub(crate) state: &'a VehicleState,
    /// With the last readings of sensors that have none now.
    pub(crate) observation: &'a Observation,
    pub(crate) goal: [f64; 2],
    pub(crate) given: &'a Command,
    /// The speed that the driver aims at, m/s.
    pub(crate) speed: f64,
    pub(crate) taken: Controls,
    /// The mean of the steering until the next frame.
    pub(crate) steering: f64,
    /// The gear at the next frame.
    pub(crate) gear_after: Gear,
    pub(crate) is_last: bool,
    pub(crate) succeeds: bool,
}

/// The values of a column, frame after frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Of [`Dtype::F32`].
    F32(Vec<f32>),
    /// Of [`Dtype::I64`].
    I64(Vec<i64>),
    /// Of [`Dtype::U8`].
    U8(Vec<u8>),
    /// Of [`Dtype::Bool`].
    Bool(Vec<bool>),
}

impl Values {
    #[must_use]
    pub fn new(dtype: Dtype) -> Self {
        match dtype {
            Dtype::F32 => Self::F32(Vec::new()),
            Dtype::I64 => Self::I64(Vec::new()),
            Dtype::U8 => Self::U8(Vec::new()),
            Dtype::Bool => Self::Bool(Vec::new()),
        }
    }

    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::Bool(v) => v.len(),
        }
    }

    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A value as a number.
    ///
    /// # Panics
    /// Panics if there are not so many.
    #[must_use]
    pub fn number(&self, index: usize) -> f64 {
        match self {
            Self::F32(v) => f64::from(v[index]),
            Self::I64(v) => v[index] as f64,
            Self::U8(v) => f64::from(v[index]),
            Self::Bool(v) => f64::from(u8::from(v[index])),
        }
    }

    /// The type of the values.
    #[must_use]
    pub fn dtype(&self) -> Dtype {
        match self {
            Self::F32(_) => Dtype::F32,
            Self::I64(_) => Dtype::I64,
            Self::U8(_) => Dtype::U8,
            Self::Bool(_) => Dtype::Bool,
        }
    }

    /// Appends some of the values of another column.
    ///
    /// # Panics
    /// Panics if these are of another type, or fewer.
    pub fn append(&mut self, other: &Self, range: std::ops::Range<usize>) {
        match (self, other) {
            (Self::F32(to), Self::F32(from)) => to.extend_from_slice(&from[range]),
            (Self::I64(to), Self::I64(from)) => to.extend_from_slice(&from[range]),
            (Self::U8(to), Self::U8(from)) => to.extend_from_slice(&from[range]),
            (Self::Bool(to), Self::Bool(from)) => to.extend_from_slice(&from[range]),
            (to, from) => panic!("{} values to a column of {}", from.dtype().name(), to.dtype().name()),
        }
    }
}

/// The label of an obstacle in a crop.
const OBSTACLE: u8 = 10;
/// The label beyond the world.
const BEYOND: u8 = 255;

impl Feature {
    /// Appends a frame's values.
    ///
    /// # Panics
    /// Panics if the column is of another type.
    pub(crate) fn push(&self, frame: &Frame<'_>, to: &mut Values) {
        match (self.fill, to) {
            (Fill::F32(fill), Values::F32(to)) => fill(frame, self, to),
            (Fill::I64(fill), Values::I64(to)) => to.push(fill(frame)),
            (Fill::U8(fill), Values::U8(to)) => fill(frame, self, to),
            (Fill::Bool(fill), Values::Bool(to)) => to.push(fill(frame)),
            (_, to) => {
                panic!("{}: {} values to a column of {}", self.name, self.dtype.name(), to.dtype().name())
            }
        }
    }

    /// The places of a crop's cells in the world, row after row.
    fn places(&self, frame: &Frame<'_>) -> impl Iterator<Item = [f64; 2]> + use<> {
        let n = self.shape[0];
        let side = CROP_SIDE * frame.ground.world.scale;
        let window = Window { rows: n, cols: n, resolution: side / n as f64, ahead: 0.0 };
        let (.., yaw) = frame.state.roll_pitch_yaw();
        let at = Pose2 { x: frame.state.position.x, y: frame.state.position.y, yaw };
        let (sin, cos) = vb_math::sin_cos(at.yaw);
        (0..n * n).map(move |k| {
            let (forward, left) = window.body_position(k / n, k % n);
            [at.x + cos * forward - sin * left, at.y + sin * forward + cos * left]
        })
    }
}

fn put(to: &mut Vec<f32>, values: impl IntoIterator<Item = f64>) {
    to.extend(values.into_iter().map(|x| x as f32));
}

fn seen_state(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    let seen = frame.observation;
    let p = seen.pose.unwrap_or_default();
    put(to, [p.position.x, p.position.y, p.position.z, p.roll, p.pitch, p.yaw]);
    put(to, [p.linear_velocity, p.angular_velocity].into_iter().flat_map(|v| [v.x, v.y, v.z]));
    put(to, [seen.steering, seen.engine_speed, gear_number(simulated_gear(seen.gear))]);
}

fn seen_wheels(frame: &Frame<'_>, feature: &Feature, to: &mut Vec<f32>) {
    let wheels = &frame.observation.wheels;
    put(to, wheels.iter().flat_map(|w| [w.spin, w.travel]));
    // A driver that doesn't ask for the wheels sees none.
    let missing = feature.width() - 2 * wheels.len().min(feature.width() / 2);
    put(to, std::iter::repeat_n(0.0, missing));
}

fn goal(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    let p = frame.observation.pose.unwrap_or_default();
    let (sin, cos) = vb_math::sin_cos(p.yaw);
    let (dx, dy) = (frame.goal[0] - p.position.x, frame.goal[1] - p.position.y);
    put(to, [cos * dx + sin * dy, cos * dy - sin * dx]);
}

fn heights(frame: &Frame<'_>, feature: &Feature, to: &mut Vec<f32>) {
    let ground = &frame.ground.world.heightfield;
    let under = ground.height(frame.state.position.x, frame.state.position.y);
    put(to, feature.places(frame).map(|[x, y]| ground.height(x, y) - under));
}

fn classes(frame: &Frame<'_>, feature: &Feature, to: &mut Vec<u8>) {
    to.extend(feature.places(frame).map(|at| frame.ground.label(at)));
}

fn frictions(frame: &Frame<'_>, feature: &Feature, to: &mut Vec<f32>) {
    let world = &frame.ground.world;
    let friction =
        |[x, y]: [f64; 2]| if world.heightfield.contains(x, y) { world.friction_at(x, y) } else { 0.0 };
    put(to, feature.places(frame).map(friction));
}

fn given(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    let c = frame.given;
    // As the vehicle takes it: what is out of range counts as the end of the range.
    let [throttle, brake] = [c.throttle, c.brake].map(|v| v.clamp(0.0, 1.0));
    put(to, [c.steering.clamp(-1.0, 1.0), throttle, brake, gear_number(simulated_gear(c.gear))]);
}

fn applied(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    let c = frame.taken;
    put(to, [frame.steering, c.throttle, c.brake, gear_number(frame.gear_after)]);
}

fn true_state(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    let state = frame.state;
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    let (p, v, w) = (state.position, state.velocity_body, state.angular_velocity_body);
    put(to, [p.x, p.y, p.z, roll, pitch, yaw, v.x, v.y, v.z, w.x, w.y, w.z]);
    put(to, [state.steering, state.engine_speed, gear_number(state.gear)]);
}

fn true_wheels(frame: &Frame<'_>, _: &Feature, to: &mut Vec<f32>) {
    put(to, frame.state.wheels.iter().flat_map(|w| [w.load, w.sinkage]));
}

/// A world, with the outlines of its obstacles.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    pub(crate) world: Arc<World>,
    outlines: Vec<Vec<[f64; 2]>>,
}

impl Ground {
    pub(crate) fn new(world: Arc<World>) -> Self {
        let outlines = world.obstacles.iter().map(vb_world::Obstacle::footprint).collect();
        Self { world, outlines }
    }

    /// The distance from a place to the nearest obstacle, m; 0 within one, infinite without any.
    pub(crate) fn clearance(&self, at: [f64; 2]) -> f64 {
        let distance = |o: &Vec<[f64; 2]>| vb_world::geometry::point_to_polygon(at, o);
        self.outlines.iter().map(distance).fold(f64::INFINITY, f64::min)
    }

    /// The label of the terrain class under a vehicle.
    fn class(&self, state: &VehicleState) -> i64 {
        i64::from(self.world.class_at(state.position.x, state.position.y).label())
    }

    fn label(&self, [x, y]: [f64; 2]) -> u8 {
        if !self.world.heightfield.contains(x, y) {
            return BEYOND;
        }
        let is_near = |o: &&vb_world::Obstacle| {
            let [along, across, _] = o.size();
            // No outline reaches farther from the centre than its box is long and wide.
            (o.x - x).abs().max((o.y - y).abs()) < along + across
        };
        let mut near = self.world.obstacles.iter().zip(&self.outlines).filter(|(o, _)| is_near(o));
        if near.any(|(_, outline)| vb_world::geometry::contains(outline, [x, y])) {
            return OBSTACLE;
        }
        self.world.class_at(x, y).label()
    }
}
