//! Engine, converter, gearbox and driveline as data, and the curves of engine and converter.

mod converter;
mod engine;

pub use converter::ConverterTorque;
pub use engine::EngineTorque;
use serde::{Deserialize, Serialize};

/// From the engine to the wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Powertrain {
    /// The engine.
    pub engine: Engine,
    /// Between engine and gearbox; without it the two turn together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converter: Option<Converter>,
    /// The gearbox.
    pub gearbox: Gearbox,
    /// From the gearbox to the wheels.
    pub driveline: Driveline,
    /// What limits the speed, if anything does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub governor: Option<Governor>,
}

/// Closes the throttle towards a greatest speed of the vehicle over ground. Wheels that spin do not concern it: the
/// engine alone limits them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Governor {
    /// Speed from which the throttle is closed, m/s.
    pub speed: f64,
    /// Range of speeds below it over which the greatest throttle falls from 1 to 0, m/s.
    pub band: f64,
}

impl Governor {
    /// Greatest throttle at a road speed (m/s), in [0, 1].
    #[must_use]
    pub fn ceiling(&self, speed: f64) -> f64 {
        ((self.speed - speed) / self.band).clamp(0.0, 1.0)
    }
}

/// What makes the torque. Points of tables are \[speed rad/s, torque N m\], linear between and constant beyond them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Engine {
    /// Torque maps at both ends of the throttle, linear in the throttle between them.
    Map {
        /// At throttle 1.
        full_throttle: Vec<[f64; 2]>,
        /// At throttle 0; what is negative here is drag and only ever opposes the motion.
        closed_throttle: Vec<[f64; 2]>,
        /// Inertia at engine speed, kg m².
        #[serde(default)]
        inertia: f64,
    },
    /// Constant torque up to a limit of power, no drag.
    Simple {
        /// N m, at throttle 1.
        torque: f64,
        /// W, at throttle 1.
        power: f64,
        /// Speed above which there is no torque, rad/s.
        max_speed: f64,
        /// Inertia at engine speed, kg m².
        #[serde(default)]
        inertia: f64,
    },
    /// A motor whose torque falls from stall to none at its no-load speed.
    Electric {
        /// At throttle 1, from \[0, stall torque\] to \[no-load speed, 0\].
        torque: Vec<[f64; 2]>,
        /// Brake torque at throttle 0, as a fraction of that of a motor with shorted terminals, which is the stall
        /// torque times speed over no-load speed: 0 rolls free, 1 is a direct-current motor on a constant voltage.
        #[serde(default)]
        regeneration: f64,
        /// Torque of friction in motor and gears at throttle 0, N m; it holds at rest.
        #[serde(default)]
        friction: f64,
        /// Inertia of the rotor, kg m².
        #[serde(default)]
        inertia: f64,
    },
}

/// A hydrodynamic torque converter. Points of tables are \[turbine speed over impeller speed, value\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// Speed at which a governor keeps the engine, rad/s.
    pub idle_speed: f64,
    /// Capacity factor K, rad/s per √(N m): the impeller takes (its speed / K)².
    pub capacity: Vec<[f64; 2]>,
    /// Turbine torque over impeller torque.
    pub torque_ratio: Vec<[f64; 2]>,
    /// A clutch past the fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock_up: Option<LockUp>,
}

/// When a converter is bridged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockUp {
    /// Turbine speed over impeller speed from which the clutch closes.
    pub speed_ratio: f64,
    /// Turbine speed below which it opens, rad/s.
    pub release_speed: f64,
    /// Greatest torque of the clutch, N m.
    pub torque: f64,
}

/// An automatic gearbox that shifts by the speed of its input shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gearbox {
    /// Output speed over input speed, lowest gear first.
    pub ratios: Vec<f64>,
    /// The same of the reverse gear, negative. Data: no command asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reverse: Option<f64>,
    /// Input speed below which a gear shifts down, rad/s.
    pub shift_down: Vec<f64>,
    /// Input speed above which a gear shifts up, rad/s.
    pub shift_up: Vec<f64>,
    /// Time for which a shift interrupts the torque, s.
    #[serde(default)]
    pub shift_time: f64,
    /// Least time between two shifts, s.
    #[serde(default)]
    pub latency: f64,
    /// Whether it shifts up only into gears that can sustain the load, so that a constant load never makes it hunt.
    #[serde(default)]
    pub load_sensing: bool,
}

/// Shafts and differentials between gearbox and wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Driveline {
    /// Inertia of all that turns with the gearbox's output shaft, the centre differential's box included, kg m².
    pub shaft_inertia: f64,
    /// Between neighbouring driven axles. With one driven axle it has nothing to do.
    pub centre: Differential,
    /// One for each driven axle, front to back.
    pub axles: Vec<DrivenAxle>,
}

/// The drive of one axle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrivenAxle {
    /// Share of the gearbox's torque, as an open centre differential gives it; all shares make 1.
    #[serde(rename = "share")]
    pub fraction: f64,
    /// Speed of the differential's box over that of the axle's drive shaft.
    pub final_drive: f64,
    /// Inertia of the axle's drive shaft, at its speed, kg m².
    pub shaft_inertia: f64,
    /// Inertia of the differential's box, kg m².
    pub box_inertia: f64,
    /// Between the two wheels.
    pub differential: Differential,
}

/// How a differential resists a difference in speed of its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Differential {
    /// Not at all.
    Open {},
    /// By a clutch between the outputs.
    Clutch {
        /// Torque that the clutch moves from the faster to the slower output while it slips, N m.
        torque: f64,
    },
    /// By friction that grows with the torque: the slower output gets up to `bias` times the torque of the faster.
    LimitedSlip {
        /// Greatest ratio of the outputs' torques, ≥ 1.
        bias: f64,
        /// Torque moved from the faster to the slower output at no load, N m.
        #[serde(default)]
        preload: f64,
    },
    /// Completely: the outputs turn together.
    Locked {},
}
