//! A vehicle as data. The file format is `tasks/vehicles/*.yaml`; see there for a commented example.

use serde::{Deserialize, Serialize};

/// A point of the chassis frame, or relative to an axle's reference point, m.
pub type Point = [f64; 3];

/// A wheeled vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSpec {
    /// Version of this format; 1.
    pub schema: u32,
    /// Short name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Overall length, m.
    pub length: f64,
    /// Overall width, m.
    pub width: f64,
    /// Overall height, m.
    pub height: f64,
    /// Top speed on flat ground, m/s.
    pub max_speed: f64,
    /// The sprung body.
    pub chassis: Chassis,
    /// Front to back.
    pub axles: Vec<Axle>,
    /// Steering gear.
    pub steering: Steering,
    /// All tyres.
    pub tyre: TyreSpec,
    /// Engine, gearbox and driveline.
    pub powertrain: Powertrain,
}

/// The sprung body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chassis {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the chassis frame, m.
    pub com: Point,
    /// Principal moments about the centre of mass along the chassis axes, kg m².
    pub inertia: [f64; 3],
    /// Friction coefficient of the hull.
    pub friction: f64,
    /// Convex parts that touch ground and obstacles, as point clouds in the chassis frame, m.
    pub hull: Vec<Vec<Point>>,
}

/// An axle with a wheel at each side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axle {
    /// Name for people.
    pub name: String,
    /// Reference point of the hardpoints in the chassis frame, m.
    pub position: Point,
    /// Whether the rack moves its inner tie-rod joints.
    pub steered: bool,
    /// Whether the engine drives it.
    pub driven: bool,
    /// Unsprung mass a wheel, kg.
    pub unsprung_mass: f64,
    /// Spin inertia a wheel, kg m².
    pub spin_inertia: f64,
    /// Greatest brake torque a wheel, N m.
    pub brake_torque: f64,
    /// How the wheels are guided.
    pub suspension: Suspension,
}

/// How a wheel is guided and sprung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Suspension {
    /// Two wishbones and a tie rod of fixed length, ideal joints, massless links; the strut acts on the upright.
    DoubleWishbone {
        /// Where the joints are.
        hardpoints: Hardpoints,
        /// Along the strut.
        spring: Spring,
        /// Along the strut.
        damper: Damper,
        /// At the ends of the travel.
        stops: Stops,
    },
}

/// Joints of a double wishbone: left side, at design height, relative to the axle's reference point, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct Hardpoints {
    pub spindle: Point,
    pub upper_arm_front: Point,
    pub upper_arm_rear: Point,
    pub upper_ball_joint: Point,
    pub lower_arm_front: Point,
    pub lower_arm_rear: Point,
    pub lower_ball_joint: Point,
    pub strut_chassis: Point,
    pub strut_upright: Point,
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// A linear spring: force = stiffness · (free length − length), in tension too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// N/m.
    pub stiffness: f64,
    /// m.
    pub free_length: f64,
}

/// A linear damper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Damper {
    /// N s/m.
    pub coefficient: f64,
}

/// Linear stops that act on the wheel beyond these travels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stops {
    /// Compression at which the upper stop is met, m, > 0.
    pub jounce: f64,
    /// Travel at which the lower stop is met, m, < 0.
    pub rebound: f64,
    /// N/m at the wheel.
    pub stiffness: f64,
}

/// A rack that moves the inner tie-rod joints of steered axles sideways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steering {
    /// Travel to the right at command +1, m.
    pub rack_travel: f64,
    /// Greatest rate of the command, 1/s.
    pub rate: f64,
}

/// A tyre; see [`crate::Envelope`] for its contact and [`crate::Brush`] for its forces in the contact plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TyreSpec {
    /// Unloaded radius, m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Friction coefficient, combined with the ground's by the minimum.
    pub friction: f64,
    /// N/m.
    pub vertical_stiffness: f64,
    /// N s/m.
    pub vertical_damping: f64,
    /// Slope of force over slip at zero slip, per unit load: longitudinal, lateral.
    pub slip_stiffness: [f64; 2],
    /// Longitudinal, lateral, m.
    pub relaxation_length: [f64; 2],
    /// Damping ratio of the carcass against a quarter of the vehicle's mass.
    pub damping_ratio: f64,
    /// Rolling resistance as a fraction of load.
    pub rolling_resistance: f64,
}

/// Engine, gearbox and driveline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Powertrain {
    /// The engine.
    pub engine: Engine,
    /// The gearbox.
    pub gearbox: Gearbox,
    /// Axle speed over drive-shaft speed.
    pub final_drive: f64,
    /// Inertia of all that turns with the drive shaft, at its speed, kg m².
    pub shaft_inertia: f64,
    /// How the torque is split.
    pub differentials: Differentials,
}

/// Torque (N m) over engine speed (rad/s), linear between points and constant beyond them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Engine {
    /// At throttle 1.
    pub full_throttle: Vec<[f64; 2]>,
    /// At throttle 0.
    pub closed_throttle: Vec<[f64; 2]>,
}

/// An automatic gearbox without slip, that shifts at fixed engine speeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gearbox {
    /// Output speed over input speed, lowest gear first.
    pub ratios: Vec<f64>,
    /// Engine speed below which a gear shifts down, rad/s.
    pub shift_down: Vec<f64>,
    /// Engine speed above which a gear shifts up, rad/s.
    pub shift_up: Vec<f64>,
}

/// Clutch torque with which each differential resists a difference in speed, N m: 0 is open, a large value locked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Differentials {
    /// Between the wheels of driven axles of the front half.
    pub front: f64,
    /// Between the wheels of driven axles of the rear half.
    pub rear: f64,
    /// Between driven axles.
    pub centre: f64,
}
