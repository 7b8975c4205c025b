//! The skid steering of a vehicle on wheels as data.

use serde::{Deserialize, Serialize};

/// Skid steering by motors: the wheels of the two sides turn at different speeds.
///
/// All wheels are driven, none is steered. The engine stands for all motors together: a side has half of them. The wheels of a
/// side turn together (by chains, belts or shafts) if the centre differential is `locked`; each has a motor of its own if it
/// is `open`. The throttle asks for the torque of all motors, the steering command for the difference between the sides.
/// Within the limits of the motors the difference comes first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "control", rename_all = "snake_case", deny_unknown_fields)]
pub enum Skid {
    /// The command sets the difference of the speeds of the sides.
    Speed {
        /// The difference over the mean speed at full command: at 2 the inner wheels stand still.
        relative: f64,
        /// The minimum difference at full command, m/s at the circumference of the wheels: that with which the vehicle turns in
        /// place. 0 if it turns only while it drives.
        at_rest: f64,
        /// The torque that the motors of a side add, and those of the other take off, for each unit by which the difference of
        /// the spins of the sides falls short, N m s.
        gain: f64,
    },
    /// The command sets the difference of the torques.
    Torque {
        /// The torque that the motors of the outer side add at full command, and those of the inner take off, at the wheels of
        /// a side, N m.
        torque: f64,
    },
}
