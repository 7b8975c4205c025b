//! Actions of a policy: a few numbers, and the command that they represent.

use crate::speed::SpeedKeeper;
use crate::{Command, Gear, Observation, Task};

/// One number of an action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// The name of the number.
    pub name: &'static str,
    /// The minimum.
    pub low: f64,
    /// The maximum.
    pub high: f64,
    /// Its meaning, in words.
    pub about: &'static str,
}

/// The maximum change of the steering per action of [`ActionKind::Rate`]: lock to lock in ten actions.
pub const STEERING_STEP: f64 = 0.2;

/// The meaning of an action's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActionKind {
    /// Steering and speed, both in [-1, 1]. The speed maps linearly from −1 (`slowest`) to 1 (`fastest`); a controller
    /// tracks it with throttle and brake ([`SpeedKeeper`]), in the reverse gear if it is negative.
    Speed {
        /// The speed at −1, m/s at full scale; negative in reverse. It scales with the root of the scale.
        slowest: f64,
        /// The speed at 1, m/s at full scale.
        fastest: f64,
    },
    /// Like [`Self::Speed`], but the first number, in [-1, 1], is the change of the steering as a fraction of
    /// [`STEERING_STEP`]. Exploration noise then accumulates and leads to other paths, whereas noise on the steering
    /// itself averages out within a second.
    Rate {
        /// The speed at −1, m/s at full scale; negative in reverse. It scales with the root of the scale.
        slowest: f64,
        /// The speed at 1, m/s at full scale.
        fastest: f64,
    },
    /// Steering in [-1, 1], throttle and brake in [0, 1], and the gear: reverse below −1/3, forward above 1/3, else neutral.
    Pedals,
}

impl Default for ActionKind {
    /// Steering and a speed from 0 to 6 m/s.
    fn default() -> Self {
        Self::Speed { slowest: 0.0, fastest: 6.0 }
    }
}

const STEERING: Dimension =
    Dimension { name: "steering", low: -1.0, high: 1.0, about: "steering, positive to the left" };
const CHANGE: Dimension = Dimension {
    name: "change",
    low: -1.0,
    high: 1.0,
    about: "change of the steering as a fraction of 0.2, positive to the left",
};
const SPEED: Dimension = Dimension {
    name: "speed",
    low: -1.0,
    high: 1.0,
    about: "target speed, linear from the minimum at -1 to the maximum at 1",
};

impl ActionKind {
    /// The numbers of an action, in order.
    #[must_use]
    pub fn dimensions(self) -> &'static [Dimension] {
        match self {
            Self::Speed { .. } => &[STEERING, SPEED],
            Self::Rate { .. } => &[CHANGE, SPEED],
            Self::Pedals => &[
                STEERING,
                Dimension { name: "throttle", low: 0.0, high: 1.0, about: "throttle" },
                Dimension { name: "brake", low: 0.0, high: 1.0, about: "brake" },
                Dimension {
                    name: "gear",
                    low: -1.0,
                    high: 1.0,
                    about: "gear: reverse below -1/3, forward above 1/3, otherwise neutral",
                },
            ],
        }
    }
}

/// Converts actions to commands. It contains the state of the speed controller, and serves one task.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    kind: ActionKind,
    keeper: SpeedKeeper,
    pace: f64,
    period: f64,
    /// The last measured forward speed, m/s.
    speed: f64,
}

impl Actuator {
    /// Creates an actuator for a task.
    #[must_use]
    pub fn new(kind: ActionKind, task: &Task) -> Self {
        let scale = task.vehicle.scale;
        Self {
            kind,
            keeper: SpeedKeeper::new(scale),
            pace: scale.sqrt(),
            period: task.control_period,
            speed: 0.0,
        }
    }

    /// The command for an action, with the observation that it responds to. Numbers are clamped to their ranges;
    /// missing numbers are 0.
    pub fn command(&mut self, action: &[f64], observation: &Observation) -> Command {
        if let Some(pose) = &observation.pose {
            self.speed = pose.linear_velocity.x;
        }
        let dimensions = self.kind.dimensions();
        let number = |k: usize| {
            let Dimension { low, high, .. } = dimensions[k];
            action.get(k).copied().unwrap_or(0.0).clamp(low, high)
        };
        match self.kind {
            ActionKind::Speed { slowest, fastest } | ActionKind::Rate { slowest, fastest } => {
                let steering = match self.kind {
                    ActionKind::Rate { .. } => {
                        (observation.last_steering + STEERING_STEP * number(0)).clamp(-1.0, 1.0)
                    }
                    _ => number(0),
                };
                let share = 0.5 * (number(1) + 1.0);
                self.keeper.aim((slowest + share * (fastest - slowest)) * self.pace);
                let (throttle, brake, gear) = self.keeper.update(self.speed, self.period);
                Command { steering, throttle, brake, gear, debug: Vec::new() }
            }
            ActionKind::Pedals => {
                let gear = match number(3) {
                    g if g < -1.0 / 3.0 => Gear::Reverse,
                    g if g > 1.0 / 3.0 => Gear::Forward,
                    _ => Gear::Neutral,
                };
                Command {
                    steering: number(0),
                    throttle: number(1),
                    brake: number(2),
                    gear,
                    debug: Vec::new(),
                }
            }
        }
    }
}
