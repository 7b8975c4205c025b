//! The last stage of a step: the new state, by symplectic Euler.

use super::drive::Driven;
use super::solve::Increments;
use super::state::State;
use super::steering::Steering;

/// Advances steering, spins, velocities and travels; the pose of the chassis is left to whoever knows what its hull
/// touches. Each travel goes on with its new rate.
pub(super) fn integrate(
    state: &mut State,
    steering: Steering,
    driven: &Driven,
    increments: &Increments,
    dt: f64,
) {
    (state.steering.command, state.steering.rate) = (steering.command, steering.rate);
    state.steering.stalled += u64::from(steering.stalled);
    for ((wheel, spin), increment) in state.wheels.iter_mut().zip(driven.spins).zip(increments.travel_rates) {
        wheel.spin = spin;
        wheel.travel_rate += increment;
        wheel.travel += dt * wheel.travel_rate;
    }
    for (belt, speed) in state.belts.iter_mut().zip(driven.belts) {
        belt.speed = speed;
    }
    state.body.v_world += increments.velocity;
    state.body.w_world += increments.angular_velocity;
}
