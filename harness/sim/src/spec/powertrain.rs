//! Engine, gearbox and driveline as data.

use serde::{Deserialize, Serialize};

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
