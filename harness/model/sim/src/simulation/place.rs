//! The vehicle comes to the ground at the start.

use super::Simulation;
use crate::error::SimError;
use crate::monitor::EnergyMonitor;
use crate::state::Controls;
use crate::tyre::Envelope;
use crate::{Quat, V3};
use vb_math::atan;
use vb_world::Pose2;

impl Simulation {
    /// Sets the vehicle down as low as it goes without touching the ground, aligned with the ground under its wheels.
    pub(super) fn place(&mut self, start: Pose2) {
        let ground = &self.world.heightfield;
        let heading = Quat::from_axis_angle(&V3::z_axis(), start.yaw);
        let body = self.vehicle.body_mut();
        body.q = heading;
        body.x_world = V3::new(start.x, start.y, 0.0) - heading * self.reference;
        let centre = body.x_world + heading * self.reference;
        // Least squares of the ground's height over the wheels' positions in the vehicle's own axes.
        let (mut sxx, mut syy, mut sxz, mut syz) = (0.0, 0.0, 0.0, 0.0);
        let wheels: Vec<(V3, f64)> = self
            .vehicle
            .hubs()
            .map(|(hub, _)| (heading.inverse() * (hub - centre), ground.height(hub.x, hub.y)))
            .collect();
        let count = wheels.len() as f64;
        let middle = wheels.iter().map(|w| w.0).sum::<V3>() / count;
        // Wheels that lie evenly about the reference point need no centring.
        let even = middle.x.abs().max(middle.y.abs()) < 1e-6;
        let (ox, oy, oz) = if even {
            (0.0, 0.0, 0.0)
        } else {
            (middle.x, middle.y, wheels.iter().map(|w| w.1).sum::<f64>() / count)
        };
        for (p, z) in wheels {
            let (p, z) = (V3::new(p.x - ox, p.y - oy, p.z), z - oz);
            sxx += p.x * p.x;
            syy += p.y * p.y;
            sxz += p.x * z;
            syz += p.y * z;
        }
        let pitch = Quat::from_axis_angle(&V3::y_axis(), -atan(sxz / sxx));
        let roll = Quat::from_axis_angle(&V3::x_axis(), atan(syz / syy));
        self.vehicle.body_mut().q = heading * pitch * roll;
        let may_touch = self.height_for_wheels(start);
        // From well above any ground nearby, down in steps of 1 cm of the full-size world.
        let step = 0.01 * self.world.scale;
        let (low, high) = ground.range();
        let top = high + 3.0;
        let mut z = top;
        while z > low {
            let below = V3::new(start.x, start.y, z - step) - self.vehicle.body().q * self.reference;
            let before = std::mem::replace(&mut self.vehicle.body_mut().x_world, below);
            if !self.is_free(below.z <= may_touch) {
                self.vehicle.body_mut().x_world = before;
                break;
            }
            z -= step;
        }
    }

    /// Leaves the vehicle level in the air with its reference point `height` above the ground, whose height is read at the
    /// place over `stretch`, or as much higher as it takes not to touch the ground.
    pub(super) fn place_above(&mut self, start: Pose2, height: f64, stretch: f64) {
        let ground = &self.world.heightfield;
        let (_, high) = ground.range();
        self.vehicle.body_mut().q = Quat::from_axis_angle(&V3::z_axis(), start.yaw);
        let mut z = ground.height(start.x / stretch, start.y / stretch) + height;
        loop {
            self.vehicle.body_mut().x_world =
                V3::new(start.x, start.y, z) - self.vehicle.body().q * self.reference;
            if self.is_free(true) || z > high + height.max(3.0) {
                break;
            }
            z += 0.01 * self.world.scale;
        }
    }

    /// The height of the body above which no wheel comes near the ground with the vehicle turned as it is and its reference
    /// point at this place, m: at the edge of the world infinite.
    fn height_for_wheels(&self, place: Pose2) -> f64 {
        let body = self.vehicle.body();
        let at = V3::new(place.x, place.y, 0.0) - body.q * self.reference;
        let wheels = self.vehicle.hubs().zip(self.vehicle.envelopes()).map(|((hub, _), envelope)| {
            // However its axle is turned.
            let radius = envelope.radius() + envelope.half_width();
            let from_body = hub - body.x_world;
            (radius - from_body.z, from_body.norm() + radius)
        });
        let (depth, reach) =
            wheels.fold((0.0f64, 0.0f64), |(d, r), (depth, reach)| (d.max(depth), r.max(reach)));
        self.world.heightfield.highest(at.x, at.y, reach) + depth + 0.1 * self.world.scale
    }

    /// Whether neither wheels nor hull touch the ground. Wheels that are known to be far above the ground needn't be looked at; the
    /// hull, which remembers where it was clear, is always.
    fn is_free(&mut self, wheels_are_low: bool) -> bool {
        self.pass_over_soil();
        let ground = &self.world.heightfield;
        let mut wheels = self.vehicle.hubs().zip(self.vehicle.envelopes());
        let touch = |((hub, axis), envelope): ((V3, V3), &Envelope)| {
            hub.z < ground.height(hub.x, hub.y) || envelope.query(ground, &hub, &axis).is_some()
        };
        let touches = wheels_are_low && wheels.any(touch);
        let margin = 0.02 * self.world.scale;
        let body = self.vehicle.body();
        !touches && !self.chassis.may_touch(ground, &self.obstacles, &body.x_world, &body.q, margin)
    }

    /// Lets the vehicle come to rest with its brakes on, and starts the clock.
    pub(super) fn settle(&mut self) -> Result<(), SimError> {
        let controls = Controls { brake: 1.0, ..Controls::default() };
        let most = (self.options.settle_time / self.options.step) as u64;
        let mut still = 0;
        for _ in 0..most {
            self.step(controls);
            let body = self.vehicle.body();
            let quiet = body.v_world.norm() < 0.01 && body.w_world.norm() < 0.01;
            still = if quiet { still + 1 } else { 0 };
            if still >= 100 {
                break;
            }
        }
        // A wheel that was put into a rock has been thrown out of it: energy that a start in a bad place gave.
        self.energy = EnergyMonitor::new(self.vehicle.weight_and_radius());
        self.vehicle.count_anew();
        self.check()?;
        self.steps = 0;
        self.contact_steps = 0;
        Ok(())
    }
}
