//! What a policy does: a few numbers, and the command that they stand for.

use crate::speed::SpeedKeeper;
use crate::{Command, Gear, Observation, Task};

/// One number of an action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// The name of the number.
    pub name: &'static str,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// What it means, in words.
    pub about: &'static str,
}

/// The greatest change of the steering by one action of [`ActionKind::Rate`]: from lock to lock in ten actions.
pub const STEERING_STEP: f64 = 0.2;

/// What the numbers of an action are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActionKind {
    /// Steering and speed, both in [-1, 1]. Speed −1 stands for `slowest` and 1 for `fastest`, with all between in
    /// proportion; a controller keeps it by throttle and brake ([`SpeedKeeper`]), in the reverse gear if it is negative.
    Speed {
        /// The speed at −1, m/s of a full-size vehicle; negative in reverse. It is multiplied by the root of the scale.
        slowest: f64,
        /// The speed at 1, m/s of a full-size vehicle.
        fastest: f64,
    },
    /// As [`Self::Speed`], but the first number, in [-1, 1], is by how much the steering changes, as a part of [`STEERING_STEP`].
    /// Noise on it makes the vehicle wander, where noise on the steering itself cancels out within a second: a learner that explores
    /// by noise comes to other lines through rough ground.
    Rate {
        /// The speed at −1, m/s of a full-size vehicle; negative in reverse. It is multiplied by the root of the scale.
        slowest: f64,
        /// The speed at 1, m/s of a full-size vehicle.
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
    Dimension { name: "steering", low: -1.0, high: 1.0, about: "the steering, positive to the left" };
const CHANGE: Dimension = Dimension {
    name: "change",
    low: -1.0,
    high: 1.0,
    about: "by how much the steering changes, as a part of 0.2, positive to the left",
};
const SPEED: Dimension = Dimension {
    name: "speed",
    low: -1.0,
    high: 1.0,
    about: "the speed to keep, from the slowest at -1 to the fastest at 1",
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
                Dimension { name: "throttle", low: 0.0, high: 1.0, about: "the throttle" },
                Dimension { name: "brake", low: 0.0, high: 1.0, about: "the brake" },
                Dimension {
                    name: "gear",
                    low: -1.0,
                    high: 1.0,
                    about: "the gear: reverse below -1/3, forward above 1/3, else neutral",
                },
            ],
        }
    }
}

/// Turns actions into commands. It remembers what its speed controller has to remember, so it serves one task.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    kind: ActionKind,
    keeper: SpeedKeeper,
    pace: f64,
    period: f64,
    /// The last forward speed that was measured, m/s.
    speed: f64,
}

impl Actuator {
    /// An actuator for a task.
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

    /// The command for an action, with the observation that it answers. Numbers out of range are limited to it; missing ones
    /// count as 0.
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
