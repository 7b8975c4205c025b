//! A single wheel and a plate on soil, as in a soil bin: the measurements by which soils and wheels are compared.

use super::footprint::Footprint;
use super::ground::{SoilGround, Under};
use super::law::SoilLaw;
use crate::V3;
use crate::tyre::WheelMotion;
use vb_vehicle::GRAVITY;
use vb_world::Heightfield;

/// A rigid wheel that a carriage pulls over level soil under a given load, at a given speed and slip ratio.
#[derive(Clone, Debug)]
pub struct WheelRig {
    /// The radius of the wheel, m.
    pub radius: f64,
    /// The width of the wheel, m.
    pub width: f64,
    /// The weight on the wheel, N.
    pub load: f64,
    /// The speed of the carriage, m/s.
    pub speed: f64,
    /// The time step, s.
    pub step: f64,
    /// The side of the cells of the soil's memory, m.
    pub resolution: f64,
}

/// The behaviour of a wheel in a soil bin once it runs steadily: means over the last part of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelBehaviour {
    /// The depth of the rim's lowest point below the undisturbed surface, m.
    pub sinkage: f64,
    /// The horizontal force on the carriage, N, positive when the wheel pulls.
    pub drawbar: f64,
    /// The resistance to compaction, N: the horizontal part of the pressure.
    pub compaction: f64,
    /// The torque on the axle that keeps the wheel turning, N m.
    pub torque: f64,
    /// The smallest and the greatest load of the soil on the wheel, N.
    pub load_range: [f64; 2],
}

impl WheelRig {
    /// Runs the wheel on fresh soil with the slip ratio s = 1 − v/(ωr) for s ≥ 0, and ωr/v − 1 for s < 0 (braked), then
    /// `passes` − 1 more times in the same rut. It returns the behaviour in the last pass.
    #[must_use]
    pub fn run(&self, law: &SoilLaw, slip: f64, passes: u32) -> WheelBehaviour {
        let surface = Heightfield::flat(3, 41, 1.0, 0.0);
        let mut ground = SoilGround::of_one(law.prepare(), [20.0, 1.0], self.resolution);
        let mut last = None;
        for _ in 0..passes.max(1) {
            last = Some(self.pass(&mut ground, &surface, slip));
        }
        last.unwrap_or_else(|| self.pass(&mut ground, &surface, slip))
    }

    fn pass(&self, ground: &mut SoilGround, surface: &Heightfield, slip: f64) -> WheelBehaviour {
        let mut wheel = Footprint::wheel(self.radius, self.width, self.resolution);
        let spin = self.speed / self.radius * if slip >= 0.0 { 1.0 / (1.0 - slip) } else { 1.0 + slip };
        let (axis, mass) = (V3::y(), self.load / GRAVITY);
        let (mut x, mut z, mut vz) = (-4.0, self.radius, 0.0);
        let (mut sums, mut count, mut range) = ([0.0; 4], 0.0, [f64::INFINITY, 0.0_f64]);
        while x < 4.0 {
            let motion = WheelMotion {
                hub: V3::new(x, 0.0, z),
                velocity: V3::new(self.speed, 0.0, vz),
                rotation: axis * spin,
                axis,
                spin,
            };
            let under = ground.under(x, 0.0, self.radius);
            let (mut force, mut moment, mut load, mut added, mut pushed) = (V3::zeros(), 0.0, 0.0, 0.0, 0.0);
            if let Some(s) = wheel.step(ground, surface, under, &motion, self.step) {
                (force, moment, load, added, pushed) =
                    (s.force, s.moment.y, s.load, s.inertia.m33, s.compaction);
            }
            // The carriage lets the wheel down gently: a damper that is critical for a wheel's usual stiffness.
            let damper = 2.0 * (mass * 2e5).sqrt();
            vz += self.step * (force.z - self.load - damper * vz) / (mass + added + self.step * damper);
            z += self.step * vz;
            x += self.step * self.speed;
            if x > 1.0 {
                for (sum, value) in sums.iter_mut().zip([self.radius - z, force.x, -moment, pushed]) {
                    *sum += value;
                }
                count += 1.0;
                range = [range[0].min(load), range[1].max(load)];
            }
        }
        // The wheel is lifted at the end of its way, so that the next pass finds the whole rut.
        let lifted = WheelMotion {
            hub: V3::new(x, 0.0, 3.0 * self.radius),
            velocity: V3::zeros(),
            rotation: V3::zeros(),
            axis,
            spin: 0.0,
        };
        wheel.step(ground, surface, Under::Rigid, &lifted, self.step);
        let [sinkage, drawbar, torque, compaction] = sums.map(|s| s / count);
        WheelBehaviour { sinkage, drawbar, compaction, torque, load_range: range }
    }
}
