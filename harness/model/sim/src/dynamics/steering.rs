//! The steering gear: how the command follows what the driver asks for against the load of the wheels.
//!
//! The command c moves all gears together. The forces on the steered wheels do the work Q dc on it, with the generalised
//! force Q = Σ F·∂hub/∂c + M·∂(rotation of the upright)/∂c (N m), which is positive where they push the command up. A gear
//! with a force limit is a servo that moves the inertia of its wheels: it reaches the asked speed within the step if that
//! takes no more than its limit, and exerts its limit otherwise. So a load above the limit stalls it and drives it back.

use super::design::Design;
use super::state::SteeringState;

/// The steering in one step.
#[derive(Clone, Copy)]
pub(super) struct Steering {
    /// The command after the limits of rate and force, in [-1, 1].
    pub(super) command: f64,
    /// How fast it changes, 1/s.
    pub(super) rate: f64,
    /// Whether the load exceeded the gear's force.
    pub(super) stalled: bool,
}

impl Steering {
    /// The steering of a step of `dt` (s) in which it follows what the driver asks for from its present state.
    pub(super) fn follow(asked: f64, design: &Design, state: &SteeringState, dt: f64) -> Self {
        let (present, fastest) = (state.command, design.steering_rate);
        let Some(servo) = &design.servo else {
            let change = (asked - present).clamp(-dt * fastest, dt * fastest);
            return Self { command: present + change, rate: change / dt, stalled: false };
        };
        let (distance, limit) = (asked - present, servo.at(present));
        let wanted = (distance / dt).abs().min(fastest).min(limit.approach(distance)).copysign(distance);
        let (rate, reached) = limit.drive(wanted, state.rate, state.load, dt);
        let command = (present + dt * rate).clamp(-1.0, 1.0);
        // A gear that only gathers speed isn't stalled.
        let stalled = !reached && state.load.abs() > limit.effort();
        Self { command, rate: (command - present) / dt, stalled }
    }
}
