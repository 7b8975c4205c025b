//! The stage of a step in which driveline and brakes turn wheels and sprockets.

use super::contact::Forces;
use super::design::{Design, Track};
use super::state::{Belt, Body, Wheel};
use crate::V3;
use crate::powertrain::{Demand, Drive, Wheels};
use crate::state::{Controls, Gear};
use vb_vehicle::MAX_WHEELS;

/// What the driver asks of the powertrain, with what a governor leaves of the throttle, while `direction` is in and the steering follows as far as `steering`. In reverse
/// the governor looks at the speed backwards. The gearbox goes by the speed of the reference point, which is what a driver
/// is told.
pub(super) fn demand(
    design: &Design,
    body: &Body,
    direction: Gear,
    controls: &Controls,
    steering: f64,
) -> Demand {
    let forward = body.q * V3::x();
    let speed = body.v_world.dot(&forward);
    let ahead = if direction == Gear::Reverse { -speed } else { speed };
    let throttle = design.governor.map_or(controls.throttle, |g| controls.throttle.min(g.ceiling(ahead)));
    let turning = body.w_world.cross(&(body.q * design.reference)).dot(&forward);
    Demand { throttle, gear: controls.gear, speed: speed + turning, steering }
}

/// What turns with the driveline, which is wheels or sprockets, and what acts on each.
pub(super) struct Shafts {
    count: usize,
    /// rad/s.
    spins: [f64; MAX_WHEELS],
    /// Of ground and obstacles, N m.
    moments: [f64; MAX_WHEELS],
    /// The greatest torques of brakes and friction, N m.
    brakes: [f64; MAX_WHEELS],
}

/// What the driveline has made of a step.
pub(super) struct Driven {
    /// The new spins of all wheels, rad/s.
    pub(super) spins: [f64; MAX_WHEELS],
    /// The new speeds of the belts, m/s.
    pub(super) belts: [f64; 2],
    /// The torque of driveline and brake on each wheel, which the chassis reacts, N m.
    pub(super) torques: [f64; MAX_WHEELS],
}

impl Shafts {
    fn none(count: usize) -> Self {
        Self { count, spins: [0.0; MAX_WHEELS], moments: [0.0; MAX_WHEELS], brakes: [0.0; MAX_WHEELS] }
    }

    /// The wheels of a vehicle without tracks, with its brake pressed as far as `brake` says, in [0, 1].
    pub(super) fn of_wheels(design: &Design, wheels: &[Wheel], forces: &[Forces], brake: f64) -> Self {
        let mut shafts = Self::none(wheels.len());
        for (i, ((c, w), f)) in design.corners.iter().zip(wheels).zip(forces).enumerate() {
            shafts.spins[i] = w.spin;
            shafts.moments[i] = f.spin_moment;
            shafts.brakes[i] = brake * c.brake_torque;
        }
        shafts
    }

    /// The sprockets of a tracked vehicle. `thrusts` are the forces of ground and obstacles along each belt, N. The belt on
    /// the inside of the bend is braked by the steering command.
    pub(super) fn of_sprockets(
        design: &Design,
        belts: &[Belt],
        thrusts: [f64; 2],
        forces: &[Forces],
        brake: f64,
        steering: f64,
    ) -> Self {
        let mut shafts = Self::none(belts.len());
        // A positive command turns to the left: the left belt is the inner one.
        let inner = usize::from(steering < 0.0);
        for (i, (t, belt)) in design.tracks.iter().zip(belts).enumerate() {
            let radius = t.pitch_radius();
            shafts.spins[i] = t.sprocket_spin(belt.speed);
            shafts.moments[i] = -radius * thrusts[i];
            // A track that is pushed from the side may bear less than nothing away from the ground: then nothing resists.
            let load = (0..t.count()).map(|j| forces[t.wheel(j)].load).sum::<f64>().max(0.0);
            let [rest, growth] = t.spec.resistance;
            let friction = (rest + growth * belt.speed.abs()) * load * radius;
            let brake = brake * design.corners[t.wheel(t.sprocket)].brake_torque;
            let steering = if i == inner { steering.abs() * t.spec.steering_torque } else { 0.0 };
            shafts.brakes[i] = friction + brake + steering;
        }
        shafts
    }

    /// The maximum torques of brakes and friction on the first two, N m.
    #[cfg(test)]
    pub(super) fn brakes(&self) -> [f64; 2] {
        [self.brakes[0], self.brakes[1]]
    }

    /// Advances engine, gearbox and shafts by `dt` (s).
    // Inlined into the step, the powertrain's code takes registers from all that is around it.
    #[inline(never)]
    pub(super) fn advance(mut self, tracks: &[Track], drive: &mut Drive, demand: &Demand, dt: f64) -> Driven {
        let n = self.count;
        let mut torques = [0.0; MAX_WHEELS];
        let mut wheels = Wheels {
            spins: &mut self.spins[..n],
            moments: &self.moments[..n],
            brakes: &self.brakes[..n],
            torques: &mut torques[..n],
        };
        drive.advance(demand, &mut wheels, dt);
        if tracks.is_empty() {
            return Driven { spins: self.spins, belts: [0.0; 2], torques };
        }
        let mut driven = Driven { spins: [0.0; MAX_WHEELS], belts: [0.0; 2], torques: [0.0; MAX_WHEELS] };
        for (i, t) in tracks.iter().enumerate() {
            let speed = self.spins[i] * t.pitch_radius();
            driven.belts[i] = speed;
            driven.torques[t.wheel(t.sprocket)] = torques[i];
            for j in 0..t.count() {
                driven.spins[t.wheel(j)] = speed / t.outer_radius(j);
            }
        }
        driven
    }
}
