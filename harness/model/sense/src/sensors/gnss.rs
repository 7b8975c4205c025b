//! The receiver for satellites: the position with an error that is mostly correlated in time, as orbits, clocks, the
//! atmosphere and reflections make it (Rankin, "An error model for sensor simulation: GPS and differential GPS", IEEE
//! PLANS 1994), and spells without a position.

use super::DT;
use crate::frame::vec3;
use crate::noise::{GaussMarkov, Outage, Seed, White};
use crate::profile::{GnssError, GnssModel};
use vb_sdk::GnssFix;
use vb_sim::VehicleState;

#[derive(Clone, Debug)]
pub(crate) struct Gnss {
    /// Samples from one position to the next.
    every: u64,
    axes: [(GaussMarkov, White); 3],
    outage: Option<Outage>,
    fix: Option<GnssFix>,
}

impl Gnss {
    pub(crate) fn new(model: &GnssModel, every: u64, scale: f64, seed: &Seed) -> Self {
        let axis = |name: &str, e: &GnssError| {
            let stream = |part: &str| seed.stream("gnss", &format!("{name} {part}"));
            (
                GaussMarkov::new(e.std_m * scale, e.correlation_s, DT, stream("correlated")),
                White::new(e.white_std_m * scale, stream("white")),
            )
        };
        let outage = model
            .outages
            .map(|s| Outage::new(s.mean_interval_s, s.mean_duration_s, DT, seed.stream("gnss", "outages")));
        Self {
            every,
            axes: [axis("x", &model.horizontal), axis("y", &model.horizontal), axis("z", &model.vertical)],
            outage,
            fix: None,
        }
    }

    /// Takes the state at sample `k`.
    pub(crate) fn sample(&mut self, k: u64, now: &VehicleState) {
        let mut position = now.position;
        for (axis, (correlated, white)) in self.axes.iter_mut().enumerate() {
            position[axis] += correlated.step() + white.step();
        }
        let out = self.outage.as_mut().is_some_and(Outage::step);
        if !out && k.is_multiple_of(self.every) {
            self.fix = Some(GnssFix { time: now.time, position: vec3(&position) });
        }
    }

    /// The last position since the last call, if there is one.
    pub(crate) fn take(&mut self) -> Option<GnssFix> {
        self.fix.take()
    }
}
