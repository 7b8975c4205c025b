//! The vehicle's mechanical energy.

use super::design::{Design, Guide};
use super::kinematics::{BeamPlacement, Placement};
use super::state::State;
use crate::V3;

/// Kinetic energy and energy of height less the work that engine and steering have done so far, J. Energy held by springs and
/// tyres is not in it. Wheels are taken where they were at the start of the last step, which is a joule or two.
pub(super) fn balance(
    design: &Design,
    state: &State,
    placements: &[Placement],
    beams: &[BeamPlacement],
    gravity: &V3,
) -> f64 {
    let (body, wheels) = (&state.body, &state.wheels);
    let spin = body.q.inverse() * body.w_world;
    let mut kinetic =
        0.5 * (design.mass * body.v_world.norm_squared() + spin.dot(&design.inertia.component_mul(&spin)));
    let mut height = -design.mass * gravity.dot(&body.x_world);
    for ((c, w), p) in design.corners.iter().zip(wheels).zip(placements) {
        let mut mass = c.mass;
        let mut velocity = body.v_world + body.w_world.cross(&p.arm) + p.tangent * w.travel_rate;
        if let Guide::Beam(b) = c.guide {
            let (b, place) = (&design.beams[b], &beams[b]);
            let i = c.side.index();
            mass += b.at_hub;
            velocity += place.cross[i] * wheels[b.left + 1 - i].travel_rate;
        }
        kinetic += 0.5 * mass * velocity.norm_squared();
        height -= mass * gravity.dot(&(body.x_world + p.arm));
    }
    for (b, p) in design.beams.iter().zip(beams) {
        let rates = [0, 1].map(|i| wheels[b.left + i].travel_rate);
        let velocity =
            body.v_world + body.w_world.cross(&p.arm) + p.tangents[0] * rates[0] + p.tangents[1] * rates[1];
        kinetic += 0.5 * b.at_middle * velocity.norm_squared();
        height -= b.at_middle * gravity.dot(&(body.x_world + p.arm));
    }
    let turning = |i: usize| match (design.tracks.get(i), state.belts.get(i)) {
        (Some(track), Some(belt)) => track.sprocket_spin(belt.speed),
        _ => wheels[i].spin,
    };
    kinetic + height + state.drive.energy(turning) - state.drive.work() - state.steering.work
}
