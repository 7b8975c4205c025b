//! The engine, the converter, the gearbox and the driveline as data, and the curves of engine and converter.

mod converter;
mod engine;

pub use converter::ConverterTorque;
pub use engine::EngineTorque;
use serde::{Deserialize, Serialize};

/// The powertrain from the engine to the wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Powertrain {
    /// The engine.
    pub engine: Engine,
    /// The converter between engine and gearbox. Without it the two turn together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converter: Option<Converter>,
    /// The gearbox.
    pub gearbox: Gearbox,
    /// The driveline from the gearbox to the wheels.
    pub driveline: Driveline,
    /// The governor that limits the speed, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub governor: Option<Governor>,
}

/// A governor that closes the throttle towards a maximum speed of the vehicle over ground. Wheels that spin do not
/// concern it: the engine alone limits them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Governor {
    /// The speed from which on the throttle is closed, m/s.
    pub speed: f64,
    /// The range of speeds below `speed` over which the maximum throttle falls from 1 to 0, m/s.
    pub band: f64,
}

impl Governor {
    /// The maximum throttle at a road speed (m/s), in [0, 1].
    #[must_use]
    pub fn ceiling(&self, speed: f64) -> f64 {
        ((self.speed - speed) / self.band).clamp(0.0, 1.0)
    }
}

/// The source of the torque. Points of tables are \[speed rad/s, torque N m\], linear between and constant beyond them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Engine {
    /// An engine with torque maps at both ends of the throttle, linear in the throttle between them.
    Map {
        /// The torque at throttle 1.
        full_throttle: Vec<[f64; 2]>,
        /// The torque at throttle 0. What is negative here is drag and only ever opposes the motion.
        closed_throttle: Vec<[f64; 2]>,
        /// The inertia at engine speed, kg m².
        #[serde(default)]
        inertia: f64,
    },
    /// An engine with a constant torque up to a limit of power, and without drag.
    Simple {
        /// The torque at throttle 1, N m.
        torque: f64,
        /// The maximum power at throttle 1, W.
        power: f64,
        /// The speed above which there is no torque, rad/s.
        max_speed: f64,
        /// The inertia at engine speed, kg m².
        #[serde(default)]
        inertia: f64,
    },
    /// A motor whose torque falls from stall to none at its no-load speed.
    Electric {
        /// The torque at throttle 1, from \[0, stall torque\] to \[no-load speed, 0\].
        torque: Vec<[f64; 2]>,
        /// The brake torque at throttle 0, as a fraction of that of a motor with shorted terminals, which is the stall
        /// torque times the speed over the no-load speed: 0 rolls free, 1 is a direct-current motor on a constant
        /// voltage.
        #[serde(default)]
        regeneration: f64,
        /// The torque of friction in motor and gears at throttle 0, N m. It also holds at rest.
        #[serde(default)]
        friction: f64,
        /// The voltage at the motor over the throttle, both as fractions of the maximum, from \[0, 0\] to \[1, 1\]: the
        /// characteristic of a speed controller. In proportion if absent.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        voltage: Vec<[f64; 2]>,
        /// The inertia of the rotor, kg m².
        #[serde(default)]
        inertia: f64,
    },
}

/// A hydrodynamic torque converter. Points of tables are \[turbine speed over impeller speed, value\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// The speed at which a governor keeps the engine, rad/s.
    pub idle_speed: f64,
    /// The capacity factor K, rad/s per √(N m): the impeller takes the torque (its speed / K)².
    pub capacity: Vec<[f64; 2]>,
    /// The turbine's torque over the impeller's.
    pub torque_ratio: Vec<[f64; 2]>,
    /// The clutch that bridges the fluid, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock_up: Option<LockUp>,
}

/// The clutch of a converter, and when it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockUp {
    /// The turbine speed over the impeller speed from which on the clutch closes.
    pub speed_ratio: f64,
    /// The turbine speed below which the clutch opens, rad/s.
    pub release_speed: f64,
    /// The maximum torque of the clutch, N m.
    pub torque: f64,
}

/// An automatic gearbox that shifts by the speed of its input shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gearbox {
    /// The output speed over the input speed of each gear, lowest gear first.
    pub ratios: Vec<f64>,
    /// The output speed over the input speed of the reverse gear, negative. Without it the vehicle has no reverse gear:
    /// a driver who asks for one gets neutral.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reverse: Option<f64>,
    /// When and how fast the direction is changed.
    #[serde(default)]
    pub direction_change: DirectionChange,
    /// The input speeds below which each gear shifts down, rad/s.
    pub shift_down: Vec<f64>,
    /// The input speeds above which each gear shifts up, rad/s.
    pub shift_up: Vec<f64>,
    /// The time for which a shift interrupts the torque, s.
    #[serde(default)]
    pub shift_time: f64,
    /// The minimum time between two shifts, s.
    #[serde(default)]
    pub latency: f64,
    /// Whether the gearbox shifts up only into gears that can sustain the load, so that a constant load never makes it
    /// hunt.
    #[serde(default)]
    pub load_sensing: bool,
}

/// Changes of a gearbox between forward, neutral and reverse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionChange {
    /// The speed of the vehicle over ground below which a direction can be put in that is opposed to the motion, m/s.
    /// Above it the gearbox waits.
    pub speed: f64,
    /// The time from the beginning of a change until the new direction is in, s. The torque is interrupted meanwhile.
    pub latency: f64,
}

impl Default for DirectionChange {
    /// Of a full-size vehicle with an automatic gearbox: half a metre a second, at which it all but stands, and half a
    /// second for a clutch to fill and to close. Ours: operator's manuals ask for a vehicle that has stopped
    /// (TM 9-2320-272-10, para. 2-15, "to drive in reverse"), and give no numbers.
    fn default() -> Self {
        Self { speed: 0.5, latency: 0.5 }
    }
}

/// The shafts and differentials between gearbox and wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Driveline {
    /// The inertia of all that turns with the gearbox's output shaft, the centre differential's box included, kg m².
    pub shaft_inertia: f64,
    /// The differential between neighbouring driven axles. With one driven axle it has nothing to do.
    pub centre: Differential,
    /// The driven axles, front to back.
    pub axles: Vec<DrivenAxle>,
}

/// The drive of one axle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrivenAxle {
    /// The share of the gearbox's torque that an open centre differential gives to the axle. All shares add up to 1.
    #[serde(rename = "share")]
    pub fraction: f64,
    /// The speed of the differential's box over that of the axle's drive shaft.
    pub final_drive: f64,
    /// The inertia of the axle's drive shaft, at its own speed, kg m².
    pub shaft_inertia: f64,
    /// The inertia of the differential's box, kg m².
    pub box_inertia: f64,
    /// The differential between the two wheels.
    pub differential: Differential,
}

/// The way in which a differential resists a difference in the speeds of its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Differential {
    /// It doesn't resist at all.
    Open {},
    /// It resists by a clutch between the outputs.
    Clutch {
        /// The torque that the clutch moves from the faster to the slower output while it slips, N m.
        torque: f64,
    },
    /// It resists by friction that grows with the torque: the slower output gets up to `bias` times the torque of the
    /// faster.
    LimitedSlip {
        /// The maximum ratio of the outputs' torques, ≥ 1.
        bias: f64,
        /// The torque that is moved from the faster to the slower output at no load, N m.
        #[serde(default)]
        preload: f64,
    },
    /// It resists completely: the outputs turn together.
    Locked {},
}
